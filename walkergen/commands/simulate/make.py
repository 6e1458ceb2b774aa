"""Simulation of a walker: the speed of its runs, their motion and landings, and an orbit that all runs may share."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.analysis import landings
from walkergen.analysis.landings import Landings
from walkergen.analysis.motion import Motion
from walkergen.core.errors import InputError
from walkergen.core.files.progress import Expect, Progress, ignore_estimate, silent
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.scene import Scene
from walkergen.core.simulation import ensemble, observables
from walkergen.core.simulation.ensemble import Summary
from walkergen.core.simulation.observables import SPEED
from walkergen.core.simulation.run import ENDED_WELL, RunResult, recorded_impacts
from walkergen.core.tolerance import Tolerance
from walkergen.core.walker import names
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties
from walkergen.points import trajectory, walkers
from walkergen.points.effect_selection import Simplest
from walkergen.points.experiments import Results, Walker
from walkergen.points.walkers import ErrorResult

PRINT_DRAWS, MAX_RUN_S = 24, 4.0
"""Number of simulated prints if all runs share an orbit, and largest measured time of a print's run, s."""


class Orbit(NamedTuple):
    """Orbit on which all runs end, and the variation of speeds from print to print."""

    kind: str
    """Name of the orbit, from `orbits`: one periodic orbit, or at rest."""
    draws: int
    """Number of prints simulated for the bounds."""
    prints: Quantity
    """Speed of the runs, without an error. Its bounds contain the variation from print to print."""
    reason: str = ""
    """Reason why bounds are missing, otherwise ""."""


def find_shared_orbit(point: Results, progress: Progress) -> Orbit | None:
    """Find the orbit that all runs of a point share, with bounds from simulated prints; None without such an orbit.

    If runs are missing because of Ctrl-C, no prints are simulated and the result is None.
    """
    walker, scene = point.walker, point.walker.scene
    good = [result.speed for result in point.results if result.outcome in ENDED_WELL]
    kind = ensemble.common_orbit(np.array(good), walker.equivalent_drive.peak_speed)
    if not kind or len(good) < scene.run.runs:
        return None
    from walkergen.points import print_ensemble as draws

    speed = point.summary.speed._replace(se=None)
    run = scene.run.model_copy(update={"seconds": min(scene.run.seconds, MAX_RUN_S)})
    short_scene = scene.model_copy(update={"run": run})
    try:
        drawn = draws.simulate_prints(short_scene, walker.design, PRINT_DRAWS, progress)
    except InputError as error:
        return Orbit(kind, 0, speed, error.text)
    bounds = draws.speed_bounds(drawn.halves.mean(axis=1), draws.statistical_error(drawn.halves))
    mean = float(drawn.halves.mean())
    bounds = draws.add_step_error(bounds, mean, drawn.by_step_mm_s)
    return Orbit(kind, len(drawn.halves), speed._replace(ends=bounds))


def with_print_bounds(summary: Summary, orbit: Orbit) -> Summary:
    """Return the summary of runs on one orbit: without errors from scatter, with the speed and bounds of prints."""
    numbers = {name: number._replace(se=None) for name, number in summary.numbers.items()}
    return summary._replace(numbers=numbers | {observables.SPEED: orbit.prints})


MAX_LANDINGS_S = 500.0
"""Largest time of all runs together (s) for which every landing is recorded. They need 0.3 MB a second."""


class Simulation(NamedTuple):
    """Results of a simulated walker: its runs, and what was computed from them."""

    results: Results
    orbit: Orbit | None = None
    """Orbit that all runs share. The runs then have no statistical error, and the bounds are those of prints."""
    motion: Motion | None = None
    no_motion_reason: str = ""
    """Reason why `motion` is missing, otherwise ""."""
    landings: Sequence[Landings] = ()
    """Landings of each run that ended well; empty if they were not recorded."""
    legs: tuple[str, ...] = ()
    """Names of the legs, in the order of their landings."""
    chosen: ErrorResult | None = None
    """Runs chosen to meet a requested error; None without such a request."""
    simplest: Simplest | None = None
    """Effects left out of the scene within its accepted error; None if nothing was tried."""

    @property
    def scene(self) -> Scene:
        """Scene of the runs, with the number of runs and the time step that an error required."""
        return self.results.walker.scene

    def include_omissions(self, simple: Simplest) -> "Simulation":
        """Return these results with bounds of the speed that include the error of the effects left out."""
        results = self.results._replace(summary=simple.widen(self.results.summary))
        chosen = None if self.chosen is None else self.chosen._replace(results=results)
        orbit = None if self.orbit is None else self.orbit._replace(prints=simple.widen_speed(self.orbit.prints))
        return self._replace(results=results, orbit=orbit, chosen=chosen, simplest=simple)


def make_walker(scene: Scene, design: Design, mass: MassProperties, interval: float | None = None) -> Walker:
    """Return a walker in a scene. Short runs record landings. `interval`: time between samples, s; None for none."""
    few = scene.run.runs * scene.run.seconds <= MAX_LANDINGS_S
    return Walker(scene, design, mass, impacts=few, sample_interval=interval)


def measure(
    walker: Walker,
    progress: Progress,
    wanted: Tolerance | None = None,
    of: str = SPEED,
    expect: Expect = ignore_estimate,
) -> Simulation:
    """Simulate a walker as requested, and measure its motion and landings.

    Parameters
    ----------
    walker : Walker
        Walker in its scene.
    progress : Progress
        Callback for progress.
    wanted : Tolerance, optional
        Error to reach. As many runs as necessary are made, without recorded landings.
    of : str
        Observable that has this error.
    expect : Expect
        Callback that receives the expected time after the first runs.

    Raises
    ------
    InputError
        If the scene contradicts itself or requests too many samples, or if no number of runs reaches the error.
    """
    if walker.sample_interval is not None:
        trajectory.check_sample_count(walker.scene, walker.sample_interval, walker.scene.run.runs)
    if wanted is None:
        return analyse_point(walkers.with_measured_step_error(walkers.simulate(walker, progress)), progress)
    met = walkers.simulate_to_error(
        walker._replace(impacts=False, sample_interval=None), wanted, of, progress, expect=expect
    )
    return analyse_point(met.results, progress)._replace(chosen=met)


def analyse_point(point: Results, progress: Progress = silent) -> Simulation:
    """Return the results of the runs of a simulated point: a shared orbit, the motion and the landings."""
    walker = point.walker
    shared = find_shared_orbit(point, progress)
    if shared is not None:
        point = point._replace(summary=with_print_bounds(point.summary, shared))
    simulated = Simulation(point, shared)
    good = [result for result in point.results if result.outcome in ENDED_WELL]
    if not good:
        return simulated._replace(no_motion_reason="no run ended well")
    moved, untold = walkers.motion_of(good, walker.scene, walker.sample_interval)
    legs = names.leg_names(walker.design)
    landed = [_count_landings(result, len(legs)) for result in good] if walker.impacts else []
    return simulated._replace(motion=moved, no_motion_reason=untold, landings=landed, legs=legs)


def _count_landings(result: RunResult, feet: int) -> Landings:
    """Count the landings of a run on the plate, without contacts with walls, whose numbers are above the corners'."""
    rows = recorded_impacts(result)
    rows = rows[rows[:, 1] < feet * landings.CORNERS_PER_FOOT]
    return landings.count(rows[:, 0], rows[:, 1].astype(np.int64), result.measured_s, feet)
