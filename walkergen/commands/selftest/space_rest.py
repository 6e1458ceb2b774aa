"""Hard cases of rest in space: a spin that stops, feet that do not creep, a roll that rights."""

import math
import time
from collections.abc import Iterator

import numpy as np

from walkergen.commands.selftest.case import SPACE, Case, Check, check_fact
from walkergen.commands.selftest.scenes import HALF_SPACING_MM, STILL_DRIVE, advance, paper_drive
from walkergen.commands.selftest.space_scenes import (
    SETTLING_S,
    friction_windup,
    max_pose_difference,
    resting_state,
    space_plan,
)
from walkergen.core.numerics import Array
from walkergen.core.scene import GRAVITY, REST_GAMMA
from walkergen.core.simulation import record
from walkergen.core.simulation.plan import Plan
from walkergen.core.simulation.run import Outcome
from walkergen.core.simulation.space.state import (
    C_Y,
    HEADING,
    LEGS,
    PITCH,
    QUIET,
    ROLL,
    SHOWN_X,
    SHOWN_Y,
    V_X,
    V_Y,
    V_Z,
    W_X,
    W_Y,
    W_Z,
)

BOOKS = 1e-3, "second order in the steps in which feet start and stop to slide"
"""Limit of a book of energy, with its reason."""

STANDING_S = 5.0
"""Time (s) during which a standing walker is observed."""

AWAKE_STEP_S = 0.02
"""Time (s) during which a walker at rest is still simulated step by step."""

LONG_REST_S = 1e5
"""Duration of a long rest, s."""

RAISED_CORNER_MM = 0.02
"""Height (mm) of one uneven corner."""

FRICTION = 0.25
"""Friction that stops a spin."""

SPINS = (*((10.0, rate) for rate in np.linspace(8.0, 44.0, 10)), (0.0, 20.0), (20.0, 20.0))
"""Tilts of legs (deg) and rates of spins (rad/s). At ten rates a spin stops at ten phases of its ringing."""


def _check_spins() -> Iterator[Check]:
    """Check spins on four corners against Coulomb friction on the circle through them."""
    for tilt, rate in SPINS:
        plan = space_plan(tilt, drive=STILL_DRIVE, contact={"friction": FRICTION, "restitution": 0.3})
        yield from _check_spin(plan, rate, f"{tilt:g} deg, {rate:g} rad/s")


def _check_spin(plan: Plan, rate: float, title: str) -> Iterator[Check]:
    """Check one spin at `rate`, rad/s: its turn, then its rest and its energy."""
    state = resting_state(plan)
    state[[W_Y, QUIET]] = rate, 0.0
    start, radius = state.copy(), math.hypot(HALF_SPACING_MM, 0.5 * plan.case.design.size.depth)
    walker = plan.world.walker
    turn = 0.5 * walker.inertia[1, 1] * rate**2 / (FRICTION * walker.mass * GRAVITY * radius)
    swing = 2.0 * friction_windup(plan) / radius
    before = plan.energy(start)
    _, spun = advance(plan, state, 2.4 * turn / rate)  # 1.2 of Coulomb's time
    stopped = state.copy()
    _, rested = advance(plan, state, 0.5)
    yield Check(
        f"{title}: turn against that of Coulomb's torque, rad",
        abs(float(state[HEADING] - start[HEADING]) - turn),
        4.0 * swing + 4e-3 * turn,
        "springs wind up, at the start and at the end: twice their range; feet of tilted legs lie off the circle by "
        "0.3 % of its radius",
    )
    yield Check(
        f"{title}: turn after 1.2 of Coulomb's time, rad",
        abs(float(state[HEADING] - stopped[HEADING])),
        2.0 * swing,
        "it has stopped, and swings on springs that friction has wound up: twice their range",
    )
    rates = float(np.abs(state[W_X : W_Z + 1]).max())
    yield Check(f"{title}: rates half a second later, rad/s", rates, 0.0, "exact: it rides on the plate")
    gained = record.energy_error(spun.sums + rested.sums, plan.energy(state) - before, before)
    yield Check(f"{title}: energy unaccounted for, relative", gained, *BOOKS)
    if not plan.case.design.limbs[0].tilt:
        drift = float(np.abs(state - start)[[SHOWN_X, SHOWN_Y]].max())
        yield Check(f"{title}: drift, mm", drift, 1e-9, "none by symmetry; rounding")


def _raise_corner(plan: Plan, height: float) -> Plan:
    """Return a plan whose corner 1 is higher than the others by `height`, mm."""
    walker = plan.world.walker
    reach = walker.reach.copy()
    reach[1, 1] += height
    return plan._replace(world=plan.world._replace(walker=walker._replace(reach=reach)))


def _advance_awake(plan: Plan, state: Array, seconds: float) -> None:
    """Advance a walker's `state` in place without letting it rest: at rest it would move with the plate."""
    for _ in range(round(seconds / AWAKE_STEP_S)):
        state[QUIET] = 0.0
        advance(plan, state, AWAKE_STEP_S)


