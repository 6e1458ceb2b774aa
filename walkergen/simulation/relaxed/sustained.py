"""Sustained contact: the mode of each foot, the forces, and the motion on both feet.

A closed foot sticks or slips; accelerations follow from rigid dynamics with the foot's
acceleration over the plate fixed to zero (normal; tangential too when it sticks) and
|F_x| = mu N against the slip. Modes are enumerated once after each event (physics.md section 5).

On both feet the body translates with the plate, so that the sum of the friction forces sets both
normal forces, and every motion is in closed form. The split of the friction is hyperstatic: each
foot takes a share proportional to its normal force, so that both reach the friction limit at once.
"""

import math
from typing import NamedTuple

from walkergen.numerics.kernels import kernel
from walkergen.simulation.drive import TWO_PI, acceleration, derivative_bound, height, velocity
from walkergen.simulation.relaxed.cascade import stopping_impulse
from walkergen.simulation.relaxed.flight import quadratic_wait
from walkergen.simulation.relaxed.walker import (
    MODE_BACK,
    MODE_FRONT,
    OMEGA,
    OPEN,
    PHASE,
    PITCH,
    SLIP_BACKWARD,
    SLIP_FORWARD,
    STICK,
    TRIAL_FRICTION,
    TRIAL_WORK,
    V_X,
    V_Y,
    X,
    Y,
    across,
    along,
    level_pitch,
    lever,
    rigid_tensor,
)

_level_pitch = kernel(level_pitch)

JAM = 4.0
NO_JAM, BACK_JAMS, FRONT_JAMS = 0, 1, 2
# What ends a stretch of contact (continues flight's NOTHING, TOUCH, CORNER, STUCK).
LIFT, LIFT_BACK, LIFT_FRONT, STOP, BREAK = 4, 5, 6, 7, 8
# Share of the snap speed below which a tangential speed is rounding.
REST = 1e-6
MOST_STEPS = 100_000


class Pivot(NamedTuple):
    """Motion of the body on one foot: mm/s^2, rad/s^2; contact force in g mm/s^2."""

    a_x: float
    alpha: float
    F_x: float
    N: float


@kernel
def direction(mode: float) -> float:
    """Sign of the slip of a mode; 0 when it does not slip."""
    if mode == SLIP_FORWARD:
        return 1.0
    return -1.0 if mode == SLIP_BACKWARD else 0.0


@kernel
def on_one_foot(walker, r, Omega, pull, g_x, friction, mode):
    """Accelerations and force with one foot closed in `mode`: a `Pivot`.

    r = O -> foot in the plate's frame; pull = gravity into the plate + the plate's acceleration.
    """
    H = rigid_tensor(walker, r)
    free_x, free_y = g_x - Omega * Omega * r[0], -pull - Omega * Omega * r[1]
    if mode == STICK:
        F_x, N = stopping_impulse(H, free_x, free_y)
    else:
        s_mu = direction(mode) * friction
        N = -free_y / (H.yy - s_mu * H.xy)
        F_x = -s_mu * N
    return Pivot(g_x + F_x / walker.M, (r[0] * N - r[1] * F_x) / walker.J, F_x, N)


@kernel
def _mode_of_one(walker, r, v_t, Omega, pull, g_x, friction, snap):
    """Mode of the only closed foot, which slides at v_t; JAM when no force lets it slide on."""
    if -pull - Omega * Omega * r[1] >= 0.0:
        return OPEN
    rests = abs(v_t) <= REST * snap
    if rests or (abs(v_t) <= snap and friction > 0.0):
        held = on_one_foot(walker, r, Omega, pull, g_x, friction, STICK)
        if held.N >= 0.0 and abs(held.F_x) <= friction * held.N:
            return STICK
    H = rigid_tensor(walker, r)
    if not rests:
        slides = H.yy - math.copysign(friction, v_t) * H.xy > 0.0
        return (SLIP_FORWARD if v_t > 0.0 else SLIP_BACKWARD) if slides else JAM
    # From rest it slips the way in which it would accelerate.
    forward = _starts(walker, r, Omega, pull, g_x, friction, SLIP_FORWARD)
    backward = _starts(walker, r, Omega, pull, g_x, friction, SLIP_BACKWARD)
    if forward and backward:
        forward = g_x - Omega * Omega * r[0] > 0.0
    if forward:
        return SLIP_FORWARD
    return SLIP_BACKWARD if backward else STICK


