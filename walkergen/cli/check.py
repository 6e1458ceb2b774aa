"""The command `check`."""

from typing import TYPE_CHECKING

from walkergen.cli import loading, show
from walkergen.cli import options as opt

if TYPE_CHECKING:
    from walkergen.jobs.orders.make import Checked
    from walkergen.printing.printers import Printer


def check(
    design: opt.DesignName = opt.PAPER,
    tilt: opt.Tilt = None,
    legs: opt.LegKinds = None,
    printer: opt.PrinterName = opt.PRINTER,
    keys: opt.Values = None,
    copies: opt.Copies = None,
    strict: opt.Strict = False,
    json: opt.AsJson = False,
) -> None:
    """Check whether walkers will print as designed, without writing any file."""
    from walkergen.jobs.orders import make as batch
    from walkergen.printing import checks

    inputs = loading.inputs(keys, "design printer")
    chosen, machine = inputs.design(design), inputs.printer(printer)
    members, counts = inputs.batch(chosen, tilt, legs, copies, whole=True)
    checked = batch.check(members, counts, machine)
    if json:
        show.as_json({
            "walls": [wall._asdict() for wall in checked.walls],
            "findings": [finding._asdict() for finding in checks.grouped(checked.findings)],
            "orientations": checked.orientations,
            "parts": checked.parts,
            "plates": checked.plates,
        })  # fmt: skip
    else:
        _show_checked(checked, machine)
    checks.refuse(checked.findings, strict)


def _show_checked(checked: "Checked", printer: "Printer") -> None:
    """Print the walls in printed lines, warnings and advice; errors are left to `checks.refuse`."""
    from walkergen.printing import checks

    wide = max([8, *(len(wall.wall) + 2 for wall in checked.walls)])
    print(f"{'wall':{wide}s}{'mm':>8s}{'lines':>8s}{'plastic':>10s}   (expected, against the mesh)")
    for wall in checked.walls:
        percent = round(wall.plastic_percent)
        plastic = f"{percent:+d} %" if percent else "as drawn"
        print(f"{wall.wall:{wide}s}{wall.thickness_mm:8.2f}{wall.lines:8.2f}{plastic:>10s}")
    for lying in checked.orientations:
        print(f"printed {lying}")
    findings = checks.grouped(checked.findings)
    for finding in findings:
        if finding.level != "error":
            print(f"{finding.level}: {checks.line(finding)}")
    lines = [
        _count(sum(finding.level == level for finding in findings), level)
        for level in ("error", "warning")
    ]
    parts, plates = _count(checked.parts, "part"), _count(checked.plates, "plate")
    print(f"{parts} on {plates} of {printer.name}: {', '.join(lines)}")


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"
