"""Preview: a shaded picture of every part of a family, as in the paper's figure 1."""

import math
from collections.abc import Sequence
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch

from walkergen.core.numerics import Array
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import pockets
from walkergen.core.walker.design import Design
from walkergen.files.canvas import nice_floor
from walkergen.files.figures import LEG_COLOURS, style
from walkergen.readers.walkers import caps

ROW_PARTS, PART_INCHES, LABEL_SIZE_PT = 5, 2.4, 10.0
"""Parts in a row, inches for each, and the size of labels in points."""

MAX_LARGE_PARTS, SMALL_PART_INCHES, MAX_ASPECT = 40, 1.35, 3.0
"""Number of parts above which parts are drawn closer, as on a contact sheet; inches for each; and the
largest ratio of the sheet's height to its width."""

MAX_SCALE_BAR_SHARE = 0.4
"""Largest length of the scale bar relative to the body's."""

ARROW_SHARE, ARROW_GAP_MM = 0.5, 2.0
"""Length of the arrow of a run over that of the walker, and its distance from the walker, mm."""

SEAM_WIDTH_PT = 0.8
"""Width of the edges of triangles, points, in their own colour: 1.7 pixels hide the seams."""

MAX_EDGE_MM = 2.0
"""Longest edge of the triangles of a drawn body with pockets, mm: the painter's algorithm
requires small triangles if one part lies within the other."""

POCKET_COLOURS = {"motor": "#d55e00", "battery": "#999999"}
"""Colours of the parts that bodies carry. The bodies are drawn transparent."""

ROUNDING_MM = 1e-6
"""Largest error, mm, of the heights of a mesh."""


class Part(NamedTuple):
    """Walker in the preview, in its standing position."""

    design: Design
    mesh: Mesh
    caption: str = ""
    """Lines below the picture that replace its own."""
    speed: str = ""
    """Speed in words, in a line below that."""
    low: bool = False
    """True to show a body in plan view from the same height as other bodies, with its legs."""

    way: int = 0
    """1 for a walker that runs forward, -1 for one that runs backward, which an arrow on the plate shows, else 0."""

    @property
    def arrow(self) -> Array:
        """Tail and tip of the arrow on the plate before the walker, shape (2, 3); shape (0, 3) if it does not run."""
        if self.way == 0:
            return np.empty((0, 3))
        low, high = self.mesh.vertices.min(axis=0), self.mesh.vertices.max(axis=0)
        half = 0.5 * ARROW_SHARE * self.way * (high[0] - low[0])
        middle = np.array([0.5 * (low[0] + high[0]), low[1], high[2] + ARROW_GAP_MM])
        ends: Array = middle + np.array([[-half, 0.0, 0.0], [half, 0.0, 0.0]])
        return ends

    @property
    def label(self) -> str:
        """Words below the picture: the tilt, unless every leg has its own, the kind of legs, what it does."""
        kind = self.design.kind
        name = f"{self.design.tilt_deg:g}° {kind}" if self.design.has_family_tilt else kind
        return "\n".join(filter(None, (self.caption or name, self.speed)))

    @property
    def carried(self) -> dict[str, Mesh]:
        """Motor and battery in their positions, by name."""
        return pockets.part_meshes(self.design)

    @property
    def cap(self) -> tuple[Array, list[Array]] | None:
        """Corners of its cap and of the black rectangles on it, shapes (n, 3); None without a cap.

        The marker is drawn flat for every way of making it black.
        """
        cap, depth = self.design.cap, self.design.size.depth
        if cap is None:
            return None
        bottom = float(self.mesh.vertices[:, 1].max())

        def to_mesh_frame(corners: Array, up: float) -> Array:
            """Return corners (n, 2), forward and to the left, in the mesh's frame (n, 3), `up` mm above the body."""
            x, y = corners.T
            return np.column_stack([x, np.full(len(x), bottom + up), 0.5 * depth - y])

        rim, top = caps.tile_outline(cap), cap.thickness
        tile = np.concatenate([to_mesh_frame(rim, 0.0), to_mesh_frame(rim, top)])
        return tile, [to_mesh_frame(square, top) for square in caps.black_rectangles(cap)]

    @property
    def attached(self) -> list[Array]:
        """Corners of everything that is drawn with the walker, shapes (n, 3)."""
        return [*(one.vertices for one in self.carried.values()), *(self.cap or ())[:1], self.arrow]

    @property
    def view(self) -> Array:
        """Camera that shows the shape. Bodies in plan view are seen from higher above."""
        return TOP_CAMERA if self.design.body.flat and not self.low else SIDE_CAMERA


