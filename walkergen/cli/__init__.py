"""The command line: `walkergen COMMAND`; each command calls one public function and shows it."""

import os
import sys
from typing import Annotated

import typer

from walkergen import __version__
from walkergen.cli import (
    accuracy,
    analyse,
    bench,
    check,
    design,
    explain,
    export,
    family,
    fit,
    movie,
    plate,
    predict,
    report,
    reproduce,
    selftest,
    simulate,
    sweep,
    templates,
    validate,
    weigh,
)
from walkergen.errors import WalkergenError

app = typer.Typer(
    name="walkergen",
    help="From a leg tilt to 3D-printed walkers that run on a vibrating plate as predicted.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)
for command in (
    family.family, predict.predict, sweep.sweep, design.design, export.export, check.check,
    plate.plate, simulate.simulate, explain.explain, accuracy.accuracy, selftest.selftest,
    analyse.analyse, fit.fit, movie.movie, report.report, reproduce.reproduce, validate.validate,
    weigh.weigh,
):  # fmt: skip
    app.command()(command)
app.add_typer(bench.app, name="bench")
app.add_typer(templates.app, name="templates")


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"walkergen {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version."),
    ] = False,
) -> None:
    """From a leg tilt to 3D-printed walkers that run on a vibrating plate as predicted."""


def main() -> None:
    """Run the command line; errors meant for the user become one clear message and exit code 2."""
    try:
        app()
    except WalkergenError as error:
        for line in str(error).splitlines():
            print(f"error: {line}", file=sys.stderr)
        sys.exit(2)
    except BrokenPipeError:  # the reader of our output has gone (walkergen ... | head)
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
