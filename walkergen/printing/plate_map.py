"""Plate map: every part at its place on the bed, from above, with its design, tilt and copy."""

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from walkergen.files import figures
from walkergen.printing.packing import Plate
from walkergen.printing.printers import Printer
from walkergen.walker import names
from walkergen.walker.design import Design
from walkergen.walker.mass import Mesh

Array = npt.NDArray[np.float64]

INCHES = 10.0
"""Longer side of the bed in the picture, inches."""
LINE_INCHES = 0.17
"""Height of a line of words below the picture, inches."""
MOST_LISTED = 12
"""Most designs whose names stand below a map; the print sheet names all."""
THUMBNAIL_INCHES, THUMBNAIL_DPI = 2.56, 100


def png(
    printer: Printer, members: Sequence[Design], meshes: Sequence[Mesh], one: Plate, title: str
) -> bytes:
    """Draw the map of one plate as PNG; labels are the tilt in degrees and the copy's number.

    Where `members` are of several designs, labels begin with the design's letter.
    """
    letters = names.letters(members)
    used = [members[part].name for part in sorted({placed.part for placed in one.placements})]
    named = _named({name: letters[name] for name in used if letters})
    scale = INCHES / max(printer.bed_width_mm, printer.bed_depth_mm)
    below = LINE_INCHES * len(named)
    size = scale * printer.bed_width_mm + 0.8, scale * printer.bed_depth_mm + 0.9 + below
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.add_subplot()
    _draw_parts(axes, printer, members, meshes, one)
    _label_parts(axes, members, meshes, one, scale)
    axes.set_xlabel("\n".join(("x (mm), front", *named)))
    axes.set_ylabel("y (mm)")
    told = "design, tilt (deg) - copy" if letters else "tilt (deg) - copy"
    axes.set_title(f"{title}: {len(one.placements)} parts; {told}", fontsize=10)
    figure.legend(loc="outside upper right", ncols=2, frameon=False, fontsize=9)
    return figures.png(figure, 130)


def thumbnail(
    printer: Printer, members: Sequence[Design], meshes: Sequence[Mesh], one: Plate
) -> bytes:
    """Draw a small picture of the plate without words: PNG, 256 pixels wide."""
    size = THUMBNAIL_INCHES, THUMBNAIL_INCHES * printer.bed_depth_mm / printer.bed_width_mm
    figure = Figure(figsize=size)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    _draw_parts(axes, printer, members, meshes, one)
    axes.set_axis_off()
    return figures.png(figure, THUMBNAIL_DPI)


def _draw_parts(
    axes: Axes, printer: Printer, members: Sequence[Design], meshes: Sequence[Mesh], one: Plate
) -> None:
    undersides = {part: _underside(meshes[part]) for part in {p.part for p in one.placements}}
    for kind, colour in figures.COLOURS.items():
        triangles = [
            undersides[placed.part] + (placed.x, placed.y)
            for placed in one.placements
            if members[placed.part].kind == kind
        ]
        if triangles:
            faces = PolyCollection(
                list(np.concatenate(triangles)),
                facecolors=[colour], edgecolors=[colour], linewidths=0.3, label=f"{kind} legs",
            )  # fmt: skip
            axes.add_collection(faces)
    bed = printer.bed_width_mm, printer.bed_depth_mm
    axes.add_patch(Rectangle((0.0, 0.0), *bed, fill=False, edgecolor="0.4"))
    axes.set_xlim(-0.01 * bed[0], 1.01 * bed[0])
    axes.set_ylim(-0.01 * bed[1], 1.01 * bed[1])
    axes.set_aspect("equal")


def _underside(mesh: Mesh) -> Array:
    """Triangles that lie on the bed, shape (k, 3, 2), mm, from the bounding box's corner."""
    corners = (mesh.vertices - mesh.vertices.min(axis=0))[mesh.triangles]
    lying: Array = corners[(corners[:, :, 2] == 0.0).all(axis=1)][:, :, :2]
    return lying


def _named(letters: Mapping[str, str]) -> list[str]:
    """Lines that say which letter stands for which design (letters by designs' names)."""
    listed = [f"{letter}: {name}" for name, letter in letters.items()]
    more = len(listed) - MOST_LISTED
    return listed[:MOST_LISTED] + ([f"and {more} more: see the print sheet"] if more > 0 else [])


def _label_parts(
    axes: Axes, members: Sequence[Design], meshes: Sequence[Mesh], one: Plate, scale: float
) -> None:
    """Write a label for each part in the room between its legs, as large as fits."""
    letters = names.letters(members)
    for placed in one.placements:
        design, mesh = members[placed.part], meshes[placed.part]
        left, bottom = mesh.vertices[:, :2].min(axis=0)
        below = 0.5 * (-bottom - 0.5 * design.size.thickness)
        label = f"{letters.get(design.name, '')}{design.tilt_deg:g}-{placed.copy}"
        width = 0.8 * design.foot_span / (0.65 * len(label))
        axes.text(
            placed.x - left, placed.y + below, label,
            ha="center", va="center", fontsize=min(72.0 * scale * min(below, width), 9.0),
        )  # fmt: skip
