"""Event-driven integration of the compliant (or braced) walker: the reference of model B.

Between events `flow` integrates the motion in the present contact modes, with error control. Events
(landing, lift-off, stop, break-away) are located by shortening the step itself, not by an
interpolant, so that they are as accurate as the flow. Impacts follow any law of restitution; a foot
that would rebound slower than `snap` stays on the plate, which ends endless sequences of impacts.
"""

import math
from typing import NamedTuple

import numpy as np

from walkergen.numerics.kernels import kernel
from walkergen.simulation import record
from walkergen.simulation.compliant.chain import (
    LOOSE,
    accelerate,
    chain_of,
    corner_height,
    feet_velocities,
    gaps,
    mobility_of,
    push,
)
from walkergen.simulation.compliant.contact import (
    FRICTIONLESS,
    JAMMED,
    SMOOTH,
    Instant,
    applied,
    collide,
    folded,
    frictions,
    give,
    impulses,
    restitutions,
    settle,
    solve,
)
from walkergen.simulation.compliant.flow import (
    Work,
    accelerations,
    error_of,
    level_of,
    scales_of,
    shoot,
    slopes_of,
)
from walkergen.simulation.drive import TWO_PI, velocity
from walkergen.simulation.record import (
    add_impulse,
    next_sample,
    note_event,
    take_sample,
    tally_impact,
)
from walkergen.simulation.world import (
    FAILED,
    FOLDED,
    FORWARD,
    MODE_BACK,
    MODE_FRONT,
    OK,
    OPEN,
    PHASE,
    PITCH,
    STICK,
    TOPPLED,
    World,
)
from walkergen.theory.impact import III_MIRRORED, TYPE_III

TOUCH = 500.0
"""Gap, in roundings of a foot's height, below which a foot that approaches takes part in an impact:
1e-11 mm for a walker of 1 cm."""

REST = 1e-8
"""Sliding speed (mm/s) below which a foot on the plate is at rest."""

SHORTEST = 1e-10
"""Step (s) taken over an event that lasts no time, such as friction exactly at its limit, unless
legs are so fast that it would be a long one (`_shortest`)."""

INSTANT, REPEATED = 1e-15, 10
"""Time (s) that counts as zero after `REPEATED` steps in a row without more progress."""

PACE, HAMMERING, DOUBLES = 1e-6, 50.0, 10.0
"""Time (s) in which one event is forgotten; number of events, so counted, from which on feet
hammer; number of further ones with which the rebounds that do not count last twice as long."""

BRIEF = 1e-7
"""Longest rebound (s) that does not count where feet hammer, as they do at restitution 1 until all
friction has slowed them: it ends within a hundredth of the contact time of a real foot."""

STALLED = 10_000
"""Number of steps in a row no longer than the shortest after which a run has failed."""

ABOVE_FED = 2.0
"""Least speed at which feet rebound, over that which a foot gains by falling as deep as `level_of`:
enough where an impact passes less than 0.87 of a foot's speed to the other."""

JAMS = 60
"""Number of jams at one instant after which the feet go on as they are. Each may push the other
foot into a slower slide that jams too: some ten turns end below `REST` if the ninth part passes."""


class Options(NamedTuple):
    """Accuracy of the integration."""

    tolerance: float = 1e-10
    """Error of a step, relative to the speeds of a fall by a leg's length (1e-3 of the length)."""
    snap: float = 1e-3
    """Speed (mm/s) below which a foot does not rebound, if `_resting` is not more."""
    longest: float = 2e-4
    """Longest step, s."""


def coarser(world: World, factor: float) -> World:
    """World with a tolerance of the integration `factor` times larger."""
    options = world.options
    return world._replace(options=options._replace(tolerance=factor * options.tolerance))


def resting(world: World) -> float:
    """Speed (mm/s) below which a foot does not rebound."""
    return float(world.options.snap)


@kernel
def _shortest(legs, swing):
    """SHORTEST, or a hundredth of the time in which the fastest leg swings or is damped, s."""
    if legs is None:
        return SHORTEST
    fastest = 0.0
    for leg in legs:
        mobility = max(swing.mobility_1, swing.mobility_2)
        fastest = max(fastest, leg.damping * mobility, math.sqrt(leg.stiffness * mobility))
    return SHORTEST if fastest * SHORTEST <= 1e-2 else 1e-2 / fastest


