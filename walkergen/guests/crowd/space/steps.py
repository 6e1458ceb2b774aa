"""Time steps of a crowd: every walker moves as a single one while it cannot touch another.

Time passes in ticks and in rounds of 2^LEVELS ticks. Contacts take one tick each. A walker moves on by 2^n ticks in one
step. n is as large as its gaps allow at its own and its neighbours' speeds: far from all others, a whole round. As
these spans nest, walkers near each other are always at the same time. The result depends only on the order of the pairs
that touch. `crowd` is a `bodies.Crowd`, which kernels change. `i` and `j` are numbers of walkers.
"""

import math
from typing import NamedTuple

import numpy as np

from walkergen.core import Array
from walkergen.core.numerics.kernels import borrow_item, kernel, kernel_without_refcount, lean
from walkergen.core.simulation.space.pose import plate_velocity, update_pose
from walkergen.core.simulation.space.state import C_X, C_Z, HEADING, LEGS, V_X
from walkergen.core.simulation.space.steps import advance_in
from walkergen.core.simulation.world import OK
from walkergen.guests.crowd.space.bodies import (
    COS,
    DEEPEST,
    LATE,
    LEAN_X,
    LEAN_Z,
    LIFTED,
    PERIODIC,
    SIN,
    SPEED,
    STORED,
    TOUCHES,
    X,
    Z,
)
from walkergen.guests.crowd.space.contacts import resolve_pair, resolve_walls
from walkergen.guests.crowd.space.gaps import FAR, body_gap, gap_lower_bound, wall_gap

LEVELS = 8
"""A round is 2^LEVELS ticks, about ten milliseconds."""


class Plans(NamedTuple):
    """Times of the next updates, in ticks of a round, for p pairs and N walkers."""

    safe: Array
    """Time before which a pair cannot touch, shape (p,)."""
    seen: Array
    """Gap (mm) of a pair at its last update, and the time of that update, shape (p, 2)."""
    safe_wall: Array
    seen_wall: Array
    """`safe_wall` and `seen_wall`: the same for walkers and walls, shapes (N,) and (N, 2)."""
    until: Array
    """Time reached by each walker, shape (N,)."""
    allowed: Array
    """Largest n of the 2^n ticks that it may move now, shape (N,)."""


NEAR_TICKS = 64.0
"""Two bodies whose gap may close within so many ticks get an exact gap, others a lower bound."""

RECENT_TICKS = 8.0
"""Ticks after which an earlier closing rate of a gap no longer counts."""

FORESEEN_TICKS, LANDING_SHARE = 2.0, 0.25
"""Ticks over which a gap's rate is extrapolated, and the part of a landing's change of velocity within these ticks."""


@kernel_without_refcount
def _move(crowd, i, t):
    """Move walker i by t seconds as if alone, and update its row of `crowd.planar`. With t = 0 only update it."""
    mover = borrow_item(crowd.movers, i)
    if t == 0.0:
        update_pose(mover.world, mover.state, mover.work)
    elif crowd.status[i] == OK:
        crowd.status[i] = advance_in(mover.world, mover.state, mover.work, t, mover.tally)
    _update_planar(crowd, i, mover)


@lean
def _update_planar(crowd, i, mover):
    """Update the row of walker i in `crowd.planar`: its top view, and a bound of its outline's speed."""
    state, work, walker, planar = mover.state, mover.work, mover.world.walker, crowd.planar
    R, now, n = work.R, work.now, len(walker.stiffness)
    o_x, o_y, o_z = 0.0, 0.0, 0.0
    for j in range(n):
        o_x -= walker.shift[0, j] * state[LEGS + j]
        o_y -= walker.shift[1, j] * state[LEGS + j]
        o_z -= walker.shift[2, j] * state[LEGS + j]
    planar[i, X] = state[C_X] + R[0, 0] * o_x + R[0, 1] * o_y + R[0, 2] * o_z
    planar[i, Z] = state[C_Z] + R[2, 0] * o_x + R[2, 1] * o_y + R[2, 2] * o_z
    planar[i, COS], planar[i, SIN] = math.cos(state[HEADING]), -math.sin(state[HEADING])
    planar[i, LEAN_X], planar[i, LEAN_Z] = R[0, 1], R[2, 1]
    planar[i, LIFTED] = plate_velocity(mover.world, state)
    if crowd.status[i] != OK:
        planar[i, SPEED] = 0.0
        return
    kind = crowd.bodies.kind[i]
    turning = R[1, 0] * now[3] + R[1, 1] * now[4] + R[1, 2] * now[5]
    whole = now[3] * now[3] + now[4] * now[4] + now[5] * now[5]
    tilting = math.sqrt(max(whole - turning * turning, 0.0))
    height = max(abs(crowd.bodies.ends[kind, 0]), abs(crowd.bodies.ends[kind, 1]))
    speed = math.sqrt(state[V_X] * state[V_X] + state[V_X + 2] * state[V_X + 2])
    speed += abs(turning) * crowd.bodies.reach[kind] + tilting * height
    planar[i, SPEED] = speed + crowd.law.margin


