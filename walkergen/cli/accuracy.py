"""The command `accuracy`."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from walkergen.cli import loading, show
from walkergen.cli import options as opt
from walkergen.cli.times import parse_time
from walkergen.files import words


def accuracy(
    design: opt.DesignName = opt.PAPER,
    scene: opt.SceneName = opt.SCENE,
    tilt: opt.OneTilt = None,
    legs: opt.OneKind = None,
    restitution: opt.Restitution = None,
    friction: opt.Friction = None,
    keys: opt.Values = None,
    only: Annotated[
        str, typer.Option("--only", metavar="LADDERS", help="Comma-separated ladders to measure.")
    ] = "models,steps,statistics,shape",
    budget: Annotated[str, typer.Option("--budget", metavar="TIME", help="Time of all of it: 30s, 5min, 1h.")] = "60s",
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Measure what accuracy costs in time: models, steps, statistics, shape."""
    from walkergen.jobs.trust.accuracy import make as study
    from walkergen.walker import names

    chosen = study.check(only)
    seconds = parse_time(budget)
    inputs = loading.inputs(keys, "design scene", restitution=restitution, friction=friction)
    resolved, member = inputs.scene(scene), inputs.one(design, tilt, legs)
    name = f"{member.name}_{names.tilt(member)}_{member.kind}_{resolved.name}"
    folder = out or Path("out") / "accuracy" / name

    def too_short(least_s: float) -> None:
        print(
            f"--budget {budget}: too short for {only}, which are given {words.budget(least_s)}, "
            "the least that gives error bars here; --only takes fewer",
            file=sys.stderr,
            flush=True,
        )

    job = study.Job(member, resolved, chosen, seconds)
    with show.progress("accuracy", wanted=not quiet, about_s=seconds) as progress:
        report = study.make(job, folder, progress, too_short)
    show.report(report, json, quiet)
