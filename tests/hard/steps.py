"""Hard cases of time steps: rebounds shorter than a step, and feet that must not sink."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from hard import COMPLIANT, drawn
from walkergen.jobs.trust.selftest.case import Case, Check, exactly
from walkergen.jobs.trust.selftest.scenes import STILL, Array, advance, shaken
from walkergen.simulation.model import Plan
from walkergen.simulation.run import ENDED_WELL, Outcome, simulate

Sinking = tuple[float, float, float, float, dict[str, float], float, float, float]

SWIFT = (
    ({"tilt_deg": 20.0, "flexible_thickness_mm": 0.8}, 0.8),
    ({"tilt_deg": 25.0, "flexible_thickness_mm": 0.4}, 0.9),
)
"""Legs, and restitutions, of walkers that lost half their speed and its sign while rebounds of less
than two steps were absorbed: 9.5 in place of 20.3 mm/s, and 0.4 in place of -6.4."""

SINKING: tuple[Sinking, ...] = (
    (25.0, 1.0, 7.5, 13.0, {}, 0.8, 0.25, 10.0),
    (-26.0, 0.99, 5.49, 14.9, {"length_mm": 24.1, "thickness_mm": 5.4}, 1.0, 0.25, 2.0),
    (31.3, 0.266, 4.14, 36.0, {"length_mm": 59.7, "thickness_mm": 5.17}, 0.272, 0.1, 0.626),
    (35.7, 0.226, 3.61, 23.2, {"length_mm": 47.1, "thickness_mm": 5.11}, 0.595, 0.6, 0.377),
)
"""Tilt (deg), thickness, length and spacing (mm) of legs, body, restitution, friction and damping
ratio of walkers whose rebounds end within a step, by their dampers."""

DROPS = 8
"""Drops of each of them, each with a pitch and a velocity of its own."""


def _plan(shape: dict[str, float], body: dict[str, float], seconds: float, **tables: Any) -> Plan:
    run: dict[str, float] = {"seconds": seconds, "discard_seconds": 0.5}
    run |= tables.pop("run", {})
    return drawn("compliant", {"legs": shape, "body": body}, run=run, **tables)


def _short_rebounds(model: str) -> Iterator[Check]:
    """Check the mean speed by the walker's own step against a tenth of it, over 8 runs each."""
    for shape, e in SWIFT:
        found = []
        for part, seconds in ((1.0, 6.0), (0.1, 3.0)):
            contact = {"restitution": e, "friction": 0.1}
            plan = _plan(shape, {}, seconds, drive=shaken(1.8), contact=contact)
            step = 1e6 * part * plan.world.options.step
            plan = _plan(shape, {}, seconds, drive=shaken(1.8), contact=contact, run={"step_us": step})
            runs = [simulate(plan, number) for number in range(8)]
            yield exactly(
                f"{shape['tilt_deg']:g} deg, {step:.3g} us: all runs end well",
                all(run.outcome in ENDED_WELL for run in runs),
            )
            found.append(np.array([run.speed for run in runs]))
        own, fine = found
        error = float(np.sqrt(np.var(own, ddof=1) / 8 + np.var(fine, ddof=1) / 8))
        yield Check(
            f"{shape['tilt_deg']:g} deg: own step against its tenth, mm/s",
            abs(float(own.mean() - fine.mean())),
            5.0 * error,
            "five standard errors of 8 runs each, which chance exceeds once in 5000 (Student's t)",
        )


def _dropped(plan: Plan, rng: np.random.Generator) -> Array:
    """State of a walker let go up to 0.2 mm above the plate."""
    state = plan.start(rng.uniform(0.0, 0.2), rng.uniform(-0.02, 0.02), 0.0)
    state[3:5] += rng.uniform(-30.0, 30.0, 2)
    return state


def _sinking(model: str) -> Iterator[Check]:
    """Check that no foot sinks on a plate at rest, by steps too long for the legs' dampers."""
    for tilt, thickness, length, spacing, body, e, mu, ratio in SINKING:
        shape = {
            "tilt_deg": tilt,
            "flexible_thickness_mm": thickness,
            "length_mm": length,
            "contact_spacing_mm": spacing,
        }
        plan = _plan(
            shape,
            body,
            1.0,
            drive=STILL,
            contact={"restitution": e, "friction": mu},
            legs={"damping_ratio": ratio},
            run={"step_us": 30.0},
        )
        rng, lowest, ends = np.random.default_rng(1), 0.0, []
        for _ in range(DROPS):
            state = _dropped(plan, rng)
            for _ in range(20):
                outcome, _tally = advance(plan, state, 0.01)
                lowest = min(lowest, float(plan.feet(state)[:, 1].min()))
            ends.append(outcome)
        told = f"{tilt:g} deg, damping ratio {ratio:g}"
        yield exactly(f"{told}: no failure", set(ends) <= {Outcome.OK, Outcome.TOPPLED})
        yield Check(f"{told}: deepest foot, mm", -lowest, 1e-8, "a landing is lifted to first order")


CASES = [
    Case("rebounds shorter than a step", "6.15", "the same runs by a tenth of the step", COMPLIANT, _short_rebounds),
    Case("feet do not sink", "6.15", "Signorini: no foot below the plate", COMPLIANT, _sinking),
]
