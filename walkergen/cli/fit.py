"""The command `fit`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from walkergen.cli import options as opt
from walkergen.cli import show

if TYPE_CHECKING:
    from walkergen.jobs.fit.make import Fitted


def fit(
    file: Annotated[Path, typer.Argument(metavar="SPEEDS.csv", help="File of measured speeds.")],
    design: Annotated[
        str, typer.Option("--design", metavar="DESIGN", help="Walker: a template or a TOML file.")
    ] = opt.PAPER,
    scene: opt.SceneName = opt.SCENE,
    fix: Annotated[
        list[str] | None,
        typer.Option("--fix", metavar="NAME=VALUE", help="Parameter to hold: restitution=0.8."),
    ] = None,
    mode: opt.ModeName = "coulomb",
    law: opt.LawName = None,
    pictures: opt.Pictures = True,
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Estimate friction, restitution and impact speed from measured speeds against tilt.

    The CSV file has columns tilt_deg, speed_mm_s and, if known, speed_se_mm_s, legs (flexible or
    braced; otherwise the design's) and plate_speed_mm_s (otherwise the scene's).
    """
    from walkergen.files import output
    from walkergen.jobs.fit import make as calibration

    resolved = opt.scene_of(scene, opt.Changes(law=law))
    job = calibration.Job(
        opt.design_of(design), resolved, opt.mode_of(mode, resolved),
        calibration.parse_fixed(fix or []), pictures,
    )  # fmt: skip
    with show.progress("fit", wanted=not quiet) as progress:
        found = calibration.fit(file, job, output.results(file, out, "fit"), progress)
    if json:
        _fit_as_json(found)
    elif not quiet:
        _show_fit(found, file.name)


def _fit_as_json(found: "Fitted") -> None:
    """Print the fitted parameters and the notes on them as JSON."""
    from walkergen.jobs.fit import tables as fit_tables

    data = fit_tables.as_dict(found.fit)
    show.as_json(data | {"notes": found.notes, "folder": str(found.folder)})


def _show_fit(found: "Fitted", title: str) -> None:
    """Print the table of fitted parameters, the quality of the fit and the notes."""
    from rich.console import Console

    from walkergen.jobs.fit import tables as fit_tables

    console = Console(highlight=False)
    console.print(fit_tables.to_table(found.fit, title))
    told = (fit_tables.quality(found.fit), fit_tables.correlations(found.fit), *found.notes)
    for line in told:
        if line:
            console.print(line, markup=False)
    print(f"tables, figure and scene.toml in {found.folder}/")
