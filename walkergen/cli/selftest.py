"""The command `selftest`."""

import sys
from typing import Annotated

import typer

from walkergen.cli import options as opt
from walkergen.cli import show


def selftest(
    only: Annotated[
        str | None, typer.Option("--only", metavar="NAME-OR-SECTION", help="Case to run, or section: 6.7.")
    ] = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Run the hard cases, each with an exact outcome or an invariant; exit code 1 if any fails."""
    from walkergen.jobs.trust.selftest import make as hard
    from walkergen.jobs.trust.selftest import report

    jobs = hard.choose(only)
    with show.progress("selftest", wanted=not quiet) as progress:
        results, whole = hard.run(jobs, progress)
    width = None if sys.stdout.isatty() else 160  # a log need not fit 80 columns
    show.report(report.of(results, whole), json, quiet, width)
    if not whole:
        print(f"interrupted after {len(results)} of {len(jobs)}", file=sys.stderr)
        raise typer.Exit(130)
    if not all(result.holds for result in results):
        raise typer.Exit(1)
