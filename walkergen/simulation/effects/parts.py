"""Effects that are part of a model: their numbers tell what matters, and nothing switches them."""

import math

from walkergen.simulation.effects.effect import Case, Effect
from walkergen.theory.tensors import feet

LANE = "the scene is a lane: the walker stays in its plane"

RARE = 50.0
"""Peak acceleration over g from which feet hardly rest on the plate."""


def sticking(case: Case) -> Effect:
    """Sticking of a foot within an impact."""
    friction = case.scene.contact.friction
    ratios = [
        friction * float(H.xx) / abs(float(H.xy)) if H.xy != 0.0 else math.inf
        for H in feet(case.mass)
    ]
    on = max(ratios) >= 1.0
    reason = "friction can hold a foot" if on else "feet always slide on in single impacts"
    meaning = "friction over |H_xy|/H_xx, the larger of both feet"
    number = min(max(ratios), 1e9)  # infinite for an upright leg: written as a large number
    return Effect("sticking in impacts", on, number, meaning, reason, "")


def sustained(case: Case) -> Effect:
    """Contact that lasts."""
    gamma = case.scene.drive.peak_gamma
    reason = "bounces die out and feet rest on the plate" if gamma < RARE else "rare at this drive"
    return Effect("sustained contact", True, gamma, "peak acceleration over g", reason, "")


def pitch(case: Case) -> Effect:
    """Turning in the plane."""
    number = case.design.legs.contact_spacing_mm / case.design.body.length_mm
    return Effect("pitch", True, number, "contact spacing over body length", "two feet", "")


def yaw_and_roll(case: Case) -> Effect:
    """Turning out of the plane, which needs a model in space."""
    depth = case.design.body.depth_mm / case.design.legs.contact_spacing_mm
    return Effect("yaw and roll", False, depth, "depth over contact spacing", LANE, "")


def lane_walls(case: Case) -> Effect:
    """Walls of a lane, which need yaw."""
    return Effect("lane walls", False, 0.0, "needs yaw", LANE, "")


def neighbours(case: Case) -> Effect:
    """Neighbours on the plate, which need a plane."""
    return Effect("neighbours", False, 0.0, "other walkers", "one walker alone", "")
