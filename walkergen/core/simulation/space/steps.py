"""Time steps of the 3D simulation: frozen frames of implicit midpoint steps, and flights between them.

Within a frame the pose's directions and Jacobians are held, so that corner velocities obey linear
equations with Coulomb's cones; exact gaps are computed again in every frame. A contact that touches
within a step acts for the rest of it (forces.py): landings, sliding and flight all err by second
order. While no contact can close, the walker flies (flight.py).

`world` holds what stays the same in a run, `state` (1-d array, entries named by constants as C_X) what changes, and
`work` memory for results (state.py). C is the centre of mass of the whole walker, O that of its body. W is the rate
(rad/s, body axes) at which body and legs would turn together with locked joints. k numbers the contacts.
"""

import math

from walkergen.core.numerics.kernels import kernel, lean
from walkergen.core.simulation import record
from walkergen.core.simulation.effects import motor as motors
from walkergen.core.simulation.effects import sway as sways
from walkergen.core.simulation.effects.active_effects import gravity_into
from walkergen.core.simulation.record import next_sample_time, take_sample
from walkergen.core.simulation.space.flight import MAX_TURN_RAD, clear_time, fly, max_plate_acceleration, pass_time
from walkergen.core.simulation.space.forces import guess_modes, solve
from walkergen.core.simulation.space.frame import (
    fill_accelerations,
    fill_frame,
    fill_leg_mobility,
    fill_midpoint_pose,
    motor_work,
    plate_acceleration,
    sway_work,
)
from walkergen.core.simulation.space.landings import advance_contact, end_landing
from walkergen.core.simulation.space.pose import fill_points, lowest_corner, plate_velocity, turn, update_pose
from walkergen.core.simulation.space.resting import DOZE_PERIODS, count_rest_time, ride_on_plate
from walkergen.core.simulation.space.state import (
    ACROSS,
    ALONG,
    C_X,
    HALVINGS,
    LANDED,
    LEGS,
    MODE,
    OPEN,
    PITCH,
    QUIET,
    ROW_LENGTH,
    V_X,
    W_X,
    first_row,
    work_for,
)
from walkergen.core.simulation.space.tips import response
from walkergen.core.simulation.world import FAILED, FOLDED, OK, TOPPLED, TWO_PI

MIN_TIME_PERIODS = 9e-11
"""Time, of the plate's period, that counts as zero: 1e-12 s at 90 Hz."""

_motor_acts, _sways = motors.acts, sways.moves

MAX_MOTOR_TURN_RAD = 0.5
"""Largest turn of a motor in a flight, rad."""


@lean
def _turn_stretches(walker, state, turned):
    """Turn the stretches of contacts with plate and lid back by `turned` rad, by which the heading has turned."""
    c, s, row = math.cos(turned), math.sin(turned), first_row(walker)
    for k in range(len(walker.leg)):
        at = row + ROW_LENGTH * k
        if state[at + MODE] != OPEN and walker.wall_distance[k] <= 0.0:
            a, b = state[at + ALONG], state[at + ACROSS]
            state[at + ALONG], state[at + ACROSS] = c * a - s * b, s * a + c * b


@lean
def _list_near_contacts(walker, state, work, t):
    """List in `work.near` the contacts that are closed or may close within t seconds; return their number."""
    m, first = 0, first_row(walker)
    for k in range(len(walker.leg)):
        at = first + ROW_LENGTH * k
        if state[at + MODE] == OPEN and work.points[k].clear > t:
            continue
        work.near[m].number, work.near[m].gap[0] = k, work.points[k].gap
        work.near[m].gap[1], work.near[m].gap[2] = state[at + ALONG], state[at + ACROSS]
        m += 1
    return m


