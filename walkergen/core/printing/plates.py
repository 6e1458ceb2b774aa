"""Plates of walkers as files: 3MF with a thumbnail, a picture that names every part, a CSV map."""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from walkergen.core.files.tables import csv_text
from walkergen.core.printing import checks, packing, print_sheet, slicer, supports
from walkergen.core.printing.findings import Finding
from walkergen.core.printing.printers import Printer
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import names, solids, weighed_masses
from walkergen.core.walker.design import Design
from walkergen.core.walker.solids import Solids

DrawPlate = Callable[[Printer, Sequence[Design], Sequence[Mesh], packing.Plate, str], tuple[bytes, bytes]]
"""Function that draws a plate, of this title: its map and its thumbnail, PNG both."""

COMMON_FILE_COUNT = 5
"""Number of files of a layout apart from those of each plate."""


class CopyPosition(NamedTuple):
    """Position of one copy; the field names are the columns of a map."""

    printer: str
    plate: int
    """Number of the plate, from 1."""
    item: str
    """Name of the copy, as in the 3MF file."""
    name: str
    """Name of the part, as in stl/; of several designs it begins with the design's name."""
    tilt_deg: float
    legs: str
    mark: str
    copy: int
    x_mm: float
    """Left side of the bounding box, from the left edge of the bed, mm."""
    y_mm: float
    """Front side of the bounding box, from the front edge of the bed, mm."""
    width_mm: float
    depth_mm: float


class Layout(NamedTuple):
    """Arrangement of copies of walkers for one printer."""

    printer: Printer
    """Printer, with a brim if a member needs one."""
    members: Sequence[Design]
    built: Sequence[Solids]
    """Solids of the members, in their order."""
    meshes: Sequence[Mesh]
    """Meshes of the members as they lie on the bed, in their order."""
    parts: Sequence[packing.Part]
    """Bounding boxes and copies of the members, in their order."""
    plates: Sequence[packing.Plate]
    findings: Sequence[Finding]
    """Findings of the printability checks on parts and plates."""
    supported: Sequence[bool]
    """Whether each member prints with supports, in their order. The print settings are those of all plates."""


def arrange(
    members: Sequence[Design],
    built: Sequence[Solids],
    copies: Sequence[int],
    printer: Printer,
    max_plates: int | None = None,
    max_parts: int = packing.MAX_PARTS,
) -> Layout:
    """Arrange copies of walkers (`members`, whose solids are `built`) on plates, and check them. Raises PlateError."""
    empty = layout_without_plates(members, built, copies, printer)
    return add_findings(empty._replace(plates=packing.pack(empty.parts, empty.printer, max_plates, max_parts)))


def layout_without_plates(
    members: Sequence[Design], built: Sequence[Solids], copies: Sequence[int], printer: Printer
) -> Layout:
    """Return the layout, without plates and findings, of walkers with solids `built` and these numbers of copies."""
    meshes = orient_for_print(members, built)
    supported = [supports.is_needed(design, mesh) for design, mesh in zip(members, meshes, strict=True)]
    rows = zip(members, names.part_names(members), meshes, copies, supported, strict=True)
    parts = [
        packing.Part.from_mesh(name, mesh, count, design.marks.serial if count == 1 else None)._replace(
            supports=is_on, run_direction=design.run_direction
        )
        for design, name, mesh, count, is_on in rows
    ]
    return Layout(supports.add_brim(printer, meshes, supported), members, built, meshes, parts, [], [], supported)


def orient_for_print(members: Sequence[Design], built: Sequence[Solids]) -> list[Mesh]:
    """Return the meshes of walkers, whose solids are `built`, turned as they lie on the bed, in the same order."""
    return [
        solids.orient_for_print(design, built_solids.walker)
        for design, built_solids in zip(members, built, strict=True)
    ]


def add_findings(layout: Layout) -> Layout:
    """Run the printability checks on a layout, and return it with their findings."""
    findings = checks.check_batch(layout.members, layout.meshes, layout.parts, layout.plates, layout.printer)
    return layout._replace(findings=findings)


def list_copy_positions(layout: Layout) -> list[CopyPosition]:
    """List the positions of all copies on their plates, plate by plate. They are the rows of the plates' map."""
    rows = []
    for number, plate in enumerate(layout.plates, start=1):
        for placed in plate.placements:
            design, part = layout.members[placed.part], layout.parts[placed.part]
            item = packing.item_name(part, placed.copy)
            lengths = (placed.x, placed.y, part.width, part.depth)
            row = CopyPosition(
                layout.printer.name,
                number,
                item,
                part.name,
                design.tilt_deg,
                design.kind,
                design.mark,
                placed.copy,
                *(round(length, 6) for length in lengths),
            )
            rows.append(row)
    return rows


def layout_files(
    layout: Layout, stem: str, draw: DrawPlate | None, prusaslicer: bool = False
) -> Iterator[tuple[str, bytes]]:
    """Yield the name and the bytes of each file of a layout: COMMON_FILE_COUNT on all plates, then those of each plate.

    STEM_PRINTER.csv is the map and STEM_PRINTER.md the print sheet. STEM_PRINTER.ini holds the settings for
    PrusaSlicer, with printer and filament to load it alone. STEM_PRINTER_print.ini omits these. STEM_PRINTER_orca.json
    holds the settings for OrcaSlicer and Bambu Studio. STEM_PRINTER_NUMBER.3mf (.stl without lib3mf) is a plate. `draw`
    adds STEM_PRINTER_NUMBER.png and a view of the plate from above as each 3MF file's thumbnail. `prusaslicer` declares
    3MF files to be PrusaSlicer's own.
    """
    start = f"{stem}_{layout.printer.name}"
    meshes = layout.meshes
    yield f"{start}.csv", to_csv(list_copy_positions(layout)).encode()
    yield f"{start}.md", _print_sheet(layout, start).encode()
    yield from slicer.settings_files(layout.printer, layout.members[0].material, start, any(layout.supported))
    for number, plate in enumerate(layout.plates, start=1):
        name = f"{start}_{number}"
        thumbnail = None
        if draw:
            picture, thumbnail = draw(layout.printer, layout.members, meshes, plate, name)
            yield f"{name}.png", picture
        suffix, data = packing.plate_file(plate, layout.parts, meshes, layout.printer, name, thumbnail, prusaslicer)
        yield f"{name}{suffix}", data


def _print_sheet(layout: Layout, stem: str) -> str:
    """Return the Markdown of the layout's print sheet. Names of its files begin with `stem`."""
    weighed = [
        print_sheet.expected_masses(part.name, design, built_solids, layout.printer)
        for part, design, built_solids in zip(layout.parts, layout.members, layout.built, strict=True)
    ]
    form = weighed_masses.form_name(layout.members, "DESIGN")
    printed = print_sheet.Batch(
        stem, layout.printer, layout.members, layout.plates, layout.parts, form, layout.supported
    )
    legend = names.legend(layout.members)
    return print_sheet.to_markdown(printed, weighed, layout.findings, legend)


def to_csv(rows: Sequence[CopyPosition]) -> str:
    """Format the positions of copies as CSV, the plates' map. Lengths are exact to a nanometre."""
    return csv_text(CopyPosition._fields, rows)
