"""Braced legs: the bar of a flexible leg with an upright brace from its foot, rigid with the body."""

import math

import numpy as np

from walkergen.core.walker.limbs import Limb, Polygon, Strut
from walkergen.core.walker.sections import flexible
from walkergen.core.walker.sections.flexible import second_moment as second_moment
from walkergen.core.walker.sections.flexible import torsion_constant as torsion_constant

PLASTIC_TOLERANCE = 0.08
"""A brace shares lines with its leg where they meet (measured; `printing.walls`)."""


def profile(limb: Limb, segments: int) -> list[Polygon]:
    """Return the profiles of the leg and of its brace, as `flexible` has them."""
    return [*flexible.profile(limb, segments), _brace_profile(limb)]


def struts(limb: Limb) -> tuple[Strut, ...]:
    """Return its brace, whose middle is on the foot."""
    reach = limb.length - (0.5 * limb.thickness if limb.foot == "round" else 0.0)
    return (Strut(-reach * math.sin(limb.tilt), limb.brace),)


def axial(limb: Limb) -> float:
    """Return the stiffness of leg and brace together, over Young's modulus times the width."""
    return 1.0 / _compliance(limb)


def _compliance(limb: Limb) -> float:
    """Return the axial compliance of a leg and its upright brace, times modulus and width, dimensionless.

    Cuts in series, each as wide as the leg's and the brace's parts that do not overlap: at the
    foot the brace lies in the leg, which leaves it by tan(tilt) a height. An upright leg hides its
    brace wholly.
    """
    height, slope = limb.length * math.cos(limb.tilt), math.tan(abs(limb.tilt))
    leg, hidden = limb.thickness * math.cos(limb.tilt), min(limb.brace, 2.0 * limb.half_width)
    least = leg + limb.brace - hidden
    inside = 0.5 * abs(2.0 * limb.half_width - limb.brace)
    if slope * height <= inside:
        return height / least
    parting = min(slope * height - inside, hidden)
    beside = height - (inside + parting) / slope
    return inside / slope / least + math.log1p(parting / least) / slope + beside / (leg + limb.brace)


def problems(limb: Limb) -> list[str]:
    """Return the problem of a brace wider than its foot supports."""
    foot_width = (
        limb.thickness * {"flat": 1.0 / math.cos(limb.tilt), "square": math.cos(limb.tilt), "round": 1.0}[limb.foot]
    )
    if limb.brace <= foot_width:
        return []
    return [f"the brace ({limb.brace:g} mm) is thicker than its foot ({foot_width:.3f} mm)"]


def _brace_profile(limb: Limb) -> Polygon:
    """Return the profile of the brace, from the foot to the underside."""
    x, half = struts(limb)[0].offset, 0.5 * limb.brace
    reach = limb.length - (0.5 * limb.thickness if limb.foot == "round" else 0.0)
    y = -reach * math.cos(limb.tilt)
    slope = math.tan(limb.tilt) if limb.foot == "square" else 0.0
    left, right = (x - half, y + slope * half), (x + half, y - slope * half)
    return np.array([(x - half, 0.0), left, right, (x + half, 0.0)])
