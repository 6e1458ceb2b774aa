"""Survival: any run, however extreme, ends as physics may and accounts for its energy."""

from collections.abc import Iterator

import numpy as np

from hard import energy_error, lift
from walkergen.jobs.trust.selftest.case import Check, exactly
from walkergen.jobs.trust.selftest.scenes import advance
from walkergen.simulation import record
from walkergen.simulation.drive import TWO_PI
from walkergen.simulation.model import Plan
from walkergen.simulation.run import Outcome
from walkergen.simulation.world import PHASE, PITCH, V_X

ENDINGS = (Outcome.OK, Outcome.TOPPLED, Outcome.FOLDED)
"""Physical ends of a run; failed convergence and energy from nowhere are not among them."""

STEPPED, EXACT = (
    (2e-2, "steps of 30 us: second order, of impacts and friction"),
    (1e-9, "rounding and the rocking integrator's 1e-11 a step"),
)
"""Largest share of the exchanged energy that may be unaccounted for, by steps and by events, and
the reason."""

DEEPEST_STEPPED, DEEPEST = 4e-3, 1e-9
"""Largest depth below the plate, mm: by steps, a foot's way in a step of 30 us at 130 mm/s, where
legs lighter by 1e-9 swing back many times within it; by events, rounding."""


def survives(plan: Plan, seconds: float, about: str, limit: tuple[float, str] | None = None) -> Iterator[Check]:
    """A tilted drop: a physical end, finite, over the plate, every energy accounted for."""
    state = plan.start(0.03, 0.0, 1.0)
    state[PITCH] += 2e-3
    state[V_X] = 5.0
    lift(plan, state, 0.03)
    before, lowest, outcome = plan.energy(state), 0.0, Outcome.OK
    total, turned = record.new(len(state)), True
    for _ in range(40):
        outcome, tally = advance(plan, state, seconds / 40)
        total.sums[:] += tally.sums
        turned = turned and 0.0 <= state[PHASE] < TWO_PI
        lowest = min(lowest, float(plan.feet(state)[:, 1].min()))
        if outcome is not Outcome.OK:
            break
    finite = bool(np.isfinite(state).all() and np.isfinite(total.sums).all())
    yield exactly(f"{about}: a physical end ({outcome.value}), finite", outcome in ENDINGS and finite)
    yield exactly(f"{about}: phase stays in one turn", turned)
    stepped = plan.resolved.model == "compliant"
    allowed, reason = limit or (STEPPED if stepped else EXACT)
    yield Check(f"{about}: energy unaccounted for", energy_error(plan, before, state, total), allowed, reason)
    yield Check(
        f"{about}: foot below the plate, mm",
        -lowest,
        DEEPEST_STEPPED if stepped else DEEPEST,
        "rounding; by steps, a dip within a step",
    )
