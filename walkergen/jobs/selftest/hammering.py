"""Hard cases of feet that hammer the plate: impacts that follow each other without end in sight."""

import math
from collections.abc import Iterator

import numpy as np

from walkergen.jobs.selftest.case import COMPLIANT, THREE_COORDINATES, Case, Check, exactly
from walkergen.jobs.selftest.scenes import Array, advance, drawn, energy_error, shaken
from walkergen.simulation import record
from walkergen.simulation.run import Outcome
from walkergen.simulation.world import MODE_BACK, MODE_FRONT, OPEN, V_X, V_Y

EVENT = (*THREE_COORDINATES, COMPLIANT[0])


def _stands(state: Array) -> bool:
    return OPEN not in (state[MODE_BACK], state[MODE_FRONT])


def _far_apart(model: str, method: str) -> Iterator[Check]:
    """Check feet so far apart that a blow at one throws the other into the plate.

    Each blow of one foot fed the other by the speed below which that one stays: a million impacts.
    """
    contact = {"restitution": 0.9, "friction": 0.06}
    legs = {"tilt_deg": 10.0, "contact_spacing_mm": 18.0}
    plan = drawn(model, method, {"legs": legs}, drive=shaken(0.5), contact=contact)
    most, lost, stand = 0, 0.0, True
    for phase in (0.3, 1.0, 2.0, 3.0, 4.0):
        state = plan.start(0.05, 1e-3, phase)
        before = plan.energy(state)
        outcome, tally = advance(plan, state, 0.1)
        stand = stand and outcome is Outcome.OK and _stands(state)
        most = max(most, int(tally.counts[0]))
        lost = max(lost, energy_error(plan, before, state, tally))
    yield exactly("stands on both feet after 0.1 s", stand)
    yield Check("impacts", most, 3000.0, "series of 100 (e = 0.9); a million where fed")
    yield Check("energy unaccounted for", lost, 1e-9, "rounding; the flow's error on springs")


def _elastic(model: str, method: str) -> Iterator[Check]:
    """Check bent legs at restitution 1: their springs press the feet down, and they hammer."""
    contact = {"restitution": 1.0, "friction": 0.6, "law": "stronge"}
    legs = {"tilt_deg": 40.0, "flexible_thickness_mm": 0.21, "length_mm": 4.5}
    plan = drawn(model, method, {"legs": legs}, drive=shaken(0.6), contact=contact)
    state = plan.start(0.06, 1e-3, 0.0)
    before = plan.energy(state)
    outcome, tally = advance(plan, state, 0.0045)
    yield exactly("runs on", outcome is Outcome.OK)
    yield Check(
        "impacts",
        float(tally.counts[0]),
        3000.0,
        "1 000; 40 000 where rebounds within 1e-7 s count",
    )
    yield Check(
        "energy unaccounted for", energy_error(plan, before, state, tally), 1e-9, "the flow's error"
    )
    yield exactly("losses are losses", tally.sums[record.IMPACT_LOSS] >= 0.0)


def _upright(model: str, method: str) -> Iterator[Check]:
    """Check nearly upright legs held by friction, dropped at an angle without any rebound."""
    contact = {"restitution": 0.0, "friction": 1.5}
    legs = {"tilt_deg": -0.32, "flexible_thickness_mm": 0.54, "length_mm": 5.94}
    shape = {"legs": {**legs, "contact_spacing_mm": 13.5}, "body": {"thickness_mm": 5.0}}
    damped = {"damping_ratio": 0.5}
    plan = drawn(model, method, shape, drive=shaken(0.6), contact=contact, legs=damped)
    rng, finished, lost = np.random.default_rng(2), True, 0.0
    for _ in range(20):
        state = plan.start(0.06, 1e-3 * rng.normal(), rng.uniform(0.0, 2.0 * math.pi))
        state[V_X], state[V_Y] = -9.6, -8.6
        before = plan.energy(state)
        outcome, tally = advance(plan, state, 0.03)
        finished = finished and outcome is Outcome.OK
        lost = max(lost, energy_error(plan, before, state, tally))
    yield exactly("20 drops run to their end", finished)
    yield Check("energy unaccounted for", lost, 1e-9, "the flow's error")


CASES = [
    Case("feet far apart come to rest", "6.10", EVENT, _far_apart),
    Case("elastic feet on bent legs", "6.7", COMPLIANT[:1], _elastic),
    Case("nearly upright legs held by friction", "6.1", COMPLIANT[:1], _upright),
]
"""Hard cases of feet that hammer."""
