"""The command `analyse`."""

from pathlib import Path
from typing import Annotated

import typer

from walkergen.cli import options as opt
from walkergen.cli import show


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
    from walkergen.jobs.measure.analyse import make

    folder = output.results(file, out, "analysis")
    scale, scale_se = measured(mm_per_px, "--mm-per-px")
    units = Units(fps, scale, y_down, lane, scale_se)
    lag_s = None if lag_ms is None else 1e-3 * lag_ms
    with show.progress("analyse", wanted=not quiet) as progress:
        result = make.analyse(file, units, lag_s, folder, pictures, progress)
    show.report(result, json, quiet)
