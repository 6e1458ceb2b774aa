"""Calibration plate: strips, block and walker arranged for a printer, with sheet and form."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from walkergen.core import Design, Printer
from walkergen.core.files import output
from walkergen.core.files.output import Folder
from walkergen.core.files.progress import Progress
from walkergen.core.files.tables import csv_text
from walkergen.core.printing import checks, packing, print_sheet, supports
from walkergen.core.printing.findings import Finding, check_printable, combine_printers
from walkergen.core.printing.walls import Wall
from walkergen.core.walker import solids
from walkergen.files import report
from walkergen.files.report import Report, Table
from walkergen.guests.lab.calibrate import form, parts, plate_files
from walkergen.guests.lab.calibrate import sheet as measuring
from walkergen.guests.lab.calibrate.fields import CalibrateFields
from walkergen.guests.lab.calibrate.parts import DrawnStrip
from walkergen.guests.lab.calibrate.plate_files import Layout, Piece

STEM = "calibration"


class PartPosition(NamedTuple):
    """Position of a part; the field names are the columns of a map."""

    printer: str
    plate: int
    """Number of the plate, from 1."""
    item: str
    """Name of the copy, as in the 3MF file."""
    x_mm: float
    """Left side of the bounding box, from the left edge of the bed, mm."""
    y_mm: float
    """Front side of the bounding box, from the front edge of the bed, mm."""
    width_mm: float
    depth_mm: float


def make_plate(
    request: CalibrateFields,
    design: Design,
    printers: Sequence[Printer],
    folder: Path,
    progress: Progress,
    report_findings: Callable[[Sequence[Finding]], None],
) -> Report:
    """Write a calibration plate for every printer, and the empty form, into folder/calibration. Return the report.

    Its strips are made for the material and leg of `design`, the walker of the drop test. Each printer gets 3MF and STL
    files, a map, settings, and a sheet on printing and measuring. An edited form is kept. `report_findings` is called
    with the checks' findings. Raises, before anything is written, PlateError for parts that do not fit and
    PrintabilityError for those that would not print.
    """
    drawings = [(parts.make_strips(design, printer), printer) for printer in printers]
    layouts = [
        plate_files.arrange(_make_pieces(design, strips, printer), printer, request.max_plates)
        for strips, printer in drawings
    ]
    findings = combine_printers([(batch.printer.name, batch.findings) for batch in layouts])
    report_findings(findings)
    check_printable(findings, request.strict)
    paths: list[Path] = []
    for number, ((strips, printer), batch) in enumerate(zip(drawings, layouts, strict=True)):
        progress(printer.name, number, len(layouts))
        paths += _write_printer_files(request, design, strips, batch, folder / STEM)
    path = folder / STEM / form.FORM_FILE
    first, machine = drawings[0]
    air = {strip.name: parts.air_percent(strip, machine) for strip in first}
    if form.write_empty_form(path, air):
        paths.append(path)
    return _make_report([row for batch in layouts for row in _locate_parts(batch)], paths, path)


def _make_report(rows: Sequence[PartPosition], files: Sequence[Path], form_path: Path) -> Report:
    """Return the report of the parts on each plate and of the next steps."""
    columns = (
        report.text_column("printer", "printer"),
        report.text_column("plate", "plate"),
        report.text_column("part", "item"),
    )
    return Report(
        name="calibration",
        title="Calibration plate",
        tables=[Table("calibration", rows, (), columns)],
        facts={"rows": [row._asdict() for row in rows], "files": [str(path) for path in files]},
        lines=[f"measure as in the sheet (.md), fill in the form (.csv), then run: walkergen calibrate {form_path}"],
        files=files,
    )


def _make_pieces(design: Design, strips: Sequence[DrawnStrip], printer: Printer) -> list[Piece]:
    """Return strips, block and walker as they lie on the bed, each with the findings of its checks."""
    checked = []
    for part in strips:
        mesh, strip = parts.strip_mesh(part), part.strip
        wall = Wall("strip", strip.thickness, slant=1.0, height=strip.width)
        seen = checks.check_piece(part.name, [wall], mesh, printer)
        label = f"{part.name}: {strip.thickness:g} mm"
        checked.append(Piece(part.name, mesh, label, seen))
    mesh = parts.block_mesh(printer)
    checked.append(Piece("block", mesh, "block", checks.check_piece("block", [], mesh, printer)))
    mesh = solids.orient_for_print(design, solids.build(design).walker)
    seen = checks.check_part("walker", design, mesh, printer)
    return [*checked, Piece("walker", mesh, f"walker, {design.tilt_deg:g} deg", seen, supports.is_needed(design, mesh))]


def _write_printer_files(
    request: CalibrateFields, design: Design, strips: Sequence[DrawnStrip], layout: Layout, folder: Path
) -> list[Path]:
    """Write the files of one printer and return their paths."""
    start = f"{STEM}_{layout.printer.name}"
    with Folder(folder, f"{start}.json") as target:
        rows = csv_text(PartPosition._fields, _locate_parts(layout))
        for name, data in (
            (f"{start}.csv", rows.encode()),
            (f"{start}.md", _format_sheet(design, strips, layout, start).encode()),
            *plate_files.plate_files(layout, design, STEM, request.pictures, request.prusaslicer),
        ):
            target.write(name, data)
        target.finish(_facts(design, strips, layout))
    return [folder / name for name in (*target.hashes, target.manifest)]


def _format_sheet(design: Design, strips: Sequence[DrawnStrip], layout: Layout, stem: str) -> str:
    """Return the sheet on printing and measuring, as Markdown. `stem`: start of the names of its files."""
    batch = print_sheet.Batch(
        stem, layout.printer, [design], layout.plates, layout.parts, form.FORM_FILE, [layout.has_supports]
    )
    loads = plate_files.piece_loads(layout, design.material.density_g_cm3)
    printing = print_sheet.format_print_section(batch, loads, layout.findings, legend="")
    return f"{printing}\n\n{measuring.to_markdown(strips, design, layout.printer)}"


def _locate_parts(layout: Layout) -> list[PartPosition]:
    """Return the position of each part on each plate of a layout."""
    rows = []
    for number, plate in enumerate(layout.plates, start=1):
        for placement in plate.placements:
            part = layout.parts[placement.part]
            item = packing.item_name(part, placement.copy)
            lengths = (placement.x, placement.y, part.width, part.depth)
            rows.append(PartPosition(layout.printer.name, number, item, *(round(length, 6) for length in lengths)))
    return rows


def _facts(design: Design, strips: Sequence[DrawnStrip], layout: Layout) -> dict[str, Any]:
    """Return facts for the manifest: resolved inputs, drawn parts, findings, versions."""
    return {
        "design": design.model_dump(mode="json"),
        "bodies": {design.name: print_sheet.body_facts(design)},
        "printer": layout.printer.model_dump(mode="json"),
        "strips": {part.name: part.strip._asdict() for part in strips},
        "print": print_sheet.manifest_facts(layout.printer, layout.findings, layout.has_supports),
        "versions": output.versions(),
    }