@lean
def _swing_freely(state, near, J, work, swing, springs, dampers, m, h):
    """Compute the motion of legs and of m near contacts without contact forces, for a step of h seconds.

    Fills the legs' accelerations, `work.pull`, and the contacts' velocities in the middle of the step, `free`. The
    velocities with contact forces, `middle`, become those that the forces of the previous step would give.

    Arguments: J, Jacobian of the near contacts, three rows each; `swing`, inverse inertia of the legs' coordinates in
    a step, shape (n, n); `springs` and `dampers`, stiffness and damping of these coordinates, shape (n,).
    """
    n, pull, left = len(springs), work.pull, work.left
    for i in range(n):
        pull[i] = 0.0
    for j in range(n):
        angle, rate = state[LEGS + j], state[LEGS + n + j]
        torque = -springs[j] * (angle + 0.5 * h * rate) - dampers[j] * rate + left[j]
        for i in range(n):
            pull[i] += swing[i, j] * torque
    for i in range(m):
        for p in range(3):
            total = near[i].drift[p]
            for j in range(n):
                total += J[3 * i + p, 6 + j] * pull[j]
            free = near[i].speed[p] + 0.5 * h * total
            near[i].middle[p] += free - near[i].free[p]
            near[i].free[p] = free


@lean
def _move_legs(state, near, ML, pull, dampers, m, h):
    """Move the legs over a step of h seconds; return the energy that their dampers take, g mm^2/s^2.

    Arguments: `near`, of which the first m contacts are in use; ML, response of the legs' coordinates to contact
    forces, three rows a contact; `pull`, accelerations of the coordinates without contact forces, to which those from
    the contacts are added, shape (n,); `dampers`, damping of the coordinates, shape (n,).
    """
    n, damped = len(dampers), 0.0
    for i in range(m):
        if near[i].tried != OPEN:
            for p in range(3):
                for j in range(n):
                    pull[j] += ML[3 * i + p, j] * near[i].force[p]
    for j in range(n):
        change = h * pull[j]
        rate = state[LEGS + n + j] + 0.5 * change
        state[LEGS + j] += h * rate
        state[LEGS + n + j] += change
        damped += h * dampers[j] * rate * rate
    return damped


@lean
def _move_contacts(state, near, m, first, upward, t, h, plate_speed, tally):
    """Advance springs, velocities and impulses of m near contacts over a step of h seconds that ends at t (s).

    Arguments: `first`, index of the first contact's row in the state; `upward`, upward component of each contact's
    directions (normal, along, across), shape (k, 3); `plate_speed`, upward, in the middle of the step,
    mm/s; `tally`, to which the plate's work, energy losses and landings are added. A contact's `share` is the part of
    the step, up to its end, with contact. Its `carried` is the time integral of its impulse since the frame began,
    g mm. `advance_contact` returns whether the contact's landing has ended.
    """
    sums = tally.sums
    for i in range(m):
        k = near[i].number
        at = first + ROW_LENGTH * k
        if advance_contact(state, near, i, at, t, h, sums):
            end_landing(state, at, k, upward[k, 0] > 0.0, tally)
        for p in range(3):
            sums[record.PLATE_WORK] += h * plate_speed * upward[k, p] * near[i].force[p]
        span = 0.5 * h * near[i].share
        for p in range(3):
            near[i].speed[p] = 2.0 * near[i].middle[p] - near[i].speed[p]
            push = h * near[i].force[p]
            near[i].carried[p] += h * near[i].impulse[p] + span * push
            near[i].impulse[p] += push


@lean
def _correct_late_touches(state, near, H, ML, n, m, h):
    """Undo the motion that forces caused before their contact began, for contacts that touched within the step.

    The step of h seconds has moved m near contacts and the n coordinates of the legs as if each force acted from its
    start. The force of a late contact acted for a shorter time. H is the inverse mass at the contacts, 1/g, and ML
    the response of the legs' coordinates to contact forces.
    """
    for i in range(m):
        late = 0.5 * h * h * (1.0 - near[i].share)
        if near[i].tried == OPEN or late == 0.0:
            continue
        for p in range(3):
            short, c = late * near[i].force[p], 3 * i + p
            for j in range(m):
                near[j].gap[0] -= short * H[3 * j, c]
                if near[j].tried != OPEN and near[j].share == 1.0:
                    near[j].gap[1] -= short * H[3 * j + 1, c]
                    near[j].gap[2] -= short * H[3 * j + 2, c]
            for j in range(n):
                state[LEGS + j] -= short * ML[c, j]


