"""Meshes drawn in perspective: a camera, and a picture with hidden faces hidden, pixel by pixel."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.core import Array, Mask, Mesh, Whole

CAMERA_DIRECTION = np.array([0.45, 0.36, 0.85])
"""Direction from the walker to the camera: before it, above it, and to its right."""

CAMERA_DISTANCE = 6.0
"""Distance of the camera over the size of its view."""

LIGHT_DIRECTION = np.array([-0.35, 0.6, 0.72])
"""Direction to the light: to the right, up, and toward the camera, in the camera's axes."""

AMBIENT = 0.5
"""Brightness of a face that the light only grazes."""

SHARP_EDGE_COSINE = math.cos(math.radians(25.0))
"""Cosine of the smallest angle between the normals of two faces whose common edge is drawn."""

SAMPLES_PER_PIXEL = 2
"""Samples along either side of a pixel."""

DEPTH_TOLERANCE = 2e-3
"""Relative tolerance of depths for an edge to count as visible."""


class Camera(NamedTuple):
    """Camera that looks along -CAMERA_DIRECTION; pictures count pixels from their lower left corner."""

    axes: Array
    """Rows to the right, up and toward the camera, shape (3, 3)."""
    eye: Array
    """Position of the camera, shape (3,), mm."""
    scale: float
    """Pixels per unit tangent of the angle from the line of sight."""
    offset: Array
    """Pixels at which the line of sight meets the picture, shape (2,)."""

    def project(self, points: Array) -> Array:
        """Project points (..., 3) to pixels and inverse distance (1/mm), shape (..., 3)."""
        seen = (points - self.eye) @ self.axes.T
        nearness = -1.0 / seen[..., 2]
        flat = self.scale * seen[..., :2] * nearness[..., None] + self.offset
        return np.concatenate([flat, nearness[..., None]], axis=-1)


def fit_camera(points: Array, size: tuple[float, float]) -> Camera:
    """Return the camera whose picture of `size` (width, height, pixels) just contains points (n, 3), mm."""
    low, high = points.min(axis=0), points.max(axis=0)
    back = CAMERA_DIRECTION / np.linalg.norm(CAMERA_DIRECTION)
    right = np.cross([0.0, 1.0, 0.0], back)
    right /= np.linalg.norm(right)
    eye = 0.5 * (low + high) + CAMERA_DISTANCE * float(np.linalg.norm(high - low)) * back
    unscaled = Camera(np.array([right, np.cross(back, right), back]), eye, 1.0, np.zeros(2))
    projected = unscaled.project(points)[:, :2]
    low, high = projected.min(axis=0), projected.max(axis=0)
    scale = float((np.array(size) / (high - low)).min())
    return unscaled._replace(scale=scale, offset=0.5 * np.array(size) - 0.5 * scale * (low + high))


class Model(NamedTuple):
    """Mesh with the data that drawing it requires."""

    mesh: Mesh
    normals: Array
    """Normals of the triangles, shape (m, 3)."""
    edges: Whole
    """Sharp edges: two vertices and the two adjacent triangles, shape (e, 4)."""


