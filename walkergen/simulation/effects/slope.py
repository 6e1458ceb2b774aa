"""Slope of the plate: it turns gravity in the plate's frame, in which everything else stays.

Limit: slope 0 is the level plate; with friction mu a walker at rest slides from tan(slope) = mu on.
"""

import math
from typing import NamedTuple

from walkergen.numerics.kernels import kernel
from walkergen.scene import GRAVITY
from walkergen.simulation.effects.effect import Case, Effect, forced

NAME, SWITCH = "plate slope", "effects.plate_slope"


class Gravity(NamedTuple):
    """Gravity in the plate's frame, mm/s^2."""

    size: float
    """Acceleration of free fall, > 0."""
    into: float
    """Its component into the plate, > 0."""
    along: float | None
    """Its component along the plate, toward +x; None on a level plate."""


def verdict(case: Case) -> Effect:
    """On when the scene's plate is not level."""
    slope = math.radians(case.scene.plate.slope_deg)
    friction = case.scene.contact.friction
    number = math.tan(slope) / friction if friction > 0 else math.tan(slope)
    reason = "plate.slope_deg" + (" is not 0" if slope != 0 else " = 0")
    on, reason = forced(case.scene.effects.plate_slope, slope != 0, reason)
    return Effect(NAME, on, number, "slope over friction", reason, SWITCH)


def gravity_of(slope: float | None, size: float = GRAVITY) -> Gravity:
    """Gravity (mm/s^2) over a plate that descends toward +x by `slope` rad; None: level."""
    if slope is None:
        return Gravity(size, size, None)
    return Gravity(size, size * math.cos(slope), size * math.sin(slope))


@kernel
def along(component):
    """Gravity along the plate, mm/s^2, for which a level plate has no code."""
    return 0.0 if component is None else component
