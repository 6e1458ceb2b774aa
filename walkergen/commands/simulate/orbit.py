"""Orbits that all runs share: these then agree to rounding, and prints tell the scatter."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.files.progress import Progress
from walkergen.core.simulation import orbits
from walkergen.core.simulation.ensemble import Summary
from walkergen.core.simulation.run import ENDED_WELL
from walkergen.points.experiments import Results

if TYPE_CHECKING:
    from walkergen.points.print_ensemble import Bounds

PRINT_DRAWS, MAX_RUN_S = 24, 4.0
"""Number of prints drawn in place of runs, and measured time of a print's run at most, s."""


class Orbit(NamedTuple):
    """Orbit on which all runs end, and how speeds differ from print to print."""

    kind: str
    """Name of it, of `orbits`: one periodic orbit, or at rest."""
    draws: int
    """Prints simulated for the bounds."""
    bounds_mm_s: "Bounds | None"
    """Speeds below which 2.5, 16, 84 and 97.5 % of prints run; None where it is not known."""
    reason: str = ""
    """Reason why it is not known; "" where it is."""


def find_shared_orbit(point: Results, progress: Progress) -> Orbit | None:
    """Orbit that all runs of a point share, with bounds by draws of the print; None for none.

    Nothing is drawn after Ctrl-C, which left runs out.
    """
    walker, scene = point.walker, point.walker.scene
    good = [result.speed for result in point.results if result.outcome in ENDED_WELL]
    kind = orbits.common_orbit(np.array(good), walker.shaken.peak_speed)
    if not kind or len(good) < scene.run.runs:
        return None
    from walkergen.points import print_ensemble as draws

    run = scene.run.model_copy(update={"seconds": min(scene.run.seconds, MAX_RUN_S)})
    short = scene.model_copy(update={"run": run})
    try:
        drawn = draws.simulate_prints(short, walker.design, PRINT_DRAWS, progress)
    except InputError as error:
        return Orbit(kind, 0, None, error.text)
    ends = draws.speed_bounds(drawn.halves.mean(axis=1), draws.statistical_error(drawn.halves))
    mean = float(drawn.halves.mean())
    return Orbit(kind, len(drawn.halves), draws.add_step_error(ends, mean, drawn.by_step_mm_s))


def with_print_bounds(summary: Summary, orbit: Orbit) -> Summary:
    """Summary of runs on one orbit: without errors by their scatter, its bounds those of prints."""
    low2, low1, high1, high2 = orbit.bounds_mm_s or (None, None, None, None)
    return summary._replace(
        speed_se_mm_s=None,
        speed_low_68_mm_s=low1,
        speed_high_68_mm_s=high1,
        speed_low_95_mm_s=low2,
        speed_high_95_mm_s=high2,
        errors=dict.fromkeys(summary.errors),
    )
