"""Pictures of the templates on a page: the walker's outline from the side, as SVG."""

from functools import cache

import numpy as np

from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates

WIDTH, HEIGHT, MARGIN = 120.0, 60.0, 6.0
"""Size of a picture and its margin around the walker, pixels."""

VIEW_AXES = np.array([[0.87, 0.0, 0.5], [0.21, 0.91, -0.36]])
"""Axes of the picture, to the right and upward, in the frame of the walker, which is seen from the front, the left
and above."""


@cache
def side_view(name: str) -> str:
    """Draw a template's walker as SVG, its triangles from the farthest to the nearest."""
    design = templates.load(name, "walkers", Design)
    return _draw_mesh(solids.build(design).walker)


def _draw_mesh(mesh: Mesh) -> str:
    """Draw the visible triangles of a mesh as SVG, shaded, the nearest last."""
    towards = np.cross(VIEW_AXES[0], VIEW_AXES[1])
    corners = mesh.vertices[mesh.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    seen = normals @ towards > 0.0
    order = np.argsort((corners.mean(axis=1) @ towards)[seen], kind="stable")
    flat = (corners @ VIEW_AXES.T)[seen][order]
    low, high = flat.min(axis=(0, 1)), flat.max(axis=(0, 1))
    scale = min((WIDTH - 2 * MARGIN) / (high - low)[0], (HEIGHT - 2 * MARGIN) / (high - low)[1])
    places = (flat - 0.5 * (low + high)) * scale * [1.0, -1.0] + [0.5 * WIDTH, 0.5 * HEIGHT]
    light = 0.55 + 0.45 * np.clip(normals[seen][order] @ [0.2, 0.8, 0.55], 0.0, 1.0)
    paths = [
        f'<path fill="{_colour(share)}" stroke="{_colour(share)}" d="M'
        + "L".join(f"{x:.1f} {y:.1f}" for x, y in triangle)
        + 'Z"/>'
        for share, triangle in zip(light, places, strict=True)
    ]
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" '
        f'stroke-width=".4">{"".join(paths)}</svg>'
    )


def _colour(brightness: float) -> str:
    """Return the colour (#rrggbb) of a face for a brightness of 0 to 1."""
    return "#" + "".join(f"{round(value * brightness):02x}" for value in (126, 184, 230))