def _check_standing() -> Iterator[Check]:
    """Check that standing walkers do not creep, on even feet and with one raised corner."""
    for tilt in (0.0, 10.0, 20.0, 35.0):
        for height in (0.0, RAISED_CORNER_MM):
            plan = space_plan(tilt, drive=STILL_DRIVE, contact={"friction": FRICTION, "restitution": 0.3})
            plan = _raise_corner(plan, height)
            state = plan.initial_state(clearance=0.0, pitch=0.0, phase=0.0)
            _advance_awake(plan, state, SETTLING_S)
            before = state.copy()
            _advance_awake(plan, state, STANDING_S)
            how = f"one corner {1e3 * height:g} um high" if height else "even"
            yield Check(
                f"{tilt:g} deg, {how}: creep in {STANDING_S:g} s of a walker kept awake, mm or rad",
                max_pose_difference(state, before),
                2.0 * friction_windup(plan),
                "what friction lets springs swing, however long",
            )


def _check_long_rest() -> Iterator[Check]:
    """Check 1e5 s on a plate that moves but cannot throw the walker: no creep, at no cost."""
    for gamma in (REST_GAMMA, 0.5):
        plan = space_plan(
            drive=STILL_DRIVE if gamma == REST_GAMMA else paper_drive(gamma),
            contact={"friction": 0.6, "restitution": 0.3},
        )
        state, legs = resting_state(plan), len(plan.world.walker.stiffness)
        state[[V_X, V_Y, V_Z, W_X, W_Y, W_Z, LEGS + legs]] += 1e-3  # whose energy then is lost
        before, energy, started = state.copy(), plan.energy(state), time.process_time()
        outcome, tally = advance(plan, state, LONG_REST_S)
        title = f"{gamma:g} g"
        yield check_fact(f"{title}: it ends well ({outcome.value})", outcome is Outcome.OK)
        moved = float(np.abs(state - before)[[SHOWN_X, SHOWN_Y, HEADING, PITCH, ROLL]].max())
        yield Check(f"{title}: way in {LONG_REST_S:g} s, mm or rad", moved, 0.0, "exact: it rides on the plate")
        rates = float(np.abs(state[[V_X, V_Z, W_X, W_Y, W_Z, *range(LEGS + legs, LEGS + 2 * legs)]]).max())
        yield Check(f"{title}: rates, mm/s or rad/s", rates, 0.0, "exact: it rides on the plate")
        cost = time.process_time() - started
        yield Check(f"{title}: time on the processor, s", cost, 1.0, "a few steps")
        gained = plan.energy(state) - energy - float(tally.sums[record.PLATE_WORK] - tally.sums[record.DAMPING_LOSS])
        whole = plan.world.walker.mass * GRAVITY * float(state[C_Y])
        yield Check(f"{title}: energy from nowhere, relative", abs(gained) / whole, 1e-9, "rounding")


def _check_righting() -> Iterator[Check]:
    """Check that a walker rights itself or topples, let go just inside and beyond the edge of its feet."""
    for tilt in (0.0, 10.0):
        plan = space_plan(tilt, drive=STILL_DRIVE, contact={"friction": FRICTION, "restitution": 0.3})
        # It topples where C stands over the edge of its feet
        level = plan.initial_state(clearance=0.0, pitch=0.0, phase=0.0)
        edge = math.atan2(0.5 * plan.case.design.size.depth, float(level[C_Y]))
        for side in (1.0, -1.0):
            for beyond, wanted in ((-3e-3, Outcome.OK), (3e-3, Outcome.TOPPLED)):
                state = plan.initial_state(clearance=0.0, pitch=0.0, phase=0.0, roll=side * (edge + beyond))
                outcome, _ = advance(plan, state, 1.0)
                title = f"{tilt:g} deg, let go at {side * (edge + beyond):.3f} rad"
                yield check_fact(f"{title}: {outcome.value}", outcome is wanted)
                angle = 0.0 if wanted is Outcome.OK else 0.5 * math.pi
                yield Check(
                    f"{title}: roll at the end from {angle:.2g}, rad",
                    abs(side * float(state[ROLL]) - angle),
                    1e-3 if wanted is Outcome.OK else 0.02,
                    "ringing" if wanted is Outcome.OK else "feet in the air or pressed down",
                )


CASES = [
    Case("space: a spin stops", "7", "Coulomb: torque mu m g r on a ring", SPACE, _check_spins),
    Case("space: stands without creep", "7", "statics: a body at rest stays", SPACE, _check_standing),
    Case("space: 1e5 s at rest", "7", "statics: below 1 g nothing lifts off", SPACE, _check_long_rest),
    Case("space: rights itself, or topples", "7", "statics: C over the edge of its feet", SPACE, _check_righting),
]
