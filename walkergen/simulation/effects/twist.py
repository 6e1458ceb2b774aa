"""Leg twist: each flexible leg turns about its long axis, its foot most, linearly along it.

Saint-Venant's torsion of a thin strip: stiffness G D s^3 / (3 l), G = E / (2 (1 + nu)), as if both
ends were free to warp (a clamped end is 1.34 times as stiff at most; docs/physics.md section 7).
Limits: without twist the foot is rigid along its edge; at infinite stiffness the same.
"""

from walkergen.simulation.effects.compliance import natural_frequency
from walkergen.simulation.effects.effect import Case, Effect, forced
from walkergen.walker.design import Design

NAME, SWITCH = "leg twist", "effects.leg_twist"

POISSON_RATIO = 0.36
"""Poisson's ratio of PLA, assumed."""


def verdict(case: Case) -> Effect:
    """Verdict: on in space for flexible legs. The number is its frequency over the drive's."""
    if case.design.braced:
        return Effect(NAME, False, 0.0, "legs are braced", "no free leg", "")
    spatial = case.model == "space"
    inertia = float(case.mass.m) * case.design.body.depth_mm**2 / 36.0
    ratio = natural_frequency(stiffness(case.design), inertia) / case.scene.drive.frequency
    reason = "corners land one by one" if spatial else f"the {case.model} model is planar"
    on, reason = forced(case.scene.effects.leg_twist, True, reason) if spatial else (False, reason)
    return Effect(NAME, on, ratio, "frequency of a leg's twist over the drive's", reason, SWITCH)


def stiffness(design: Design) -> float:
    """Torsional stiffness of a flexible leg about its long axis, g mm^2/s^2 per rad."""
    modulus = 1e9 * design.material.youngs_modulus_gpa / (2.0 * (1.0 + POISSON_RATIO))
    section = design.body.depth_mm * design.leg_thickness**3 / 3.0
    return modulus * section / design.legs.length_mm
