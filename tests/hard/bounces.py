"""Hard cases of bouncing: series without end, energy over very many impacts, grazing contact."""

import math
from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from hard import COMPLIANT, EVERY, RIGID, THREE_COORDINATES, fall_time, lift, with_legs
from walkergen.jobs.trust.selftest.case import Case, Check, exactly
from walkergen.jobs.trust.selftest.scenes import HALF, STILL, TALL, Array, advance, plan_of, shaken
from walkergen.scene import GRAVITY
from walkergen.simulation import record
from walkergen.simulation.drive import TWO_PI, velocity
from walkergen.simulation.model import Plan
from walkergen.simulation.run import Outcome
from walkergen.simulation.world import MODE_BACK, MODE_FRONT, OPEN, PHASE, PITCH, SPIN, V_X, V_Y, X

STEP_US = 10.0

BOUNCES = {"relaxed": 1_108_000, "rigid": 1_108_000, "compliant": 50_000}
"""Numbers of bounces that take some seconds to compute, of 9 ms each: by events 1e4 s; both feet strike
in each."""


def _ball(model: str, restitution: float, friction: float = 0.0) -> Plan:
    """An upright walker over a plate at rest: dropped level, it bounces like a ball."""
    plan = plan_of(
        model, 0.0, drive=STILL, run={"step_us": STEP_US}, contact={"restitution": restitution, "friction": friction}
    )
    return with_legs(plan, 1.0, 0.0) if model == "compliant" else plan


def _rebound(plan: Plan, restitution: float) -> float:
    """Restitution of a level landing of relaxed legs: v' = v + H_rigid F, F = (1 + e) w / H_yy."""
    if plan.resolved.model != "relaxed":
        return restitution
    walker = plan.world.walker
    rigid = 1.0 / walker.mass + walker.feet[0][0] ** 2 / walker.inertia
    return float((1.0 + restitution) * rigid / walker.flexible[0].yy - 1.0)


def _zeno(model: str) -> Iterator[Check]:
    gap = 0.1
    for e in (0.0, 0.5, 0.8):
        plan = _ball(model, e)
        k = _rebound(plan, e)
        state = plan.start(gap, 0.0, 0.0)
        state[V_Y] = 0.0
        end = fall_time(gap) * (1 + k) / (1 - k)
        # only engines that stand in closed form rest for a day; the others for half a second
        duration = 1e5 if model in THREE_COORDINATES else end + 0.5
        outcome, tally = advance(plan, state, duration)
        late = abs(duration - tally.sums[record.CONTACT_TIME] - end)
        cut = 2.0 * plan.model.resting(plan.world) / (GRAVITY * (1 - k))
        yield Check(
            f"e = {e:g}: end of the series, s",
            late,
            cut + 1e-9 + 1e-14 * duration,
            "the bounces left out below the resting speed; rounding of the time",
        )
        yield exactly(
            f"e = {e:g}: rests on both feet",
            outcome is Outcome.OK and OPEN not in (state[MODE_BACK], state[MODE_FRONT]),
        )
        yield Check(
            f"e = {e:g}: way, mm",
            abs(float(state[X])),
            1e-9,
            "rounding; undamped legs that still swing push the frictionless body by 1e-11",
        )
        yield Check(
            f"e = {e:g}: impacts computed",
            float(tally.counts[0]),
            700.0,
            "two feet, until 44 mm/s have shrunk to 1e-5 by factors of 0.92",
        )


def _many_bounces(model: str) -> Iterator[Check]:
    """Check energy and height in endless bounces: restitution 1 on a plate at rest."""
    gap, bounces = 0.1, BOUNCES[model]
    plan = _ball(model, 1.0)
    if model == "relaxed":  # the restitution of its feet with which it rebounds elastically
        plan = _ball(model, 4.0 / (1.0 + _rebound(plan, 1.0)) - 1.0)
    state = plan.start(gap, 0.0, 0.0)
    state[V_Y] = 0.0
    rest = plan.energy(state) - _weight(plan) * gap
    before = plan.energy(state) - rest
    period = 2.0 * fall_time(gap)
    outcome, impacts, seconds, piece = Outcome.OK, 0, 0.0, 2.0**-3
    while seconds < (bounces + 0.5) * period and outcome is Outcome.OK:  # in pieces, as a run is
        outcome, tally = advance(plan, state, piece)
        impacts += tally.counts[record.IMPACTS]
        seconds += piece
    drift = abs((plan.energy(state) - rest) / before - 1.0)
    yield Check(
        f"energy after {2 * bounces:.0e} impacts, relative",
        drift,
        2e-14 * bounces,
        "1e-9 in 1e5 impacts: the rounding of a height, 1e-15 mm of 0.1 mm, in each",
    )
    yield Check(
        "impacts missed",
        abs(float(impacts) - 2.0 * seconds / period),
        2.0,
        "the first falls half a period after the start, the last on either side of the end",
    )
    yield exactly("no pitch", outcome is Outcome.OK and abs(state[PITCH]) < 1e-9)
    yield Check(
        f"phase after {seconds:.3g} s, s",
        _phase_error(state, 0.0, plan.world.drive.omega, seconds),
        1e-9,
        "docs/physics.md asks for 1e-9 s",
    )
    yield Check(
        "drift sideways, mm",
        abs(float(state[X])),
        1e-9 * bounces * period,
        "1e-9 mm/s, which the roundings of impulses that stop 44 mm/s may add up to",
    )
    yield Check(
        "foot below the plate, mm",
        max(0.0, -float(plan.feet(state)[:, 1].min())),
        2e-5,
        "a step's dip, a h^2 / 8; event-driven: 1e-12",
    )


