"""Runs that all end on one periodic orbit: their agreement is no measurement of an error."""

import numpy as np

from walkergen.core.numerics import Array

MIN_RUNS = 4
"""Number of runs below which their agreement may be chance, as for an error of their mean."""

MAX_SPEED_DIFFERENCE = 1e-4
"""Largest difference of two runs' speeds on one orbit, over the plate's peak speed. Runs that start
at random fall into an orbit within some hundred periods to rounding; those that do not repeat
differ by 1e-2 and more after a minute."""

ORBIT, REST = "one periodic orbit", "at rest"
"""Names of what runs end on."""


def common_orbit(speeds: Array, plate_speed: float) -> str:
    """Name of what all runs end on, from their mean speeds, shape (n,), in mm/s as the plate's.

    "" when they differ, or are fewer than MIN_RUNS. A walker driven by a periodic plate and let
    go at random repeats its motion every whole number of drive periods, or never; only in the first
    case can all runs have one speed. REST is the orbit that does not move.
    """
    if len(speeds) < MIN_RUNS or float(np.ptp(speeds)) > MAX_SPEED_DIFFERENCE * plate_speed:
        return ""
    return REST if not np.any(speeds) else ORBIT
