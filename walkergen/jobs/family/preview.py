"""Preview: a shaded picture of every part of a family, as in the paper's figure 1."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from walkergen.files.figures import COLOURS
from walkergen.walker.design import Design
from walkergen.walker.mass import Mesh

Array = npt.NDArray[np.float64]

FEWEST_COLUMNS, WIDEST_INCHES = 5, 24.0

ROUNDING_MM = 1e-6
"""Largest error, mm, of the heights of a mesh."""


class Part(NamedTuple):
    """Walker in the preview, as it stands."""

    design: Design
    mesh: Mesh

    @property
    def label(self) -> str:
        """Words below the picture: the tilt, unless every leg has its own, and the kind of legs."""
        kind = self.design.kind
        return f"{self.design.tilt_deg:g}° {kind}" if self.design.follows else kind

    @property
    def view(self) -> Array:
        """Camera that shows the shape: bodies in plan view from higher above."""
        return FROM_ABOVE if self.design.body.flat else VIEW


def _view(nod_deg: float) -> Array:
    """Rotation to the camera's frame (right, up, towards the viewer): from above, to the right."""
    turn, nod = np.radians(-28.0), np.radians(nod_deg)
    about_y = [[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]]
    about_x = [[1, 0, 0], [0, np.cos(nod), -np.sin(nod)], [0, np.sin(nod), np.cos(nod)]]
    return np.array(about_x) @ np.array(about_y)


VIEW, FROM_ABOVE = _view(16.0), _view(32.0)
LIGHT = np.array([-0.35, 0.75, 0.56])


def preview_figure(parts: Sequence[Part], title: str) -> Figure:
    """Draw all parts, braced above flexible, each with its label; rows grow with the family."""
    rows: list[list[Part]] = []
    most = max(FEWEST_COLUMNS, round(math.sqrt(1.2 * len(parts))))
    for kind in ("braced", "flexible"):
        chosen = [part for part in parts if part.design.kind == kind]
        rows += [chosen[i : i + most] for i in range(0, len(chosen), most)]
    screens = [part.mesh.vertices @ part.view.T for part in parts]
    size = np.max([np.ptp(screen, axis=0) for screen in screens], axis=0)
    pitch_x, pitch_y = 1.12 * size[0], 1.55 * size[1]
    columns = max(len(row) for row in rows)
    width = min(WIDEST_INCHES, 1.0 + 2.4 * columns)
    font = 9.0 * min(1.0, width / (2.4 * columns))
    aspect = (len(rows) * pitch_y + 0.2 * pitch_y) / (columns * pitch_x)
    figure = Figure(figsize=(width, width * aspect + 0.4), layout="constrained")
    axes = figure.add_subplot()
    for line, row in enumerate(rows):
        for column, part in enumerate(row):
            _draw(axes, part, np.array([column * pitch_x, -line * pitch_y]), size[1], font)
    axes.set_xlim(-0.55 * pitch_x, (columns - 0.45) * pitch_x)
    axes.set_ylim(-(len(rows) - 0.38) * pitch_y, 0.58 * pitch_y)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title(title, fontsize=11)
    return figure


def _draw(axes: Axes, part: Part, at: Array, height: float, font: float) -> None:
    """Draw a part by the painter's algorithm without back faces: exact enough for a prism.

    Of a body in plan view legs come first, below it, and its upper side last: nothing hides that.
    """
    standing = part.mesh.vertices[part.mesh.triangles]
    corners = standing @ part.view.T
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    facing = normals[:, 2] > 0
    corners, normals = corners[facing], normals[facing]
    storey = np.zeros(len(corners))
    if part.design.body.flat:
        half = 0.5 * part.design.size.thickness - ROUNDING_MM
        lowest = standing[facing][:, :, 1].min(axis=1)
        storey = np.digitize(lowest, (-half - 2.0 * ROUNDING_MM, half))
    order = np.lexsort([corners[:, :, 2].mean(axis=1), storey])
    middle = 0.5 * (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1)))[:2]
    shade = 0.45 + 0.6 * np.clip(normals @ LIGHT, 0.0, 1.0)
    colours = np.clip(shade[:, None] * np.array(COLOURS[part.design.kind]), 0.0, 1.0)[order]
    faces = PolyCollection(
        list(corners[order][:, :, :2] - middle + at),
        facecolors=colours, edgecolors=colours, linewidths=0.3,
    )  # fmt: skip
    axes.add_collection(faces)
    axes.annotate(part.label, (at[0], at[1] - 0.62 * height), ha="center", va="top", fontsize=font)
