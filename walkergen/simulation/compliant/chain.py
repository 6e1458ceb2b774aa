"""Equations of motion of a tree of three rigid bodies (docs/physics.md sections 2 and 5).

A leg is a mass on a hinge: eliminating its angle leaves an apparent mass that the body carries at
the anchor, so that the whole chain is inverted by one 3 x 3 matrix and a number per leg, for any
ratio of the masses. Nothing is linearised.
"""

import math
from typing import NamedTuple

from walkergen.numerics.kernels import inlined, kernel
from walkergen.simulation.drive import height, velocity
from walkergen.simulation.effects.acting import across, along, body_force
from walkergen.simulation.world import (
    ANGLE_BACK,
    ANGLE_FRONT,
    PHASE,
    PITCH,
    RATE_BACK,
    RATE_FRONT,
    SPIN,
    V_X,
    V_Y,
    X,
    Y,
)

LOOSE = (0.0, 0.0)
"""Inertia added to the hinges of either leg where nothing stiffens them, g mm^2."""


class Limb(NamedTuple):
    """One leg in the laboratory's axes: vectors (mm) A = O -> anchor, C = anchor -> centre of mass,
    r = anchor -> foot; maps from the body's rates (v_x, v_y, spin), hinge free: k to minus
    the leg's spin, E (2 x 3) to the foot's velocity; mobility = 1 / inertia about the hinge.
    """

    A_x: float
    A_y: float
    C_x: float
    C_y: float
    r_x: float
    r_y: float
    k_x: float
    k_y: float
    k_t: float
    mobility: float
    E_xx: float
    E_xy: float
    E_xt: float
    E_yx: float
    E_yy: float
    E_yt: float


class Chain(NamedTuple):
    """Inverse mass of a walker: S (3 x 3), inverse apparent mass of the body, and legs."""

    S_xx: float
    S_xy: float
    S_xt: float
    S_yy: float
    S_yt: float
    S_tt: float
    back: Limb
    front: Limb


@kernel
def turned(vector, cos, sin):
    """Vector turned by an angle, from its cosine and sine."""
    return cos * vector[0] - sin * vector[1], sin * vector[0] + cos * vector[1]


@kernel
def _limb(leg, anchor, reach, cos, sin, pitch, alpha, implicit):
    A_x, A_y = turned(anchor, cos, sin)
    c, s = math.cos(pitch + alpha), math.sin(pitch + alpha)
    (C_x, C_y), (r_x, r_y) = turned(leg.centre, c, s), turned(reach, c, s)
    mobility = 1.0 / (leg.inertia + implicit)
    k_x, k_y = -leg.mass * C_y * mobility, leg.mass * C_x * mobility
    k_t = (leg.mass * (A_x * C_x + A_y * C_y) - implicit) * mobility
    return Limb(
        A_x,
        A_y,
        C_x,
        C_y,
        r_x,
        r_y,
        k_x,
        k_y,
        k_t,
        mobility,
        1.0 + r_y * k_x,
        r_y * k_y,
        -A_y + r_y * k_t,
        -r_x * k_x,
        1.0 - r_x * k_y,
        A_x - r_x * k_t,
    )


@kernel
def _carried(leg, limb, implicit):
    """Apparent mass (xx, xy, xt, yy, yt, tt) that a leg on its hinge adds to the body."""
    m, A_x, A_y = leg.mass, limb.A_x, limb.A_y
    p = m * (A_x * limb.C_x + A_y * limb.C_y)
    # The last is m A^2 + implicit - (p - implicit)^2 mobility, without cancellation when stiff
    return (
        m * (1.0 + limb.C_y * limb.k_x),
        m * limb.C_y * limb.k_y,
        m * (-A_y + limb.C_y * limb.k_t),
        m * (1.0 - limb.C_x * limb.k_y),
        m * (A_x - limb.C_x * limb.k_t),
        m * (A_x * A_x + A_y * A_y) + (implicit * (leg.inertia + 2.0 * p) - p * p) * limb.mobility,
    )


