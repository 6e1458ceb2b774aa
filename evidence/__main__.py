"""Commands of the evidence, run from a checkout: `python -m evidence NAME`; `make evidence` runs them all."""

from pathlib import Path
from typing import Annotated

import typer

from walkergen import cli
from walkergen.cli import options as opt
from walkergen.cli import show

commands = typer.Typer(no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False)

Quick = Annotated[bool, typer.Option("--quick", help="Simulate less: wider error bars.")]


@commands.command()
def validate(
    only: Annotated[
        str | None,
        typer.Option(
            "--only", metavar="GROUPS", help="Comma-separated groups: paper, closed, bouncing, rivals, programs."
        ),
    ] = None,
    quick: Quick = False,
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Put every prediction beside what is known outside: number, error, source, verdict."""
    from evidence.validate import make
    from evidence.validate.claim import Effort

    groups = make.choose(only)
    folder = out or Path("out") / "validation"
    choice = (f" --only {','.join(groups)}" if only else "") + (" --quick" if quick else "")
    with show.progress("validate", wanted=not quiet) as progress:
        report = make.make(groups, Effort(quick), f"python -m evidence validate{choice}", folder, progress)
    show.report(report, json, quiet)


@commands.command()
def crowd_checks(quick: Quick = False, out: opt.Out = None, json: opt.AsJson = False, quiet: opt.Quiet = False) -> None:
    """Compare walkers in a plane with walkers in space. Raises InputError without LAMMPS."""
    from evidence.crowd_checks import make
    from evidence.crowd_checks.setting import QUICK, WHOLE

    folder = out or Path("out") / "crowd-checks"
    command = "python -m evidence crowd-checks" + (" --quick" if quick else "")
    with show.progress("crowd-checks", wanted=not quiet) as progress:
        report = make.make(QUICK if quick else WHOLE, command, folder, progress)
    show.report(report, json, quiet)


@commands.command()
def crowds_published(
    quick: Quick = False,
    seconds: opt.Seconds = None,
    runs: opt.Runs = None,
    seed: opt.Seed = None,
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Compare our crowds with published ones. Raises InputError."""
    from evidence.crowds_published import make
    from evidence.crowds_published.cases import QUICK, WHOLE

    size = QUICK if quick else WHOLE
    size = size._replace(
        runs=size.runs if runs is None else runs,
        seconds=size.seconds if seconds is None else seconds,
        seed=size.seed if seed is None else seed,
    )
    make.check(size)
    folder = out or Path("out") / "crowds-published"
    with show.progress("crowds-published", wanted=not quiet, about_s=make.expected_s(size)) as progress:
        report = make.make(size, folder, progress)
    show.report(report, json, quiet)


if __name__ == "__main__":
    cli.main(commands)