def make_model(mesh: Mesh) -> Model:
    """Return a closed mesh with its normals and sharp edges."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals /= np.where(lengths > 0.0, lengths, 1.0)  # slivers of a person's mesh have none
    triangles_of: dict[tuple[int, int], list[int]] = {}
    for number, triangle in enumerate(mesh.triangles.tolist()):
        for start, end in zip(triangle, triangle[1:] + triangle[:1], strict=True):
            triangles_of.setdefault((min(start, end), max(start, end)), []).append(number)
    edges = [
        (*ends, *adjacent[:2])
        for ends, adjacent in triangles_of.items()
        if len(adjacent) > 1 and normals[adjacent[0]] @ normals[adjacent[1]] < SHARP_EDGE_COSINE
    ]
    return Model(mesh, normals, np.array(edges, np.int64).reshape(-1, 4))


def render(
    model: Model, R: Array, shift: Array, camera: Camera, colour: str, ink: str
) -> tuple[npt.NDArray[np.uint8], int, int]:
    """Render a mesh, first rotated and then moved, into the smallest picture that contains it.

    Parameters
    ----------
    model : Model
        Mesh to render.
    R : ndarray
        Rotation matrix, shape (3, 3).
    shift : ndarray
        Displacement after the rotation, shape (3,), mm.
    camera : Camera
        Camera of the whole picture.
    colour, ink : str
        Colours of faces and of edges, #rrggbb.

    Returns
    -------
    tuple
        RGBA picture, upper row first, and the positions of its left and its lower edge in the camera's picture, pixels.
    """
    projected = camera.project(model.mesh.vertices @ R.T + shift)
    left, low = np.floor(projected[:, :2].min(axis=0)).astype(int) - 1
    right, high = np.ceil(projected[:, :2].max(axis=0)).astype(int) + 2
    fine = np.column_stack([SAMPLES_PER_PIXEL * (projected[:, :2] - (left, low)), projected[:, 2]])
    shape = SAMPLES_PER_PIXEL * int(high - low), SAMPLES_PER_PIXEL * int(right - left)
    number = np.full(shape, -1, np.int32)
    near = np.zeros(shape)
    corners = fine[model.mesh.triangles]
    for triangle in np.flatnonzero(_doubled_areas(corners) > 0.0):
        _fill_triangle(number, near, corners[triangle], int(triangle))
    _draw_edges(number, near, fine, model, _doubled_areas(corners) > 0.0)
    shades = _shade_faces(model.normals @ R.T @ camera.axes.T, colour, ink)
    return _downsample(shades[number][::-1]), int(left), int(low)


def _doubled_areas(corners: Array) -> Array:
    """Return twice the signed areas of triangles (..., 3, 2 or more): positive if counter-clockwise."""
    first, second = (corners[..., 1, :2] - corners[..., 0, :2], corners[..., 2, :2] - corners[..., 0, :2])
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])


def _fill_triangle(number: npt.NDArray[np.int32], near: Array, corners: Array, value: int) -> None:
    """Draw a counter-clockwise triangle into the buffers, at samples where it is nearer than all earlier ones.

    Parameters
    ----------
    number, near : ndarray
        At each sample the index of the nearest triangle and its inverse distance (1/mm), shape (height, width) each.
    corners : ndarray
        x, y (samples) and inverse distance (1/mm) of each corner, shape (3, 3).
    value : int
        Index of the triangle.
    """
    (left, low), (right, high) = corners[:, :2].min(axis=0), corners[:, :2].max(axis=0)
    x = np.arange(math.ceil(left - 0.5), math.floor(right - 0.5) + 1)
    y = np.arange(math.ceil(low - 0.5), math.floor(high - 0.5) + 1)
    if not (len(x) and len(y)):
        return
    # In each row the triangle reaches from the nearest of its left edges to that of its right ones
    begin, end = np.full(len(y), -np.inf), np.full(len(y), np.inf)
    middle = y + 0.5
    for i in range(3):
        (x_0, y_0, _), (x_1, y_1, _) = corners[i], corners[(i + 1) % 3]
        if y_0 != y_1:
            crossing = x_0 + (middle - y_0) * ((x_1 - x_0) / (y_1 - y_0))
            if y_1 < y_0:
                begin = np.maximum(begin, crossing)
            else:
                end = np.minimum(end, crossing)
    # Nearness is linear over the picture
    spread = np.linalg.solve(np.column_stack([corners[:, :2], np.ones(3)]), corners[:, 2])
    nearness = spread[0] * (x + 0.5) + (spread[1] * middle + spread[2])[:, None]
    rows, columns = slice(y[0], y[-1] + 1), slice(x[0], x[-1] + 1)
    inside = (x + 0.5 >= begin[:, None]) & (x + 0.5 < end[:, None]) & (nearness > near[rows, columns])
    near[rows, columns][inside] = nearness[inside]
    number[rows, columns][inside] = value


def _draw_edges(number: npt.NDArray[np.int32], near: Array, points: Array, model: Model, facing: Mask) -> None:
    """Draw the visible sharp edges: set `number` there to len(facing), the index of the ink among the colours.

    Parameters
    ----------
    number, near : ndarray
        Buffers, as in `_fill_triangle`.
    points : ndarray
        Projected vertices, shape (v, 3).
    model : Model
        Mesh whose edges are drawn.
    facing : ndarray of bool
        True for each triangle that faces the camera.
    """
    edges = model.edges[facing[model.edges[:, 2]] | facing[model.edges[:, 3]]]
    ends = points[edges[:, :2]]
    counts = np.ceil(np.hypot(*(ends[:, 1, :2] - ends[:, 0, :2]).T)).astype(int) + 1
    share = np.concatenate([np.linspace(0.0, 1.0, count) for count in counts])
    first, last = (np.repeat(ends[:, end], counts, axis=0) for end in (0, 1))
    dots = first + share[:, None] * (last - first)
    x, y = np.floor(dots[:, :2]).astype(int).T
    shown = dots[:, 2] > near[y, x] * (1.0 - DEPTH_TOLERANCE)
    for right in range(SAMPLES_PER_PIXEL):
        for up in range(SAMPLES_PER_PIXEL):
            number[y[shown] + up - 1, x[shown] + right - 1] = len(facing)


def _shade_faces(normals: Array, colour: str, ink: str) -> npt.NDArray[np.uint8]:
    """Return the RGBA colours of m faces with these normals in the camera's axes, of the ink, and of nothing."""
    light = LIGHT_DIRECTION / np.linalg.norm(LIGHT_DIRECTION)
    bright = AMBIENT + (1.0 - AMBIENT) * np.clip(normals @ light, 0.0, 1.0)
    full, dark = (np.array([int(code[i : i + 2], 16) for i in (1, 3, 5)]) for code in (colour, ink))
    colours = np.vstack([bright[:, None] * np.minimum(1.15 * full, 255.0), dark, np.zeros(3)])
    alpha = np.append(np.full(len(colours) - 1, 255.0), 0.0)
    return np.column_stack([colours, alpha]).round().astype(np.uint8)


def _downsample(picture: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Average SAMPLES_PER_PIXEL² RGBA samples to each pixel. Transparent samples do not count for its colour."""
    first, *others = (
        picture[row::SAMPLES_PER_PIXEL, column::SAMPLES_PER_PIXEL]
        for row in range(SAMPLES_PER_PIXEL)
        for column in range(SAMPLES_PER_PIXEL)
    )
    total = first.astype(np.uint16)
    for sample in others:
        total += sample
    pixels, opaque = np.empty(total.shape, np.uint8), np.maximum(total[..., 3:] // 255, 1)
    pixels[..., :3] = (total[..., :3] + opaque // 2) // opaque
    pixels[..., 3] = (total[..., 3] + SAMPLES_PER_PIXEL**2 // 2) // SAMPLES_PER_PIXEL**2
    return pixels