@kernel
def chain_of(walker, state, implicit):
    """Chain at the pose of `state`; `implicit` (g mm^2, of either leg) stiffens the hinges of an
    implicit step: h c / 2 + h^2 k / 4 for the trapezoidal rule, `LOOSE` for the true inertia.
    """
    pitch, (leg_b, leg_f), (b_i, f_i) = state[PITCH], walker.legs, implicit
    cos, sin = math.cos(pitch), math.sin(pitch)
    alpha, beta = state[ANGLE_BACK], state[ANGLE_FRONT]
    back = _limb(leg_b, walker.anchors[0], walker.reaches[0], cos, sin, pitch, alpha, b_i)
    front = _limb(leg_f, walker.anchors[1], walker.reaches[1], cos, sin, pitch, beta, f_i)
    b_xx, b_xy, b_xt, b_yy, b_yt, b_tt = _carried(leg_b, back, b_i)
    f_xx, f_xy, f_xt, f_yy, f_yt, f_tt = _carried(leg_f, front, f_i)
    xx, xy, xt = walker.mass + b_xx + f_xx, b_xy + f_xy, b_xt + f_xt
    yy, yt, tt = walker.mass + b_yy + f_yy, b_yt + f_yt, walker.inertia + b_tt + f_tt
    c_xx, c_xy, c_xt = yy * tt - yt * yt, xt * yt - xy * tt, xy * yt - yy * xt
    d = 1.0 / (xx * c_xx + xy * c_xy + xt * c_xt)
    return Chain(
        c_xx * d,
        c_xy * d,
        c_xt * d,
        (xx * tt - xt * xt) * d,
        (xy * xt - xx * yt) * d,
        (xx * yy - xy * xy) * d,
        back,
        front,
    )


@kernel
def _moved(chain, g_x, g_y, g_t, tau_back, tau_front):
    b, f = chain.back, chain.front
    v_x = chain.S_xx * g_x + chain.S_xy * g_y + chain.S_xt * g_t
    v_y = chain.S_xy * g_x + chain.S_yy * g_y + chain.S_yt * g_t
    spin = chain.S_xt * g_x + chain.S_yt * g_y + chain.S_tt * g_t
    return (
        v_x,
        v_y,
        spin,
        b.mobility * tau_back - (b.k_x * v_x + b.k_y * v_y + b.k_t * spin),
        f.mobility * tau_front - (f.k_x * v_x + f.k_y * v_y + f.k_t * spin),
    )


@kernel
def respond(chain, f_x, f_y, f_t, tau_back, tau_front):
    """Change of (v_x, v_y, spin, spin of back leg, of front leg) by generalised impulses.

    f acts on the body's coordinates, tau on the absolute angle of either leg.
    """
    b, f = chain.back, chain.front
    return _moved(
        chain,
        f_x - b.k_x * tau_back - f.k_x * tau_front,
        f_y - b.k_y * tau_back - f.k_y * tau_front,
        f_t - b.k_t * tau_back - f.k_t * tau_front,
        tau_back,
        tau_front,
    )


@kernel
def push(chain, impulses):
    """Change as by `respond`, by impulses (back x, y, front x, y) at the feet, g mm/s."""
    b, f = chain.back, chain.front
    b_x, b_y, f_x, f_y = impulses
    return _moved(
        chain,
        b.E_xx * b_x + b.E_yx * b_y + f.E_xx * f_x + f.E_yx * f_y,
        b.E_xy * b_x + b.E_yy * b_y + f.E_xy * f_x + f.E_yy * f_y,
        b.E_xt * b_x + b.E_yt * b_y + f.E_xt * f_x + f.E_yt * f_y,
        b.r_x * b_y - b.r_y * b_x,
        f.r_x * f_y - f.r_y * f_x,
    )


@kernel
def accelerate(state, change):
    """Add a change of (v_x, v_y, spin, spins of the legs) to the rates of `state`."""
    v_x, v_y, spin, back, front = change
    state[V_X] += v_x
    state[V_Y] += v_y
    state[SPIN] += spin
    state[RATE_BACK] += back - spin
    state[RATE_FRONT] += front - spin


@kernel
def shift(state, change):
    """Add a change of (x, y, pitch, turns of the legs) to the positions of `state`."""
    x, y, turn, back, front = change
    state[X] += x
    state[Y] += y
    state[PITCH] += turn
    state[ANGLE_BACK] += back - turn
    state[ANGLE_FRONT] += front - turn


class Mobility(NamedTuple):
    """Inverse mass at the feet (b back, f front), 1/g: bf_xy gives back v_x by front F_y."""

    bb_xx: float
    bb_xy: float
    bb_yy: float
    ff_xx: float
    ff_xy: float
    ff_yy: float
    bf_xx: float
    bf_xy: float
    bf_yx: float
    bf_yy: float


@kernel
def _carry(chain, e_x, e_y, e_t):
    return (
        chain.S_xx * e_x + chain.S_xy * e_y + chain.S_xt * e_t,
        chain.S_xy * e_x + chain.S_yy * e_y + chain.S_yt * e_t,
        chain.S_xt * e_x + chain.S_yt * e_y + chain.S_tt * e_t,
    )


