"""Sway of the plate as kernels know it: motion along it, and heights linear in place, at the drive's frequency.

What a scene makes of it: `swaying_plate`; a scene without sway imports this alone.
"""

import math
from typing import NamedTuple

from walkergen.core.numerics.kernels import lean

Four = tuple[float, float, float, float]


class Sway(NamedTuple):
    """A plate that moves along itself and tilts: displacements along x and z, mm, then slopes along both."""

    moves: bool
    """Whether it does either."""
    with_sine: Four
    """Amplitudes of what goes with the sine of the drive's phase, as the plate's height does,"""
    with_cosine: Four
    """and a quarter of a period ahead of it."""


OFF = Sway(False, (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0))
"""A plate that moves up and down equally everywhere."""


@lean
def moves(sway):
    """Return whether points of the plate do more than move up and down together."""
    return sway.moves


@lean
def displacements_and_slopes(sway, phase):
    """Return the displacements (mm) and slopes along x and z at a phase (rad) of the drive."""
    p, q, s, c = sway.with_sine, sway.with_cosine, math.sin(phase), math.cos(phase)
    return s * p[0] + c * q[0], s * p[1] + c * q[1], s * p[2] + c * q[2], s * p[3] + c * q[3]


@lean
def motion(sway, omega, phase, x, z):
    """Compute velocity (mm/s), then acceleration (mm/s^2), along x, y, z of the plate's point (x, z), mm.

    Both are relative to the vertical motion of the plate's middle.
    """
    p, q, s, c = sway.with_sine, sway.with_cosine, math.sin(phase), math.cos(phase)
    v_x, v_z, t_x, t_z = c * p[0] - s * q[0], c * p[1] - s * q[1], c * p[2] - s * q[2], c * p[3] - s * q[3]
    a_x, a_z, b_x, b_z = displacements_and_slopes(sway, phase)
    square = -omega * omega
    return (
        omega * v_x,
        omega * (t_x * x + t_z * z),
        omega * v_z,
        square * a_x,
        square * (b_x * x + b_z * z),
        square * a_z,
    )


@lean
def bounds(sway):
    """Return the largest displacement (mm) and slope."""
    p, q = sway.with_sine, sway.with_cosine
    return (
        math.sqrt(p[0] * p[0] + p[1] * p[1] + q[0] * q[0] + q[1] * q[1]),
        math.sqrt(p[2] * p[2] + p[3] * p[3] + q[2] * q[2] + q[3] * q[3]),
    )
