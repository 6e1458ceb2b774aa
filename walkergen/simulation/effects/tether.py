"""Tether: a spring from a point of the body to a point over the plate, slack below its length.

F = k (d - l) along the line between both, for distances d > l (R. Hooke, 1678), without damping.
Its end stands still in the laboratory: heights count from the middle of the plate's motion. The
point is fixed to the centre of mass of the whole walker and to the body's axes (docs/physics.md
section 5). Limits: slack, it is as if it were not there; from the centre of mass it turns nothing.
"""

import math
from typing import NamedTuple

from walkergen.numerics.kernels import lean
from walkergen.scene import GRAVITY, Tether
from walkergen.simulation.effects.effect import Case, Effect, Rule, called_for, only_in_space

NAME, SWITCH, KEY = "tether", "tether", "tether.stiffness_n_per_m"

FROM_N_PER_M = 1e3
"""g/s^2 in 1 N/m."""


class Spring(NamedTuple):
    """A tether: lengths in mm, in the axes of `space.state` (x forward, y up, z to the right)."""

    stiffness: float
    """Stiffness, g/s^2."""
    length: float
    """Length up to which it is slack, > 0."""
    end: tuple[float, float, float]
    """Its end over the plate, in the laboratory."""
    place: tuple[float, float, float]
    """Its point of the body from the centre of mass of the walker, body axes."""


OFF = Spring(0.0, 1.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
"""No tether."""


def judge(case: Case) -> Effect:
    """Effect on where the scene's tether has a stiffness. Raises InputError for planar models."""
    tether = case.scene.tether
    stiff = tether.stiffness_n_per_m
    on, reason = called_for(case, KEY, SWITCH)
    if on:
        only_in_space(case, KEY, stiff, "a tether", SWITCH)
    weight = GRAVITY * (float(case.mass.M) + sum(float(leg.m) for leg in case.mass.legs))
    number = FROM_N_PER_M * stiff * case.design.foot_span / weight
    meaning = "its force, stretched by the distance of the feet, over the weight"
    return Effect(NAME, on, number, meaning, reason, SWITCH)


RULE = Rule(judge, SWITCH, planar=False, away={"tether": Tether()}, usual={KEY: 0.05})


def parameters(case: Case) -> Spring:
    """Tether of the scene."""
    tether = case.scene.tether
    return Spring(
        FROM_N_PER_M * tether.stiffness_n_per_m,
        tether.length_mm,
        (tether.x_mm, tether.height_mm, -tether.y_mm),
        (tether.forward_mm, tether.up_mm, -tether.left_mm),
    )


@lean
def acts(spring):
    """True where there is a tether, taut or slack."""
    return spring.stiffness > 0.0


@lean
def _line(spring, x, y, z, R):
    """Vector (mm) from the tether's point of the body to its end, and their distance."""
    p, end = spring.place, spring.end
    d_x = end[0] - x - (R[0, 0] * p[0] + R[0, 1] * p[1] + R[0, 2] * p[2])
    d_y = end[1] - y - (R[1, 0] * p[0] + R[1, 1] * p[1] + R[1, 2] * p[2])
    d_z = end[2] - z - (R[2, 0] * p[0] + R[2, 1] * p[1] + R[2, 2] * p[2])
    return d_x, d_y, d_z, math.sqrt(d_x * d_x + d_y * d_y + d_z * d_z)


@lean
def pull(spring, x, y, z, R):
    """Force (g mm/s^2) and place (mm, from C) of a walker's tether, body axes.

    The walker's centre of mass C is at (x, y, z); R: body axes -> world.
    """
    if spring.stiffness == 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    d_x, d_y, d_z, distance = _line(spring, x, y, z, R)
    s = spring.stiffness * max(distance - spring.length, 0.0) / max(distance, 1e-300)
    p = spring.place
    return (
        s * (R[0, 0] * d_x + R[1, 0] * d_y + R[2, 0] * d_z),
        s * (R[0, 1] * d_x + R[1, 1] * d_y + R[2, 1] * d_z),
        s * (R[0, 2] * d_x + R[1, 2] * d_y + R[2, 2] * d_z),
        p[0],
        p[1],
        p[2],
    )


@lean
def potential(spring, x, y, z, R):
    """Energy of the spring, g mm^2/s^2."""
    if spring.stiffness == 0.0:
        return 0.0
    _, _, _, distance = _line(spring, x, y, z, R)
    stretch = max(distance - spring.length, 0.0)
    return 0.5 * spring.stiffness * stretch * stretch


@lean
def strongest(spring, x, y, z, R, way):
    """Largest force (g mm/s^2) while no point of the body moves by more than `way` (mm), and the
    distance (mm) of its place from the centre of mass.
    """
    if spring.stiffness == 0.0:
        return 0.0, 0.0
    _, _, _, distance = _line(spring, x, y, z, R)
    p = spring.place
    arm = math.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2])
    return spring.stiffness * max(distance + way - spring.length, 0.0), arm