@kernel
def mobility_of(chain):
    """Inverse mass at the feet: E S E^T, plus each leg's own swing in its own block."""
    b, f = chain.back, chain.front
    x_x, x_y, x_t = _carry(chain, b.E_xx, b.E_xy, b.E_xt)
    y_x, y_y, y_t = _carry(chain, b.E_yx, b.E_yy, b.E_yt)
    p_x, p_y, p_t = _carry(chain, f.E_xx, f.E_xy, f.E_xt)
    q_x, q_y, q_t = _carry(chain, f.E_yx, f.E_yy, f.E_yt)
    return Mobility(
        b.E_xx * x_x + b.E_xy * x_y + b.E_xt * x_t + b.mobility * b.r_y * b.r_y,
        b.E_xx * y_x + b.E_xy * y_y + b.E_xt * y_t - b.mobility * b.r_x * b.r_y,
        b.E_yx * y_x + b.E_yy * y_y + b.E_yt * y_t + b.mobility * b.r_x * b.r_x,
        f.E_xx * p_x + f.E_xy * p_y + f.E_xt * p_t + f.mobility * f.r_y * f.r_y,
        f.E_xx * q_x + f.E_xy * q_y + f.E_xt * q_t - f.mobility * f.r_x * f.r_y,
        f.E_yx * q_x + f.E_yy * q_y + f.E_yt * q_t + f.mobility * f.r_x * f.r_x,
        b.E_xx * p_x + b.E_xy * p_y + b.E_xt * p_t,
        b.E_xx * q_x + b.E_xy * q_y + b.E_xt * q_t,
        b.E_yx * p_x + b.E_yy * p_y + b.E_yt * p_t,
        b.E_yx * q_x + b.E_yy * q_y + b.E_yt * q_t,
    )


@inlined
def longest_leg(walker):
    """Distance from anchor to foot of the longer leg, mm."""
    back, front = walker.reaches
    return max(math.hypot(back[0], back[1]), math.hypot(front[0], front[1]))


@inlined
def gaps(drive, state, chain):
    """Heights of the back and the front foot over the plate, mm."""
    level = state[Y] - height(drive, state[PHASE])
    return level + chain.back.A_y + chain.back.r_y, level + chain.front.A_y + chain.front.r_y


@inlined
def feet_velocities(world, state, chain):
    """Velocities (back x, y, front x, y) of the feet over the plate, mm/s."""
    b, f, spin = chain.back, chain.front, state[SPIN]
    spin_b = spin + state[RATE_BACK]
    spin_f = spin + state[RATE_FRONT]
    v_x, v_y = state[V_X], state[V_Y] - velocity(world.drive, state[PHASE])
    return (
        v_x - spin * b.A_y - spin_b * b.r_y,
        v_y + spin * b.A_x + spin_b * b.r_x,
        v_x - spin * f.A_y - spin_f * f.r_y,
        v_y + spin * f.A_x + spin_f * f.r_x,
    )


@kernel
def feet_changes(chain, change):
    """Changes of the feet's velocities by a change of (v_x, v_y, spin, spins of the legs)."""
    b, f = chain.back, chain.front
    v_x, v_y, spin, spin_b, spin_f = change
    return (
        v_x - spin * b.A_y - spin_b * b.r_y,
        v_y + spin * b.A_x + spin_b * b.r_x,
        v_x - spin * f.A_y - spin_f * f.r_y,
        v_y + spin * f.A_x + spin_f * f.r_x,
    )


@inlined
def feet_turning(state, chain):
    """Accelerations (back x, y, front x, y) of the feet by rotation alone, -spin^2 r, mm/s^2."""
    b, f, spin = chain.back, chain.front, state[SPIN]
    back = (spin + state[RATE_BACK]) ** 2
    front = (spin + state[RATE_FRONT]) ** 2
    spin = spin * spin
    return (
        -spin * b.A_x - back * b.r_x,
        -spin * b.A_y - back * b.r_y,
        -spin * f.A_x - front * f.r_x,
        -spin * f.A_y - front * f.r_y,
    )


@inlined
def corner_height(world, state):
    """Height of the body's lowest corner over the plate, mm; toppled when it reaches zero."""
    sin, cos = math.sin(state[PITCH]), math.cos(state[PITCH])
    lower = min(sin * world.walker.corner_back_x, sin * world.walker.corner_front_x)
    return state[Y] + lower + cos * world.walker.corner_y - height(world.drive, state[PHASE])


