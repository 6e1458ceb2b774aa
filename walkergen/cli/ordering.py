"""The commands that prepare a print: `check` and `plate`."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from walkergen.cli import options as opt
from walkergen.cli import show

if TYPE_CHECKING:
    from walkergen.batch import Checked, Room
    from walkergen.design import Design
    from walkergen.plates import Place
    from walkergen.printing.printers import Printer


def check(
    design: opt.DesignName = opt.PAPER,
    tilt: opt.Tilt = None,
    legs: opt.LegKinds = None,
    printer: opt.PrinterName = opt.PRINTER,
    copies: opt.Copies = "1",
    strict: opt.Strict = False,
    json: opt.AsJson = False,
) -> None:
    """Check whether walkers will print as designed, without writing any file."""
    from walkergen import batch, templates
    from walkergen.printing import checks
    from walkergen.printing.printers import Printer

    chosen = opt.design_of(design)
    machine = templates.load(printer, "printers", Printer)
    members, counts = opt.batch_of(chosen, tilt, legs, copies, whole=True)
    found = batch.check(members, counts, machine)
    if json:
        show.as_json({
            "walls": [wall._asdict() for wall in found.walls],
            "findings": [finding._asdict() for finding in checks.grouped(found.findings)],
            "parts": found.parts,
            "plates": found.plates,
        })  # fmt: skip
    else:
        _show_checked(found, machine)
    checks.refuse(found.findings, strict)


def plate(
    design: opt.DesignName = opt.PAPER,
    tilt: opt.Tilt = None,
    legs: opt.LegKinds = None,
    copies: opt.Copies = "1",
    printers: Annotated[
        str,
        typer.Option("--printer", metavar="PRINTER", help="Names or TOML files, commas between."),
    ] = opt.PRINTER,
    max_parts: opt.MaxParts = 5000,
    prusaslicer: opt.ForPrusaSlicer = False,
    max_plates: Annotated[
        int | None, typer.Option(min=1, max=1000, help="Refuse to use more plates than this.")
    ] = None,
    how_many: Annotated[
        bool, typer.Option("--how-many", help="Only say how many of each fit on one plate.")
    ] = False,
    strict: opt.Strict = False,
    out: opt.Out = None,
    pictures: Annotated[bool, typer.Option(help="Draw a map of every plate.")] = True,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Arrange copies of walkers on as many print-ready plates (3MF) as they need, with maps."""
    from walkergen import batch

    chosen = opt.design_of(design)
    members, counts = opt.batch_of(chosen, tilt, legs, copies, whole=False)
    machines = opt.printers_of(printers)
    if how_many:
        room = batch.how_many(members, machines, max_parts)
        if json:
            show.rows_as_json(room)
        else:
            _show_room(room)
        return
    folder = out or Path("out") / chosen.name
    order = batch.Order(
        members, counts, machines, max_plates, max_parts, pictures, prusaslicer, strict
    )
    with show.progress(chosen.name, wanted=not quiet) as progress:
        tell = partial(show.warnings, quiet=quiet)
        rows, files = batch.make_plates(order, folder, progress, tell)
    if json:
        show.rows_as_json(rows, files=files)
    elif not quiet:
        _show_placements(rows, files, chosen)


def _show_placements(rows: "Sequence[Place]", paths: Sequence[Path], design: "Design") -> None:
    """Print how many copies of each part lie on each plate, the files, and how to read marks."""
    from collections import Counter

    from walkergen.report import tables

    counts = Counter((row.printer, row.plate, row.name, row.mark) for row in rows)
    for printer, number in dict.fromkeys((row.printer, row.plate) for row in rows):
        print(f"{printer}, plate {number}")
        for (machine, plate, name, mark), count in counts.items():
            if (machine, plate) == (printer, number):
                print(f"  {count:4d} x {name}" + (f"  {mark}" if mark else ""))
    print("\n".join(str(path) for path in paths))
    for printer in dict.fromkeys(row.printer for row in rows):
        own = [row.plate for row in rows if row.printer == printer]
        count = max(own)
        print(f"{printer}: {len(own)} parts on {count} plate{'s' if count > 1 else ''}")
    if legend := tables.legend_caption(design):
        print(legend)


def _show_room(rows: "Sequence[Room]") -> None:
    """Print how many copies fit on one plate."""
    for row in rows:
        print(f"{row.printer:14s}  {row.fit:5d} x {row.name}")


def _show_checked(found: "Checked", printer: "Printer") -> None:
    """Print how walls come out in lines, warnings and advice; errors follow as such."""
    from walkergen.printing import checks

    print(f"{'wall':8s}{'mm':>8s}{'lines':>8s}{'plastic':>10s}   (expected, against the mesh)")
    for wall in found.walls:
        percent = round(wall.plastic_percent)
        plastic = f"{percent:+d} %" if percent else "as drawn"
        print(f"{wall.wall:8s}{wall.thickness_mm:8.2f}{wall.lines:8.2f}{plastic:>10s}")
    findings = checks.grouped(found.findings)
    for finding in findings:
        if finding.level != "error":
            print(f"{finding.level}: {checks.line(finding)}")
    told = [
        _count(sum(finding.level == level for finding in findings), level)
        for level in ("error", "warning")
    ]
    parts, plates = _count(found.parts, "part"), _count(found.plates, "plate")
    print(f"{parts} on {plates} of {printer.name}: {', '.join(told)}")


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


ALL = (check, plate)
