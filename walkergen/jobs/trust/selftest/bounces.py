"""Hard case of a walker that bounces for 1e5 s: the orbit of a ball, in closed form."""

import math
from collections.abc import Iterator

from walkergen.jobs.trust.selftest.case import Case, Check, exactly
from walkergen.jobs.trust.selftest.scenes import advance, plan_of
from walkergen.scene import GRAVITY
from walkergen.simulation import record
from walkergen.simulation.run import Outcome
from walkergen.simulation.world import PHASE, PITCH, V_X, V_Y, X, Y

LONG, FREQUENCY = 1e5, 4.0
"""Duration (s), and frequency (Hz) of the plate: 4e5 bounces."""

RESTITUTION, GAMMA = 0.8, 1.05
"""Restitution and peak acceleration over g at which one bounce a period is stable: below 1.07."""


def _long_bouncing(model: str) -> Iterator[Check]:
    """Check 1e5 s of a level walker that sticks where it lands, and so bounces as a ball does.

    On the orbit of one bounce a period it flies up at g T / 2 and lands as fast; the plate, which gives back what the
    bounce takes, meets it at g T / 2 (1 - e) / (1 + e).
    """
    contact = {"restitution": RESTITUTION, "friction": 1.0}
    plan = plan_of(model, drive={"frequency_hz": FREQUENCY, "gamma": GAMMA}, contact=contact)
    drive, mass = plan.world.drive, float(plan.case.mass.total)
    up = math.pi * GRAVITY / drive.omega
    landing = math.acos(math.pi * (1.0 - RESTITUTION) / ((1.0 + RESTITUTION) * GAMMA))
    flown = (2.0 * math.pi - landing) / drive.omega
    state = plan.start(0.0, 0.0, 0.0)
    state[Y] += drive.amplitude * math.sin(landing) + up * flown - 0.5 * GRAVITY * flown**2
    state[V_Y] = up - GRAVITY * flown
    before, energy = state.copy(), plan.energy(state)
    outcome, tally = advance(plan, state, LONG)
    sums = tally.sums
    yield exactly(f"it ends well ({outcome.value}), after {LONG:g} s", outcome is Outcome.OK)
    yield exactly("time, s", sums[record.ELAPSED] == LONG)
    phase = abs(math.remainder(float(state[PHASE]), 2.0 * math.pi))
    yield Check("phase of the plate, s", phase / drive.omega, 1e-9, "rounding of 8e5 landings' instants")
    off = abs(float(state[Y] - before[Y])) / drive.amplitude
    yield Check("height against the closed form, amplitudes", off, 1e-9, "rounding, damped by each bounce")
    off = abs(float(state[V_Y] - before[V_Y])) / up
    yield Check("speed against the closed form, relative", off, 1e-9, "rounding, damped by each bounce")
    yield exactly("two feet land once a period", tally.counts[record.IMPACTS] == 2 * LONG * FREQUENCY)
    yield exactly("no way, no speed along the plate, no turn", not state[[X, V_X, PITCH]].any())
    impulse = float(sums[record.IMPULSES :].sum()) - mass * float(state[V_Y] - before[V_Y])
    weight = mass * GRAVITY * LONG
    yield Check(
        "momentum: impulses less weight, relative", abs(impulse / weight - 1.0), 1e-10, "rounding of a long sum"
    )
    met = up * (1.0 - RESTITUTION) / (1.0 + RESTITUTION)
    work = abs(float(sums[record.PLATE_WORK]) / (weight * met) - 1.0)
    yield Check("energy: the plate's work, relative", work, 1e-9, "rounding, damped by each bounce")
    error = record.energy_error(sums, plan.energy(state) - energy, energy)
    yield Check("energy unaccounted for", error, 1e-12, "rounding of a long sum")


CASES = [
    Case("1e5 s of bounces", "6.12", "Tufillaro et al. 1986: a ball's orbit of one bounce", ("rigid",), _long_bouncing)
]
