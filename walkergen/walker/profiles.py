"""Profiles of legs and braces in the plane: polygons with the anchor at the origin, y <= 0."""

import math

import numpy as np
import numpy.typing as npt

from walkergen.walker.limbs import Limb

Polygon = npt.NDArray[np.float64]


def limb(limb: Limb, segments: int) -> list[Polygon]:
    """Profile of a leg and of its brace if it has one, counter-clockwise.

    `segments`: edges of a round foot's half circle.
    """
    leg = _leg(limb, segments)
    return [leg, _brace(limb)] if limb.braced else [leg]


def raised(profile: Polygon, embedding: float) -> Polygon:
    """Profile that reaches `embedding` mm higher, into the body."""
    left, right = profile[0], profile[-1]
    up = np.array([0.0, embedding])
    return np.concatenate([profile, [right + up, left + up]])


def _leg(limb: Limb, segments: int) -> Polygon:
    """Profile of a leg below the bottom face (y <= 0)."""
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
    return np.vstack([-top, foot, top])


def _half_circle(tilt: float, segments: int) -> Polygon:
    """Unit half circle below a leg, counter-clockwise, a vertex exactly at its lowest point."""
    start, lowest, end = math.pi - tilt, 1.5 * math.pi, 2.0 * math.pi - tilt
    before = max(1, round(segments * (lowest - start) / math.pi))
    after = max(1, segments - before)
    angles = np.concatenate([np.linspace(start, lowest, before + 1), np.linspace(lowest, end, after + 1)[1:]])
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    circle[before] = (0.0, -1.0)
    return circle


def _brace(limb: Limb) -> Polygon:
    """Profile of the vertical support from the foot to the bottom face, in the leg's frame."""
    x, half = limb.brace_offset, 0.5 * limb.brace
    reach = limb.length - (0.5 * limb.thickness if limb.foot == "round" else 0.0)
    y = -reach * math.cos(limb.tilt)
    slope = math.tan(limb.tilt) if limb.foot == "square" else 0.0
    left, right = (x - half, y + slope * half), (x + half, y - slope * half)
    return np.array([(x - half, 0.0), left, right, (x + half, 0.0)])
