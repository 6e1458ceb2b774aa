"""Time stepping: Moreau and Jean's scheme with located landings, for the compliant walker.

While a foot lies on the plate, steps have a fixed length h: trapezoidal rule (springs implicit),
contact as a complementarity problem between velocities and impulses, solved exactly by enumeration
of modes. In the air, flight is in closed form, in long steps when no foot can reach the plate and
the walker does not turn fast. A landing is located inside its step and resolved there by the law of
impact; rebounds far too short for steps are absorbed, and so is every rebound off a leg that swings
back within 2 h. Second order in h while h resolves the legs' swing (docs/physics.md section 5,
accuracy); a foot may sink by part of what it travels in a step.
"""

import math
from typing import NamedTuple

import numpy as np

from walkergen.numerics.kernels import inlined, kernel
from walkergen.simulation import record
from walkergen.simulation.compliant.chain import (
    LOOSE,
    accelerate,
    chain_of,
    corner_height,
    feet_changes,
    feet_turning,
    feet_velocities,
    free_acceleration,
    gaps,
    longest_leg,
    mobility_of,
    power_lost,
    push,
    rate_forces,
    respond,
)
from walkergen.simulation.compliant.contact import (
    PLASTIC,
    Instant,
    applied,
    collide,
    folded,
    frictions,
    impulses,
    restitutions,
    settle,
    solve,
)
from walkergen.simulation.compliant.flight import clear_time, fly
from walkergen.simulation.compliant.lengths import SLIVER, longest_contact, longest_flight, stiffening, swings_back
from walkergen.simulation.compliant.momentum import keep, total_mass, whole_at, whole_of
from walkergen.simulation.drive import acceleration, derivative_bound, moved_on, velocity
from walkergen.simulation.effects.acting import across, along, body_force
from walkergen.simulation.record import next_sample, take_sample
from walkergen.simulation.world import (
    ANGLE_BACK,
    ANGLE_FRONT,
    BACKWARD,
    FAILED,
    FOLDED,
    FORWARD,
    INSIDE,
    MODE_BACK,
    MODE_FRONT,
    OK,
    OPEN,
    PHASE,
    PITCH,
    RATE_BACK,
    RATE_FRONT,
    SPIN,
    STICK,
    TOPPLED,
    V_X,
    V_Y,
    World,
    X,
    Y,
)

REACH = 1e-10
"""Gap, over the longer leg's length, below which an open foot that approaches has landed."""

INSTANT = 3e-8
"""Part of a step that counts as no time."""

TOGETHER = 1e-9
"""Part of a step within which two landings count as simultaneous."""

ABSORBED = 0.03
"""Rebounds that last less than 2 h times this are absorbed. What they lose took half of the speed
of some walkers at 1, and at a tenth of this nothing changes (docs/physics.md section 5)."""

SUNK = 1e-3
"""Depth of a rising foot, over the longer leg's length, that no step explains: a run has failed."""

STALLED = 200
"""Number of steps in a row that take no time after which a run has failed."""


class Options(NamedTuple):
    """Lengths of the steps."""

    step: float = 3e-5
    """Length h of a step in contact, s."""
    flight: int = 50
    """Longest step in the air, in units of h."""


class Work(NamedTuple):
    """Work space of a run."""

    start: np.ndarray
    """State before the step."""
    trial: np.ndarray
    """Sums of the tally after a trial step."""
    rows: np.ndarray
    """Equations of two feet, work space of shape (4, 5)."""
    pushed: np.ndarray
    """What the last trial step in contact gave all as one: velocity (x, y) and angular momentum."""


def coarser(world: World, factor: float) -> World:
    """World with steps `factor` times longer."""
    return world._replace(options=world.options._replace(step=factor * world.options.step))


def resting(world: World) -> float:
    """Speed (mm/s) below which a foot does not rebound: what gravity gives it in part of a step."""
    return float(ABSORBED * world.options.step * world.acting.gravity.size)


@kernel
def _drift(state, t):
    """Move the positions on for t seconds at the present rates."""
    state[X] += t * state[V_X]
    state[Y] += t * state[V_Y]
    state[PITCH] += t * state[SPIN]
    state[ANGLE_BACK] += t * state[RATE_BACK]
    state[ANGLE_FRONT] += t * state[RATE_FRONT]


@kernel
def _sliding_on(mode, v_x):
    """Mode of a foot that goes on sliding at v_x; `mode` when it is open or does not slide."""
    if mode == OPEN or v_x == 0.0:
        return mode
    return FORWARD if v_x > 0.0 else BACKWARD