@kernel
def _starts(walker, r, Omega, pull, g_x, friction, mode):
    pivot = on_one_foot(walker, r, Omega, pull, g_x, friction, mode)
    a_t = pivot.a_x - pivot.alpha * r[1] - Omega * Omega * r[0]
    return pivot.N >= 0.0 and a_t * direction(mode) > 0.0


@kernel
def choose_modes(walker, plate, contact, options, state, near_back, near_front):
    """Set the modes of both feet from velocities and accelerations; snap the closed ones.

    Returns NO_JAM, or which foot slides into a jam (its modes are then left for after the stop).
    """
    sin, cos = math.sin(state[PITCH]), math.cos(state[PITCH])
    back, front = lever(walker.d_back, sin, cos), lever(walker.d_front, sin, cos)
    v_y, Omega = state[V_Y] - velocity(plate, state[PHASE]), state[OMEGA]
    pull = across(options) + acceleration(plate, state[PHASE])
    hold_back = near_back and abs(v_y + Omega * back[0]) <= options.snap_speed
    hold_front = near_front and abs(v_y + Omega * front[0]) <= options.snap_speed
    state[MODE_BACK], state[MODE_FRONT] = OPEN, OPEN
    if hold_back and hold_front:
        state[PITCH], state[OMEGA] = _level_pitch(walker), 0.0
        sin, cos = math.sin(state[PITCH]), math.cos(state[PITCH])
        back, front = lever(walker.d_back, sin, cos), lever(walker.d_front, sin, cos)
        if pull > 0.0:
            mode = _mode_of_both(state[V_X], pull, along(options), contact.friction, options)
            N_back, N_front = _normals(back, front, pull, along(options), contact.friction, mode)
            if N_back >= 0.0 and N_front >= 0.0:
                _press(plate, state, back)
                state[MODE_BACK], state[MODE_FRONT] = mode, mode
                if mode == STICK:
                    state[V_X] = 0.0
                return NO_JAM
            hold_back, hold_front = N_back >= 0.0, N_back < 0.0
    if not (hold_back or hold_front):
        return NO_JAM
    r = back if hold_back else front
    _press(plate, state, r)
    v_t = state[V_X] - state[OMEGA] * r[1]
    mode = _mode_of_one(
        walker, r, v_t, state[OMEGA], pull, along(options), contact.friction, options.snap_speed
    )
    if mode == JAM:
        return BACK_JAMS if hold_back else FRONT_JAMS
    state[MODE_BACK if hold_back else MODE_FRONT] = mode
    if mode == STICK:
        state[V_X] = state[OMEGA] * r[1]
    return NO_JAM


@kernel
def _press(plate, state, r):
    """Put the foot exactly on the plate, moving with it."""
    state[Y] = height(plate, state[PHASE]) - r[1]
    state[V_Y] = velocity(plate, state[PHASE]) - state[OMEGA] * r[0]


@kernel
def _mode_of_both(v_x, pull, g_x, friction, options):
    rests = abs(v_x) <= REST * options.snap_speed
    slow = rests or (abs(v_x) <= options.snap_speed and friction > 0.0)
    if slow and abs(g_x) <= friction * pull:
        return STICK
    way = g_x if rests else v_x
    return SLIP_FORWARD if way > 0.0 else SLIP_BACKWARD


@kernel
def _normals(back, front, pull, g_x, friction, mode):
    """Normal forces on both feet over the mass, from the balance of torques about O."""
    f_x = -g_x if mode == STICK else -direction(mode) * friction * pull
    torque = back[1] * f_x
    return (
        (torque - front[0] * pull) / (back[0] - front[0]),
        (torque - back[0] * pull) / (front[0] - back[0]),
    )


