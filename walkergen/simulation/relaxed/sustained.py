"""Sustained contact: the mode of each foot, the forces, and the motion on both feet.

A closed foot sticks or slips; accelerations follow from rigid dynamics with the foot's
acceleration over the plate fixed to zero (normal; tangential too when it sticks) and
|F_x| = mu N against the slip. Modes are enumerated once after each event (docs/physics.md
section 5).

On both feet the body translates with the plate, so that the sum of the friction forces sets both
normal forces, and every motion is in closed form: while it slides, each foot carries a fixed share
of the pull, so that two unlike feet slide as one foot does of a friction between theirs
(`joint_friction`). The split of the friction that holds is hyperstatic: each foot takes a share
proportional to its own limit, so that both reach it at once.
"""

import math
from typing import NamedTuple

from walkergen.numerics.kernels import kernel
from walkergen.simulation.drive import TWO_PI, acceleration, derivative_bound, height, moved_on, velocity
from walkergen.simulation.effects.acting import across, along
from walkergen.simulation.relaxed.cascade import stopping_impulse
from walkergen.simulation.relaxed.flight import quadratic_wait
from walkergen.simulation.relaxed.state import TRIAL_FRICTION, TRIAL_WORK, level_pitch, levers, rigid_tensor
from walkergen.simulation.world import (
    BACKWARD,
    FORWARD,
    MODE_BACK,
    MODE_FRONT,
    OPEN,
    PHASE,
    PITCH,
    SPIN,
    STICK,
    V_X,
    V_Y,
    X,
    Y,
)

_level_pitch = kernel(level_pitch)

JAM = 4
"""Mode of a sliding foot that jams: no contact force lets it slide on."""
NO_JAM = -1
"""Answer of `choose_modes` when no foot jams."""
# What ends a stretch of contact (continues flight's NOTHING, TOUCH, CORNER, STUCK).
LIFT, LIFT_BACK, LIFT_FRONT, STOP, BREAK = 4, 5, 6, 7, 8
# Tangential speed, over the snap speed, below which it is rounding.
REST = 1e-6
MOST_STEPS = 100_000


class Pivot(NamedTuple):
    """Accelerations of the body on one foot, mm/s^2 and rad/s^2, and contact force, g mm/s^2."""

    a_x: float
    alpha: float
    F_x: float
    N: float


@kernel
def direction(mode: int) -> float:
    """Sign of the slip in a contact mode; 0 without slip."""
    if mode == FORWARD:
        return 1.0
    return -1.0 if mode == BACKWARD else 0.0


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
    return Pivot(g_x + F_x / walker.mass, (r[0] * N - r[1] * F_x) / walker.inertia, F_x, N)


@kernel
def _mode_of_one(walker, r, v_t, Omega, pull, g_x, friction, snap):
    """Mode of the only closed foot, at r, sliding at v_t mm/s; JAM: no force lets it slide on."""
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
        return (FORWARD if v_t > 0.0 else BACKWARD) if slides else JAM
    # From rest a foot slips the way in which it would accelerate.
    forward = _starts(walker, r, Omega, pull, g_x, friction, FORWARD)
    backward = _starts(walker, r, Omega, pull, g_x, friction, BACKWARD)
    if forward and backward:
        forward = g_x - Omega * Omega * r[0] > 0.0
    if forward:
        return FORWARD
    return BACKWARD if backward else STICK


@kernel
def _starts(walker, r, Omega, pull, g_x, friction, mode):
    pivot = on_one_foot(walker, r, Omega, pull, g_x, friction, mode)
    a_t = pivot.a_x - pivot.alpha * r[1] - Omega * Omega * r[0]
    return pivot.N >= 0.0 and a_t * direction(mode) > 0.0