def _springs(model: str) -> Iterator[Check]:
    """Check that undamped legs keep their energy in chaos: e = 1, no friction, plate at rest."""
    for tilt in (0.0, 20.0):
        plan = with_legs(
            plan_of(model, tilt, drive=STILL, run={"step_us": STEP_US}, contact={"restitution": 1.0, "friction": 0.0}),
            1.0,
            0.0,
        )
        state = plan.start(0.1, 0.01, 0.0)
        rest = plan.energy(plan.start(0.0, 0.0, 0.0))
        before = plan.energy(state) - rest
        outcome, tally = advance(plan, state, 0.5)
        drift = abs((plan.energy(state) - rest) / before - 1.0)
        yield exactly(f"tilt {tilt:g}: runs on, with impacts", outcome is Outcome.OK and tally.counts[0] > 50)
        yield Check(
            f"tilt {tilt:g}: energy after 0.5 s, relative",
            drift,
            5e-2,
            "rebounds below the resting speed are left out; second order",
        )


def _weight(plan: Plan) -> float:
    """Of all, g mm/s^2, by the energy of one mm."""
    low = plan.start(1.0, 0.0, 0.0)
    high = plan.start(2.0, 0.0, 0.0)
    return plan.energy(high) - plan.energy(low)


def _grazing(model: str) -> Iterator[Check]:
    """Check a double root of the gap of foot and plate; `offset` decides if they touch."""
    offset = 1e-9
    reason = "a double root is found down to the rounding of a height, far below 1e-9 mm"
    if model == "compliant":
        offset, reason = 1e-5, "within one step a gap may dip by a h^2 / 8 = 2e-6 mm unseen"
    plan = plan_of(model, 0.0, drive=shaken(3.0), run={"step_us": 30.0}, contact={"restitution": 0.5, "friction": 0.0})
    shaker = plan.world.drive
    touch, before = 1.2, 1.5e-3
    for sign in (1.0, -1.0):
        state = plan.start(sign * offset, 0.0, touch)
        state[V_Y] = velocity(shaker, touch)
        state[1] -= before * (state[V_Y] + 0.5 * GRAVITY * before)
        state[V_Y] += GRAVITY * before
        state[PHASE] -= shaker.omega * before
        _, tally = advance(plan, state, before + 1e-4)
        what = "misses by" if sign > 0 else "touches, deep by"
        yield exactly(f"{what} {offset:g} mm", (tally.counts[0] > 0) == (sign < 0), reason)


def _phase_error(state: Array, phase: float, omega: float, seconds: float) -> float:
    """Time (s) by which the drive's phase is off after `seconds`, by exact fractions."""
    turn = Fraction(TWO_PI)
    exact = (Fraction(phase) + Fraction(omega) * Fraction(seconds)) % turn
    off = (Fraction(float(state[PHASE])) - exact) % turn
    return float(min(off, turn - off)) / omega


def _long_time(model: str) -> Iterator[Check]:
    """Standing on a plate shaken at 0.5 g; 1e5 s where a stand costs nothing, else 1 s."""
    plan = plan_of(model, 0.0, drive=shaken(0.5))
    state = plan.start(0.0, 0.0, 0.3)
    omega = plan.world.drive.omega
    if model in THREE_COORDINATES:
        pieces, length = 10_000, 10.0
    else:
        pieces, length = 64, 2.0**-7
    inside = True
    for _ in range(pieces):
        advance(plan, state, length)
        inside = inside and 0.0 <= state[PHASE] < TWO_PI
    yield exactly("phase stays in one turn", inside, "so that no digit is lost to the time")
    yield Check(
        f"phase after {pieces * length:g} s, s",
        _phase_error(state, 0.3, omega, pieces * length),
        1e-9,
        "docs/physics.md asks for 1e-9 s",
    )


