"""The command `explain`."""

from typing import Annotated

import typer

from walkergen.cli import loading, show
from walkergen.cli import options as opt


def explain(
    design: opt.DesignName = opt.PAPER,
    scene: opt.SceneName = opt.SCENE,
    tilt: opt.OneTilt = None,
    legs: opt.OneKind = None,
    model: opt.Model = None,
    friction: opt.Friction = None,
    gamma: opt.Gamma = None,
    frequency: opt.Frequency = None,
    keys: opt.Values = None,
    cost: Annotated[bool, typer.Option(show_default=False, help="Measure the CPU time that each effect costs.")] = True,
    json: opt.AsJson = False,
) -> None:
    """Say which effects a scene calls for, why, how large they are and what they cost."""
    from walkergen.jobs.run.explain import make

    inputs = loading.inputs(keys, "design scene", friction=friction, gamma=gamma, frequency=frequency, model=model)
    resolved_scene, chosen = inputs.scene(scene), inputs.one(design, tilt, legs)
    with show.progress("explain", wanted=True) as progress:
        report = make.explain(resolved_scene, chosen, cost, progress)
    show.report(report, json, quiet=False)
