"""Flight of the compliant walker: exact for the linear legs, corrected for what is not linear.

The centre of mass of body and legs falls freely, exactly. In the body's frame the legs are two
uncoupled damped oscillators (`Swing`), whatever the pitch, also exact; the rest (finite angles,
centrifugal forces, what unlike dampers couple) is a kick in the middle of the flight: the flow is
of second order in its length, with an error that vanishes for small angles of legs damped alike.
"""

import math

from walkergen.numerics.kernels import inlined, kernel
from walkergen.simulation.compliant.chain import LOOSE, chain_of, free_acceleration, longest_leg
from walkergen.simulation.compliant.momentum import keep, total_mass, whole_of
from walkergen.simulation.drive import derivative_bound, moved_on, velocity
from walkergen.simulation.effects.acting import across, along, body_force
from walkergen.simulation.record import DAMPING_LOSS
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


@inlined
def fly(world, state, t, sums):
    """Free flight of `t` seconds, in place; what damping and effects take goes to `sums`."""
    _fly(world.walker.legs, world, state, t, sums)
    state[PHASE] = moved_on(world.drive, state[PHASE], t)


@inlined
def _fly(legs, world, state, t, sums):
    walker, x_0, y_0 = world.walker, state[X], state[Y]
    a_x, a_y, f_x, f_y = _falling(world, state, total_mass(walker), t)
    before = whole_of(walker, state)
    _swing(legs, walker, state, 0.5 * t, sums)
    _kick(legs, world, state, t, sums)
    _swing(legs, walker, state, 0.5 * t, sums)
    v_x, v_y = before.v_x + t * a_x, before.v_y + t * a_y
    after = keep(walker, state, v_x, v_y, before.turning + t * (before.y * f_x - before.x * f_y))
    state[X] = x_0 + before.x - after.x + 0.5 * t * (before.v_x + v_x)
    state[Y] = y_0 + before.y - after.y + 0.5 * t * (before.v_y + v_y)
    sums[DAMPING_LOSS] -= f_x * (state[X] - x_0) + f_y * (state[Y] - y_0)


@inlined
def _falling(world, state, mass, t):
    """Acceleration (x, y) of the centre of mass of all and force (x, y) of effects on the body, at
    the middle of a flight of t seconds.
    """
    acting, pitch, v_x, v_y = world.acting, state[PITCH], state[V_X], state[V_Y]
    f_x, f_y = body_force(acting, pitch, v_x, v_y)
    v_x += 0.5 * t * (along(acting) + f_x / mass)
    v_y += 0.5 * t * (f_y / mass - across(acting))
    f_x, f_y = body_force(acting, pitch + 0.5 * t * state[SPIN], v_x, v_y)
    return along(acting) + f_x / mass, f_y / mass - across(acting), f_x, f_y


@kernel
def _oscillate(value, rate, square, decay, t):
    """Value and rate after t, where value'' = -square value - 2 decay rate, for any damping."""
    d = square - decay * decay
    if d > 0.0:
        w, fade = math.sqrt(d), math.exp(-decay * t)
        cos, sin = fade * math.cos(w * t), fade * math.sin(w * t) / w
    elif d < 0.0:
        w = math.sqrt(-d)
        slow, fast = math.exp(-square / (decay + w) * t), math.exp(-(decay + w) * t)
        cos, sin = 0.5 * (slow + fast), 0.5 * (slow - fast) / w
    else:
        cos = math.exp(-decay * t)
        sin = cos * t
    return (cos * value + sin * (rate + decay * value), cos * rate - sin * (decay * rate + square * value))


@inlined
def _swing(legs, walker, state, t, sums):
    s, k, c = walker.swing, legs[0].stiffness, legs[0].damping
    root, unroot = walker.ratios.root, walker.ratios.unroot
    b, p = state[ANGLE_BACK], state[RATE_BACK]
    f, q = root * state[ANGLE_FRONT], root * state[RATE_FRONT]
    u, v = s.cos * b + s.sin * f, s.cos * f - s.sin * b
    du, dv = s.cos * p + s.sin * q, s.cos * q - s.sin * p
    m_1, m_2 = s.mobility_1, s.mobility_2
    c_1, c_2 = c * (1.0 + s.excess * (s.sin * s.sin)), c * (1.0 + s.excess * (s.cos * s.cos))
    u_1, du_1 = _oscillate(u, du, k * m_1, 0.5 * c_1 * m_1, t)
    v_1, dv_1 = _oscillate(v, dv, k * m_2, 0.5 * c_2 * m_2, t)
    sums[DAMPING_LOSS] += 0.5 * (
        k * (u * u + v * v - u_1 * u_1 - v_1 * v_1) + (du * du - du_1 * du_1) / m_1 + (dv * dv - dv_1 * dv_1) / m_2
    )
    share_b, share_f = s.share_back, s.share_front * unroot
    b_1, f_1 = s.cos * u_1 - s.sin * v_1, s.sin * u_1 + s.cos * v_1
    p_1, q_1 = s.cos * du_1 - s.sin * dv_1, s.sin * du_1 + s.cos * dv_1
    state[ANGLE_BACK], state[ANGLE_FRONT] = b_1, f_1 * unroot
    state[RATE_BACK], state[RATE_FRONT] = p_1, q_1 * unroot
    steady = state[SPIN] + (share_b * p + share_f * q)
    state[SPIN] = steady - share_b * p_1 - share_f * q_1
    swung = share_b * (b_1 - b) + share_f * (f_1 - f)
    state[PITCH] += steady * t - swung


