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
    """Return the side views of the leg and of its brace, shape (n, 2) each, mm. `segments`: edges of a round foot."""
    return [*flexible.profile(limb, segments), _brace_profile(limb)]


def struts(limb: Limb) -> tuple[Strut, ...]:
    """Return the leg's only brace, whose middle is above the foot."""
    length = limb.length - (0.5 * limb.thickness if limb.foot == "round" else 0.0)
    return (Strut(-length * math.sin(limb.tilt), limb.brace),)


def axial(limb: Limb) -> float:
    """Return the stiffness of leg and brace together over Young's modulus times the width, dimensionless."""
    return 1.0 / _compliance(limb)


def _compliance(limb: Limb) -> float:
    """Return the axial compliance of a leg and its upright brace, times modulus and width, dimensionless.

    Horizontal slices act as springs in series, each as stiff as the thickness of leg and brace together. From the foot
    upward the brace first lies inside the leg, then leaves it by tan(tilt) a height, and is apart from it at the top.
    """
    height, slope = limb.length * math.cos(limb.tilt), math.tan(abs(limb.tilt))
    leg, overlap = limb.thickness * math.cos(limb.tilt), min(limb.brace, 2.0 * limb.half_width)
    least = leg + limb.brace - overlap  # thickness of a slice at the foot, mm
    inside = 0.5 * abs(2.0 * limb.half_width - limb.brace)
    if slope * height <= inside:
        return height / least
    parting = min(slope * height - inside, overlap)
    apart_height = height - (inside + parting) / slope
    return inside / slope / least + math.log1p(parting / least) / slope + apart_height / (leg + limb.brace)


def problems(limb: Limb) -> list[str]:
    """Return a message if the brace is thicker than its foot, otherwise an empty list."""
    foot_width = (
        limb.thickness * {"flat": 1.0 / math.cos(limb.tilt), "square": math.cos(limb.tilt), "round": 1.0}[limb.foot]
    )
    if limb.brace <= foot_width:
        return []
    return [f"the brace ({limb.brace:g} mm) is thicker than its foot ({foot_width:.3f} mm). Make it thinner"]


def _brace_profile(limb: Limb) -> Polygon:
    """Return the brace's side view from the underside to the foot, shape (4, 2), mm. The leg's anchor is the origin."""
    x, half = struts(limb)[0].offset, 0.5 * limb.brace
    length = limb.length - (0.5 * limb.thickness if limb.foot == "round" else 0.0)
    y = -length * math.cos(limb.tilt)
    slope = math.tan(limb.tilt) if limb.foot == "square" else 0.0
    left, right = (x - half, y + slope * half), (x + half, y - slope * half)
    return np.array([(x - half, 0.0), left, right, (x + half, 0.0)])
