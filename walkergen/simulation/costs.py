"""Cost of each effect of a scene: CPU time against that of the same scene without it."""

import time
from typing import NamedTuple

from walkergen.files.progress import Progress
from walkergen.simulation.model import Plan
from walkergen.simulation.plan import prepare, without
from walkergen.simulation.run import simulate
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

MEASURED_S = 2.0
"""Simulated time of one measurement, s."""

REPEATS = 3


class Explained(NamedTuple):
    """Row of `explain`: the fields of an `Effect`, and its cost."""

    effect: str
    on: bool
    number: float
    meaning: str
    reason: str
    switch: str
    cost: float | None
    """CPU time with the effect over that without it; None: off, unmeasured, without a switch, or
    what a plane cannot do without."""


def explain(plan: Plan, design: Design, mass: MassProperties, measured: bool, progress: Progress) -> list[Explained]:
    """Rows for all effects of a plan; `measured` times those that are on and have a switch."""
    effects = plan.resolved.effects
    whole = cpu_per_second(plan) if measured else None
    rows = []
    for place, effect in enumerate(effects, start=1):
        cost = None
        planar = effect.switch == "legs.model" and plan.scene.arena.kind == "plane"
        if whole is not None and effect.on and effect.switch and not planar:
            cost = whole / cpu_per_second(prepare(without(plan.scene, effect), design, mass))
        rows.append(Explained(*effect, cost))
        progress(effect.name, place, len(effects))
    return rows


def cpu_per_second(plan: Plan) -> float:
    """CPU seconds per simulated second: the fastest of three runs, after one that compiles."""
    short = plan.lasting(seconds=MEASURED_S, discard_seconds=0.0)
    simulate(short, 0)
    seconds = []
    for number in range(REPEATS):
        started = time.thread_time()
        result = simulate(short, number)
        seconds.append((time.thread_time() - started) / max(result.measured_s, 1e-9))
    return min(seconds)