@kernel
def stand(walker, plate, contact, options, state, dt, out):
    """Both feet closed for `dt` seconds: the plate carries the body, which may slide; exact."""
    g_x, g_y, slip = along(options), across(options), direction(state[MODE_BACK])
    h, v_p = height(plate, state[PHASE]), velocity(plate, state[PHASE])
    phase = (state[PHASE] + plate.omega * dt) % TWO_PI
    rise, v_end = height(plate, phase) - h, velocity(plate, phase)
    out[:9] = state[:9]
    out[PHASE] = phase
    out[Y], out[V_Y] = state[Y] + rise, v_end
    s_mu = slip * contact.friction
    if slip != 0.0:
        # a_x = g_x - s mu (g_y + plate's acceleration), integrated once and twice.
        out[V_X] = state[V_X] + (g_x - s_mu * g_y) * dt - s_mu * (v_end - v_p)
        out[X] = (
            state[X] + dt * (state[V_X] + 0.5 * (g_x - s_mu * g_y) * dt) - s_mu * (rise - v_p * dt)
        )
    M = walker.M
    out[TRIAL_WORK] = M * (g_y * rise + 0.5 * (v_end - v_p) * (v_end + v_p))
    slowing = 0.5 * (state[V_X] - out[V_X]) * (state[V_X] + out[V_X])
    out[TRIAL_FRICTION] = M * (slowing + g_x * (out[X] - state[X]))


@kernel
def end_of_stand(walker, plate, contact, options, state, limit):
    """Time (s) within `limit` for which both feet stay closed in their mode, and what ends it."""
    sin, cos = math.sin(state[PITCH]), math.cos(state[PITCH])
    back, front = lever(walker.d_back, sin, cos), lever(walker.d_front, sin, cos)
    g_x, mode = along(options), state[MODE_BACK]
    least, event = 0.0, LIFT
    if mode == STICK:
        # Pull at which a normal force vanishes, or friction no longer holds.
        if back[1] * g_x / front[0] < -least:
            least, event = -back[1] * g_x / front[0], LIFT_BACK
        if back[1] * g_x / back[0] < -least:
            least, event = -back[1] * g_x / back[0], LIFT_FRONT
        if g_x != 0.0 and abs(g_x) > contact.friction * least:
            least, event = abs(g_x) / contact.friction, BREAK
    dt = falling_wait(plate, state[PHASE], least - across(options))
    if mode != STICK:
        stop = _stopping_time(plate, contact, options, state, min(dt, limit))
        if stop < dt:
            dt, event = stop, STOP
    return (dt, event) if dt < limit else (limit, 0)


@kernel
def falling_wait(plate, phase, threshold):
    """Time (s) until the plate's acceleration is at or below `threshold`; infinity if never."""
    if plate.amplitude == 0.0:
        return 0.0 if threshold >= 0.0 else math.inf
    return _falling_wait(plate.harmonic, plate, phase, threshold)


@kernel
def _falling_wait(harmonic, plate, phase, threshold):
    if harmonic is None:
        ratio = -threshold / (plate.amplitude * plate.omega * plate.omega)
        if ratio > 1.0:
            return math.inf
        if ratio <= -1.0:
            return 0.0
        first = math.asin(ratio)
        since = (phase - first) % TWO_PI
        return 0.0 if since <= math.pi - 2.0 * first else (TWO_PI - since) / plate.omega
    bound, jerk = derivative_bound(plate, 4), derivative_bound(plate, 3)
    t, step = 0.0, 1e-13 / plate.omega
    while t * plate.omega < TWO_PI:
        above = acceleration(plate, phase + plate.omega * t) - threshold
        if above <= step * jerk:
            return t
        ahead = acceleration(plate, phase + plate.omega * (t + step)) - threshold
        t += max(quadratic_wait(above, min(0.0, ahead - above) / step, bound), above / jerk)
    return math.inf


@kernel
def _stopping_time(plate, contact, options, state, limit):
    """Time (s) at which sliding on both feet stops; infinity if not before `limit`."""
    slip, mu = direction(state[MODE_BACK]), contact.friction
    g_x, g_y = slip * along(options), across(options)
    v_p, bound = velocity(plate, state[PHASE]), mu * derivative_bound(plate, 3)
    t, instant = 0.0, 1e-12 / plate.omega  # a break-away may have been located so much too early
    for _ in range(MOST_STEPS):
        phase = state[PHASE] + plate.omega * t
        speed = slip * state[V_X] + (g_x - mu * g_y) * t - mu * (velocity(plate, phase) - v_p)
        rate = g_x - mu * (g_y + acceleration(plate, phase))
        if speed <= 1e-2 * REST * options.snap_speed and rate < -bound * instant:
            return t
        t += max(quadratic_wait(max(speed, 0.0), rate, bound), instant)
        if t >= limit:
            break
    return math.inf
