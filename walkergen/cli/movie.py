"""The command `movie`."""

from pathlib import Path
from typing import Annotated

import typer

from walkergen.cli import loading, show
from walkergen.cli import options as opt
from walkergen.errors import InputError


def movie(
    design: opt.DesignName = opt.PAPER,
    scene: opt.SceneName = opt.SCENE,
    tilt: opt.Tilt = None,
    legs: opt.LegKinds = None,
    seconds: Annotated[float | None, typer.Option("--seconds", metavar="S", help="Simulated time to show, s.")] = None,
    periods: Annotated[
        float | None, typer.Option("--periods", metavar="N", help="Time to show, in periods of the drive.")
    ] = None,
    slow: Annotated[
        float | None, typer.Option("--slow", metavar="N", help="Play N times slower than real time.")
    ] = None,
    view: Annotated[
        str | None, typer.Option("--view", metavar="VIEW", help="How to see a walker in space: above or perspective.")
    ] = None,
    fps: Annotated[int, typer.Option("--fps", metavar="N", help="Frames per second: 10, 20, 25 or 50.")] = 25,
    model: opt.Model = None,
    law: opt.LawName = None,
    restitution: opt.Restitution = None,
    friction: opt.Friction = None,
    gamma: opt.Gamma = None,
    frequency: opt.Frequency = None,
    step: opt.Step = None,
    seed: opt.Seed = None,
    keys: opt.Values = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="GIF to write; the MP4 comes beside it.")
    ] = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Film a walker in slow motion, or several tilts running (GIF, and MP4).

    A walker in space is seen in perspective in a lane, in slow motion, and from above on a plane,
    as are several; --view above or --view perspective says otherwise.
    """
    from walkergen.jobs.run.movie import make as movies
    from walkergen.jobs.run.movie import report

    if out is not None and out.suffix.lower() != ".gif":
        raise InputError(f"--out {str(out)[:80]!r}: must end in .gif (the MP4 comes beside it)")
    inputs = loading.inputs(
        keys,
        "design scene",
        restitution=restitution,
        friction=friction,
        law=law,
        gamma=gamma,
        frequency=frequency,
        seed=seed,
        step=step,
        model=model,
    )
    resolved, chosen = inputs.scene(scene), inputs.design(design)
    members = inputs.members(chosen, tilt, legs, whole=False)
    job = movies.plan(members, resolved, seconds=seconds, periods=periods, slow=slow, fps=fps, view=view)
    path = out or Path("out") / chosen.name / movies.file_name(job, inputs.values)
    with show.progress("movie", wanted=not quiet) as progress:
        film = movies.make(job, path, progress, named=out is not None)
    show.report(report.of(job, film), json, quiet)
