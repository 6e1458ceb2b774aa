"""Leg compliance: each leg swings on a torsional spring at its anchor, with a damper.

Source: docs/physics.md section 7. Limit: stiff legs slide like braced legs (tests/core/simulation/test_engines.py).
"""

import math
from collections.abc import Mapping

from walkergen.core.simulation.effects.effect import Case, Effect, Rule
from walkergen.core.walker import names
from walkergen.core.walker.limbs import Limb
from walkergen.core.walker.sections import section_of

NAME = "leg compliance"

EQUAL_FREQUENCY_RATIO = 1.0 + 1e-6
"""Ratio of frequencies below which legs count as equal: meshes give their masses only to rounding."""

CANTILEVER_FACTOR = 3.0
"""Torsional stiffness times length over E I that gives a cantilever's static tip stiffness (physics.md, 5)."""


def judge(case: Case) -> Effect:
    """Judge the effect: on for free legs. The number is the frequency of the slowest leg over the drive's."""
    scene, design = case.scene, case.design
    if design.rigid:
        return Effect(NAME, False, 0.0, f"legs are {design.kind}", "no free leg", "")
    frequencies = {
        name: natural_frequency(stiffness(limb, design.material.youngs_modulus), float(leg.inertia))
        for name, limb, leg in zip(names.leg_names(design), design.limbs, case.mass.legs, strict=True)
        if leg.m > 0.0
    }
    ratio = min(frequencies.values(), default=0.0) / scene.drive.frequency
    meaning = f"frequency of a free leg over the drive's{_describe_slowest(frequencies)}"
    return Effect(NAME, True, ratio, meaning, "legs swing", "")


RULE = Rule(judge)


def _describe_slowest(frequencies: Mapping[str, float]) -> str:
    """Name the slowest and the fastest leg; "" if legs swing alike."""
    if len(frequencies) < 2:
        return ""
    slow, fast = (pick(frequencies, key=frequencies.__getitem__) for pick in (min, max))
    ratio = frequencies[fast] / frequencies[slow]
    return f", slowest {slow}; fastest {fast}, {ratio:.3g} times that" if ratio > EQUAL_FREQUENCY_RATIO else ""


def stiffness(limb: Limb, modulus: float) -> float:
    """Return the torsional stiffness of a flexible leg's hinge, g mm^2/s^2 per rad; modulus in Pa."""
    return CANTILEVER_FACTOR * modulus * section_of(limb).second_moment(limb) / limb.length


def natural_frequency(stiffness: float, inertia: float) -> float:
    """Return the natural frequency (Hz) of a leg with `inertia` (g mm^2) about its anchor, on a held body."""
    return math.sqrt(stiffness / inertia) / (2.0 * math.pi)
