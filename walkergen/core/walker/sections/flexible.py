"""Flexible legs: a bar as thick all along, which bends at its hinge and twists.

Limits: a stiff bar slides like a rigid leg (docs/physics.md section 6).
"""

import math

import numpy as np

from walkergen.core.walker.limbs import Limb, Polygon, Strut

PLASTIC_TOLERANCE = 0.05
"""Its ends differ from its middle, and only the middle's plastic is known (measured; `printing.walls`)."""


def profile(limb: Limb, segments: int) -> list[Polygon]:
    """Return the leg's side view below the underside, counter-clockwise, shape (n, 2), mm. Its anchor is the origin.

    `segments`: edges of a round foot's half circle.
    """
    sin, cos = math.sin(limb.tilt), math.cos(limb.tilt)
    half, length = 0.5 * limb.thickness, limb.length
    along, across = np.array([-sin, -cos]), np.array([cos, -sin])
    top = np.array([half / cos, 0.0])
    if limb.foot == "round":
        centre = (length - half) * along
        foot = centre + half * _half_circle(limb.tilt, segments)
    elif limb.foot == "square":
        foot = np.array([length * along - half * across, length * along + half * across])
    else:
        foot = np.array([length * along - top, length * along + top])
    return [np.vstack([-top, foot, top])]


def _half_circle(tilt: float, segments: int) -> Polygon:
    """Return the unit half circle below a leg of this tilt (rad), shape (n, 2), with a vertex at its lowest point."""
    start, lowest, end = math.pi - tilt, 1.5 * math.pi, 2.0 * math.pi - tilt
    before = max(1, round(segments * (lowest - start) / math.pi))
    after = max(1, segments - before)
    angles = np.concatenate([np.linspace(start, lowest, before + 1), np.linspace(lowest, end, after + 1)[1:]])
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    circle[before] = (0.0, -1.0)
    return circle


def struts(limb: Limb) -> tuple[Strut, ...]:
    """Return (): a flexible leg has no brace."""
    return ()


def second_moment(limb: Limb) -> float:
    """Return the second moment of the leg's cross-section about the axis across the run, mm^4."""
    return limb.width * limb.thickness**3 / 12.0


def torsion_constant(limb: Limb) -> float:
    """Return the torsion constant of a strip that is much wider than thick, mm^4."""
    return limb.width * limb.thickness**3 / 3.0


def axial(limb: Limb) -> float:
    """Return the stiffness along the leg over Young's modulus times the width, dimensionless."""
    return limb.thickness / limb.length


def problems(limb: Limb) -> list[str]:
    """Return []: every flexible leg can be built."""
    return []
