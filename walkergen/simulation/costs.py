"""What the effects of a scene cost: measured, each against the same scene without it."""

import time
from typing import NamedTuple

from walkergen.files.progress import Progress
from walkergen.scene import Scene
from walkergen.simulation import engines
from walkergen.simulation.engines import Plan
from walkergen.simulation.run import simulate
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

MEASURED_S = 2.0
"""Simulated seconds of each measurement."""

REPEATS = 3


class Explained(NamedTuple):
    """One effect as `explain` shows it."""

    effect: str
    on: bool
    number: float
    meaning: str
    reason: str
    switch: str
    cost: float | None
    """CPU time with the effect over that without it; None when off, unmeasured or not separable."""


def explain(
    plan: Plan,
    scene: Scene,
    design: Design,
    mass: MassProperties,
    measured: bool,
    progress: Progress,
) -> list[Explained]:
    """Every effect with its verdict; with `measured`, those that can be switched off are timed."""
    effects = plan.resolved.effects
    whole = cpu_per_second(plan, scene) if measured else None
    rows = []
    for place, effect in enumerate(effects, start=1):
        cost = None
        if whole is not None and effect.on and effect.switch:
            without = engines.prepare(engines.without(scene, effect), design, mass)
            cost = whole / cpu_per_second(without, scene)
        rows.append(Explained(*effect, cost))
        progress(effect.name, place, len(effects))
    return rows


def cpu_per_second(plan: Plan, scene: Scene) -> float:
    """CPU seconds per simulated second: the fastest of three runs, after one that compiles."""
    run = scene.run.model_copy(update={"seconds": MEASURED_S, "discard_seconds": 0.0})
    short = scene.model_copy(update={"run": run})
    simulate(plan.engine, short, 0)
    seconds = []
    for number in range(REPEATS):
        started = time.thread_time()
        result = simulate(plan.engine, short, number)
        seconds.append((time.thread_time() - started) / max(result.measured_s, 1e-9))
    return min(seconds)
