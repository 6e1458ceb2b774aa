"""The command `analyse`."""

from pathlib import Path
from typing import Annotated

import typer

from walkergen.cli import options as opt
from walkergen.cli import show


def analyse(
    file: Annotated[Path, typer.Argument(metavar="TRACKS.csv", help="File of tracks of walkers.")],
    fps: Annotated[float | None, typer.Option(metavar="N", help="Frames per second of the film.")] = None,
    mm_per_px: Annotated[
        str | None, typer.Option(metavar="MM", help="Millimetres per pixel of the film, as 0.05±0.001.")
    ] = None,
    y_down: Annotated[bool, typer.Option("--y-down", help="Let y grow downward, as image rows do.")] = False,
    lane: Annotated[bool, typer.Option("--lane", help="Ignore y: the walkers ran in a lane along x.")] = False,
    lag_ms: Annotated[
        float | None,
        typer.Option(metavar="MS", help="Lag of displacements along and across the body, ms; 40 by default."),
    ] = None,
    dish: Annotated[
        str | None,
        typer.Option(
            metavar="DISH",
            help="Measure the crowd that the walkers are: disc:120, ring:160,60, rectangle:200x100 "
            "or periodic:150, mm.",
        ),
    ] = None,
    body: Annotated[
        str | None,
        typer.Option(metavar="MM", help="Outline of a walker: 24x8, or 20 of a disc, mm, or a walker's name."),
    ] = None,
    middle: Annotated[
        str | None, typer.Option(metavar="X,Y", help="Place of the dish's middle, mm; 0,0 by default.")
    ] = None,
    run: Annotated[
        list[Path] | None, typer.Option(metavar="TRACKS.csv", help="Tracks of another run of the same crowd.")
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

    With --dish the walkers are a crowd: its packing, clusters, order and fluctuations are measured,
    with errors from independent runs (--run), and no walker by itself.
    """
    from walkergen.analysis.track_files import Units
    from walkergen.crowd import filmed as crowd
    from walkergen.errors import InputError
    from walkergen.files import output
    from walkergen.files.measured import measured
    from walkergen.files.report import Report
    from walkergen.track.analyse import make

    for flag, value in (("--body", body), ("--middle", middle), ("--run", run)):
        if value is not None and dish is None:
            raise InputError(f"{flag}: is of a crowd: give --dish, or leave it out")
    if dish is not None and lag_ms is not None:
        raise InputError("--lag-ms: is of single walkers: leave it or --dish out")
    folder = output.results(file, out, "analysis")
    scale, scale_se = measured(mm_per_px, "--mm-per-px")
    units = Units(fps, scale, y_down, lane, scale_se)
    lag_s = None if lag_ms is None else 1e-3 * lag_ms
    result: Report
    with show.progress("analyse", wanted=not quiet) as progress:
        if dish is not None:
            asked = crowd.asked(dish, body, middle, run or ())
            result = crowd.analyse(file, units, asked, folder, pictures, progress)
        else:
            result = make.analyse(file, units, lag_s, folder, pictures, progress)
    show.report(result, json, quiet)
