"""Effects of flexible legs: their foot tensor, their swing on a torsional spring, and their twist.

Tensor: the joints carry force but no torque in an impact (paper, eqs 8-12); locked joints give that of one rigid body
(paper, eq. 4). Swing: each leg turns about its anchor, with a damper; stiff legs slide like braced legs
(tests/core/simulation/test_engines.py). Twist: each leg turns about its long axis, its foot most, linearly along it;
at infinite stiffness the foot is rigid along its edge. Source: docs/physics.md section 7.
"""

import math
from collections.abc import Mapping

from walkergen.core.simulation.effects.effect import Case, Effect, Rule, absence_reason, apply_switch
from walkergen.core.walker import names
from walkergen.core.walker.limbs import Limb
from walkergen.core.walker.sections import section_of
from walkergen.core.walker.spec import Material

TENSOR, COMPLIANCE = "flexible foot tensor", "leg compliance"
TWIST, TWIST_SWITCH = "leg twist", "leg_twist"

EQUAL_FREQUENCY_RATIO = 1.0 + 1e-6
"""Ratio of frequencies below which legs count as equal: meshes give their masses only to rounding."""

CANTILEVER_FACTOR = 3.0
"""Torsional stiffness times length over E I that gives a cantilever's static tip stiffness (physics.md, 5)."""


def decide_tensor(case: Case) -> Effect:
    """Return the effect "flexible foot tensor": on for flexible legs. The number is a leg's mass over the body's."""
    if case.design.rigid:
        return Effect(TENSOR, False, 0.0, f"legs are {case.design.kind}", "the rigid tensor is exact", "")
    heaviest = max(float(leg.m) for leg in case.mass.legs)
    ratio, meaning = heaviest / float(case.mass.M), "mass of a leg over the body's"
    return Effect(TENSOR, True, ratio, meaning, "part of the chain of body and legs", "")


def decide_compliance(case: Case) -> Effect:
    """Return the effect "leg compliance": on if legs swing. Number: slowest leg's frequency over the drive's."""
    scene, design = case.scene, case.design
    if design.rigid:
        return Effect(COMPLIANCE, False, 0.0, f"legs are {design.kind}", "no free leg", "")
    frequencies = {
        name: natural_frequency(hinge_stiffness(limb, design.material.youngs_modulus), float(leg.inertia))
        for name, limb, leg in zip(names.leg_names(design), design.limbs, case.mass.legs, strict=True)
        if leg.m > 0.0
    }
    ratio = min(frequencies.values(), default=0.0) / scene.drive.frequency
    meaning = f"frequency of a free leg over the drive's{_describe_slowest(frequencies)}"
    return Effect(COMPLIANCE, True, ratio, meaning, "legs swing", "")


def decide_twist(case: Case) -> Effect:
    """Return the effect "leg twist": on for flexible legs. Number: lowest twist frequency over the drive's."""
    design = case.design
    if design.rigid:
        reason = absence_reason(case, TWIST_SWITCH, "no free leg")
        return Effect(TWIST, False, 0.0, f"legs are {design.kind}", reason, "")
    # A strip's inertia about its long axis, m w^2 / 12; a third of it, since the twist grows linearly from the anchor
    frequencies = [
        natural_frequency(twist_stiffness(limb, design.material), float(leg.m) * limb.width**2 / 36.0)
        for limb, leg in zip(design.limbs, case.mass.legs, strict=True)
        if leg.m > 0.0
    ]
    ratio = min(frequencies, default=0.0) / case.scene.drive.frequency
    on, reason = apply_switch(case.scene.effects.forced_state(TWIST_SWITCH), True, "corners land one by one")
    return Effect(TWIST, on, ratio, "frequency of a leg's twist over the drive's", reason, TWIST_SWITCH)


TWIST_RULE = Rule(decide_twist, TWIST_SWITCH, typical_values={f"effects.{TWIST_SWITCH}": True})


def _describe_slowest(frequencies: Mapping[str, float]) -> str:
    """Return a text that names the slowest and the fastest leg. `frequencies`: Hz, by leg. "" if all are equal."""
    if len(frequencies) < 2:
        return ""
    slow, fast = (pick(frequencies, key=frequencies.__getitem__) for pick in (min, max))
    ratio = frequencies[fast] / frequencies[slow]
    return f", slowest {slow}; fastest {fast}, {ratio:.3g} times that" if ratio > EQUAL_FREQUENCY_RATIO else ""


def hinge_stiffness(limb: Limb, modulus: float) -> float:
    """Return the torsional stiffness of a flexible leg's hinge, g mm^2/s^2 per rad; modulus in Pa."""
    return CANTILEVER_FACTOR * modulus * section_of(limb).second_moment(limb) / limb.length


def twist_stiffness(limb: Limb, material: Material) -> float:
    """Return the torsional stiffness of a flexible leg about its long axis, g mm^2/s^2 per rad.

    Saint-Venant's torsion of a thin strip, G D s^3 / (3 l) with G = E / (2 (1 + nu)), as if both ends were free to
    warp (a clamped end is 1.34 times as stiff at most; docs/physics.md section 7).
    """
    shear = material.youngs_modulus / (2.0 * (1.0 + material.poisson_ratio))
    return shear * section_of(limb).torsion_constant(limb) / limb.length


def natural_frequency(stiffness: float, inertia: float) -> float:
    """Return the frequency (Hz) of an `inertia` (g mm^2) on a torsional `stiffness` (g mm^2/s^2 per rad)."""
    return math.sqrt(stiffness / inertia) / (2.0 * math.pi)
