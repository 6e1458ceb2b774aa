"""The command `validate`."""

from pathlib import Path
from typing import Annotated

import typer

from walkergen.cli import options as opt
from walkergen.cli import show
from walkergen.errors import InputError


def validate(
    only: Annotated[
        str | None,
        typer.Option(
            "--only", metavar="GROUPS", help="Comma-separated groups: paper, closed, bouncing, rivals, programs."
        ),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Simulate less: wider error bars.")] = False,
    crowds: Annotated[
        bool, typer.Option("--crowds", help="Crowds in a plane against crowds in space, instead.")
    ] = False,
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Put every prediction beside what is known outside: number, error, source, verdict."""
    if crowds:
        if only is not None:
            raise InputError("--only: with --crowds there are no groups of claims: leave it out")
        _crowds(quick, out, json, quiet)
        return
    from walkergen.jobs.trust.validate import make
    from walkergen.jobs.trust.validate.claim import Effort

    groups = make.choose(only)
    folder = out or Path("out") / "validation"
    choice = (f" --only {','.join(groups)}" if only else "") + (" --quick" if quick else "")
    with show.progress("validate", wanted=not quiet) as progress:
        report = make.make(groups, Effort(quick), f"walkergen validate{choice}", folder, progress)
    show.report(report, json, quiet)


def _crowds(quick: bool, out: Path | None, json: bool, quiet: bool) -> None:
    """Compare walkers in a plane with walkers in space. Raises InputError without LAMMPS."""
    from walkergen.jobs.trust.crowd_checks import make
    from walkergen.jobs.trust.crowd_checks.setting import QUICK, WHOLE

    folder = out or Path("out") / "crowd-checks"
    command = "walkergen validate --crowds" + (" --quick" if quick else "")
    with show.progress("validate --crowds", wanted=not quiet) as progress:
        report = make.make(QUICK if quick else WHOLE, command, folder, progress)
    show.report(report, json, quiet)