@kernel
def _stop(W, u, before, back, front, friction, rows):
    """Part of the step after which a foot stops sliding, by its speeds if friction stayed the same.

    Friction jumps at a stop: a step across would be of first order only.
    """
    on_b, on_f = _sliding_on(back, before[0]), _sliding_on(front, before[2])
    if on_b == back and on_f == front:
        return 1.0
    d = applied(W, impulses(W, u, on_b, on_f, friction, rows))
    part = 1.0
    if on_b != back:
        part = min(part, _zero(before[0], u[0] + d[0]))
    if on_f != front:
        part = min(part, _zero(before[2], u[2] + d[2]))
    return part


@kernel
def _zero(first, last):
    """Place (0..1) where a speed linear from `first` to `last` vanishes; 1 when nowhere, or at once
    (a foot that has just stopped keeps an error of second order).
    """
    if first * last >= 0.0 or abs(first) < 1e-3 * abs(last):
        return 1.0
    return first / (first - last)


@inlined
def _accelerate(world, state, t, chain, free, F):
    """Add the changes `free` and by F to the rates, and what these change of the forces that rates make.

    Those of the rates before alone are of first order. Returns the force (x, y) of effects on the body.
    """
    x_0, y_0 = body_force(world.acting, state[PITCH], state[V_X], state[V_Y])
    early = rate_forces(world, state, chain)
    accelerate(state, free)
    accelerate(state, push(chain, F))
    x_1, y_1 = body_force(world.acting, state[PITCH], state[V_X], state[V_Y])
    late, half = rate_forces(world, state, chain), 0.5 * t
    f_x, f_y, f_t = half * (late[0] - early[0]), half * (late[1] - early[1]), half * (late[2] - early[2])
    accelerate(state, respond(chain, f_x, f_y, f_t, half * (late[3] - early[3]), half * (late[4] - early[4])))
    return 0.5 * (x_0 + x_1), 0.5 * (y_0 + y_1)


@inlined
def _pushed(world, t, chain, F, f_x, f_y):
    """Change of all as one by a step: of its velocity (x, y) and angular momentum, by weight, contacts F
    and effects f on the body.
    """
    b, f, walker = chain.back, chain.front, world.walker
    mass, mu = total_mass(walker), walker.ratios.mass
    share = walker.legs[0].mass / mass
    x, y = share * (b.A_x + b.C_x + mu * (f.A_x + f.C_x)), share * (b.A_y + b.C_y + mu * (f.A_y + f.C_y))
    back = (b.A_x + b.r_x - x) * F[1] - (b.A_y + b.r_y - y) * F[0]
    front = (f.A_x + f.r_x - x) * F[3] - (f.A_y + f.r_y - y) * F[2]
    return (
        (F[0] + F[2] + t * f_x) / mass + t * along(world.acting),
        (F[1] + F[3] + t * f_y) / mass - t * across(world.acting),
        back + front + t * (y * f_x - x * f_y),
    )


@kernel
def _contact_step(world, state, t, sums, work):
    """One step of t seconds with at least one foot closed; sets the modes.

    Returns the part of the step after which a sliding foot stops, 1 when none does.
    """
    legs = world.walker.legs
    rate_b, rate_f = state[RATE_BACK], state[RATE_FRONT]
    v_x, v_y = state[V_X], state[V_Y]
    plate_before = velocity(world.drive, state[PHASE])
    _drift(state, 0.5 * t)
    state[PHASE] = moved_on(world.drive, state[PHASE], t)
    chain = chain_of(world.walker, state, stiffening(legs, t))
    before = feet_velocities(world, state, chain)
    a_x, a_y, a_t, a_b, a_f = free_acceleration(world, state, chain)
    free = (t * a_x, t * a_y, t * a_t, t * a_b, t * a_f)
    d, turning = feet_changes(chain, free), feet_turning(state, chain)
    u = (
        before[0] + d[0] + 0.5 * t * turning[0],
        before[1] + d[1] + 0.5 * t * turning[1],
        before[2] + d[2] + 0.5 * t * turning[2],
        before[3] + d[3] + 0.5 * t * turning[3],
    )
    closed = (state[MODE_BACK] != OPEN, state[MODE_FRONT] != OPEN)
    guess, W = (int(state[MODE_BACK]), int(state[MODE_FRONT])), mobility_of(chain)
    back, front, F = solve(W, u, closed, guess, frictions(world), work.rows)
    part = _stop(W, u, before, back, front, frictions(world), work.rows)
    f_x, f_y = _accelerate(world, state, t, chain, free, F)
    state[MODE_BACK], state[MODE_FRONT] = back, front
    after = feet_velocities(world, state, chain)
    _drift(state, 0.5 * t)
    work.pushed[0], work.pushed[1], work.pushed[2] = _pushed(world, t, chain, F, f_x, f_y)

    plate_after = velocity(world.drive, state[PHASE])
    by_plate = 0.5 * (F[1] + F[3]) * (plate_before + plate_after)
    gained = 0.0
    for i in range(4):
        gained += 0.5 * F[i] * (before[i] + after[i])
    # `before` was taken over the plate's velocity at the end of the step
    gained += (F[1] + F[3]) * plate_after
    sums[record.PLATE_WORK] += by_plate
    sums[record.FRICTION_LOSS] += by_plate - gained
    mean_b = 0.5 * (rate_b + state[RATE_BACK])
    mean_f = 0.5 * (rate_f + state[RATE_FRONT])
    v_x, v_y = 0.5 * (v_x + state[V_X]), 0.5 * (v_y + state[V_Y])
    sums[record.DAMPING_LOSS] += t * power_lost(world, state[PITCH], v_x, v_y, mean_b, mean_f)
    return part