@kernel
def _locate(world, work, margin_0, t, margin_t):
    """Shorten a step of t seconds that passes an event to the event; work.trial is the state there.

    Returns the time passed, 0 when the event is at once. Illinois variant of regula falsi.
    """
    low, m_low, high, m_high = 0.0, margin_0, t, margin_t
    while m_low <= 0.0:
        low = 0.5 * high
        m_low = shoot(world, work, low)
        if m_low <= 0.0:
            high, m_high = low, m_low
            if high < 1e-13:
                return 0.0
    side = 0
    for turn in range(150):
        if high - low <= 4e-16 + 1e-14 * high:
            break
        middle = (low * m_high - high * m_low) / (m_high - m_low)
        # the margin is the least of several and may have a kink: every third cut is in half
        if turn % 3 == 2 or not low < middle < high:
            middle = 0.5 * (low + high)
        m = shoot(world, work, middle)
        if m > 0.0:
            low, m_low, m_high = middle, m, 0.5 * m_high if side == 1 else m_high
            side = 1
        else:
            high, m_high, m_low = middle, m, 0.5 * m_low if side == -1 else m_low
            side = -1
        if m == 0.0:
            break
    shoot(world, work, high)
    return high


@kernel
def _lowest(world, work, t):
    """Time within the step at which an open foot turns from falling to rising; 0 when none does."""
    first = feet_velocities(world, work.now, chain_of(world.walker, work.now, LOOSE))
    last = feet_velocities(world, work.trial, chain_of(world.walker, work.trial, LOOSE))
    for mode, i in ((MODE_BACK, 1), (MODE_FRONT, 3)):
        if work.now[mode] == OPEN and first[i] < 0.0 < last[i]:
            return t * first[i] / (first[i] - last[i])
    return 0.0


@kernel
def _direction(v_x):
    return 0 if abs(v_x) <= REST else (1 if v_x > 0.0 else -1)


@kernel
def _hold(world, state, chain, closed, sums, rows):
    """Remove what is left of the velocities of closed feet: normal, and tangential when at rest.

    Rebounds too slow to count end here; what they lose is an impact's loss.
    """
    u, W = feet_velocities(world, state, chain), mobility_of(chain)
    mu_b, mu_f = frictions(world)
    rests = mu_b >= FRICTIONLESS and abs(u[0]) <= REST, mu_f >= FRICTIONLESS and abs(u[2]) <= REST
    back = (STICK if rests[0] else FORWARD) if closed[0] else OPEN
    front = (STICK if rests[1] else FORWARD) if closed[1] else OPEN
    F = impulses(W, u, back, front, SMOOTH, rows)
    d = applied(W, F)
    accelerate(world.walker.legs, state, push(chain, F))
    sums[record.PLATE_WORK] += (F[1] + F[3]) * velocity(world.drive, state[PHASE])
    for i in range(4):
        sums[record.IMPACT_LOSS] -= F[i] * (u[i] + 0.5 * d[i])


@kernel
def _stop_jam(world, state, now, closed, sliding):
    """Stop feet at once whose friction presses them ever harder into the plate (Painleve).

    The impulse sticks each foot that jams on its own, or both when they jam only together; a foot
    that this would have to pull down leaves instead.
    """
    W, tally, rows = now.mobility, now.tally, now.rows
    u, mu = feet_velocities(world, state, now.chain), frictions(world)
    back = closed[0] and (1.0 - JAMMED) * W.bb_yy <= sliding[0] * mu[0] * W.bb_xy
    front = closed[1] and (1.0 - JAMMED) * W.ff_yy <= sliding[1] * mu[1] * W.ff_xy
    if not (back or front):
        back, front = closed
    F = impulses(W, u, STICK if back else OPEN, STICK if front else OPEN, mu, rows)
    if back and front and min(F[1], F[3]) < 0.0:
        back, front = F[1] >= F[3], F[3] > F[1]
        F = impulses(W, u, STICK if back else OPEN, STICK if front else OPEN, mu, rows)
    d = applied(W, F)
    accelerate(world.walker.legs, state, push(now.chain, F))
    tally.sums[record.PLATE_WORK] += (F[1] + F[3]) * velocity(world.drive, state[PHASE])
    for i in range(4):
        tally.sums[record.IMPACT_LOSS] -= F[i] * (u[i] + 0.5 * d[i])
    for foot in range(2):
        if (back, front)[foot]:
            F_x, F_y, v_x, v_y = F[2 * foot], F[2 * foot + 1], u[2 * foot], u[2 * foot + 1]
            kind = TYPE_III if v_x > 0.0 else III_MIRRORED
            tally_impact(tally.counts, kind, True)
            add_impulse(tally.sums, kind, F_y)
            note_event(tally.events, tally.sums[record.ELAPSED], foot, F_x, F_y, v_x, v_y, kind)