@lean
def _closed_time(state, near, m, first, h):
    """Compute the time (s) within a step of h seconds with any of m near contacts closed.

    A contact opens when its force, linear in time, vanishes. If the contact counted to the end of the previous
    step, this moment may lie before the start of the present step. `first` is the index of the first contact's row in
    the state.
    """
    begin, end = 1.0, -0.5
    for i in range(m):
        if near[i].tried != OPEN:
            begin, end = min(begin, 1.0 - near[i].share), 1.0
        elif state[first + ROW_LENGTH * near[i].number + MODE] != OPEN:
            depth = -near[i].gap[0]
            begin = 0.0
            if not depth > 0.0:
                end = max(end, 0.0)
                continue
            now, k, viscous = response(near[i].spring, near[i].tip, depth)
            c = near[i].damper * math.sqrt(viscous)
            now -= c * near[i].speed[0]
            falls = k * near[i].speed[0] + 2.0 * c * (near[i].middle[0] - near[i].speed[0]) / h
            end = max(end, min(max(now / (falls * h), -0.5), 1.0) if falls > 0.0 else 0.0)
    return h * (end - begin) if begin < 1.0 else 0.0


@lean
def _take_steps(walker, state, work, m, h, count, begin, plate_speed, upward_acceleration, tally):
    """Take `count` steps of h seconds with m near contacts, from the time `begin` (s) on.

    The plate starts at `plate_speed` (mm/s) and has `upward_acceleration` (mm/s^2).
    """
    near, J, A, springs, dampers = work.near, work.J, work.A, walker.stiffness, walker.damping
    H, ML, sums, first = work.H, work.ML, tally.sums, first_row(walker)
    for done in range(count):
        _swing_freely(state, near, J, work, work.swing, springs, dampers, m, h)
        if guess_modes(state, near, H, m, h, first) > 0:
            solve(near, H, A, m, h)
        else:
            for i in range(m):
                for p in range(3):
                    near[i].force[p], near[i].middle[p] = 0.0, near[i].free[p]
        sums[record.CONTACT_TIME] += _closed_time(state, near, m, first, h)
        sums[record.DAMPING_LOSS] += _move_legs(state, near, ML, work.pull, dampers, m, h)
        t, speed = begin + (done + 1) * h, plate_speed + (done + 0.5) * h * upward_acceleration
        _move_contacts(state, near, m, first, walker.upward, t, h, speed, tally)
        _correct_late_touches(state, near, H, ML, len(springs), m, h)


@lean
def _move_body(walker, motor, state, work, m, t, sums):
    """Move the body over a frame of t seconds by the impulses of its m near contacts; the legs have moved already."""
    near, MJ, R, acting, motion = work.near, work.MJ, work.R, work.acting, work.motion
    lock, n = walker.lock, len(walker.stiffness)
    for j in range(6):
        gained = t * acting[j]
        moved = t * (motion[j] + 0.5 * gained)
        for i in range(m):
            for p in range(3):
                gained += MJ[3 * i + p, j] * near[i].impulse[p]
                moved += MJ[3 * i + p, j] * near[i].carried[p]
        work.gained[j], work.moved[j] = gained, moved
    if _motor_acts(motor):
        sums[record.PLATE_WORK] += motor_work(walker, motor, state, work, m, t)
    for i in range(3):
        for j in range(3):
            state[C_X + i] += R[i, j] * work.moved[j]
            state[V_X + i] += R[i, j] * work.gained[j]
        state[W_X + i] += work.gained[3 + i]
        for j in range(n):
            work.moved[3 + i] -= lock[i, j] * (state[LEGS + j] - work.before[j])
    turn(state, work.moved[3], work.moved[4], work.moved[5])


@lean
def _advance_frame(world, state, work, begin, h, count, tally):
    """Advance by a frame of `count` steps of h seconds that starts at the time `begin`, s."""
    walker, t = world.walker, count * h
    m = _list_near_contacts(walker, state, work, t)
    for j in range(len(walker.stiffness)):
        work.before[j] = state[LEGS + j]
    plate_speed = plate_velocity(world, state)
    fill_midpoint_pose(world, state, work, t)
    fill_leg_mobility(walker, work, h)
    fill_accelerations(world, work.midway, work)
    fill_frame(world, work, plate_speed, t, m)
    upward_acceleration = plate_acceleration(world, work.midway)
    _take_steps(walker, state, work, m, h, count, begin, plate_speed, upward_acceleration, tally)
    if _sways(world.acting.sway):
        tally.sums[record.PLATE_WORK] += sway_work(work.near, m, t)
    _move_body(walker, world.acting.motor, state, work, m, t, tally.sums)
    pass_time(world, state, t)