@inlined
def _step(world, state, t, sums, work):
    """One step of t seconds; returns the part of it after which a foot stops, else 1."""
    if state[MODE_BACK] == OPEN and state[MODE_FRONT] == OPEN:
        fly(world, state, t, sums)
        return 1.0
    return _contact_step(world, state, t, sums, work)


@kernel
def _crossing(gap_0, rate_0, gap_1, rate_1, t):
    """Part of the step after which a foot lands: root of the cubic through gaps and rates."""
    c_1, c_2 = t * rate_0, 3.0 * (gap_1 - gap_0) - t * (2.0 * rate_0 + rate_1)
    c_3 = 2.0 * (gap_0 - gap_1) + t * (rate_0 + rate_1)
    low, high = 0.0, 1.0
    for _ in range(48):
        middle = 0.5 * (low + high)
        if gap_0 + middle * (c_1 + middle * (c_2 + middle * c_3)) > 0.0:
            low = middle
        else:
            high = middle
    return high if high > 1e-6 else 1.0  # it starts below: a dip that ends with the step


@kernel
def _lands(gap_0, gap_1, rate_1):
    """True when an open foot lands in a step: it ends below the plate, and fell to get there.

    A foot that began below it may also end the step rising and yet deeper, where the step misses
    whole swings of its leg.
    """
    return gap_1 < 0.0 and (gap_0 > 0.0 or rate_1 < 0.0 or gap_1 < gap_0)


@inlined
def _step_to_landing(world, state, t, stops, gap_0, u_0, sums, work):
    """Step of t seconds, or less when a foot lands: (time passed, back lands, front lands).

    `stops`: end at a foot's stop as well; gap_0, u_0: gaps and velocities of the feet before it.
    """
    start, trial = work.start, work.trial
    start[:] = state
    part, located, back, front = 1.0, False, False, False
    while True:
        trial[:] = sums
        turn = _step(world, state, part * t, trial, work)
        if located:
            break
        chain = chain_of(world.walker, state, LOOSE)
        gap_1, u_1 = gaps(world.drive, state, chain), feet_velocities(world, state, chain)
        back = start[MODE_BACK] == OPEN and _lands(gap_0[0], gap_1[0], u_1[1])
        front = start[MODE_FRONT] == OPEN and _lands(gap_0[1], gap_1[1], u_1[3])
        part_b = _crossing(gap_0[0], u_0[1], gap_1[0], u_1[1], t) if back else 2.0
        part_f = _crossing(gap_0[1], u_0[3], gap_1[1], u_1[3], t) if front else 2.0
        part = min(part_b, part_f, turn if stops else 1.0)
        back, front = part_b <= part + TOGETHER, part_f <= part + TOGETHER
        if part == 1.0 and not (back or front):
            break
        located = True
        state[:] = start
    sums[:] = trial
    return part * t, back, front


@kernel
def _surface(world, state, gap, landed, rows):
    """Shift feet that land below the plate onto it.

    A foot could sink a little in every bounce that is lost in a step: where it has landed and
    rebounds it is open, and `settle` leaves it where it is.
    """
    reach = REACH * longest_leg(world.walker)
    back, front = landed[0] and gap[0] < -reach, landed[1] and gap[1] < -reach
    if back or front:
        modes = state[MODE_BACK], state[MODE_FRONT]
        state[MODE_BACK] = FORWARD if back else modes[0]
        state[MODE_FRONT] = FORWARD if front else modes[1]
        whole = whole_of(world.walker, state)
        settle(world, state, stiffening(world.walker.legs, world.options.step), rows)
        keep(world.walker, state, whole.v_x, whole.v_y, whole.turning)
        state[MODE_BACK], state[MODE_FRONT] = modes
    return back or front


