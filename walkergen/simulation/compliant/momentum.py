"""Momentum of body and legs as one: their centre, how it moves, and their turning about it.

A step's rates are those of the body and its legs, whose centre moves against the body as the legs
turn: so a step keeps momentum only to its order, and what it misses adds up. `keep` gives it back,
by a motion of all as one rigid body: what pushes along the plate, and turns, are impulses alone.
"""

import math
from typing import NamedTuple

from walkergen.numerics.kernels import inlined, kernel
from walkergen.simulation.compliant.chain import turned
from walkergen.simulation.world import ANGLE_BACK, ANGLE_FRONT, PITCH, RATE_BACK, RATE_FRONT, SPIN, V_X, V_Y


class Whole(NamedTuple):
    """Body and legs as one."""

    x: float
    y: float
    """Vector O -> centre of mass of all, mm."""
    v_x: float
    v_y: float
    """Velocity of that centre in the laboratory, mm/s."""
    turning: float
    """Angular momentum about it, g mm^2/s."""
    inertia: float
    """Moment of inertia about it, g mm^2."""


@kernel
def total_mass(walker):
    """Mass of body and legs, g."""
    return walker.mass + (1.0 + walker.ratios.mass) * walker.legs[0].mass


@inlined
def whole_of(walker, state):
    """Body and legs as one, at the pose and the rates of `state`."""
    return _whole_of(walker.legs, walker, state)


@inlined
def _whole_of(legs, walker, state):
    cos, sin = math.cos(state[PITCH]), math.sin(state[PITCH])
    psi_b, psi_f = state[PITCH] + state[ANGLE_BACK], state[PITCH] + state[ANGLE_FRONT]
    A_b, A_f = turned(walker.anchors[0], cos, sin), turned(walker.anchors[1], cos, sin)
    C_b = turned(legs[0].centre, math.cos(psi_b), math.sin(psi_b))
    C_f = turned(legs[1].centre, math.cos(psi_f), math.sin(psi_f))
    return _whole(legs, walker, state, (A_b, C_b), (A_f, C_f))


@inlined
def whole_at(walker, state, chain):
    """The same, where the chain at that pose is there already."""
    b, f = chain.back, chain.front
    back, front = ((b.A_x, b.A_y), (b.C_x, b.C_y)), ((f.A_x, f.A_y), (f.C_x, f.C_y))
    return _whole(walker.legs, walker, state, back, front)


@inlined
def _whole(legs, walker, state, back, front):
    spin = state[SPIN]
    b_m, b_x, b_y, b_vx, b_vy, b_t, b_i = _of_leg(legs[0], back, spin, spin + state[RATE_BACK])
    f_m, f_x, f_y, f_vx, f_vy, f_t, f_i = _of_leg(legs[1], front, spin, spin + state[RATE_FRONT])
    mass = walker.mass + (b_m + f_m)
    x, y, v_x, v_y = (b_x + f_x) / mass, (b_y + f_y) / mass, (b_vx + f_vx) / mass, (b_vy + f_vy) / mass
    turning = walker.inertia * spin + (b_t + f_t) - mass * (x * v_y - y * v_x)
    inertia = walker.inertia + (b_i + f_i) - mass * (x * x + y * y)
    return Whole(x, y, state[V_X] + v_x, state[V_Y] + v_y, turning, inertia)


@kernel
def _of_leg(leg, place, spin, own_spin):
    """Mass, first moments (x, y), their rates, angular momentum and inertia about O, against O.

    `place`: vectors O -> anchor and anchor -> centre of the leg.
    """
    A, C = place
    m, x, y = leg.mass, A[0] + C[0], A[1] + C[1]
    v_x, v_y = -spin * A[1] - own_spin * C[1], spin * A[0] + own_spin * C[0]
    own = leg.inertia - m * (C[0] * C[0] + C[1] * C[1])
    return m, m * x, m * y, m * v_x, m * v_y, m * (x * v_y - y * v_x) + own * own_spin, m * (x * x + y * y) + own


@inlined
def keep(walker, state, v_x, v_y, turning):
    """Move and turn all as one rigid body, so that its centre has the velocity (v_x, v_y, mm/s) and
    its angular momentum is `turning`; returns it after.
    """
    after = whole_of(walker, state)
    spin = (turning - after.turning) / after.inertia
    state[SPIN] += spin
    state[V_X] += v_x - after.v_x + spin * after.y
    state[V_Y] += v_y - after.v_y - spin * after.x
    return after
