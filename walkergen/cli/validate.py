"""The command `validate`."""

from pathlib import Path
from typing import Annotated

import typer

from walkergen.cli import options as opt
from walkergen.cli import show


def validate(
    only: Annotated[
        str | None,
        typer.Option(
            "--only",
            metavar="GROUPS",
            help="Comma-separated groups: paper, closed, bouncing, rivals, programs.",
        ),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Simulate less: wider error bars.")
    ] = False,
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Put every prediction beside what is known outside: number, error, source, verdict."""
    from walkergen.jobs.trust.validate import make
    from walkergen.jobs.trust.validate.claim import Effort

    groups = make.choose(only)
    folder = out or Path("out") / "validation"
    choice = (f" --only {','.join(groups)}" if only else "") + (" --quick" if quick else "")
    with show.progress("validate", wanted=not quiet) as progress:
        report = make.make(groups, Effort(quick), f"walkergen validate{choice}", folder, progress)
    show.report(report, json, quiet)
