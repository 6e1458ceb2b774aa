"""Sustained contact of one foot: the body rocks about it, stuck or slipping.

Integrated by the Dormand-Prince pair of orders 5 and 4 with adaptive steps in (x, pitch, v_x,
Omega); the height follows from the contact itself, so that the gap stays exactly zero. What ends
the motion (other foot or corner touches, lift-off, stop, break-away) is located by varying the
length of the last step, so that the state at an event has the order of the method.
"""

import math

import numpy as np

from walkergen.numerics.dormand_prince import ERROR_WEIGHTS, NODES, WEIGHTS
from walkergen.numerics.kernels import kernel
from walkergen.simulation.drive import TWO_PI, acceleration, height, moved_on, velocity
from walkergen.simulation.effects.acting import across, along
from walkergen.simulation.relaxed.flight import CORNER, NOTHING, STUCK, TOUCH
from walkergen.simulation.relaxed.state import TRIAL_FRICTION, TRIAL_WORK, lever
from walkergen.simulation.relaxed.sustained import BREAK, LIFT, STOP, direction, on_one_foot
from walkergen.simulation.world import MODE_BACK, MODE_FRONT, OPEN, PHASE, PITCH, SPIN, STICK, V_X, V_Y, X, Y

# Tolerated error of a step, in gap tolerances; longest and first step, in periods of the drive.
TOLERANCE, LONGEST, FIRST = 50.0, 1 / 16, 1 / 128
MOST_TRIALS, MOST_HALVINGS = 60, 200
# Columns of `stages`, a row per stage: slopes of x, pitch, v_x, Omega, plate work, friction loss.
COLUMNS = 6


@kernel
def closed_foot(walker, state):
    """Vectors O -> closed foot and O -> other foot (body's frame); the closed foot (0 back, 1
    front) and its mode.
    """
    if state[MODE_BACK] != OPEN:
        return walker.feet[0], walker.feet[1], 0, int(state[MODE_BACK])
    return walker.feet[1], walker.feet[0], 1, int(state[MODE_FRONT])


@kernel
def rock(world, state, dt, out, stages):
    """Step of `dt` seconds from `state` to `out`; returns its estimated error (1: as tolerated)."""
    d, _, foot, mode = closed_foot(world.walker, state)
    friction = world.contacts[foot].friction
    g_x, g_y = along(world.acting), across(world.acting)
    for i in range(7):
        pitch, v_x, Omega = state[PITCH], state[V_X], state[SPIN]
        for j in range(i):
            pitch += dt * WEIGHTS[i, j] * stages[j, 1]
            v_x += dt * WEIGHTS[i, j] * stages[j, 2]
            Omega += dt * WEIGHTS[i, j] * stages[j, 3]
        phase = state[PHASE] + world.drive.omega * dt * NODES[i]
        r = lever(d, math.sin(pitch), math.cos(pitch))
        pull = g_y + acceleration(world.drive, phase)
        pivot = on_one_foot(world.walker, r, Omega, pull, g_x, friction, mode)
        stages[i, 0] = v_x
        stages[i, 1] = Omega
        stages[i, 2] = pivot.a_x
        stages[i, 3] = pivot.alpha
        stages[i, 4] = pivot.N * velocity(world.drive, phase)
        stages[i, 5] = 0.0 if mode == STICK else -pivot.F_x * (v_x - Omega * r[1])
    _combine(state, dt, out, stages)
    _place(world.drive, d, mode, state, dt, out)
    size = math.hypot(d[0], d[1])
    return _error(dt, stages, size, world.drive.omega) / (TOLERANCE * world.options.gap_tolerance)


@kernel
def _combine(state, dt, out, stages):
    change = np.zeros(COLUMNS)
    for j in range(6):
        for column in range(COLUMNS):
            change[column] += dt * WEIGHTS[6, j] * stages[j, column]
    out[:9] = state[:9]
    out[X] += change[0]
    out[PITCH] += change[1]
    out[V_X] += change[2]
    out[SPIN] += change[3]
    out[TRIAL_WORK] = change[4]
    out[TRIAL_FRICTION] = change[5]


@kernel
def _place(drive, d, mode, state, dt, out):
    """Set height (and x, when the foot sticks) and their rates so that the foot stays closed."""
    before = lever(d, math.sin(state[PITCH]), math.cos(state[PITCH]))
    r = lever(d, math.sin(out[PITCH]), math.cos(out[PITCH]))
    out[PHASE] = moved_on(drive, state[PHASE], dt)
    out[Y] = height(drive, out[PHASE]) - r[1]
    out[V_Y] = velocity(drive, out[PHASE]) - out[SPIN] * r[0]
    if mode == STICK:
        out[X] = state[X] + (before[0] - r[0])
        out[V_X] = out[SPIN] * r[1]


@kernel
def _error(dt, stages, size, omega):
    """Largest estimated error of a step as a length, mm; speeds count over 1/omega."""
    largest = 0.0
    for column in range(4):
        error = 0.0
        for i in range(7):
            error += dt * ERROR_WEIGHTS[i] * stages[i, column]
        scale = size if column in (1, 3) else 1.0
        if column >= 2:
            scale /= omega
        largest = max(largest, abs(error) * scale)
    return largest


