"""The command `check`."""

from walkergen.cli import loading, show
from walkergen.cli import options as opt


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
    from walkergen.jobs.make.check import make
    from walkergen.printing import findings

    inputs = loading.inputs(keys, "design printer")
    chosen, machine = inputs.design(design), inputs.printer(printer)
    members, counts = inputs.batch(chosen, tilt, legs, copies, whole=True)
    report = make.check(members, counts, machine)
    show.report(report, json, quiet=False)
    findings.refuse(report.findings, strict)