@lean
def _turning_rate(state):
    """Return the rate at which the body turns, rad/s, never zero."""
    return math.sqrt(state[W_X] ** 2 + state[W_X + 1] ** 2 + state[W_X + 2] ** 2) + 1e-300


@lean
def _flight_level(world, state, clear):
    """Return the level i of the longest tabulated flight, Options.step 2^i, within `clear` seconds.

    It is below -HALVINGS if there is none. Flights shorter than a step are for a body that spins fast: close to a
    surface a frame of steps costs less.
    """
    step, longest = world.options.step, min(clear, MAX_TURN_RAD / _turning_rate(state))
    if _motor_acts(world.acting.motor):
        longest = min(longest, MAX_MOTOR_TURN_RAD / world.acting.motor.omega)
    level = -HALVINGS - 1
    if clear < step:
        return level
    while level + 1 < len(world.walker.flights) - HALVINGS and step * 2.0 ** (level + 1) <= longest:
        level += 1
    return level


@lean
def _has_folded_leg(walker, state):
    """Return whether a leg has turned, or its foot twisted, by 90 deg or more against the body."""
    largest = 0.0
    for j in range(len(walker.stiffness)):
        largest = max(largest, abs(state[LEGS + j]))
    return largest >= 0.5 * math.pi


@lean
def advance_in(world, state, work, duration, tally):
    """Do what `advance` does, with `work` as its memory (from `work_for`). Return a status of `world`, such as OK."""
    walker, sums, step = world.walker, tally.sums, world.options.step
    begin, t = sums[record.ELAPSED], 0.0
    can_rest = max_plate_acceleration(world) < gravity_into(world.acting)
    can_rest = can_rest and not _motor_acts(world.acting.motor)
    can_rest = can_rest and not _sways(world.acting.sway)
    period = TWO_PI / world.drive.omega
    instant, patience = MIN_TIME_PERIODS * period, DOZE_PERIODS * period
    if begin == 0.0:  # landings under way count from the record's beginning
        for k in range(len(walker.leg)):
            state[first_row(walker) + ROW_LENGTH * k + LANDED] = 0.0
    while True:
        _turn_stretches(walker, state, update_pose(world, state, work))
        sums[record.ELAPSED] = begin + t
        if begin + t >= next_sample_time(tally.samples) - instant:
            take_sample(tally.samples, begin + t, state)
        if t >= duration:
            return OK
        if not math.isfinite(state[C_X + 1]):
            return FAILED
        if lowest_corner(world, state, work) <= 0.0:
            return TOPPLED
        if _has_folded_leg(walker, state):
            return FOLDED
        sums[record.LARGEST_PITCH] = max(sums[record.LARGEST_PITCH], abs(state[PITCH]))
        fill_points(world, state, work)
        longest = min(duration - t, max(next_sample_time(tally.samples) - begin - t, instant))
        clear = clear_time(world, state, work, longest)
        level = _flight_level(world, state, clear)
        if state[QUIET] > patience:
            passed = longest
            ride_on_plate(world, state, passed, sums)
        elif level >= -HALVINGS:
            state[QUIET] = 0.0
            passed = step * 2.0**level
            fly(world, state, work, passed, level, sums)
        else:
            passed = min(longest, world.options.frame * step, max(MAX_TURN_RAD / _turning_rate(state), instant))
            count = max(math.ceil(passed / step - 1e-9), 1)
            _advance_frame(world, state, work, begin + t, passed / count, count, tally)
            if can_rest:
                count_rest_time(world, state, passed, period)
        t = duration if duration - t - passed < instant else t + passed


@kernel
def advance(world, state, duration, tally):
    """Advance `state` in place by `duration` seconds and fill `tally`. Return a status of `world`, such as OK."""
    return advance_in(world, state, work_for(world.walker, state), duration, tally)
