"""Simulation of a walker: the speed of its runs and, in space, their motion and landings."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from walkergen.analysis import landings
from walkergen.analysis.landings import Landings
from walkergen.analysis.motion import Motion
from walkergen.files.progress import Progress, silent
from walkergen.jobs.simulate import orbit
from walkergen.jobs.simulate.orbit import Orbit
from walkergen.points.runs import motion_of
from walkergen.scene import Scene
from walkergen.simulation import points, resolution, trajectory
from walkergen.simulation.effects.resolve import resolve
from walkergen.simulation.plan import prepare
from walkergen.simulation.points import Asked, Point
from walkergen.simulation.resolution import Verdict
from walkergen.simulation.run import ENDED_WELL, RunResult, impacts_of
from walkergen.walker import names
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

MOST_S = 500.0
"""Time of all runs together (s) up to which every landing in space is kept: 0.3 MB a second."""


class Simulated(NamedTuple):
    """Results of a simulation; motion and landings belong to walkers in space."""

    point: Point
    verdicts: Mapping[str, Verdict]
    """What the step leaves of each observable, by the names of `observables.NAMES`."""
    warnings: Sequence[str]
    """Warnings on the step."""
    values: Mapping[str, float]
    """Values of the same observables."""
    errors: Mapping[str, float | None]
    """Their standard errors, of the runs and the step together; None where either is unknown."""
    orbit: Orbit | None = None
    """Orbit that all runs share: they tell no error then, and the bounds are those of prints."""
    motion: Motion | None = None
    untold: str = ""
    """Reason why a walker in space has no `motion`; "" when it has one."""
    landings: Sequence[Landings] = ()
    """Landings of each run that ended well; none where they were not kept."""
    legs: tuple[str, ...] = ()
    """Names of the legs, in the order of their landings."""


def asked(
    scene: Scene, design: Design, mass: MassProperties, interval: float | None = None
) -> Asked:
    """Point of a scene: with landings where it is in space, and samples `interval` s apart."""
    in_space = resolve(scene, design, mass).model == "space"
    few = scene.run.runs * scene.run.seconds <= MOST_S
    return Asked(scene, design, mass, impacts=in_space and few, sample_interval=interval)


def measure(one: Asked, progress: Progress) -> Simulated:
    """Simulate what is asked, and measure motion and landings of a walker in space.

    Raises InputError where the scene contradicts itself or asks for too many samples.
    """
    if one.sample_interval is not None:
        trajectory.check(one.scene, one.sample_interval, one.scene.run.runs)
    return measured(points.measure(one, progress), one, progress=progress)


def measured(
    point: Point, one: Asked, studied: Mapping[str, float] | None = None,
    progress: Progress = silent,
) -> Simulated:  # fmt: skip
    """What a simulated point says of its step, and in space of motion and landings.

    `studied` are largest errors (95 %) of the step that are known better, by name.
    """
    plan = prepare(one.scene, one.design, one.mass)
    verdicts = resolution.judge(plan, point.summary)
    verdicts |= {name: Verdict(error) for name, error in (studied or {}).items()}
    values = resolution.values(point.summary)
    errors = resolution.errors(verdicts, point.summary)
    summary = resolution.bounded(verdicts, point.summary)
    shared = orbit.of(point, one, progress)
    if shared is not None:
        summary, errors = orbit.of_prints(summary, shared), dict.fromkeys(errors)
    point = point._replace(summary=summary)
    found = Simulated(point, verdicts, resolution.warnings(plan), values, errors, shared)
    if point.model != "space":
        return found
    good = [result for result in point.results if result.outcome in ENDED_WELL]
    if not good:
        return found._replace(untold="no run ended well")
    moved, untold = motion_of(good, one.scene.arena.kind == "lane", one.sample_interval)
    legs = names.legs(one.design)
    landed = [_landings(result, len(legs)) for result in good] if one.impacts else []
    return found._replace(motion=moved, untold=untold, landings=landed, legs=legs)


def _landings(result: RunResult, feet: int) -> Landings:
    """Landings of a run on the plate; walls are touched by points beyond the corners' numbers."""
    rows = impacts_of(result)
    rows = rows[rows[:, 1] < feet * landings.CORNERS]
    return landings.count(rows[:, 0], rows[:, 1].astype(np.int64), result.measured_s, feet)