def _rocking(model: str) -> Iterator[Check]:
    """One foot leaves in the instant in which the other lands: Housner's rocking block (1963)."""
    plan = plan_of(model, 0.0, drive=STILL, contact={"restitution": 0.0, "friction": 5.0})
    for side in (1.0, -1.0):
        state = plan.start(0.0, 0.0, 0.5 * math.pi)
        state[PITCH], state[SPIN] = side * 0.02, 0.0
        lift(plan, state, 0.0)
        state[V_X] = state[V_Y] = 0.0
        before = plan.energy(state)
        ratio, loss = _housner(plan)
        outcome, _ = advance(plan, state, _quarter(plan, 0.02) * (1 + 0.3 * ratio))
        fallen = before - plan.energy(state)
        yield exactly(
            "stands on the other foot, the first in the air",
            outcome is Outcome.OK
            and side * state[PITCH] < 0.0
            and state[MODE_BACK if side > 0 else MODE_FRONT] == OPEN
            and state[MODE_FRONT if side > 0 else MODE_BACK] != OPEN,
        )
        drop = before - plan.energy(plan.start(0.0, 0.0, 0.5 * math.pi))
        stands = np.abs(plan.feet(state)[:, 1]).min()
        yield Check("standing foot off the plate, mm", float(stands), 1e-13, "rounding of heights")
        yield Check("share of energy lost", abs(fallen / drop - loss), 1e-9, "integration at 1e-10")


def _dip(model: str) -> Iterator[Check]:
    """Check a front foot that dips, before friction on the sliding back foot lifts it.

    Turning down at `spin` against an angular acceleration alpha, the foot would just graze the
    plate if the pitch were spin^2 / (2 alpha).
    """
    mu, spin, share = 1.0, 0.2, 1e-3
    plan = plan_of(model, 0.0, drive=STILL, contact={"restitution": 0.0, "friction": mu})
    M, J = plan.world.walker.mass, plan.world.walker.inertia
    normal = GRAVITY / (1.0 / M + (HALF**2 - mu * HALF * TALL) / J)
    alpha = normal * (mu * TALL - HALF) / J
    for sign in (1.0, -1.0):
        state = plan.start(0.0, 0.0, 0.5 * math.pi)
        state[PITCH], state[SPIN] = (1.0 + sign * share) * spin**2 / (2.0 * alpha), -spin
        lift(plan, state, 0.0)
        back = plan.feet(state)[0]
        state[V_X], state[V_Y] = -200.0, 0.0
        state[V_Y] -= float(plan.feet(state)[0, 3])
        outcome, tally = advance(plan, state, 2.0 * spin / alpha)
        yield exactly(
            f"front foot {'misses' if sign > 0 else 'touches'} by {share:g} of the pitch",
            outcome is Outcome.OK and (tally.counts[0] > 0) == (sign < 0) and back[1] < 1e-9,
        )


def _housner(plan: Plan) -> tuple[float, float]:
    """Spin after over spin before, and share of energy lost, by angular momentum about the foot."""
    M, J = plan.world.walker.mass, plan.world.walker.inertia
    about_foot = J + M * (HALF**2 + TALL**2)
    ratio = (about_foot - 2.0 * M * HALF**2) / about_foot
    return ratio, 1.0 - ratio**2


def _quarter(plan: Plan, pitch: float) -> float:
    """Time (s) of a fall from rest at a small pitch to level: constant torque of the weight."""
    M, J = plan.world.walker.mass, plan.world.walker.inertia
    about_foot = J + M * (HALF**2 + TALL**2)
    return math.sqrt(2.0 * pitch * about_foot / (M * GRAVITY * (HALF - TALL * pitch)))


CASES = [
    Case(
        "bouncing for ever: e = 1, no friction",
        "6.4",
        "first law: a ball at e = 1 loses nothing",
        tuple(BOUNCES),
        _many_bounces,
    ),
    Case("bouncing on undamped springs", "6.4", "first law: no loss without damper or slip", COMPLIANT, _springs),
    Case("zeno: bouncing to rest", "6.7", "geometric series of a bouncing ball's times", EVERY, _zeno),
    Case("grazing contact", "6.8", "parabola against sine, by hand", EVERY, _grazing),
    Case(
        "one foot leaves as the other lands", "6.8", "Housner, Bull. Seismol. Soc. Am. 53, 403 (1963)", RIGID, _rocking
    ),
    Case(
        "a foot that dips while the other slides",
        "6.8",
        "rigid body under Coulomb friction, by hand",
        THREE_COORDINATES,
        _dip,
    ),
    Case("time after 1e5 s", "6.12", "exact rational arithmetic of the phase", EVERY, _long_time),
]