def _camera_rotation(nod_deg: float) -> Array:
    """Return the rotation to the camera's frame (right, up, towards the viewer): from above, to the right."""
    turn, nod = np.radians(-28.0), np.radians(nod_deg)
    about_y = [[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]]
    about_x = [[1, 0, 0], [0, np.cos(nod), -np.sin(nod)], [0, np.sin(nod), np.cos(nod)]]
    return np.array(about_x) @ np.array(about_y)


SIDE_CAMERA, TOP_CAMERA = _camera_rotation(16.0), _camera_rotation(32.0)
LIGHT_DIRECTION = np.array([-0.35, 0.75, 0.56])


@style()
def preview_figure(parts: Sequence[Part], title: str) -> Figure:
    """Draw all parts with labels, in rows in the order of the table. Many parts are drawn closer."""
    screens = [np.concatenate([part.mesh.vertices, *part.attached]) @ part.view.T for part in parts]
    size = np.max([np.ptp(screen, axis=0) for screen in screens], axis=0)
    inches = PART_INCHES if len(parts) <= MAX_LARGE_PARTS else SMALL_PART_INCHES
    scale = inches / (1.12 * size[0])
    lines = 2.0 + 1.2 * max(1 + part.label.count("\n") for part in parts)
    pitch = np.array([1.12 * size[0], size[1] + lines * LABEL_SIZE_PT / 72.0 / scale])
    rows = _arrange_rows(parts, pitch[1] / pitch[0])
    columns = max(len(row) for row in rows)
    middle, half = 0.5 * (columns - 1) * pitch[0], max(0.5 * columns * pitch[0], 1.7 / scale)
    low, high = middle - half, middle + half
    top, line = 0.5 * pitch[1], LABEL_SIZE_PT / 72.0 / scale
    bottom = top - len(rows) * pitch[1] - 3.5 * line
    figure = Figure(figsize=(scale * (high - low), scale * (top - bottom) + 0.4))
    axes = figure.add_axes((0.0, 0.0, 1.0, scale * (top - bottom) / figure.get_figheight()))
    places = [(part, pitch * (x, -y)) for y, row in enumerate(rows) for x, part in enumerate(row)]
    views = [_project_part(part, at) for part, at in places]
    triangles: Any = np.concatenate([view.triangles for view in views])
    colours = np.concatenate([view.colours for view in views])
    faces = PolyCollection(
        triangles, facecolors=colours, edgecolors=colours, linewidths=SEAM_WIDTH_PT, joinstyle="round"
    )
    axes.add_collection(faces, autolim=False)  # limits are set after everything is drawn
    for (part, at), view in zip(places, views, strict=True):
        _draw_attachments(axes, part, at - view.middle)
        below = at[0], at[1] - 0.52 * size[1] - 0.5 * line
        axes.annotate(part.label, below, ha="center", va="top", fontsize=LABEL_SIZE_PT)
    axes.set_xlim(low, high)
    axes.set_ylim(bottom, top)
    axes.set_axis_off()
    arrows = any(part.way for part in parts)
    _draw_scale_bar(axes, parts[0], np.array([low + 1.5 * line, bottom + 2.0 * line]), arrows)
    figure.suptitle(title, fontsize=LABEL_SIZE_PT + 2.0)
    return figure


def _arrange_rows(parts: Sequence[Part], aspect: float) -> list[list[Part]]:
    """Arrange parts in rows, a new one for another kind of legs; `aspect`: height over width of a part's cell."""
    row_length = ROW_PARTS if len(parts) <= MAX_LARGE_PARTS else 2 * ROW_PARTS
    row_length = max(row_length, math.ceil(math.sqrt(len(parts) * aspect / MAX_ASPECT)))
    kinds = [list(group) for _, group in groupby(parts, key=lambda part: part.design.kind)]
    return [kind[i : i + row_length] for kind in kinds for i in range(0, len(kind), row_length)]


