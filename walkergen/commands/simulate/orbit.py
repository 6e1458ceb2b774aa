"""Orbits that all runs share. The runs then agree to rounding, and simulated prints give the scatter."""

from typing import NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.files.progress import Progress
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.simulation import ensemble, observables
from walkergen.core.simulation.ensemble import Summary
from walkergen.core.simulation.run import ENDED_WELL
from walkergen.points.experiments import Results

PRINT_DRAWS, MAX_RUN_S = 24, 4.0
"""Number of simulated prints that replace runs, and longest measured time of a print's run, s."""


class Orbit(NamedTuple):
    """Orbit on which all runs end, and the variation of speeds from print to print."""

    kind: str
    """Name of the orbit, from `orbits`: one periodic orbit, or at rest."""
    draws: int
    """Number of prints simulated for the bounds."""
    prints: Quantity
    """Speed of the runs, without an error. Its bounds are those of prints."""
    reason: str = ""
    """Reason why bounds are missing, otherwise ""."""


def find_shared_orbit(point: Results, progress: Progress) -> Orbit | None:
    """Find the orbit that all runs of a point share, with bounds from simulated prints; None without one.

    No prints are simulated after Ctrl-C, which left runs out.
    """
    walker, scene = point.walker, point.walker.scene
    good = [result.speed for result in point.results if result.outcome in ENDED_WELL]
    kind = ensemble.common_orbit(np.array(good), walker.shaken.peak_speed)
    if not kind or len(good) < scene.run.runs:
        return None
    from walkergen.points import print_ensemble as draws

    speed = point.summary.speed._replace(se=None)
    run = scene.run.model_copy(update={"seconds": min(scene.run.seconds, MAX_RUN_S)})
    short = scene.model_copy(update={"run": run})
    try:
        drawn = draws.simulate_prints(short, walker.design, PRINT_DRAWS, progress)
    except InputError as error:
        return Orbit(kind, 0, speed, error.text)
    ends = draws.speed_bounds(drawn.halves.mean(axis=1), draws.statistical_error(drawn.halves))
    mean = float(drawn.halves.mean())
    ends = draws.add_step_error(ends, mean, drawn.by_step_mm_s)
    return Orbit(kind, len(drawn.halves), speed._replace(ends=ends))


def with_print_bounds(summary: Summary, orbit: Orbit) -> Summary:
    """Return the summary of runs on one orbit: no errors from scatter, and the bounds of prints."""
    numbers = {name: number._replace(se=None) for name, number in summary.numbers.items()}
    return summary._replace(numbers=numbers | {observables.SPEED: orbit.prints})
