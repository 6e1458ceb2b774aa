"""Files for the printer from parts of any kind, called pieces, on one plate."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from walkergen.core import Design, Printer
from walkergen.core.printing import checks, export, packing, print_sheet, slicer
from walkergen.core.printing.findings import Finding
from walkergen.core.printing.packing import Part, Plate
from walkergen.core.printing.print_sheet import Load
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import mass

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DARK, LIGHT = "#0072B2", "#9ECAE1"
"""Alternating colours of pieces, distinguishable in grey."""

THUMBNAIL_DPI = 26
"""Dots per inch of the thumbnail in a 3MF file, from a map 10 inches wide."""


class Piece(NamedTuple):
    """Part as it lies on the bed, with the findings of its checks."""

    name: str
    mesh: Mesh
    label: str
    """Text on the map."""
    findings: Sequence[Finding]
    has_supports: bool = False
    """Whether it prints with supports."""


class Layout(NamedTuple):
    """Pieces arranged on a printer's bed."""

    printer: Printer
    pieces: Sequence[Piece]
    parts: Sequence[Part]
    plates: Sequence[Plate]
    findings: Sequence[Finding]
    has_supports: bool
    """Whether a piece prints with supports."""


def arrange(pieces: Sequence[Piece], printer: Printer, max_plates: int | None) -> Layout:
    """Return pieces arranged on at most `max_plates` plates, with the checks' findings. Raises PlateError."""
    parts = [Part.from_mesh(piece.name, piece.mesh, 1)._replace(supports=piece.has_supports) for piece in pieces]
    plates = packing.pack(parts, printer, max_plates)
    findings = [
        *checks.check_printer(printer),
        *(finding for piece in pieces for finding in piece.findings),
        *(
            finding
            for number, plate in enumerate(plates, start=1)
            for finding in checks.check_plate(f"plate {number}", plate, parts, printer)
        ),
    ]
    return Layout(printer, pieces, parts, plates, findings, any(piece.has_supports for piece in pieces))


def piece_loads(layout: Layout, density: float) -> list[Load]:
    """Return mass (g), density (g/cm^3) and side area of the plastic of each piece, as drawn."""
    return [
        Load(float(mass.weigh(piece.mesh, 1e-3 * density).mass), density, print_sheet.side_area(piece.mesh))
        for piece in layout.pieces
    ]


def plate_files(
    layout: Layout, design: Design, stem: str, pictures: bool, prusaslicer: bool
) -> Iterator[tuple[str, bytes]]:
    """Yield names and contents of files: settings, plates (3MF), pieces (STL) and, with `pictures`, maps."""
    start = f"{stem}_{layout.printer.name}"
    yield from slicer.settings_files(layout.printer, design.material, start, layout.has_supports)
    meshes = [piece.mesh for piece in layout.pieces]
    for number, plate in enumerate(layout.plates, start=1):
        name, picture = f"{start}_{number}", None
        if pictures:
            from walkergen.files import figures

            with figures.style({}):
                map_figure = _draw_map(layout, plate, name)
            picture = figures.png(map_figure, dpi=THUMBNAIL_DPI)
            yield f"{name}.png", figures.png(map_figure, dpi=130)
        suffix, data = packing.plate_file(plate, layout.parts, meshes, layout.printer, name, picture, prusaslicer)
        yield f"{name}{suffix}", data
    for piece in layout.pieces:
        yield f"{start}_stl/{piece.name}.stl", export.stl_bytes(piece.mesh, piece.name)


def _draw_map(layout: Layout, plate: Plate, title: str) -> "Figure":
    """Draw every piece of a plate at its position on the bed, from above, with its label."""
    from matplotlib.figure import Figure

    wide, deep = layout.printer.bed_width_mm, layout.printer.bed_depth_mm
    scale = 10.0 / max(wide, deep)
    width, height = scale * wide + 0.8, scale * deep + 0.9
    figure = Figure(figsize=(width, height))
    axes = figure.add_axes((0.65 / width, 0.5 / height, scale * wide / width, scale * deep / height))
    _draw_pieces(axes, layout, plate)
    axes.set_xlabel("x (mm), front")
    axes.set_ylabel("y (mm)")
    axes.set_title(f"{title}: {len(plate.placements)} parts", fontsize=10)
    _draw_labels(axes, layout, plate)
    return figure


def _draw_pieces(axes: "Axes", layout: Layout, plate: Plate) -> None:
    """Draw the silhouettes of a plate's pieces from above, in alternating colours, and the bed."""
    from matplotlib.collections import PolyCollection

    from walkergen.core.shapes import modeller
    from walkergen.sheets import plate_map

    for placed in plate.placements:
        mesh = layout.pieces[placed.part].mesh
        moved = mesh.shift(-mesh.vertices.min(axis=0))
        silhouette = plate_map.triangulate(modeller.to_solid(moved).project())
        colour = (DARK, LIGHT)[placed.part % 2]
        faces = list(silhouette + np.array((placed.x, placed.y)))
        axes.add_collection(PolyCollection(faces, facecolors=[colour], edgecolors=[colour], linewidths=0.3))
    plate_map.draw_bed(axes, layout.printer)


def _draw_labels(axes: "Axes", layout: Layout, plate: Plate) -> None:
    """Write the label of each piece on its upper edge, on white."""
    for placed in plate.placements:
        piece, part = layout.pieces[placed.part], layout.parts[placed.part]
        axes.annotate(
            piece.label,
            (placed.x + 0.5 * part.width, placed.y + part.depth),
            xytext=(0, -1),
            textcoords="offset points",
            ha="center",
            va="top",
            fontsize=7,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.9},
        )