@kernel
def _resting(world, state, chain, blows):
    """Speeds (mm/s) below which the back and the front foot do not rebound at this instant.

    A foot lands at a depth of `level_of`, having left from none: its acceleration a over that depth
    would feed an endless sequence of alternating feet (docs/physics.md section 5, trap 2). And a
    rebound that ends within `SHORTEST` is none: at restitution 1 a damped leg makes any number.
    Where feet hammer, with more than HAMMERING `blows`, neither is a longer one, up to BRIEF.
    """
    _, free = accelerations(world, state, chain)
    a = max(abs(free[1]), abs(free[3]))
    fed = math.sqrt(2.0 * a * level_of(world.drive, state))
    rest = max(world.options.snap, ABOVE_FED * fed, 0.5 * a * SHORTEST)
    if blows <= HAMMERING:
        return rest, rest
    brief = min(BRIEF, SHORTEST * 2.0 ** ((blows - HAMMERING) / DOUBLES))
    return max(rest, 0.5 * abs(free[1]) * brief), max(rest, 0.5 * abs(free[3]) * brief)


@kernel
def _jammed(world, state):
    """True when feet that slide in the state's modes jam."""
    W = mobility_of(chain_of(world.walker, state, LOOSE))
    back, front = int(state[MODE_BACK]), int(state[MODE_FRONT])
    return abs(give(W, back, front, frictions(world))) <= JAMMED


@kernel
def decide(world, state, tally, rows, blows):
    """Resolve the impacts of this instant, then choose the modes of feet that stay; in place.

    `blows` (`_resting`): number of events that came close upon each other before this one.
    """
    friction = frictions(world)
    chain = chain_of(world.walker, state, LOOSE)
    gap, u = gaps(world.drive, state, chain), feet_velocities(world, state, chain)
    touch, rest = TOUCH * level_of(world.drive, state), _resting(world, state, chain, blows)
    was = (int(state[MODE_BACK]), int(state[MODE_FRONT]))
    touching = (
        was[0] != OPEN or (gap[0] <= touch and u[1] <= rest[0]),
        was[1] != OPEN or (gap[1] <= touch and u[3] <= rest[1]),
    )
    # Stopping a jam pushes the other foot into the plate or off it, and that one may slide on.
    for jams in range(1 + JAMS):
        now = Instant(chain, mobility_of(chain), rows, tally)
        collide(world, restitutions(world), state, now, touching, rest)
        u = feet_velocities(world, state, chain)
        closed = (touching[0] and u[1] <= rest[0], touching[1] and u[3] <= rest[1])
        guess = (was[0] if closed[0] else OPEN, was[1] if closed[1] else OPEN)
        state[MODE_BACK], state[MODE_FRONT] = OPEN, OPEN
        if not (closed[0] or closed[1]):
            return
        # A foot that leaves from inside the plate, if only by rounding, would land again at once.
        state[MODE_BACK] = FORWARD if closed[0] else OPEN
        state[MODE_FRONT] = FORWARD if closed[1] else OPEN
        settle(world, state, LOOSE, rows)
        chain = chain_of(world.walker, state, LOOSE)
        _hold(world, state, chain, closed, tally.sums, rows)
        W = mobility_of(chain)
        _, a = accelerations(world, state, chain)
        u = feet_velocities(world, state, chain)
        sliding = (_direction(u[0]), _direction(u[2]))
        back, front, _, violation = solve(W, a, closed, sliding, guess, friction, rows)
        state[MODE_BACK], state[MODE_FRONT] = back, front
        if jams == JAMS or (violation <= 1e-9 and not _jammed(world, state)):
            return
        _stop_jam(world, state, Instant(chain, W, rows, tally), closed, sliding)