@kernel
def choose_modes(world, state, near_back, near_front):
    """Set the modes of both feet from velocities and accelerations; snap the closed ones.

    Returns NO_JAM, or the foot (0 back, 1 front) that jams: its mode is set after its stop.
    """
    back, front = levers(world.walker, state[PITCH])
    pull = across(world.acting) + acceleration(world.drive, state[PHASE])
    hold_back, hold_front = _held(world, state, back, front, near_back, near_front)
    if near_back and near_front and hold_back != hold_front:
        if hold_back:
            _stop_approach(world, state, back, front, world.contacts[1].friction)
        else:
            _stop_approach(world, state, front, back, world.contacts[0].friction)
        hold_back, hold_front = _held(world, state, back, front, True, True)
    state[MODE_BACK], state[MODE_FRONT] = OPEN, OPEN
    if hold_back and hold_front:
        state[PITCH], state[SPIN] = _level_pitch(world.walker), 0.0
        back, front = levers(world.walker, state[PITCH])
        if pull > 0.0:
            mode = _mode_of_both(world, back, front, state[V_X], pull)
            N_back, N_front = _normals(world, back, front, pull, mode)
            if N_back >= 0.0 and N_front >= 0.0:
                _press(world.drive, state, back)
                state[MODE_BACK], state[MODE_FRONT] = mode, mode
                if mode == STICK:
                    state[V_X] = 0.0
                return NO_JAM
            hold_back, hold_front = N_back >= 0.0, N_back < 0.0
    if not (hold_back or hold_front):
        return NO_JAM
    foot = 0 if hold_back else 1
    r = back if hold_back else front
    _press(world.drive, state, r)
    v_t = state[V_X] - state[SPIN] * r[1]
    mode = _mode_of_one(
        world.walker,
        r,
        v_t,
        state[SPIN],
        pull,
        along(world.acting),
        world.contacts[foot].friction,
        world.options.snap_speed,
    )
    if mode == JAM:
        return foot
    state[MODE_BACK + foot] = mode
    if mode == STICK:
        state[V_X] = state[SPIN] * r[1]
    return NO_JAM


@kernel
def _held(world, state, back, front, near_back, near_front):
    """True for each foot that is near the plate and slow enough to stay on it."""
    v_y, snap = state[V_Y] - velocity(world.drive, state[PHASE]), world.options.snap_speed
    hold_back = near_back and abs(v_y + state[SPIN] * back[0]) <= snap
    return hold_back, near_front and abs(v_y + state[SPIN] * front[0]) <= snap


@kernel
def _stop_approach(world, state, r, other, friction):
    """Stop by the plate's impulse a foot at r that the blows at the other foot throw down.

    To lift the body instead (`_press`) would lift the other foot by the same speed, and its next
    blow would throw this foot down again: an endless sequence (docs/physics.md, trap 2).
    """
    M, J = world.walker.mass, world.walker.inertia
    v_y = state[V_Y] - velocity(world.drive, state[PHASE]) + state[SPIN] * r[0]
    if v_y < 0.0 and 1.0 / M + r[0] * other[0] / J < friction * abs(r[0] * other[1]) / J:
        F_y = -v_y / rigid_tensor(world.walker, r).yy
        state[V_Y] += F_y / M
        state[SPIN] += r[0] * F_y / J


@kernel
def _press(drive, state, r):
    """Put the foot at r exactly on the plate, moving with it."""
    state[Y] = height(drive, state[PHASE]) - r[1]
    state[V_Y] = velocity(drive, state[PHASE]) - state[SPIN] * r[0]


@kernel
def joint_friction(contacts, back, front, way):
    """Friction over the pull of a body that slides on both feet, `way` 1 toward +x or -1.

    Feet at x_i, both at y from O, carry N_i of the pull P and drag it by way mu_i N_i; torques
    about O balance where sum N_i (x_i + way mu_i y) = 0. Infinite where no share of the pull
    does, since drag on the foot ahead would press it down by more than it drags: the feet jam.
    """
    mu_b, mu_f = contacts[0].friction, contacts[1].friction
    turn_b, turn_f = back[0] + way * mu_b * back[1], front[0] + way * mu_f * back[1]
    if turn_f <= turn_b:
        return math.inf
    return mu_b + (mu_f - mu_b) * (-turn_b / (turn_f - turn_b))


@kernel
def _mode_of_both(world, back, front, v_x, pull):
    g_x, snap = along(world.acting), world.options.snap_speed
    rests = abs(v_x) <= REST * snap
    way = g_x if rests else v_x
    pulled = joint_friction(world.contacts, back, front, math.copysign(1.0, g_x))
    sliding = joint_friction(world.contacts, back, front, math.copysign(1.0, way))
    slow = rests or (abs(v_x) <= snap and sliding > 0.0)
    if (slow and abs(g_x) <= pulled * pull) or sliding == math.inf:
        return STICK
    return FORWARD if way > 0.0 else BACKWARD


