"""Printability checks of walkers on arranged plates: wall thicknesses in printed lines, and findings."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from walkergen.core.printing import packing, plates, print_sheet, walls
from walkergen.core.printing.findings import Finding, group_findings
from walkergen.core.printing.printers import Printer
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import report
from walkergen.files.report import Report, Table


class Wall(NamedTuple):
    """Wall thickness of the checked walkers, and how the printer prints it. `wall`: name of the wall."""

    wall: str
    thickness_mm: float
    lines: float
    """Thickness of the wall in printed lines."""
    plastic_percent: float
    """Expected volume of plastic in the wall, more (+) or less (-) than in the mesh, percent."""


@dataclass(frozen=True, kw_only=True, repr=False)
class CheckReport(Report):
    """Wall thicknesses of walkers, and the findings of the printability checks."""

    findings: Sequence[Finding]


def check(members: Sequence[Design], copies: Sequence[int], printer: Printer) -> CheckReport:
    """Return the report of the printability checks on copies of the members, arranged on plates. Writes no file."""
    built = [solids.build(design) for design in members]
    layout = plates.layout_without_plates(members, built, copies, printer)
    if all(packing.capacity(part, layout.printer) for part in layout.parts):
        layout = plates.arrange(members, built, copies, printer)
    else:  # a part is too large for any plate: the findings name it
        layout = plates.add_findings(layout)
    distinct_walls = dict.fromkeys(
        Wall(
            wall.name,
            wall.thickness,
            wall.thickness_in_layer / printer.line_width_mm,
            100.0 * walls.plastic_deviation(wall.thickness_in_layer, printer),
        )
        for design in members
        for wall in walls.upright_walls(design)
    )
    orientations = list(dict.fromkeys(map(print_sheet.describe_orientation, members, layout.supported)))
    return _report(list(distinct_walls), layout, orientations, sum(copies))


def _report(rows: Sequence[Wall], layout: plates.Layout, orientations: Sequence[str], parts: int) -> CheckReport:
    """Make the report of the walls, the walkers' orientations on the bed, and all findings."""
    findings, printer = group_findings(layout.findings), layout.printer.name
    counts = [
        _format_count(sum(finding.level == level for finding in findings), level) for level in ("error", "warning")
    ]
    sheets = len(layout.plates)  # none when a part fits no plate
    return CheckReport(
        name="check",
        title=f"Checks for {printer}",
        tables=[
            Table(
                "walls",
                rows,
                Wall._fields,
                (
                    report.text_column("wall", "wall"),
                    report.fixed_column("mm", "thickness_mm", 2),
                    report.fixed_column("lines", "lines", 2),
                    report.Column("plastic vs. mesh", _format_plastic, right=True),
                ),
            )
        ],
        facts={
            "walls": [wall._asdict() for wall in rows],
            "findings": [finding._asdict() for finding in findings],
            "orientations": list(orientations),
            "parts": parts,
            "plates": sheets,
        },
        lines=[
            *(f"printed {orientation}" for orientation in orientations),
            *(f"{finding.level}: {finding.line}" for finding in findings if finding.level != "error"),
            f"{_format_count(parts, 'part')} on {_format_count(sheets, 'plate')} of {printer}: {', '.join(counts)}",
        ],
        findings=layout.findings,
    )


def _format_plastic(wall: Wall) -> str:
    """Format the deviation of the plastic in a wall from the mesh, percent."""
    percent = round(wall.plastic_percent)
    return f"{percent:+d} %" if percent else "as drawn"


def _format_count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"
