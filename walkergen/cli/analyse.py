"""The command `analyse`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from walkergen.cli import options as opt
from walkergen.cli import show

if TYPE_CHECKING:
    from walkergen.jobs.analyse.make import Analysed


def analyse(
    file: Annotated[Path, typer.Argument(metavar="TRACKS.csv", help="File of tracks of walkers.")],
    fps: Annotated[
        float | None, typer.Option(metavar="N", help="Frames per second of the film.")
    ] = None,
    mm_per_px: Annotated[
        str | None,
        typer.Option(metavar="MM", help="Millimetres per pixel of the film, as 0.05±0.001."),
    ] = None,
    y_down: Annotated[
        bool, typer.Option("--y-down", help="Let y grow downward, as image rows do.")
    ] = False,
    lane: Annotated[
        bool, typer.Option("--lane", help="Ignore y: the walkers ran in a lane along x.")
    ] = False,
    lag_ms: Annotated[
        float | None,
        typer.Option(
            metavar="MS", help="Lag of displacements along and across the body, ms; 40 by default."
        ),
    ] = None,
    pictures: opt.Pictures = True,
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Measure speed, persistence and spread from tracks, filmed or simulated.

    A film is a CSV file with trackpy's columns frame, particle, x, y and, if known, the heading
    theta (rad) or theta_deg, counted from x toward y; or Pogotrack's, which has its own units. A
    simulation is a file that simulate --trajectory wrote. Tracks at several plate speeds need a
    column plate_speed_mm_s.
    """
    from walkergen.analysis.tracks import Units
    from walkergen.files import output
    from walkergen.files.measured import measured
    from walkergen.jobs.analyse import make as experiment

    folder = output.results(file, out, "analysis")
    scale, scale_se = measured(mm_per_px, "--mm-per-px")
    units = Units(fps, scale, y_down, lane, scale_se)
    lag_s = None if lag_ms is None else 1e-3 * lag_ms
    with show.progress("analyse", wanted=not quiet) as progress:
        found = experiment.analyse(file, units, lag_s, folder, pictures, progress)
    if json:
        _motion_as_json(found)
    elif not quiet:
        _show_motion(found, file.name)


def _motion_as_json(found: "Analysed") -> None:
    """Print everything measured, and the notes made while reading, as JSON."""
    from walkergen.analysis import facts

    data = facts.of(found.motion)
    data |= {"bad_rows": found.bad_rows, "notes": found.notes, "folder": str(found.folder)}
    show.as_json(data)


def _show_motion(found: "Analysed", title: str) -> None:
    """Print the table of measured quantities, and the notes made while reading."""
    from walkergen.jobs.analyse import tables as motion_tables

    if found.motion.by_plate_speed:
        show.table(motion_tables.plate_table(found.motion))
        show.text(motion_tables.line_told(found.motion))
    else:
        show.table(motion_tables.to_table(found.motion, title))
    show.table(motion_tables.walkers_table(found.motion))
    for note in found.notes:
        show.text(note)
    print(f"tables and figures in {found.folder}/")
