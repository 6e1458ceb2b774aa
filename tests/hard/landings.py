"""Hard cases of landings: both feet in one instant, feet that swing, starts in or on the plate."""

import itertools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from hard import COMPLIANT, EVERY, THREE_COORDINATES, drawn, energy_error, fall_time, lift, with_legs
from walkergen.jobs.trust.selftest.case import Case, Check, exactly
from walkergen.jobs.trust.selftest.scenes import HALF, STILL, Array, advance, plan_of, shaken
from walkergen.simulation import record
from walkergen.simulation.compliant.chain import LOOSE, chain_of
from walkergen.simulation.compliant.flight import clear_time
from walkergen.simulation.model import Plan
from walkergen.simulation.run import Outcome
from walkergen.simulation.world import (
    ANGLE_BACK,
    MODE_BACK,
    MODE_FRONT,
    OPEN,
    PITCH,
    RATE_BACK,
    RATE_FRONT,
    SPIN,
    V_X,
    V_Y,
    X,
    Y,
    mirrored,
)

INSTANT = 1e-12
"""Time, s, in which nothing happens but what happens at once."""


def _both_feet(model: str) -> Iterator[Check]:
    """Check level landings with any spin, at any tilt and friction, by Stronge's law."""
    rng = np.random.default_rng(11)
    approach = gain = image = 0.0
    finished = True
    for _ in range(80):
        tilt = float(rng.choice([0.0, 5.0, 10.0, 20.0, 35.0]))
        contact = {
            "restitution": float(rng.choice([0.0, 0.8, 1.0])),
            "friction": float(rng.choice([0.0, 0.1, 0.25, 5.0, 1e3])),
            "law": "stronge",
        }
        plan = plan_of(model, tilt, drive=STILL, contact=contact)
        state = plan.start(0.0, 0.0, 0.5 * math.pi)
        state[V_X], state[V_Y] = 30.0 * rng.normal(), -30.0 * rng.uniform()
        state[SPIN] = 3.0 * rng.normal()
        other, before = mirrored(state), plan.energy(state)
        kinetic = before - plan.energy(plan.start(0.0, 0.0, 0.5 * math.pi))
        for _ in range(3):  # the impact of one foot may bring down the other, left to the next step
            outcome, _ = advance(plan, state, INSTANT)
            finished = finished and outcome is Outcome.OK
        approach = max(approach, -float(plan.feet(state)[:, 3].min()))
        gain = max(gain, (plan.energy(state) - before) / kinetic)
        image_plan = plan_of(model, -tilt, drive=STILL, contact=contact)
        for _ in range(3):
            advance(image_plan, other, INSTANT)
        image = max(image, float(np.abs(mirrored(other) - state)[[V_X, V_Y, SPIN]].max()))
    yield exactly("every landing ends", finished)
    limit = 0.5 if model == "compliant" else 1e-2
    reason = "resting speed: the event's snap of 1e-3; g h and more on springs for steps of 30 us"
    yield Check("approach left, mm/s", approach, limit, reason)
    if model != "relaxed":  # relaxed legs may gain where H_rigid > H_flexible
        yield Check("energy gained, over the kinetic", gain, 1e-9, "rounding of the sums")
    exact = model in THREE_COORDINATES
    yield Check(
        "velocities of the mirror image, mm/s",
        image,
        0.0 if exact else 1e-9,
        "exact: only signs differ" if exact else "rounding of the hinged chain's inverse",
    )


def _a_rounding_apart(model: str) -> Iterator[Check]:
    """Check an upright walker pitched by 1e-13 rad: feet 1e-12 mm apart must land together."""
    for pitch in (1e-13, -1e-13):
        plan = plan_of(model, 0.0, drive=STILL, run={"step_us": 10.0}, contact={"restitution": 0.5, "friction": 0.25})
        state = plan.start(0.03, 0.0, 0.5 * math.pi)
        state[PITCH], state[V_Y] = pitch, 0.0
        lift(plan, state, 0.03)
        advance(plan, state, 1.2 * fall_time(0.03))
        yield exactly(f"pitch {pitch:g}: in the air again", state[V_Y] > 0.0)
        yield Check(
            f"pitch {pitch:g}: spin after, rad/s",
            abs(state[SPIN]),
            1e-6,
            "rounding, grown by an impact; one foot at a time would make some 1 rad/s",
        )


def _within_a_step(model: str) -> Iterator[Check]:
    """Check two feet that land 0.3 and 0.7 of a step apart, either first: against steps 256 times finer."""
    coarse, speed = 16e-6, 50.0
    for e, part in itertools.product((0.0, 0.5), (0.3, -0.3, 0.7, -0.7)):
        ends = []
        for step in (coarse, coarse / 16.0, coarse / 256.0):
            contact = {"restitution": e, "friction": 0.25}
            plan = plan_of(model, 10.0, drive=STILL, run={"step_us": 1e6 * step}, contact=contact)
            state = plan.start(0.0, 0.0, 0.0)
            state[PITCH] += part * coarse * speed / (2.0 * HALF)
            state[V_Y] = -speed
            lift(plan, state, 0.01 + 0.4 * coarse * speed)
            _, tally = advance(plan, state, 5e-4)
            ends.append(state)
        errors = [float(np.abs(end - ends[-1])[[X, Y, PITCH]].max()) for end in ends[:-1]]
        title = f"e = {e:g}, {part:g} of a step apart"
        yield exactly(f"{title}: both feet struck", tally.counts[record.IMPACTS] >= 2)
        if e:
            reason = "landings are located and flights exact: what a gap of 1e-9 mm may be"
            yield Check(f"{title}: end after 0.5 ms by 16 us, mm", errors[0], 1e-8, reason)
        else:
            falls = math.log2(errors[0] / errors[1]) / 4.0
            yield Check(f"{title}: order of the steps below 2", 2.0 - falls, 0.4, "landings lie anywhere in a step")


