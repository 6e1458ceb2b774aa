"""Hard cases of friction: none at all, far too much, jamming, and sliding to a stop."""

import itertools
import math
from collections.abc import Iterator

import numpy as np

from hard import EVERY, lift, survives, with_legs
from walkergen.jobs.trust.selftest.case import Case, Check, exactly
from walkergen.jobs.trust.selftest.scenes import ENDS_OF_PHYSICS, STILL, advance, plan_of, shaken
from walkergen.scene import GRAVITY
from walkergen.simulation import record
from walkergen.simulation.run import Outcome
from walkergen.simulation.world import MODE_BACK, MODE_FRONT, PITCH, STICK, V_X, V_Y, X


def _friction(model: str) -> Iterator[Check]:
    for mu in (2.0, 10.0, 1e3):
        for e in (0.0, 0.8):
            plan = plan_of(model, drive=shaken(1.8), contact={"restitution": e, "friction": mu})
            yield from survives(plan, 0.2, f"mu = {mu:g}, e = {e:g}")


def _no_friction(model: str) -> Iterator[Check]:
    """Check that nothing pushes along a smooth plate: for 100 s where each of 3e6 steps could add to it."""
    for tilt, e in ((20.0, 0.0), (20.0, 0.8), (10.0, 0.3)):
        plan = plan_of(model, tilt, drive=shaken(1.8), contact={"restitution": e, "friction": 0.0})
        state = plan.start(0.03, 0.0, 1.0)
        state[PITCH] += 0.01
        lift(plan, state, 0.03)
        before = plan.model.momentum(plan.world, state)
        outcome, tally = advance(plan, state, 100.0 if model == "compliant" else 1.0)
        limit, reason = 0.0, "exact: nothing pushes along the plate"
        if model == "compliant":
            rate = 1e-16 * 100.0 * plan.world.walker.mass / plan.world.options.step
            limit, reason = rate * tally.sums[record.ELAPSED], "rounding of the legs' 100 mm/s, in every step"
        title = f"tilt {tilt:g} deg, e = {e:g}"
        yield exactly(f"{title}: runs on ({outcome.value})", outcome in ENDS_OF_PHYSICS)
        yield Check(
            f"{title}: horizontal momentum gained in {tally.sums[record.ELAPSED]:.3g} s, g mm/s",
            abs(plan.model.momentum(plan.world, state) - before),
            limit,
            reason,
        )


def _jams(model: str) -> Iterator[Check]:
    """Check a foot whose sliding presses it ever harder down (H_yy < mu |H_xy|)."""
    tilt = 20.0 if model == "compliant" else 0.0
    plan = plan_of(model, tilt, drive=STILL, contact={"restitution": 0.0, "friction": 5.0})
    held = {}
    for way, fall in itertools.product((10.0, -10.0), (0.0, -1e-3)):
        state = plan.start(0.0, 0.0, 0.5 * math.pi)
        state[PITCH] = 1e-3
        lift(plan, state, 0.0)
        state[V_X], state[V_Y] = way, fall
        outcome, _ = advance(plan, state, 1e-6)
        speed = abs(float(plan.feet(state)[0, 2]))
        # a step resolves velocities at its middle, where the foot has turned a little
        held[way, fall] = outcome is Outcome.OK and speed < 1e-4
        yield exactly(
            f"sliding {'forward' if way > 0 else 'backward'}, {fall:g} mm/s: no failure",
            outcome is Outcome.OK and bool(np.isfinite(state).all()),
        )
    forward, backward = ({held[way, fall] for fall in (0.0, -1e-3)} for way in (10.0, -10.0))
    yield exactly(
        "the jammed way stops at once, the other slides on", len(forward) == len(backward) == 1 and forward != backward
    )


def _stops(model: str) -> Iterator[Check]:
    """Check sliding on a plate at rest: over v^2 / (2 mu g), then at rest for good."""
    mu, speed = 0.25, 60.0
    plan = plan_of(model, 10.0, drive=STILL, run={"step_us": 30.0}, contact={"restitution": 0.0, "friction": mu})
    if model == "compliant":
        plan = with_legs(plan, 1e4, 1.0)
    far = speed**2 / (2.0 * mu * GRAVITY)
    for way in (1.0, -1.0):
        state = plan.start(0.0, 0.0, 0.5 * math.pi)
        start = float(state[X])
        state[V_X] = way * speed
        outcome, _ = advance(plan, state, 0.06)
        gone = way * (float(state[X]) - start)
        limit, reason = 2e-6, "it falls by the tolerance of a gap before it stands: 1e-8 s"
        if model == "compliant":
            limit, reason = 2e-2, "legs of finite stiffness give, and bounce when let go"
        yield Check(f"{'forward' if way > 0 else 'backward'}: way, relative", abs(gone / far - 1), limit, reason)
        yield exactly(
            "stands on both feet, at rest",
            outcome is Outcome.OK and abs(state[V_X]) < 1e-6 and state[MODE_BACK] == STICK == state[MODE_FRONT],
        )


CASES = [
    Case("no friction: momentum along the plate", "6.2", "Newton: momentum along a smooth plate", EVERY, _no_friction),
    Case("friction 2, 10 and 1000", "6.2", "Painleve 1895; first law: energy book", EVERY, _friction),
    Case("jamming: a sliding foot stops at once", "6.2", "Painleve 1895: jamming H_yy < mu |H_xy|", EVERY, _jams),
    Case("sliding to a stop", "6.2", "Coulomb: way v^2 / (2 mu g)", EVERY, _stops),
]
