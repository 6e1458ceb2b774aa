"""Simulation of a walker: the speed of its runs and, in space, their motion and landings."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from walkergen.analysis import landings
from walkergen.analysis.landings import Landings
from walkergen.analysis.motion import Motion
from walkergen.files.progress import Progress, silent
from walkergen.jobs.run.simulate import orbit
from walkergen.jobs.run.simulate.orbit import Orbit
from walkergen.points import measure as ensembles
from walkergen.points.runs import motion_of
from walkergen.points.tolerance import Chosen, Tolerance
from walkergen.scene import Scene
from walkergen.simulation import experiments, resolution, trajectory
from walkergen.simulation.effects.resolve import resolve
from walkergen.simulation.experiments import Experiment, Results
from walkergen.simulation.observables import SPEED
from walkergen.simulation.resolution import Verdict
from walkergen.simulation.run import ENDED_WELL, RunResult, impacts_of
from walkergen.walker import names
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

MOST_S = 500.0
"""Time of all runs together (s) up to which every landing in space is kept: 0.3 MB a second."""


class Simulated(NamedTuple):
    """Results of a simulation; motion and landings belong to walkers in space."""

    point: Results
    scene: Scene
    """Scene with the runs and the step that were taken."""
    values: Mapping[str, float]
    """Values of all observables, by the names of `observables.NAMES`."""
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
    chosen: Chosen | None = None
    """What was taken to meet an error; None where none was asked for."""

    @property
    def verdicts(self) -> Mapping[str, Verdict]:
        """What the step leaves of each observable, by the names of `observables.NAMES`."""
        return self.point.verdicts


def asked(scene: Scene, design: Design, mass: MassProperties, interval: float | None = None) -> Experiment:
    """Results of a scene: with landings where it is in space, and samples `interval` s apart."""
    in_space = resolve(scene, design, mass).model == "space"
    few = scene.run.runs * scene.run.seconds <= MOST_S
    return Experiment(scene, design, mass, impacts=in_space and few, sample_interval=interval)


def measure(experiment: Experiment, progress: Progress, wanted: Tolerance | None = None, of: str = SPEED) -> Simulated:
    """Simulate what is asked, and measure motion and landings of a walker in space.

    With an error of the observable `of` as many runs as that needs, without landings. Raises
    InputError where the scene contradicts itself, asks for too many samples, or no number of runs
    gives the observable to an error.
    """
    if experiment.sample_interval is not None:
        trajectory.check(experiment.scene, experiment.sample_interval, experiment.scene.run.runs)
    if wanted is None:
        return measured(experiments.measure(experiment, progress), experiment, progress)
    few = experiment._replace(impacts=False, sample_interval=None)
    measured_point = ensembles.measure(few, progress, wanted, of)
    simulated = measured(measured_point.results, few._replace(scene=measured_point.scene), progress)
    return simulated._replace(chosen=measured_point.chosen())


def measured(point: Results, experiment: Experiment, progress: Progress = silent) -> Simulated:
    """What a simulated point says of shared orbits and, in space, of motion and landings."""
    values = resolution.values(point.summary)
    errors = resolution.errors(point.verdicts, point.summary)
    shared = orbit.of(point, experiment, progress)
    if shared is not None:
        point = point._replace(summary=orbit.of_prints(point.summary, shared))
        errors = dict.fromkeys(errors)
    simulated = Simulated(point, experiment.scene, values, errors, shared)
    if point.model != "space":
        return simulated
    good = [result for result in point.results if result.outcome in ENDED_WELL]
    if not good:
        return simulated._replace(untold="no run ended well")
    moved, untold = motion_of(good, experiment.scene.arena.kind == "lane", experiment.sample_interval)
    legs = names.legs(experiment.design)
    landed = [_landings(result, len(legs)) for result in good] if experiment.impacts else []
    return simulated._replace(motion=moved, untold=untold, landings=landed, legs=legs)


def _landings(result: RunResult, feet: int) -> Landings:
    """Landings of a run on the plate; walls are touched by points beyond the corners' numbers."""
    rows = impacts_of(result)
    rows = rows[rows[:, 1] < feet * landings.CORNERS]
    return landings.count(rows[:, 0], rows[:, 1].astype(np.int64), result.measured_s, feet)