def _swinging(model: str) -> Iterator[Check]:
    """Check that a flight stays clear of the plate for as long as a long step assumes.

    Hardest: upright legs on their fastest swing, which turn the body, while the plate rises at its
    largest acceleration.
    """
    rng, raised = np.random.default_rng(1), 100.0
    deepest, used = 0.0, 0
    for _ in range(250):
        tilt = float(rng.choice([0.0, 0.0, 2.0, 5.0, 20.0]))
        plan = plan_of(model, tilt, drive=shaken(1.8))
        flow = plan_of(model, tilt, drive=shaken(1.8), run={"step_us": 0.1})
        state = plan.start(0.0, 0.0, rng.uniform(3.8, 4.7))
        state[SPIN] = 0.3 * rng.normal()
        # up to 6 degrees, and the spin that keeps the whole from turning
        swing = plan.world.walker.swing
        size = 10 ** rng.uniform(-2.5, -1.0)
        state[ANGLE_BACK:] = size * rng.normal(size=4) * (0.1, 0.1, 1e4, 1e4)
        state[SPIN] -= swing.share_back * state[RATE_BACK]
        state[SPIN] -= swing.share_front * state[RATE_FRONT]
        lift(plan, state, 10 ** rng.uniform(-3.0, -0.5))
        state[V_Y] += 2.0 * rng.normal() - float(plan.feet(state)[:, 3].mean())
        clear = _clear_time(plan, state)
        used += clear > 0.0
        state[Y] += raised
        for _ in range(16):
            advance(flow, state, min(clear, 1.5e-3) / 16.0)
            deepest = max(deepest, raised - float(flow.feet(state)[:, 1].min()))
    yield exactly("many of 250 flights have such a time", used > 60)
    yield Check("foot below the plate within it, mm", deepest, 1e-9, "error of flights of 5 us")


def _clear_time(plan: Plan, state: Array) -> float:
    chain: Any = chain_of(plan.world.walker, state, LOOSE)
    gaps = tuple(float(height) for height in plan.feet(state)[:, 1])
    return float(clear_time(plan.world, state, chain, gaps))


def _starts(model: str) -> Iterator[Check]:
    plan = plan_of(model, drive=STILL, contact={"restitution": 0.8, "friction": 0.25})
    if model == "compliant":
        plan = with_legs(plan, 1.0, 1.0)
    ends = []
    deeper = (-1e-9, -1e-7) if model in THREE_COORDINATES else ()
    for gap in (0.0, -1e-12, -1e-15, *deeper):
        state = plan.start(gap, 0.0, 0.5 * math.pi)
        state[V_Y] = 0.0
        outcome, _ = advance(plan, state, 0.1)
        ends.append(state)
        yield exactly(
            f"gap {gap:g} mm: rests on both feet",
            outcome is Outcome.OK and OPEN not in (state[MODE_BACK], state[MODE_FRONT]),
        )
        lowest = float(np.abs(plan.feet(state)[:, 1]).max())
        yield Check(f"gap {gap:g} mm: feet off the plate, mm", lowest, 1e-11, "rounding of heights")
    apart = max(float(np.abs(ends[0] - end)[[X, Y, PITCH]].max()) for end in ends[1:])
    yield Check(
        "end of the run against a start in touch, mm",
        apart,
        1e-4 if model == "compliant" else 1e-9,
        "1e-12 mm of fall; legs that are let go may bounce otherwise",
    )
    if model in THREE_COORDINATES:
        outcome, _ = advance(plan, plan.start(-0.1, 0.0, 0.0), 0.1)
        yield exactly("0.1 mm inside: refused", outcome is Outcome.INSIDE)


def _far_apart(model: str) -> Iterator[Check]:
    """Check feet so far apart that a blow at one throws the other into the plate.

    Each blow of one foot fed the other by the speed below which that one stays: a million impacts.
    """
    contact = {"restitution": 0.9, "friction": 0.06}
    legs = {"tilt_deg": 10.0, "contact_spacing_mm": 18.0}
    plan = drawn(model, {"legs": legs}, drive=shaken(0.5), contact=contact)
    most, lost, stand = 0, 0.0, True
    for phase in (0.3, 1.0, 2.0, 3.0, 4.0):
        state = plan.start(0.05, 1e-3, phase)
        before = plan.energy(state)
        outcome, tally = advance(plan, state, 0.1)
        stand = stand and outcome is Outcome.OK and OPEN not in state[MODE_BACK:][:2]
        most = max(most, int(tally.counts[0]))
        lost = max(lost, energy_error(plan, before, state, tally))
    yield exactly("stands on both feet after 0.1 s", stand)
    yield Check("impacts", most, 3000.0, "series of 100 (e = 0.9); a million where fed")
    yield Check("energy unaccounted for", lost, 1e-9, "rounding")


CASES = [
    Case("start in touch and 1e-12 mm inside", "6.9", "continuity in the start", EVERY, _starts),
    Case("feet a rounding apart land as one", "6.8", "continuity in the pitch", EVERY, _a_rounding_apart),
    Case(
        "feet far apart come to rest",
        "6.10",
        "geometric series of alternating blows (docs/physics.md 5)",
        THREE_COORDINATES,
        _far_apart,
    ),
    Case("landing on both feet", "6.10", "Stronge 1990: no gain; mirror symmetry", EVERY, _both_feet),
    Case("two feet land within a step", "6.8", "the same landings by steps 256 times finer", COMPLIANT, _within_a_step),
    Case("long flights pass over no touch", "6.8", "the same flight by small steps", COMPLIANT, _swinging),
]
