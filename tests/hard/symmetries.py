"""Hard cases of symmetry: mirror images, shifts of the phase, scaled walkers, a moving plate."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from hard import COMPLIANT, EVERY, THREE_COORDINATES, lift
from walkergen.jobs.trust.selftest.case import Case, Check, exactly
from walkergen.jobs.trust.selftest.scenes import STILL, Array, advance, design_of, plan_of, scaled, shaken
from walkergen.jobs.trust.selftest.scenes import masses as masses_of
from walkergen.simulation import record
from walkergen.simulation.compliant.chain import chain_of, mobility_of
from walkergen.simulation.model import Plan
from walkergen.simulation.run import Outcome
from walkergen.simulation.world import ANGLE_FRONT, PHASE, PITCH, SPIN, V_X, V_Y, X, Y, mirrored
from walkergen.walker import mass as masses

SHORT = 0.012
"""Duration, s, of two landings, before chaos (an e-fold in 4 to 13 ms) has amplified rounding."""

GROWN = "rounding, grown tenfold by each of a few impacts"


def _dropped(plan: Plan, side: float = 1.0, phase: float = 1.0, gap: float = 0.05) -> Array:
    """A drop with everything moving; side -1 is the mirror image."""
    state = plan.start(gap, 0.0, phase)
    state[PITCH] += side * 4e-3
    state[SPIN], state[V_X] = side * 0.7, side * 12.0
    lift(plan, state, gap)
    return state


def _apart(one: Array, other: Array) -> float:
    """Largest difference of place (mm) and pitch (rad)."""
    return float(np.abs(one - other)[[X, Y, PITCH]].max())


def _mirror(model: str) -> Iterator[Check]:
    exact = model in THREE_COORDINATES
    reason = "exact: only signs differ" if exact else GROWN
    for e, mu, law in ((0.9, 0.1, "poisson"), (0.5, 2.0, "stronge"), (0.0, 0.25, "newton")):
        contact = {"restitution": e, "friction": mu, "law": law}
        right = plan_of(model, 10.0, drive=shaken(1.8), contact=contact)
        left = plan_of(model, -10.0, drive=shaken(1.8), contact=contact)
        one, other = _dropped(right), _dropped(left, -1.0)
        seconds = 0.4 if exact else SHORT
        advance(right, one, seconds)
        advance(left, other, seconds)
        yield Check(
            f"{law}, mu = {mu:g}: image after {seconds:g} s, mm",
            _apart(mirrored(other), one),
            0.0 if exact else 1e-8,
            reason,
        )


def _upright(model: str) -> Iterator[Check]:
    exact = model in THREE_COORDINATES
    seconds = 2.0 if exact else 0.05
    reason = "exact: no preference" if exact else "rounding, grown over four landings"
    for e in (0.0, 0.6):
        for mu in (0.25, 5.0):
            contact = {"restitution": e, "friction": mu}
            plan = plan_of(model, 0.0, drive=shaken(1.8), contact=contact)
            state = plan.start(0.03, 0.0, 1.0)
            advance(plan, state, seconds)
            drift = max(abs(state[X]), abs(state[PITCH]))
            yield Check(
                f"e = {e:g}, mu = {mu:g}: drift or pitch after {seconds:g} s", drift, 0.0 if exact else 1e-9, reason
            )


def _almost_upright(model: str) -> Iterator[Check]:
    ends = []
    for tilt in (0.0, 1e-12, -1e-12):
        plan = plan_of(model, tilt, drive=shaken(1.8))
        state = _dropped(plan)
        advance(plan, state, SHORT)
        ends.append(state)
    apart = max(_apart(ends[0], ends[1]), _apart(ends[0], ends[2]))
    yield Check("end of the run at +-1e-12 deg against 0, mm", apart, 1e-8, GROWN)


def _shift(model: str) -> Iterator[Check]:
    for turns, limit in ((1, 1e-8), (1_000_000, 1e-4)):
        plan = plan_of(model, 10.0, drive=shaken(1.8))
        one, other = _dropped(plan), _dropped(plan)
        other[PHASE] += 2.0 * math.pi * turns
        advance(plan, one, SHORT)
        advance(plan, other, SHORT)
        yield Check(
            f"{turns} periods later, mm",
            _apart(one, other),
            limit,
            f"rounding of a phase of {turns} turns, grown tenfold by each impact",
        )


def _moving_plate(model: str) -> Iterator[Check]:
    """Check landings at phase 0, where the plate moves at A omega: only relative speeds count."""
    instant = 1e-11
    contact = {"restitution": 0.5, "friction": 0.25}
    for both in (True, False):
        ends = []
        for drive in (STILL, shaken(1.8)):
            plan = plan_of(model, 10.0, drive=drive, contact=contact)
            state = plan.start(0.0, 0.0, 0.0)
            if not both:
                state[PITCH] += 0.01
                lift(plan, state, 0.0)
            state[V_X] = 15.0
            state[V_Y] += -25.0 - float(plan.feet(state)[0, 3])
            advance(plan, state, instant)
            ends.append(plan.feet(state)[:, 2:])
        apart = float(np.abs(ends[0] - ends[1]).max())
        yield Check(
            f"{'both feet' if both else 'one foot'}: velocities after a landing, mm/s",
            apart,
            1e-6,
            "the plate's acceleration in 1e-11 s, 1e-7 mm/s; rounding",
        )


def _scales(model: str) -> Iterator[Check]:
    ends = {}
    for scale in (1.0, 1e-3, 1e3):
        plan = scaled(model, scale, {"step_us": 10.0 * math.sqrt(scale)})
        state = plan.start(0.05 * scale, 0.0, 1.0)
        state[PITCH] += 4e-3
        state[V_X] = 12.0 * math.sqrt(scale)
        lift(plan, state, 0.05 * scale)
        advance(plan, state, SHORT * math.sqrt(scale))
        ends[scale] = state[[X, Y, PITCH]] / (scale, scale, 1.0)
    limit, reason = 1e-10, GROWN
    for scale in (1e-3, 1e3):
        apart = float(np.abs(ends[scale] - ends[1.0]).max())
        yield Check(f"lengths x {scale:g}: end of the run, scaled", apart, limit, reason)


def _powers_of_two(model: str) -> Iterator[Check]:
    """Check lengths x 4^n and times x 2^n: the scaled problem has the scaled result to the last bit.

    Every length of the code, of steps and tolerances too, must then be in units of walker and plate.
    """
    start = None
    for power in (0, -5, -4, -1, 1, 4, 5):
        length, seconds = 4.0**power, 2.0**power
        plan = scaled(model, length)
        state = plan.start(0.0625 * length, 0.0, 1.0)
        state[PITCH] += 4e-3
        state[V_X] = 12.0 * seconds
        lift(plan, state, 0.0625 * length)
        outcome, tally = advance(plan, state, 0.25 * seconds)
        state[[X, Y]] /= length
        state[[V_X, V_Y]] /= seconds
        state[[SPIN, *range(ANGLE_FRONT + 1, len(state))]] *= seconds
        if start is None:
            start = state
            yield exactly("it runs and lands", outcome is Outcome.OK and tally.counts[record.IMPACTS] > 20)
        else:
            apart = float(np.abs(state - start).max())
            yield Check(f"lengths x 4^{power}: state after 0.25 s x 2^{power}", apart, 0.0, "exact: powers of two")


def _far(model: str) -> Iterator[Check]:
    """Check a start 2^30 mm along the plate: only its place may know of it."""
    for e, mu, law in ((0.9, 0.1, "poisson"), (0.5, 2.0, "stronge"), (0.0, 0.25, "newton")):
        contact = {"restitution": e, "friction": mu, "law": law}
        plan = plan_of(model, 10.0, drive=shaken(1.8), contact=contact)
        here, far = _dropped(plan), _dropped(plan)
        far[X] += 2.0**30
        for state in (here, far):
            _, tally = advance(plan, state, 0.2)
        off = abs(far[X] - 2.0**30 - here[X])
        limit = 1.2e-7 * max(20.0 * tally.counts[record.IMPACTS], 0.2 / 5e-6)
        yield Check(f"{law}: way in 0.2 s, mm", off, limit, "rounding of 1e9 mm, 1.2e-7 mm, in each step or event")
        far[X] = here[X]
        yield Check(f"{law}: all else", float(np.abs(far - here).max()), 0.0, "exact: nothing else knows the place")


def _tolerance(model: str) -> Iterator[Check]:
    """Check contact tolerances coarser by 16, and the snap speed that belongs to them by 4."""
    for mu in (0.0, 0.1, 5.0):
        contact = {"restitution": 0.8, "friction": mu}
        plan = plan_of(model, 10.0, drive=shaken(1.8), contact=contact)
        one, other = _dropped(plan), _dropped(plan)
        advance(plan, one, 2.0 * SHORT)
        coarse = plan._replace(world=plan.model.coarser(plan.world, 16.0))
        advance(coarse, other, 2.0 * SHORT)
        yield Check(
            f"mu = {mu:g}: end of the run, mm",
            _apart(one, other),
            1e-5,
            "integration of rocking goes with the tolerance; grown by impacts",
        )


def _frozen_joints(model: str) -> Iterator[Check]:
    """Legs on springs without end stiffness: the braced walker's inverse mass at the feet."""
    plan = plan_of(model, 20.0)
    walker, state = plan.world.walker, plan.start(1.0, 0.0, 0.0)
    stiffened = tuple(1e12 * leg.inertia for leg in walker.legs)
    frozen: Any = chain_of(walker, state, stiffened)
    stiff: Any = mobility_of(frozen)
    whole = masses.as_rigid(masses_of(design_of(model, 20.0)))
    d = whole.legs[0].foot
    braced = 1.0 / whole.M + float(d[0]) ** 2 / whole.J
    yield Check(
        "mobility of the back foot, relative",
        abs(stiff.bb_yy / braced - 1.0),
        1e-9,
        "1e-12 of give in the hinges, times H_flexible / H_rigid of some hundred",
    )


CASES = [
    Case("upright walker, level drop: no drift", "6.1", "mirror symmetry", EVERY, _upright),
    Case("almost upright", "6.1", "continuity in the tilt", EVERY, _almost_upright),
    Case("lengths x 1e-3 and x 1e3", "6.5", "dimensional analysis", EVERY, _scales),
    Case("lengths x 4^n, times x 2^n", "6.5", "dimensional analysis", EVERY, _powers_of_two),
    Case("1e9 mm from the origin", "6.13", "translation along the plate", EVERY, _far),
    Case("contact tolerances change nothing", "6.10", "the limit of no tolerance", THREE_COORDINATES, _tolerance),
    Case("mirror image runs backwards", "6.13", "mirror symmetry", EVERY, _mirror),
    Case("shift by whole periods", "6.13", "periodicity of the drive", EVERY, _shift),
    Case("landing on a moving plate", "6.13", "Galileo: relative speeds alone count", EVERY, _moving_plate),
    Case(
        "stiff hinges: inverse mass of the braced walker",
        "6.14",
        "rigid bodies: parallel axes",
        COMPLIANT,
        _frozen_joints,
    ),
]