@kernel
def _normals(world, back, front, pull, mode):
    """Normal forces on both feet over the mass, mm/s^2, from the balance of torques about O."""
    f_x, way = -along(world.acting), direction(mode)
    if mode != STICK:
        f_x = -way * joint_friction(world.contacts, back, front, way) * pull
    torque = back[1] * f_x
    return ((torque - front[0] * pull) / (back[0] - front[0]), (torque - back[0] * pull) / (front[0] - back[0]))


@kernel
def stand(world, state, dt, out):
    """Exact motion to `out`, both feet closed for `dt` s: carried by the plate, it may slide."""
    g_x, g_y, slip = along(world.acting), across(world.acting), direction(int(state[MODE_BACK]))
    back, front = levers(world.walker, state[PITCH])
    h, v_p = height(world.drive, state[PHASE]), velocity(world.drive, state[PHASE])
    phase = moved_on(world.drive, state[PHASE], dt)
    rise, v_end = height(world.drive, phase) - h, velocity(world.drive, phase)
    out[:9] = state[:9]
    out[PHASE] = phase
    out[Y], out[V_Y] = state[Y] + rise, v_end
    if slip != 0.0:
        s_mu = slip * joint_friction(world.contacts, back, front, slip)
        # a_x = g_x - s mu (g_y + plate's acceleration), integrated once and twice.
        out[V_X] = state[V_X] + (g_x - s_mu * g_y) * dt - s_mu * (v_end - v_p)
        out[X] = state[X] + dt * (state[V_X] + 0.5 * (g_x - s_mu * g_y) * dt) - s_mu * (rise - v_p * dt)
    M = world.walker.mass
    out[TRIAL_WORK] = M * (g_y * rise + 0.5 * (v_end - v_p) * (v_end + v_p))
    slowing = 0.5 * (state[V_X] - out[V_X]) * (state[V_X] + out[V_X])
    out[TRIAL_FRICTION] = M * (slowing + g_x * (out[X] - state[X]))


@kernel
def end_of_stand(world, state, limit):
    """Time (s) within `limit` for which both feet stay closed in their mode, and what ends it."""
    back, front = levers(world.walker, state[PITCH])
    g_x, mode = along(world.acting), int(state[MODE_BACK])
    least, event = 0.0, LIFT
    if mode == STICK:
        # Pull at which a normal force vanishes, or friction no longer holds.
        if back[1] * g_x / front[0] < -least:
            least, event = -back[1] * g_x / front[0], LIFT_BACK
        if back[1] * g_x / back[0] < -least:
            least, event = -back[1] * g_x / back[0], LIFT_FRONT
        friction = joint_friction(world.contacts, back, front, math.copysign(1.0, g_x))
        if g_x != 0.0 and abs(g_x) / friction > least:
            least, event = abs(g_x) / friction, BREAK
    dt = falling_wait(world.drive, state[PHASE], least - across(world.acting))
    if mode != STICK:
        stop = _stopping_time(world, state, min(dt, limit))
        if stop < dt:
            dt, event = stop, STOP
    return (dt, event) if dt < limit else (limit, 0)


@kernel
def falling_wait(plate, phase, threshold):
    """Time (s) until the plate's acceleration is at or below `threshold`; infinity if never."""
    if plate.amplitude == 0.0:
        return 0.0 if threshold >= 0.0 else math.inf
    if plate.harmonic.ratio == 0.0:
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
def _stopping_time(world, state, limit):
    """Time (s) at which sliding on both feet stops; infinity if not before `limit`."""
    slip = direction(int(state[MODE_BACK]))
    back, front = levers(world.walker, state[PITCH])
    mu = joint_friction(world.contacts, back, front, slip)
    g_x, g_y = slip * along(world.acting), across(world.acting)
    v_p, bound = velocity(world.drive, state[PHASE]), mu * derivative_bound(world.drive, 3)
    t, instant = 0.0, 1e-12 / world.drive.omega  # a break-away may be located so much too early
    for _ in range(MOST_STEPS):
        phase = state[PHASE] + world.drive.omega * t
        speed = slip * state[V_X] + (g_x - mu * g_y) * t - mu * (velocity(world.drive, phase) - v_p)
        rate = g_x - mu * (g_y + acceleration(world.drive, phase))
        if speed <= 1e-2 * REST * world.options.snap_speed and rate < -bound * instant:
            return t
        t += max(quadratic_wait(max(speed, 0.0), rate, bound), instant)
        if t >= limit:
            break
    return math.inf
