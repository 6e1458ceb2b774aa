"""The command that checks walkergen on this machine: `selftest`."""

import sys
from typing import Annotated

import typer

from walkergen.cli import options as opt
from walkergen.cli import show


def selftest(
    only: Annotated[
        str | None,
        typer.Option("--only", metavar="NAME-OR-SECTION", help="A case's name or section: 6.7."),
    ] = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Run the hard cases, each with an exact outcome or an invariant; exit code 1 if one fails."""
    from walkergen.hard_cases import selftest as hard

    jobs = hard.choose(only)
    with show.progress("selftest", wanted=not quiet) as progress:
        results, whole = hard.run(jobs, progress)
    if json:
        show.hard_cases_as_json(results)
    elif not quiet:
        show.hard_cases(results)
    if not whole:
        print(f"interrupted after {len(results)} of {len(jobs)}", file=sys.stderr)
        raise typer.Exit(130)
    if not all(result.holds for result in results):
        raise typer.Exit(1)


ALL = (selftest,)