@lean
def _max_level(ticks, most):
    """Return the largest n with 2^n <= ticks, at most `most`."""
    level = 0
    while level < most and 2.0 ** (level + 1) <= ticks:
        level += 1
    return level


@lean
def _record_touch(crowd, row, column, count, late):
    """Record whether walkers `row` and `column` touch (one walker twice: it touches a wall).

    `count`: number of corners in touch. `late`: whether they overlap deeper than a tick explains.
    """
    touches = 1 if count > 0 else 0
    if touches == 1 and crowd.touching[row, column] == 0:
        crowd.book[TOUCHES] += 1.0
        if late:
            crowd.book[LATE] += 1.0
    crowd.touching[row, column] = touches


@lean
def _ticks_to_contact(crowd, fastest, margin, gap, past, ticks):
    """Compute the ticks until a gap (mm) may close; below 1 if it may close in the next tick.

    A safe answer uses `fastest`, the largest speed at which the gap can close (mm/s). Up to FORESEEN_TICKS the answer
    may be larger: the gap then closes at its mean rate since it was `past` (mm), `ticks` ago, increased by half and by
    a part of `margin` (mm/s), the change of velocity in a landing.
    """
    tick = crowd.tick[0]
    safe_ticks = gap / (tick * fastest)
    if safe_ticks >= FORESEEN_TICKS or ticks > RECENT_TICKS:
        return safe_ticks
    rate = (past - gap) / (ticks * tick)
    likely_ticks = gap / (tick * (max(1.5 * rate, 0.0) + LANDING_SHARE * margin))
    return max(safe_ticks, min(likely_ticks, FORESEEN_TICKS))


@lean
def _meet_pair(crowd, i, j, seen, now):
    """Resolve contacts of walkers i and j at contact step (tick) `now`. Return the ticks until they may touch, >= 1.

    `seen`: gap (mm) at the last update and its tick, shape (2,). Both are replaced by the present ones.
    """
    if crowd.status[i] != OK and crowd.status[j] != OK:
        return FAR
    fastest = crowd.planar[i, SPEED] + crowd.planar[j, SPEED]
    cutoff = NEAR_TICKS * fastest * crowd.tick[0]
    gap = body_gap(crowd.bodies, crowd.ground, crowd.planar, i, j, cutoff)
    ticks = _ticks_to_contact(crowd, fastest, 2.0 * crowd.law.margin, gap, seen[0], now - seen[1])
    seen[0], seen[1] = gap, now
    count = resolve_pair(crowd, i, j, True) if gap < 0.0 else 0
    _record_touch(crowd, i, j, count, -gap > fastest * crowd.tick[0])
    return max(ticks, 1.0)


@lean
def _meet_walls(crowd, i, seen, now):
    """Resolve contacts of walker i with walls at tick `now`. Return and `seen` have the meaning of `_meet_pair`."""
    if crowd.status[i] != OK:
        return FAR
    gap = wall_gap(crowd.bodies, crowd.ground, crowd.planar, i)
    fastest = crowd.planar[i, SPEED]
    ticks = _ticks_to_contact(crowd, fastest, crowd.law.margin, gap, seen[0], now - seen[1])
    seen[0], seen[1] = gap, now
    count = resolve_walls(crowd, i, True) if gap < 0.0 else 0
    _record_touch(crowd, i, i, count, -gap > fastest * crowd.tick[0])
    return max(ticks, 1.0)