@inlined
def _rest(legs, world, state, chain):
    """Rest of the true accelerations (spin, leg rates), rad/s^2, beyond the linear ones."""
    _, _, spin, back, front = free_acceleration(world, state, chain)
    s, k, c = world.walker.swing, legs[0].stiffness, legs[0].damping
    root, unroot = world.walker.ratios.root, world.walker.ratios.unroot
    t_b = -k * state[ANGLE_BACK] - c * state[RATE_BACK]
    t_f = -k * (root * state[ANGLE_FRONT]) - c * (root * state[RATE_FRONT])
    u, v = s.cos * t_b + s.sin * t_f, s.cos * t_f - s.sin * t_b
    if s.excess != 0.0:
        du, dv = _modal_rates(s, root, state)
        u -= c * s.excess * (s.sin * s.sin) * du
        v -= c * s.excess * (s.cos * s.cos) * dv
    u, v = s.mobility_1 * u, s.mobility_2 * v
    b, f = s.cos * u - s.sin * v, (s.sin * u + s.cos * v) * unroot
    return spin + s.share_back * b + s.share_front * f, back - spin - b, front - spin - f


@kernel
def _modal_rates(swing, root, state):
    p, q = state[RATE_BACK], root * state[RATE_FRONT]
    return swing.cos * p + swing.sin * q, swing.cos * q - swing.sin * p


@inlined
def _kick(legs, world, state, t, sums):
    """Change of the rates by `_rest` over t seconds at a fixed pose, by the midpoint rule.

    What the dampers take beyond the modes' own damping is that of the rates halfway.
    """
    s, root = world.walker.swing, world.walker.ratios.root
    chain = chain_of(world.walker, state, LOOSE)
    spin, back, front = state[SPIN], state[RATE_BACK], state[RATE_FRONT]
    for ahead in (0.5 * t, t):
        d_spin, d_back, d_front = _rest(legs, world, state, chain)
        state[SPIN], state[RATE_BACK] = spin + ahead * d_spin, back + ahead * d_back
        state[RATE_FRONT] = front + ahead * d_front
        if s.excess != 0.0 and ahead < t:
            du, dv = _modal_rates(s, root, state)
            sums[DAMPING_LOSS] += 2.0 * t * legs[0].damping * s.excess * s.sin * s.cos * du * dv


@inlined
def clear_time(world, state, chain, gaps):
    """Time (s) within which neither foot reaches the plate; 0 when a foot is in reach.

    The bounds: gravity, the plate's largest acceleration and the present one of effects together;
    legs that swing as far as their energy allows, to first order in their angles and 15 % more,
    which is safe for the few degrees that legs swing, but no bound for large angles.
    """
    largest = derivative_bound(world.drive, 2)
    pull = math.hypot(along(world.acting), across(world.acting)) + largest
    f_x, f_y = body_force(world.acting, state[PITCH], state[V_X], state[V_Y])
    pull += (abs(f_x) + abs(f_y)) / world.walker.mass
    return _clear_time(world.walker.legs, world, state, chain, gaps, pull)


@kernel
def _fall_time(gap, rise, pull):
    if gap <= 0.0:
        return 0.0
    return (rise + math.sqrt(rise * rise + 2.0 * pull * gap)) / pull


@inlined
def _clear_time(legs, world, state, chain, gaps, pull):
    b, f, spin = chain.back, chain.front, state[SPIN]
    back_x, front_x = b.A_x + b.r_x, f.A_x + f.r_x
    rise = state[V_Y] - velocity(world.drive, state[PHASE])
    s, root, unroot = world.walker.swing, world.walker.ratios.root, world.walker.ratios.unroot
    amplitude = math.sqrt(
        state[ANGLE_BACK] ** 2
        + (root * state[ANGLE_FRONT]) ** 2
        + (state[RATE_BACK] ** 2 + (root * state[RATE_FRONT]) ** 2) / (legs[0].stiffness * s.mobility_1)
    )
    steady = spin + s.share_back * state[RATE_BACK] + s.share_front * state[RATE_FRONT]
    whole = whole_of(world.walker, state)
    rise += whole.v_y - state[V_Y] - steady * whole.x  # of O, without its share of the legs' swing
    length = longest_leg(world.walker)
    pull += steady * steady * (length + abs(back_x) + abs(front_x))
    swing_b = amplitude * (abs(b.r_x) + 0.15 * length) + state[ANGLE_BACK] * b.r_x
    swing_f = amplitude * unroot * (abs(f.r_x) + 0.15 * length) + state[ANGLE_FRONT] * f.r_x
    return min(
        _fall_time(gaps[0] - swing_b, rise + steady * back_x, pull),
        _fall_time(gaps[1] - swing_f, rise + steady * front_x, pull),
    )
