"""Copies of walkers arranged on plates: 3MF files, maps, print sheets, and forms to enter weighed masses."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

from walkergen import sheets
from walkergen.commands.plate import order_list
from walkergen.commands.plate.request import PlateRequest
from walkergen.core.errors import InputError
from walkergen.core.files import output
from walkergen.core.files.assignments import replace_values
from walkergen.core.files.output import Folder
from walkergen.core.files.progress import Progress
from walkergen.core.printing import packing, plates, print_sheet
from walkergen.core.printing.findings import check_printable, combine_printers, warning_lines
from walkergen.core.printing.plates import CopyPosition
from walkergen.core.printing.printers import Printer
from walkergen.core.walker import names, solids, weighed_masses
from walkergen.core.walker.design import Design
from walkergen.files import report
from walkergen.files.report import Report, Table
from walkergen.inputs import add_caps, filled_form_warnings
from walkergen.request import PAPER_WALKER
from walkergen.sheets import cap_files
from walkergen.sheets.cap_files import CappedWalker

MAX_NAMED_WALKERS = 3
"""Maximum number of walkers that the headline names."""


class PlateInputs(NamedTuple):
    """Walkers, numbers of copies and printers of a request, read from files."""

    members: Sequence[Design]
    copies: Sequence[int]
    """Number of copies of each member."""
    printers: Sequence[Printer]
    """Printers to arrange for; each prints all copies."""
    name: str
    """Name of the design or of the order list, and of the default folder."""


class Capacity(NamedTuple):
    """Number of copies of one walker that fit on one plate."""

    printer: str
    name: str
    fit: int


class PlateRow(NamedTuple):
    """Row of the table of plates: number of copies of one walker on one plate."""

    printer: str
    plate: int
    copies: int
    name: str
    marks: str
    """Engraved marks of the first and the last copy."""


@dataclass(frozen=True, kw_only=True, repr=False)
class PlateReport(Report):
    """Position of each copy on its plate, and the written files."""

    places: Sequence[CopyPosition]


def count_fitting(members: Sequence[Design], printers: Sequence[Printer], max_parts: int) -> Report:
    """Return a report of how many copies of each member fit on one plate of each printer, without other walkers."""
    built = [solids.build(design) for design in members]
    rows = [
        Capacity(layout.printer.name, part.name, min(packing.capacity(part, layout.printer), max_parts))
        for printer in printers
        for layout in [plates.layout_without_plates(members, built, [1] * len(built), printer)]
        for part in layout.parts
    ]
    columns = (
        report.text_column("printer", "printer"),
        report.number_column("fit", "fit"),
        report.text_column("walker", "name"),
    )
    return Report(
        name="room",
        title="Copies that fit on one plate",
        headline=_capacity_headline(rows),
        tables=[report.table_from_rows("room", rows, columns)],
        facts={"rows": [row._asdict() for row in rows]},
    )


def _capacity_headline(rows: Sequence[Capacity]) -> str:
    """Return a sentence with the number of copies that fit on one plate: each of a few walkers, or a range for many."""
    if len(rows) > MAX_NAMED_WALKERS:
        fits = [row.fit for row in rows]
        return f"one plate holds {min(fits)} to {max(fits)} copies of a walker"
    return f"one plate holds {' or '.join(f'{row.fit} of {row.name} ({row.printer})' for row in rows)}"


def read_inputs(request: PlateRequest) -> PlateInputs:
    """Read the walkers of a request, from one design or from an order list. Raises InputError."""
    given = request.inputs()
    if request.orders is None:
        design = given.design(request.design or PAPER_WALKER)
        members, copies = given.batch(design, request.tilt, request.legs, request.copies, whole=False)
        name = design.name
    else:
        problem = "cannot be combined with ‹orders›, whose list has designs, tilts, legs and copies"
        request.check_unset(problem, "design", "tilt", "legs", "copies")
        if "copies" in request.model_fields_set:  # 1, as by default, may contradict the list
            raise InputError(f"‹copies=›{request.copies}: {problem}. Remove it.", "copies")
        given.check_unset(given.keys_of("design"), f"{problem}. Remove it.")
        members, copies = order_list.read_orders(request.orders)
        name = output.safe_folder_name(request.orders)
    return PlateInputs(add_caps(members, request.caps), copies, given.printers(request.printer), name)


def run(request: PlateRequest, progress: Progress) -> Report:
    """Arrange the copies of a request, or count how many fit on a plate."""
    inputs = read_inputs(request)
    if request.how_many:
        return count_fitting(inputs.members, inputs.printers, request.max_parts)
    return make(request, inputs, progress)


def make(request: PlateRequest, inputs: PlateInputs, progress: Progress) -> PlateReport:
    """Arrange copies for every printer. Write 3MF files, maps, print sheets and weights.csv.

    Members of several designs share plates, but each design has its weights_DESIGN.csv. Plates of an earlier run for
    the same printer that this run does not make are removed, unless they were changed since.

    Raises
    ------
    PlateError
        Before anything is written, if a part is too large for a printer, or if too many plates are needed.
    PrintabilityError
        Before anything is written, if a part would not print, or with `strict` would differ from the prediction.
    """
    members, copies = number_copies(request.serial, inputs.members, inputs.copies)
    built = [solids.build(design) for design in members]
    layouts = [
        plates.arrange(members, built, copies, printer, request.max_plates, request.max_parts)
        for printer in inputs.printers
    ]
    capped = _list_caps(layouts[0])
    findings = combine_printers(
        [(one.printer.name, [*one.findings, *cap_files.findings(capped, one.printer)]) for one in layouts]
    )
    check_printable(findings, request.strict)
    folder = request.out or Path("out") / inputs.name
    paths = _write_plates(request, layouts, folder, progress)
    if capped:
        cap_sheets = list(cap_files.files(capped, inputs.printers))
        with Folder(folder / "caps", "caps.json") as target:
            for name, data in cap_sheets:
                target.write(name, data)
                paths.append(target.path / name)
            target.finish({"caps": [entry.cap.model_dump(mode="json") for entry in capped]})
            paths.append(target.path / target.manifest)
    rows = [row for layout in layouts for row in plates.list_copy_positions(layout)]
    paths += _write_forms(inputs.members, rows, folder)
    report = _report(request.serial, inputs, rows, paths, cap_files.advice(capped) if capped else [])
    return replace(report, warnings=[*warning_lines(findings), *filled_form_warnings(folder, inputs.members)])


def _write_plates(
    request: PlateRequest, layouts: Sequence[plates.Layout], folder: Path, progress: Progress
) -> list[Path]:
    """Write the files of the plates of every printer, and return their paths."""
    steps = sum(plates.COMMON_FILE_COUNT + len(layout.plates) * (1 + request.pictures) + 1 for layout in layouts)
    draw = sheets.plate_drawing() if request.pictures else None
    paths: list[Path] = []
    for layout in layouts:
        # Each printer has a manifest, so that plates for one do not remove those for another
        with Folder(folder / "plates", f"plate_{layout.printer.name}.json") as target:
            for name, data in plates.layout_files(layout, "plate", draw, request.prusaslicer):
                target.write(name, data)
                paths.append(target.path / name)
                progress(name, len(paths), steps)
            target.finish(_facts(layout))
            paths.append(target.path / target.manifest)
            progress(target.manifest, len(paths), steps)
    return paths


def _list_caps(layout: plates.Layout) -> list[CappedWalker]:
    """Return the caps of all copies in the order of their numbers on the map. Raises InputError."""
    placements = [placement for plate in layout.plates for placement in plate.placements]
    items = [packing.item_name(layout.parts[place.part], place.copy) for place in placements]
    return cap_files.number_caps([layout.members[place.part] for place in placements], items)


def _report(
    serial: int | None, inputs: PlateInputs, rows: Sequence[CopyPosition], files: Sequence[Path], caps: Sequence[str]
) -> PlateReport:
    """Make the report of the contents of each plate, the meaning of the marks, and the caps."""
    columns = [
        report.text_column("printer", "printer"),
        report.text_column("plate", "plate"),
        report.text_column("copies", "copies"),
        report.text_column("walker", "name"),
    ]
    if any(row.mark for row in rows):
        columns.append(report.text_column("marks", "marks"))
    advice = dict.fromkeys(names.reading_instructions(design.marks) for design in inputs.members)
    lines = [text for text in advice if text]
    of_plates = [path for path in files if path.parent.name == "plates"]
    if serial is not None:
        last = serial + sum(inputs.copies) - 1
        lines.append(f"Copies are numbered {serial} to {last}. The number is the last in each mark.")
    lines += caps
    return PlateReport(
        name="plates",
        title="Plates",
        headline=_headline(rows),
        lines=lines,
        places=rows,
        files=files,
        tables=[Table("plates", list(_copies_by_plate(rows)), (), columns)],
        facts={"rows": [row._asdict() for row in rows], "files": [str(path) for path in files]},
        next_step=report.format_next_step(
            [path for path in of_plates if path.suffix == ".png"],
            [path for path in of_plates if path.suffix in (".3mf", ".stl")],
        ),
    )


def _headline(rows: Sequence[CopyPosition]) -> str:
    """Return a sentence with the number of parts and the number of plates for each printer."""
    found = []
    for printer in dict.fromkeys(row.printer for row in rows):
        numbers = [row.plate for row in rows if row.printer == printer]
        count, parts = max(numbers), len(numbers)
        found.append(f"{parts} part{'s' * (parts > 1)} on {count} plate{'s' * (count > 1)} of {printer}")
    return "; ".join(found)


def _copies_by_plate(rows: Sequence[CopyPosition]) -> Iterator[PlateRow]:
    """Yield the number of copies of each walker on each plate, one row each."""
    marks: dict[tuple[str, int, str], list[str]] = {}
    for row in rows:
        marks.setdefault((row.printer, row.plate, row.name), []).append(row.mark)
    for (printer, number, name), copies in marks.items():
        yield PlateRow(printer, number, len(copies), name, names.mark_range(copies))


def number_copies(
    serial: int | None, members: Sequence[Design], copies: Sequence[int]
) -> tuple[Sequence[Design], Sequence[int]]:
    """Return members and numbers of copies, with serial numbers engraved if `serial` is not None.

    Every copy is then a separate member. Their numbers count from `serial` over all members. Raises GeometryError for
    a copy that is too small for its number, InputError for too large a number.
    """
    if serial is None:
        return members, copies
    packing.check_part_count(sum(copies))
    designs = [design for design, count in zip(members, copies, strict=True) for _ in range(count)]
    numbered = [
        replace_values(design, _number_settings(design, number), design.name)
        for number, design in enumerate(designs, start=serial)
    ]
    return numbered, [1] * len(numbered)


def _number_settings(design: Design, number: int) -> dict[str, int]:
    """Return values by key that give a copy its number: on its body, and on its cap if it has one."""
    on_cap = {} if design.cap is None else {"cap.number": number}
    return {"marks.serial": number, **on_cap}


def _facts(layout: plates.Layout) -> dict[str, Any]:
    """Return the facts of a printer's manifest: resolved inputs, findings, software versions."""
    by_name = names.group_by_design(layout.members)
    return {
        # Of several members of a design the first: names tell the tilts and kinds of the others.
        "designs": {name: members[0].model_dump(mode="json") for name, members in by_name.items()},
        "bodies": {name: print_sheet.body_facts(members[0]) for name, members in by_name.items()},
        "members": [part.name for part in layout.parts],
        "copies": [part.copies for part in layout.parts],
        "serial": [part.serial for part in layout.parts if part.serial is not None],
        "printer": layout.printer.model_dump(mode="json"),
        "print": print_sheet.manifest_facts(layout.printer, layout.findings, any(layout.supported)),
        "versions": output.versions(),
    }


def _write_forms(members: Sequence[Design], rows: Sequence[CopyPosition], folder: Path) -> list[Path]:
    """Write a form for weighed masses for each design, except where a user has filled it in. Return the paths."""
    designs_by_name = dict(zip(names.part_names(members), members, strict=True))
    items: dict[str, dict[str, None]] = {}
    for row in rows:  # with several printers a copy has several rows
        items.setdefault(designs_by_name[row.name].name, {})[row.item] = None
    written = []
    for name, copies in items.items():
        form_rows = [*copies, *weighed_masses.carried_rows(names.group_by_design(members)[name][0])]
        written.append(weighed_masses.write_form(folder, form_rows, weighed_masses.form_name(members, name)))
    return [path for path in written if path is not None]
