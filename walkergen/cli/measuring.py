"""The commands that meet the experiment: `analyse` and `fit`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from walkergen.cli import options as opt
from walkergen.cli import show

if TYPE_CHECKING:
    from walkergen.calibration import Fitted
    from walkergen.experiment import Analysed

Pictures = Annotated[bool, typer.Option(help="Draw the figures.")]


def analyse(
    file: Annotated[Path, typer.Argument(metavar="TRACKS.csv", help="Tracks of walkers.")],
    fps: Annotated[float | None, typer.Option(help="Frames per second of a film.")] = None,
    mm_per_px: Annotated[float | None, typer.Option(help="Millimetres per pixel.")] = None,
    y_down: Annotated[
        bool, typer.Option("--y-down", help="y grows downward, as rows of an image do.")
    ] = False,
    lane: Annotated[
        bool, typer.Option("--lane", help="The walkers ran in a lane along x; y says nothing.")
    ] = False,
    lag_ms: Annotated[
        float | None,
        typer.Option(help="Lag of displacements along and across the body; 40 unless given."),
    ] = None,
    pictures: Pictures = True,
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Measure speed, persistence and spread from tracks, filmed or simulated.

    A film is a CSV file with trackpy's columns frame, particle, x, y and, if known, the heading
    theta (rad) or theta_deg, counted from x toward y. A simulation is what simulate --trajectory
    writes. Tracks at several plate speeds say so in a column plate_speed_mm_s.
    """
    from walkergen import experiment, names
    from walkergen.analysis.tracks import Units

    folder = names.results(file, out, "analysis")
    units = Units(fps, mm_per_px, y_down, lane)
    lag_s = None if lag_ms is None else 1e-3 * lag_ms
    with show.progress("analyse", wanted=not quiet) as progress:
        found = experiment.analyse(file, units, lag_s, folder, pictures, progress)
    if json:
        _motion_as_json(found)
    elif not quiet:
        _show_motion(found, file.name)


def fit(
    file: Annotated[Path, typer.Argument(metavar="SPEEDS.csv", help="Measured speeds by tilt.")],
    design: Annotated[
        str, typer.Option("--design", metavar="DESIGN", help="A template's name or a TOML file.")
    ] = opt.PAPER,
    scene: opt.SceneName = opt.SCENE,
    fix: Annotated[
        list[str] | None,
        typer.Option("--fix", metavar="NAME=VALUE", help="Not fitted; restitution=0.8, say."),
    ] = None,
    mode: opt.ModeName = "coulomb",
    law: opt.LawName = None,
    pictures: Pictures = True,
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Estimate friction, restitution and impact speed from measured speeds against tilt.

    Columns of the CSV file: tilt_deg, speed_mm_s and, if known, speed_se_mm_s, legs (flexible or
    braced) and plate_speed_mm_s, which are the design's and the scene's otherwise.
    """
    from walkergen import calibration, names

    resolved = opt.scene_of(scene, opt.Changes(law=law))
    job = calibration.Job(
        opt.design_of(design), resolved, opt.mode_of(mode, resolved),
        calibration.parse_fixed(fix or []), pictures,
    )  # fmt: skip
    with show.progress("fit", wanted=not quiet) as progress:
        found = calibration.fit(file, job, names.results(file, out, "fit"), progress)
    if json:
        _fit_as_json(found)
    elif not quiet:
        _show_fit(found, file.name)


def _motion_as_json(found: "Analysed") -> None:
    """Print everything measured, and what was noted while reading."""
    from walkergen.report import motion_tables

    data = motion_tables.as_dict(found.motion)
    data |= {"bad_rows": found.bad_rows, "notes": found.notes, "folder": str(found.folder)}
    show.as_json(data)


def _show_motion(found: "Analysed", title: str) -> None:
    """Print the table of what was measured."""
    from rich.console import Console

    from walkergen.report import motion_tables

    console = Console(highlight=False)
    if found.motion.by_plate_speed:
        console.print(motion_tables.plate_table(found.motion))
        console.print(motion_tables.line_told(found.motion), markup=False)
    else:
        console.print(motion_tables.to_table(found.motion, title))
    for note in found.notes:
        console.print(note, markup=False)
    print(f"tables and figures in {found.folder}/")


def _fit_as_json(found: "Fitted") -> None:
    """Print the fitted parameters and what was noted."""
    from walkergen.report import fit_tables

    data = fit_tables.as_dict(found.fit)
    show.as_json(data | {"notes": found.notes, "folder": str(found.folder)})


def _show_fit(found: "Fitted", title: str) -> None:
    """Print the table of fitted parameters and what to make of them."""
    from rich.console import Console

    from walkergen.report import fit_tables

    console = Console(highlight=False)
    console.print(fit_tables.to_table(found.fit, title))
    told = (fit_tables.quality(found.fit), fit_tables.correlations(found.fit), *found.notes)
    for line in told:
        if line:
            console.print(line, markup=False)
    print(f"tables, figure and scene.toml in {found.folder}/")


ALL = (analyse, fit)
"""The commands."""