@kernel
def _accept(world, state, work, passed, sums):
    """Move the state to the end of the step, without drift off the plate; tally its energies."""
    n = state.size
    closed = (state[MODE_BACK] != OPEN, state[MODE_FRONT] != OPEN)
    state[:] = work.trial[:n]
    state[PHASE] %= TWO_PI
    sums[record.PLATE_WORK] += work.trial[n]
    sums[record.FRICTION_LOSS] += work.trial[n + 1]
    sums[record.DAMPING_LOSS] += work.trial[n + 2]
    sums[record.LARGEST_PITCH] = max(sums[record.LARGEST_PITCH], abs(state[PITCH]))
    if closed[0] or closed[1]:
        sums[record.CONTACT_TIME] += passed
        settle(world, state, LOOSE, work.rows)
        chain = chain_of(world.walker, state, LOOSE)
        _hold(world, state, chain, closed, sums, work.rows)


@kernel
def _next(world, work, length):
    """Integrate to an event or by `length` s: (time, -1 on failure; event or not; next length)."""
    margins = slopes_of(world, work.now, work.slopes[0], work.rows)
    margin_0, t = min(margins[0], margins[1]), length
    while True:
        margin = shoot(world, work, t)
        error = error_of(work, t, world.options.tolerance)
        if error <= 1.0:
            break
        t *= max(0.2, 0.9 * error**-0.2)
        if not t > 1e-15:
            return -1.0, False, t
    grown = t * min(4.0, 0.9 * (error + 1e-12) ** -0.2)
    if margin > 0.0:
        dip = _lowest(world, work, t)
        if dip <= 0.0:
            return t, False, grown
        margin = shoot(world, work, dip)
        if margin > 0.0:
            shoot(world, work, t)
            return t, False, grown
        return _locate(world, work, margin_0, dip, margin), True, grown
    return _locate(world, work, margin_0, t, margin), True, grown


@kernel
def advance(world, state, duration, tally):
    """Advance `state` in place by `duration` seconds, fill `tally`, return a status of `world`."""
    n, sums = state.size, tally.sums
    work = Work(
        np.zeros(n + 3),
        np.zeros(n + 3),
        np.zeros(n + 3),
        np.zeros((7, n + 3)),
        np.empty((4, 5)),
        scales_of(world, state),
    )
    begin, t, stalled, length, blows = sums[record.ELAPSED], 0.0, 0, 1e-6, 0.0
    shortest = _shortest(world.walker.legs, world.walker.swing)
    decide(world, state, tally, work.rows, blows)
    while t < duration:
        sums[record.ELAPSED] = begin + t
        if begin + t >= next_sample(tally.samples) - 1e-12:
            take_sample(tally.samples, begin + t, state)
        if corner_height(world, state) <= 0.0:
            return TOPPLED
        if folded(world.walker.legs, state):
            return FOLDED
        work.now[:n] = state
        work.now[n:] = 0.0
        until = min(duration - t, max(next_sample(tally.samples) - begin - t, 1e-12))
        passed, event, grown = _next(world, work, min(length, world.options.longest, until))
        if passed < 0.0 or stalled > STALLED:
            return FAILED
        length = max(grown, 1e-9)
        at_once = event and (passed == 0.0 or (passed < INSTANT and stalled > REPEATED))
        if at_once and not _jammed(world, state):  # a step over a jam has no bound
            passed = min(shortest, until)
            shoot(world, work, passed)
        stalled = stalled + 1 if passed <= shortest else 0
        _accept(world, state, work, passed, sums)
        t = duration if duration - t - passed < 1e-15 else t + passed
        sums[record.ELAPSED] = begin + t
        blows = max(0.0, blows - passed / PACE)
        if event:
            decide(world, state, tally, work.rows, blows)
            blows += 1.0
    return OK