def _draw_scale_bar(axes: Axes, part: Part, at: Array, arrows: bool) -> None:
    """Draw a scale bar with its length from `at` along the bodies, as projected. `arrows`: whether arrows are drawn."""
    length = nice_floor(MAX_SCALE_BAR_SHARE * part.design.size.length)
    end = at + length * part.view[:2, 0]
    axes.plot(*np.array([at, end]).T, "|-", color="black", linewidth=1.2, markersize=7)
    axes.annotate(
        f"{length:g} mm along the body" + ("; arrows: where they run" if arrows else ""),
        (end[0], end[1]),
        xytext=(8, 0),
        textcoords="offset points",
        va="center",
        fontsize=LABEL_SIZE_PT,
    )


class _View(NamedTuple):
    """Projected part, in the order of drawing."""

    triangles: Array
    """Shape (n, 3, 2)."""
    colours: Array
    """Shape (n, 3)."""
    middle: Array
    """Middle of the complete drawing of the part, at its position."""


def _project_part(part: Part, at: Array) -> _View:
    """Return the visible triangles of a part, from back to front, as its camera sees it, with the middle at `at`.

    Legs are drawn before a body with a flat underside, because from above they hide no part of it. The upper side of
    the body is drawn last.
    """
    standing = _triangles(part)
    corners = standing @ part.view.T
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    facing = normals[:, 2] > 0
    corners, normals = corners[facing], normals[facing]
    layer = np.zeros(len(corners))
    if part.design.body.flat or part.design.body.plain:
        half = 0.5 * part.design.size.thickness - ROUNDING_MM
        lowest = standing[facing][:, :, 1].min(axis=1)
        layer = np.digitize(lowest, (-half - 2.0 * ROUNDING_MM, half))
    order = np.lexsort([corners[:, :, 2].mean(axis=1), layer])
    seen = np.concatenate([corners.reshape(-1, 3), *(points @ part.view.T for points in part.attached)])
    middle = 0.5 * (seen.min(axis=0) + seen.max(axis=0))[:2]
    shade = 0.45 + 0.6 * np.clip(normals @ LIGHT_DIRECTION, 0.0, 1.0)
    colours = np.clip(shade[:, None] * np.array(LEG_COLOURS[part.design.kind]), 0.0, 1.0)[order]
    return _View(corners[order][:, :, :2] - middle + at, colours, middle)


def _draw_attachments(axes: Axes, part: Part, shift: Array) -> None:
    """Draw the arrow, the cap and the carried parts of a part, shifted by `shift` (x, y) in the picture."""
    if part.way:
        tail, tip = ((float(x), float(y)) for x, y in (part.arrow @ part.view.T)[:, :2] + shift)
        looks: Any = {"arrowstyle": "-|>", "color": "black", "mutation_scale": 12.0, "shrinkA": 0, "shrinkB": 0}
        axes.add_patch(FancyArrowPatch(tail, tip, linewidth=1.5, **looks))
    cap, carried = part.cap, {name: mesh.vertices @ part.view.T for name, mesh in part.carried.items()}
    if cap is None and not carried:
        return
    from scipy.spatial import ConvexHull

    if cap is not None:
        tile, squares = cap
        rim = (tile @ part.view.T)[:, :2] + shift
        axes.fill(*rim[ConvexHull(rim).vertices].T, facecolor="white", edgecolor="#808080", lw=0.5)
        marker = [(square @ part.view.T)[:, :2] + shift for square in squares]
        axes.add_collection(PolyCollection(marker, facecolors="black", edgecolors="black", lw=0.2))
    for name, outline in carried.items():
        hull = outline[ConvexHull(outline[:, :2]).vertices, :2] + shift
        axes.fill(*hull.T, facecolor=POCKET_COLOURS[name], edgecolor="black", linewidth=0.5, alpha=0.6)
        axes.annotate(name, hull.mean(axis=0), ha="center", va="center", fontsize=0.6 * LABEL_SIZE_PT)


def _triangles(part: Part) -> Array:
    """Return the triangles of a part for drawing, shape (n, 3, 3), mm."""
    vertices, triangles = part.mesh
    if part.design.parts:
        from trimesh.remesh import subdivide_to_size

        vertices, triangles = subdivide_to_size(vertices, triangles, MAX_EDGE_MM)
    return np.asarray(vertices[triangles])