@kernel_without_refcount
def _list_neighbours(crowd, span, pairs):
    """Fill `pairs`, (p, 2), with walkers that may touch within `span` s. Return their number; -1 if p is too small."""
    count, n = 0, len(crowd.status)
    for i in range(n):
        for j in range(i + 1, n):
            closing = 2.0 * (crowd.planar[i, SPEED] + crowd.planar[j, SPEED])
            if gap_lower_bound(crowd.bodies, crowd.ground, crowd.planar, i, j) < closing * span:
                if count == len(pairs):
                    return -1
                pairs[count, 0], pairs[count, 1] = i, j
                count += 1
    return count


@kernel_without_refcount
def _advance_round(crowd, pairs, count, plans, levels):
    """Move the crowd by 2^levels contact steps (ticks). The first `count` of `pairs` may touch. `plans`: work space."""
    n, ticks, tick = len(crowd.status), 1 << levels, crowd.tick[0]
    safe, seen, safe_wall, seen_wall = plans.safe, plans.seen, plans.safe_wall, plans.seen_wall
    until, allowed = plans.until, plans.allowed
    safe[:count], safe_wall[:], until[:] = 0.0, 0.0, 0
    seen[:count, 1] = seen_wall[:, 1] = -FAR
    for now in range(ticks):
        max_level = levels
        if now > 0:
            max_level = 0
            while (now >> max_level) & 1 == 0:
                max_level += 1
        for i in range(n):
            if until[i] != now:
                continue
            if safe_wall[i] <= now + 1.0:
                safe_wall[i] = now + _meet_walls(crowd, i, seen_wall[i], now)
            allowed[i] = _max_level(safe_wall[i] - now, max_level)
        for p in range(count):
            i, j = pairs[p, 0], pairs[p, 1]
            if until[i] != now or until[j] != now:
                continue
            if safe[p] <= now + 1.0:
                safe[p] = now + _meet_pair(crowd, i, j, seen[p], now)
            pair_level = _max_level(safe[p] - now, max_level)
            allowed[i], allowed[j] = min(allowed[i], pair_level), min(allowed[j], pair_level)
        for i in range(n):
            if until[i] == now:
                until[i] = now + (1 << allowed[i])
                _move(crowd, i, tick * 2.0 ** allowed[i])


@kernel
def advance(crowd, pairs, duration):
    """Advance a crowd, in place, by `duration` seconds and return the time that has passed.

    `pairs`: working memory for the walkers that may touch, shape (p, 2). If p is too small, less time has passed.
    """
    n, passed, law = len(crowd.status), 0.0, crowd.law
    if n == 1 and crowd.ground.kind >= PERIODIC:
        _move(crowd, 0, duration)
        return duration
    plans = Plans(
        np.empty(len(pairs)),
        np.empty((len(pairs), 2)),
        np.empty(n),
        np.empty((n, 2)),
        np.empty(n, np.int64),
        np.empty(n, np.int64),
    )
    full = law.tick * 2.0**LEVELS
    for i in range(n):
        _move(crowd, i, 0.0)
    while passed < duration:
        left, levels, tick = duration - passed, LEVELS, law.tick
        if left < full:
            while levels > 0 and 2.0 ** (levels - 1) * law.tick >= left:
                levels -= 1
            tick = left / 2.0**levels
        crowd.tick[0] = tick
        count = _list_neighbours(crowd, tick * 2.0**levels, pairs)
        if count < 0:
            return passed
        _advance_round(crowd, pairs, count, plans, levels)
        passed = passed + full if left > full else duration
    return passed


@kernel
def contact_energy(crowd):
    """Return the energy stored in contacts between bodies and with walls, g mm^2/s^2. The book keeps it as STORED."""
    deepest = crowd.book[DEEPEST]
    crowd.book[STORED] = 0.0
    for i in range(len(crowd.status)):
        resolve_walls(crowd, i, False)  # only adds the energy to the book
        for j in range(i + 1, len(crowd.status)):
            if gap_lower_bound(crowd.bodies, crowd.ground, crowd.planar, i, j) < 0.0:
                resolve_pair(crowd, i, j, False)
    crowd.book[DEEPEST] = deepest
    return crowd.book[STORED]
