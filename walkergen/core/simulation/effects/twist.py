"""Leg twist: each flexible leg turns about its long axis, its foot most, linearly along it.

Saint-Venant's torsion of a thin strip: stiffness G D s^3 / (3 l), G = E / (2 (1 + nu)), as if both
ends were free to warp (a clamped end is 1.34 times as stiff at most; docs/physics.md section 7).
Limits: without twist the foot is rigid along its edge; at infinite stiffness the same.
"""

from walkergen.core.simulation.effects.compliance import natural_frequency
from walkergen.core.simulation.effects.effect import Case, Effect, Rule, absence_reason, apply_switch
from walkergen.core.walker.limbs import Limb
from walkergen.core.walker.sections import section_of
from walkergen.core.walker.spec import Material

NAME, SWITCH = "leg twist", "leg_twist"


def judge(case: Case) -> Effect:
    """Judge the effect: on for flexible legs.

    The number is the least frequency of a leg's twist over the drive's.
    """
    if case.design.rigid:
        return Effect(NAME, False, 0.0, f"legs are {case.design.kind}", absence_reason(case, SWITCH, "no free leg"), "")
    material = case.design.material
    frequencies = [
        natural_frequency(stiffness(limb, material), float(leg.m) * limb.width**2 / 36.0)
        for limb, leg in zip(case.design.limbs, case.mass.legs, strict=True)
        if leg.m > 0.0
    ]
    ratio = min(frequencies, default=0.0) / case.scene.drive.frequency
    meaning = "frequency of a leg's twist over the drive's"
    on, reason = apply_switch(case.scene.effects.forced_state(SWITCH), True, "corners land one by one")
    return Effect(NAME, on, ratio, meaning, reason, SWITCH)


RULE = Rule(judge, SWITCH, usual={f"effects.{SWITCH}": True})


def stiffness(limb: Limb, material: Material) -> float:
    """Return the torsional stiffness of a flexible leg about its long axis, g mm^2/s^2 per rad."""
    shear = material.youngs_modulus / (2.0 * (1.0 + material.poisson_ratio))
    return shear * section_of(limb).torsion_constant(limb) / limb.length