@kernel
def _gap_rate(world, state):
    _, other, _, _ = closed_foot(world.walker, state)
    r = lever(other, math.sin(state[PITCH]), math.cos(state[PITCH]))
    return state[V_Y] + state[SPIN] * r[0] - velocity(world.drive, state[PHASE])


@kernel
def margin(world, state, event):
    """Quantity that is positive until `event`: a gap (mm), force (g mm/s^2) or speed (mm/s)."""
    d, other, foot, mode = closed_foot(world.walker, state)
    sin, cos = math.sin(state[PITCH]), math.cos(state[PITCH])
    if event == TOUCH:
        gap = state[Y] + lever(other, sin, cos)[1] - height(world.drive, state[PHASE])
        # A foot that leaves from within the tolerance of closed contacts does not touch.
        return gap if _gap_rate(world, state) < 0.0 else max(gap, 0.0)
    if event == CORNER:
        lowest = math.inf
        for corner in world.walker.corners:
            lowest = min(lowest, lever(corner, sin, cos)[1])
        return state[Y] + lowest - height(world.drive, state[PHASE])
    r, Omega = lever(d, sin, cos), state[SPIN]
    if event == STOP:
        return math.inf if mode == STICK else direction(mode) * (state[V_X] - Omega * r[1])
    pull = across(world.acting) + acceleration(world.drive, state[PHASE])
    g_x, friction = along(world.acting), world.contacts[foot].friction
    pivot = on_one_foot(world.walker, r, Omega, pull, g_x, friction, mode)
    if event == LIFT:
        return pivot.N
    return friction * pivot.N - abs(pivot.F_x) if mode == STICK else math.inf


@kernel
def end_of_step(world, state, limit, suggested, out, stages):
    """Accepted step of at most `limit` s to `out`: (its length s, its event, next length to try s).

    The event is what ended it, NOTHING, or STUCK when no step is short enough.
    """
    dt = min(limit, suggested)
    for _ in range(MOST_HALVINGS):
        error = rock(world, state, dt, out, stages)
        if error <= 1.0:
            break
        dt *= max(0.2, 0.9 * error**-0.2) if error < 1e10 else 0.1
    if not error <= 1.0:
        return dt, STUCK, suggested
    growth = min(4.0, 0.9 * max(error, 1e-6) ** -0.2)
    following = min(LONGEST * TWO_PI / world.drive.omega, max(dt * growth, 0.5 * suggested))
    if _dips(world, state, dt, out, stages):
        dt = _lowest(world, state, dt, out, stages)
    first = NOTHING
    for event in (TOUCH, LIFT, STOP, BREAK, CORNER):
        if margin(world, out, event) < -_slack(world, event):
            dt = _locate(world, state, dt, event, out, stages)
            first = event
    return dt, first, following


@kernel
def _slack(world, event):
    """Rounding error of an event's margin, in its unit."""
    if event in (LIFT, BREAK):
        return 1e-13 * world.walker.mass * world.acting.gravity.size
    return 1e-8 * world.options.snap_speed if event == STOP else 0.5 * world.options.gap_tolerance


@kernel
def _locate(world, state, dt, event, out, stages):
    """Length (s) of the step at whose end `event` happens, by the Illinois method; fills `out`.

    A foot that rises does not touch, however close it is: it falls later within the step.
    """
    slack = _slack(world, event)
    low, above = 0.0, max(margin(world, state, event), 0.0) + 0.5 * slack
    high, below = dt, margin(world, out, event) + 0.5 * slack
    side = 0
    for _ in range(MOST_TRIALS):
        middle = high - below * (high - low) / (below - above)
        if not low < middle < high:
            middle = 0.5 * (low + high)
        rock(world, state, middle, out, stages)
        value = margin(world, out, event) + 0.5 * slack
        rises = event == TOUCH and _gap_rate(world, out) > 0.0
        if (abs(value) <= 0.5 * slack and not rises) or high - low <= 1e-14 / world.drive.omega:
            return middle
        if value > 0.0 or rises:  # an end kept twice counts half
            above = max(value, 0.5 * slack) if rises else value
            low, below = middle, 0.5 * below if side == 1 else below
            side = 1
        else:
            high, below, above = middle, value, 0.5 * above if side == -1 else above
            side = -1
    return middle


@kernel
def _dips(world, state, dt, out, stages):
    """True when the other foot is low enough to touch and rise again within the step."""
    start, end = _gap_rate(world, state), _gap_rate(world, out)
    gap = margin(world, out, TOUCH)
    return start < 0.0 < end and gap >= 0.0 and gap < 0.5 * end * dt


@kernel
def _lowest(world, state, dt, out, stages):
    """Length (s) of the step at whose end the other foot is lowest, by bisection; fills `out`."""
    low, high = 0.0, dt
    for _ in range(MOST_TRIALS):
        middle = 0.5 * (low + high)
        rock(world, state, middle, out, stages)
        if _gap_rate(world, out) < 0.0:
            low = middle
        else:
            high = middle
        if high - low <= 1e-9 * dt:
            break
    return middle