@kernel
def energy(world, state):
    """Kinetic, gravitational and elastic energy, g mm^2/s^2 (1e-9 J)."""
    walker = world.walker
    v_x, v_y, spin = state[V_X], state[V_Y], state[SPIN]
    body = 0.5 * (walker.mass * (v_x * v_x + v_y * v_y) + walker.inertia * spin * spin)
    fallen = along(world.acting) * state[X] - across(world.acting) * state[Y]
    return body - walker.mass * fallen + _legs_energy(walker.legs, world, state)


@kernel
def _legs_energy(legs, world, state):
    chain, spin, total = chain_of(world.walker, state, LOOSE), state[SPIN], 0.0
    for leg, limb, alpha, rate in (
        (legs[0], chain.back, state[ANGLE_BACK], state[RATE_BACK]),
        (legs[1], chain.front, state[ANGLE_FRONT], state[RATE_FRONT]),
    ):
        v_x = state[V_X] - spin * limb.A_y - (spin + rate) * limb.C_y
        v_y = state[V_Y] + spin * limb.A_x + (spin + rate) * limb.C_x
        own = leg.inertia - leg.mass * (limb.C_x * limb.C_x + limb.C_y * limb.C_y)
        total += 0.5 * (leg.mass * (v_x * v_x + v_y * v_y) + own * (spin + rate) ** 2)
        total += 0.5 * leg.stiffness * alpha * alpha
        total -= leg.mass * (
            along(world.acting) * (state[X] + limb.A_x + limb.C_x)
            - across(world.acting) * (state[Y] + limb.A_y + limb.C_y)
        )
    return total


@inlined
def free_acceleration(world, state, chain):
    """Accelerations without contact, as in `respond`: by gravity, rotation, springs and effects."""
    return _free(world.walker.legs, world, state, chain)


@inlined
def _free(legs, world, state, chain):
    g_x, g_y, walker = along(world.acting), -across(world.acting), world.walker
    r_x, r_y, r_t, r_b, r_f = rate_forces(world, state, chain)
    b, f, m, m_f, mu = chain.back, chain.front, legs[0].mass, legs[1].mass, walker.ratios.mass
    torque_b = _torque(legs[0], state[ANGLE_BACK], state[RATE_BACK])
    torque_f = _torque(legs[1], state[ANGLE_FRONT], state[RATE_FRONT])
    total = walker.mass + (1.0 + mu) * m
    weight = m * ((b.A_x + mu * f.A_x) * g_y - (b.A_y + mu * f.A_y) * g_x)
    return respond(
        chain,
        r_x + total * g_x,
        r_y + total * g_y,
        r_t + weight - torque_b - torque_f,
        r_b + m * (b.C_x * g_y - b.C_y * g_x) + torque_b,
        r_f + m_f * (f.C_x * g_y - f.C_y * g_x) + torque_f,
    )


@inlined
def rate_forces(world, state, chain):
    """Forces, as in `respond`, that rates make: of rotation, and of effects on the body."""
    return _rate_forces(world.walker.legs, world, state, chain)


@inlined
def _rate_forces(legs, world, state, chain):
    f_x, f_y = body_force(world.acting, state[PITCH], state[V_X], state[V_Y])
    b, f, m, m_f, mu = chain.back, chain.front, legs[0].mass, legs[1].mass, world.walker.ratios.mass
    spin = state[SPIN]
    spin_b, spin_f = spin + state[RATE_BACK], spin + state[RATE_FRONT]
    spin, spin_b, spin_f = spin * spin, spin_b * spin_b, spin_f * spin_f
    cross_b, cross_f = b.A_x * b.C_y - b.A_y * b.C_x, f.A_x * f.C_y - f.A_y * f.C_x
    A_x, A_y = b.A_x + mu * f.A_x, b.A_y + mu * f.A_y
    return (
        f_x + m * (spin * A_x + spin_b * b.C_x + mu * (spin_f * f.C_x)),
        f_y + m * (spin * A_y + spin_b * b.C_y + mu * (spin_f * f.C_y)),
        m * (spin_b * cross_b + mu * (spin_f * cross_f)),
        -(m * spin * cross_b),
        -(m_f * spin * cross_f),
    )


@kernel
def _torque(leg, alpha, rate):
    return -leg.stiffness * alpha - leg.damping * rate


@inlined
def power_lost(world, pitch, v_x, v_y, rate_b, rate_f):
    """Power (g mm^2/s^3) that the legs' dampers take at the rates of both legs (rad/s), and effects
    from a body with that pitch (rad) and velocity (mm/s).
    """
    f_x, f_y = body_force(world.acting, pitch, v_x, v_y)
    rates = rate_b * rate_b + world.walker.ratios.damping * (rate_f * rate_f)
    return world.walker.legs[0].damping * rates - (f_x * v_x + f_y * v_y)
