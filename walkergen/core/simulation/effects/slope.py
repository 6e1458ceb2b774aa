"""Slope of the plate: gravity is turned in the plate's frame, and nothing else changes.

Limits: slope 0 is the level plate; a walker at rest starts to slide beyond tan(slope) = mu.
"""

import math
from typing import NamedTuple

from walkergen.core.scene import GRAVITY
from walkergen.core.simulation.effects.effect import Case, Effect, Rule, decide_from_key

NAME, SWITCH, KEY = "plate slope", "plate_slope", "plate.slope_deg"


class Gravity(NamedTuple):
    """Gravity in the plate's frame, mm/s^2."""

    size: float
    """Acceleration of free fall, > 0."""
    into: float
    """Component of gravity into the plate, > 0."""
    along: float
    """Component of gravity along the plate, toward +x."""


def decide(case: Case) -> Effect:
    """Return the effect "plate slope". Its number is the slope over the friction coefficient."""
    slope = math.radians(case.scene.plate.slope_deg)
    friction = case.scene.contact.friction
    number = math.tan(slope) / friction if friction > 0 else math.tan(slope)
    on, reason = decide_from_key(case, KEY, SWITCH)
    return Effect(NAME, on, number, "slope over friction", reason, SWITCH)


RULE = Rule(decide, SWITCH, absent_values={KEY: 0.0}, typical_values={KEY: 2.0})


def gravity_of(slope: float, size: float = GRAVITY) -> Gravity:
    """Return the gravity in the frame of a plate that descends toward +x by `slope` (rad). `size` is g, mm/s^2."""
    return Gravity(size, size * math.cos(slope), size * math.sin(slope))
