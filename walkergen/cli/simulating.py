"""The commands that simulate: `simulate` and `explain`."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from walkergen.cli import options as opt
from walkergen.cli import show
from walkergen.errors import InputError

if TYPE_CHECKING:
    from walkergen.design import Design
    from walkergen.mass import MassProperties
    from walkergen.scene import Scene
    from walkergen.study.choose import Met
    from walkergen.study.ladder import Progress

Model = Annotated[
    str | None, typer.Option("--model", metavar="MODEL", help="rigid, relaxed, compliant or auto.")
]
Method = Annotated[
    str | None, typer.Option("--method", metavar="METHOD", help="event, step or auto.")
]
Gamma = Annotated[float | None, typer.Option("--gamma", help="Peak acceleration over g.")]
Frequency = Annotated[float | None, typer.Option("--frequency", help="Of the drive, Hz.")]
Step = Annotated[
    float | None, typer.Option("--step", metavar="MICROSECONDS", help="Step of method step.")
]
Seed = Annotated[int | None, typer.Option("--seed", help="Of the runs' phases and drops.")]


def simulate(
    design: opt.DesignName = opt.PAPER,
    scene: opt.SceneName = opt.SCENE,
    tilt: opt.OneTilt = None,
    legs: opt.OneKind = None,
    seconds: opt.Seconds = None,
    runs: opt.Runs = None,
    model: Model = None,
    method: Method = None,
    law: opt.LawName = None,
    restitution: opt.Restitution = None,
    friction: opt.Friction = None,
    gamma: Gamma = None,
    frequency: Frequency = None,
    step: Step = None,
    seed: Seed = None,
    trajectory: Annotated[
        Path | None, typer.Option("--trajectory", help="File for the first run's trajectory.")
    ] = None,
    form: Annotated[
        str, typer.Option("--format", metavar="FORMAT", help="Of the trajectory: csv or npz.")
    ] = "csv",
    rate: Annotated[
        float, typer.Option("--rate", min=1e-3, max=1e7, help="Trajectory samples per second.")
    ] = 1000.0,
    error: Annotated[
        str | None,
        typer.Option("--error", metavar="ERROR", help="Choose the cheapest setting: 5% or 3mm/s."),
    ] = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Bounce a walker on the plate and measure its speed."""
    from walkergen.simulation import engines, ensemble
    from walkergen.simulation import trajectory as trajectories

    if form not in trajectories.FORMATS:
        known = ", ".join(trajectories.FORMATS)
        raise InputError(f"--format {form[:30]!r}: must be one of {known}")
    if error is not None:
        _check_error(model=model, method=method, step=step, seconds=seconds, runs=runs)
    changes = opt.Changes(
        restitution, friction, law, gamma, frequency, seconds, runs, seed, method, step, model
    )
    resolved_scene = opt.scene_of(scene, changes)
    if trajectory is not None:
        trajectories.check(resolved_scene, 1.0 / rate)
    chosen = opt.one_design(design, tilt, legs)
    mass = _weighed(chosen)
    met = None
    with show.progress("simulate", wanted=not quiet) as progress:
        if error is None:
            plan = engines.prepare(resolved_scene, chosen, mass)
            summary, _ = ensemble.measure(plan.engine, resolved_scene, progress)
        else:
            met = _met(error, resolved_scene, chosen, mass, progress)
            plan, resolved_scene, summary = met.plan, met.scene, met.summary
        if trajectory is not None:
            progress("trajectory", resolved_scene.run.runs, resolved_scene.run.runs)
            trajectories.write(plan.engine, resolved_scene, trajectory, form, 1.0 / rate)
    if summary.runs < resolved_scene.run.runs:
        told = f"interrupted after {summary.runs} of {resolved_scene.run.runs} runs"
        print(told, file=sys.stderr)
    if json:
        show.as_json(show.summary_as_dict(plan.engine, resolved_scene, summary, met))
    elif not quiet:
        show.summary(plan.engine, resolved_scene, summary, chosen, met)


def explain(
    design: opt.DesignName = opt.PAPER,
    scene: opt.SceneName = opt.SCENE,
    tilt: opt.OneTilt = None,
    legs: opt.OneKind = None,
    model: Model = None,
    method: Method = None,
    friction: opt.Friction = None,
    gamma: Gamma = None,
    frequency: Frequency = None,
    cost: Annotated[bool, typer.Option(help="Measure what the effects cost.")] = True,
    json: opt.AsJson = False,
) -> None:
    """Say which effects a scene calls for, why, how large they are and what they cost."""
    from walkergen.simulation import costs, engines

    changes = opt.Changes(
        friction=friction, gamma=gamma, frequency=frequency, method=method, model=model
    )
    resolved_scene = opt.scene_of(scene, changes)
    chosen = opt.one_design(design, tilt, legs)
    mass = _weighed(chosen)
    plan = engines.prepare(resolved_scene, chosen, mass)
    with show.progress("explain", wanted=True) as progress:
        rows = costs.explain(plan, resolved_scene, chosen, mass, measured=cost, progress=progress)
    if json:
        show.rows_as_json(rows)
    else:
        show.effects(plan, rows, resolved_scene, chosen)


def _weighed(design: "Design") -> "MassProperties":
    from walkergen import solids

    return solids.weigh(design, solids.build(design))


def _met(
    error: str, scene: "Scene", design: "Design", mass: "MassProperties", progress: "Progress"
) -> "Met":
    from walkergen.study import choose

    return choose.meet(scene, design, mass, choose.parse(error), progress)


def _check_error(**chosen: object) -> None:
    """--error chooses these itself."""
    for name, value in chosen.items():
        if value is not None:
            raise InputError(f"--{name} {value}: --error chooses it; leave one of them out")


ALL = (simulate, explain)