@kernel
def _land(world, state, chain, gap, landed, tally, rows):
    """Impacts of the feet that land, of those on the plate and of those in reach of it, which the
    other's impact may throw onto it; sets the modes of all of these.
    """
    short, reach = ABSORBED * world.options.step, REACH * longest_leg(world.walker)
    touching = (
        landed[0] or state[MODE_BACK] != OPEN or gap[0] <= reach,
        landed[1] or state[MODE_FRONT] != OPEN or gap[1] <= reach,
    )
    d = feet_changes(chain, free_acceleration(world, state, chain))
    turning = feet_turning(state, chain)
    lift = acceleration(world.drive, state[PHASE])
    least = short * across(world.acting)
    rest = (max(short * (lift - d[1] - turning[1]), least), max(short * (lift - d[3] - turning[3]), least))
    swung = swings_back(world.walker, 2.0 * world.options.step)
    e = PLASTIC if swung else restitutions(world)
    collide(world, e, state, Instant(chain, mobility_of(chain), rows, tally), touching, rest)
    u = feet_velocities(world, state, chain)
    if touching[0]:
        state[MODE_BACK] = OPEN if u[1] > rest[0] else max(state[MODE_BACK], STICK)
    if touching[1]:
        state[MODE_FRONT] = OPEN if u[3] > rest[1] else max(state[MODE_FRONT], STICK)


@kernel
def _sunk(world, state, gap, u):
    """True when an open foot lies deeper than a step explains: it would never be lifted."""
    step, deep = world.options.step, SUNK * longest_leg(world.walker)
    deep += step * derivative_bound(world.drive, 1)
    back = state[MODE_BACK] == OPEN and gap[0] < -deep - step * abs(u[1])
    return back or (state[MODE_FRONT] == OPEN and gap[1] < -deep - step * abs(u[3]))


@kernel
def advance(world, state, duration, tally):
    """Advance `state` in place by `duration` seconds, fill `tally`, return a status of `world`."""
    work = Work(np.empty_like(state), np.empty_like(tally.sums), np.empty((4, 5)), np.empty(3))
    sums, h, legs = tally.sums, world.options.step, world.walker.legs
    instant, reach = INSTANT * h, REACH * longest_leg(world.walker)
    begin, t, stalled, back, front = sums[record.ELAPSED], 0.0, 0, False, False
    stopped = False
    while t < duration:
        sums[record.ELAPSED] = begin + t
        if begin + t >= next_sample(tally.samples) - instant:
            take_sample(tally.samples, begin + t, state)
        if corner_height(world, state) <= 0.0:
            return TOPPLED
        if folded(state):
            return FOLDED
        chain = chain_of(world.walker, state, LOOSE)
        gap, u = gaps(world.drive, state, chain), feet_velocities(world, state, chain)
        back = back or (state[MODE_BACK] == OPEN and gap[0] <= reach and u[1] <= 0.0)
        front = front or (state[MODE_FRONT] == OPEN and gap[1] <= reach and u[3] <= 0.0)
        if back or front:
            if _surface(world, state, gap, (back, front), work.rows):
                chain = chain_of(world.walker, state, LOOSE)
                gap = gaps(world.drive, state, chain)
            _land(world, state, chain, gap, (back, front), tally, work.rows)
            u = feet_velocities(world, state, chain)
        if _sunk(world, state, gap, u):
            return INSIDE
        closed = state[MODE_BACK] != OPEN or state[MODE_FRONT] != OPEN
        if closed:
            length = longest_contact(state, h)
        else:
            clear = clear_time(world, state, chain, gap)
            length = min(max(clear, h), longest_flight(world.walker, state, world.options, clear))
        length = min(length, duration - t, max(next_sample(tally.samples) - begin - t, instant))
        stops = length > SLIVER * h and not stopped
        whole = whole_at(world.walker, state, chain)
        passed, back, front = _step_to_landing(world, state, length, stops, gap, u, sums, work)
        stopped = passed < length and not (back or front)
        if closed:
            sums[record.CONTACT_TIME] += passed
            settle(world, state, stiffening(legs, h), work.rows)
            v_x, v_y, turned = work.pushed
            keep(world.walker, state, whole.v_x + v_x, whole.v_y + v_y, whole.turning + turned)
        sums[record.LARGEST_PITCH] = max(sums[record.LARGEST_PITCH], abs(state[PITCH]))
        stalled = stalled + 1 if passed <= instant else 0
        if stalled > STALLED or not math.isfinite(state[Y]):
            return FAILED
        t = duration if duration - t - passed < 1e-3 * instant else t + passed
    sums[record.ELAPSED] = begin + duration
    return OK
