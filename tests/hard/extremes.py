"""Hard cases at the ends of the ranges: friction, drive, masses, stiffness, angles, starts."""

import itertools
import math
from collections.abc import Iterator

import numpy as np

from hard import COMPLIANT, EVERY, RIGID, lift, survives, with_legs
from walkergen.errors import InputError
from walkergen.jobs.trust.selftest.case import Case, Check, exactly
from walkergen.jobs.trust.selftest.scenes import STILL, Array, advance, plan_of, shaken
from walkergen.scene import GRAVITY
from walkergen.simulation import record
from walkergen.simulation.drive import velocity
from walkergen.simulation.run import Outcome
from walkergen.simulation.world import ANGLE_BACK, PHASE, PITCH, RATE_BACK, SPIN, V_Y, X, Y
from walkergen.walker.design import Design


def _below_one_g(model: str) -> Iterator[Check]:
    plan = plan_of(model, 10.0, drive=shaken(0.999), contact={"restitution": 0.8, "friction": 0.25})
    if model == "compliant":  # critically damped, or legs that are let go bounce for long
        plan = with_legs(plan, 1.0, 1.0)
    seconds = 0.1 if model == "compliant" else 1e4
    state = plan.start(0.0, 0.0, 0.5 * math.pi)
    shaker = plan.world.drive
    state[V_Y] = velocity(shaker, state[PHASE])
    advance(plan, state, 0.3)
    place = state[X]
    outcome, tally = advance(plan, state, seconds)
    yield exactly("no impact", outcome is Outcome.OK and tally.counts[record.IMPACTS] == 0)
    yield Check(
        "time out of contact, s",
        abs(seconds - tally.sums[record.CONTACT_TIME]),
        1e-12 * seconds + 1e-12,
        "rounding of the time",
    )
    off = float(np.abs(plan.feet(state)[:, 1]).max())
    yield Check("feet off the plate, mm", off, 1e-13, "rounding: drift is taken back each step")
    if model != "compliant":  # on springs, legs lose hold once a period and creep
        yield Check("way, mm", abs(state[X] - place), 1e-12, "held by friction; rounding")


def _drives(model: str) -> Iterator[Check]:
    for gamma in (1.0 - 1e-12, 1.0, 1.0 + 1e-12, 50.0):
        for mu in (0.0, 0.25, 1e3):
            plan = plan_of(model, drive=shaken(gamma), contact={"friction": mu})
            yield from survives(plan, 0.1, f"{gamma:.13g} g, mu = {mu:g}")


def _steep(model: str) -> Iterator[Check]:
    steepest = 60.05 if model == "rigid" else 68.16
    for tilt in (1e-9, 0.1, steepest, -steepest):
        plan = plan_of(model, tilt, drive=shaken(1.8))
        yield from survives(plan, 0.1, f"tilt {tilt:g} deg")


def _laws(model: str) -> Iterator[Check]:
    for law in ("poisson", "newton", "stronge"):
        for e in (0.0, 1.0):
            contact = {"restitution": e, "friction": 0.25, "law": law}
            plan = plan_of(model, drive=shaken(1.8), contact=contact)
            yield from survives(plan, 0.1, f"{law}, e = {e:g}")


def _never_gains(model: str) -> Iterator[Check]:
    worst = math.inf
    for e in (0.0, 0.8, 1.0):
        contact = {"restitution": e, "friction": 0.25, "law": "stronge"}
        plan = plan_of(model, drive=shaken(1.8), contact=contact)
        state = plan.start(0.03, 0.0, 1.0)
        state[PITCH] += 2e-3
        lift(plan, state, 0.03)
        _, tally = advance(plan, state, 0.1)
        worst = min(worst, tally.sums[record.IMPACT_LOSS] / tally.sums[record.PLATE_WORK])
    yield Check(
        "energy gained in impacts, over the plate's work",
        max(0.0, -worst),
        1e-9,
        "rounding of the sum over a hundred impacts",
    )


def _any_mass(model: str) -> Iterator[Check]:
    for ratio in (1e-9, 1e-3, 1.0, 1e3):
        plan = plan_of(model, leg_mass=0.833 * ratio, drive=shaken(1.8))
        stepped = (5e-2, "steps of 30 us against legs of any frequency")
        limit = stepped if model == "compliant" else None
        yield from survives(plan, 0.05, f"m/M = {ratio:g}", limit)


def _topples(model: str) -> Iterator[Check]:
    falls = (("over a foot", 0.5, 0.5, 20.0), ("in flight", 4.0, 0.0, 50.0))
    for (way, gap, pitch, spin), side in itertools.product(falls, (1.0, -1.0)):
        plan = plan_of(model, drive=STILL, contact={"restitution": 0.0, "friction": 1.0})
        state = plan.start(gap, 0.0, 0.5 * math.pi)
        state[PITCH], state[SPIN] = side * pitch, side * spin
        lift(plan, state, gap)
        outcome, tally = advance(plan, state, 2.0)
        yield exactly(f"{way}: reported as toppled", outcome is Outcome.TOPPLED)
        yield exactly(f"{way}: before the end", 0.0 < tally.sums[record.ELAPSED] < 1.0)
        limit = 0.8 if model == "compliant" else 1e-9
        yield Check(
            f"{way}: height of the corner then, mm",
            abs(_corner(state)),
            limit,
            "located; on springs, seen after the step: 500 mm/s x 1.5 ms",
        )
        yield Check(
            f"{way}: 44.6 deg less the pitch then",
            44.6 - math.degrees(abs(state[PITCH])),
            2.0 if model == "compliant" else 0.1,
            "docs/physics.md gives three digits; bent legs let it down earlier",
        )


def _corner(state: Array) -> float:
    """Height of the lowest corner of the paper's body over a plate at rest, mm."""
    cos, sin = math.cos(state[PITCH]), math.sin(state[PITCH])
    return float(state[Y]) - 14.0 * abs(sin) - 1.5 * cos


def _stiff(model: str) -> Iterator[Check]:
    """Check k_t -> infinity: the legs of a resting walker bend in proportion to 1 / k_t."""
    sunk = []
    for factor in (1e2, 1e4):
        plan = plan_of(model, 20.0, drive=STILL, contact={"restitution": 0.0, "friction": 0.0})
        plan = with_legs(plan, factor, 1.0)
        state = plan.start(0.0, 0.0, 0.5 * math.pi)
        height = float(state[Y])
        advance(plan, state, 0.03)
        sunk.append(height - float(state[Y]))
    walker = plan.world.walker
    load = 0.5 * walker.mass * GRAVITY
    bent = load * walker.reaches[0][0] ** 2 * 1e2 / walker.legs[0].stiffness
    yield Check(
        "depth against load x lever^2 / k_t, relative",
        abs(sunk[0] / bent - 1),
        0.2,
        "both feet alike up to the legs' weight and the shift of the load",
    )
    yield Check(
        "a hundredfold stiffness, a hundredth: relative",
        abs(sunk[0] / sunk[1] / 100 - 1),
        1e-2,
        "finite angles of the softer legs",
    )


def _rigid_hinges(model: str) -> Iterator[Check]:
    """Check hinges up to 1e12 times as stiff, with any damper: steps far longer than their swing."""
    for factor, ratio in itertools.product((1e3, 1e6, 1e12), (0.0, 1.0, 50.0)):
        plan = with_legs(plan_of(model, drive=shaken(1.8)), factor, ratio)
        yield from survives(plan, 0.1, f"stiffness x {factor:g}, damping ratio {ratio:g}")


def _soft(model: str) -> Iterator[Check]:
    plan = plan_of(model, 35.0, drive=STILL, contact={"restitution": 0.0, "friction": 0.25})
    plan = with_legs(plan, 1e-5, 1.0)
    outcome, tally = advance(plan, plan.start(0.0, 0.0, 0.5 * math.pi), 0.5)
    yield exactly(
        "reported as folded or toppled, before the end",
        outcome in (Outcome.FOLDED, Outcome.TOPPLED) and tally.sums[record.ELAPSED] < 0.5,
    )


def _damping(model: str) -> Iterator[Check]:
    """Check flight: undamped legs keep energy; legs damped critically do not swing back."""
    for ratio in (0.0, 1.0, 3.0, 50.0):
        plan = with_legs(plan_of(model, drive=STILL), 1.0, ratio)
        state = plan.start(50.0, 0.0, 0.5 * math.pi)
        state[ANGLE_BACK] = 0.05
        before = plan.energy(state)
        lowest = math.inf
        total = record.new(len(state))
        for _ in range(20):
            _, tally = advance(plan, state, 1e-4)
            total.sums[:] += tally.sums
            lowest = min(lowest, float(state[ANGLE_BACK]))
        swing = 0.5 * plan.world.walker.legs[0].stiffness * 0.05**2
        off = abs(plan.energy(state) - before + total.sums[record.DAMPING_LOSS]) / swing
        yield Check(f"ratio {ratio:g}: energy unaccounted for, over the swing's", off, 1e-2, "a kick of second order")
        if ratio >= 1.0:
            yield exactly(
                f"ratio {ratio:g}: no swing back beyond the body's own",
                lowest > -1e-3 * 0.05 and abs(state[RATE_BACK]) < 1e3,
            )


def _laid_flat(model: str) -> Iterator[Check]:
    """Check tilts towards 90 deg: refused with the limit, up to which walkers can be built."""
    for tilt in (90.0, 89.999, -90.0, math.nan, 80.0, -70.0):
        try:
            Design.model_validate({"legs": {"tilt_deg": tilt}})
            told = ""
        except (InputError, ValueError) as refusal:
            told = str(refusal)
        limit = "finite" if math.isnan(tilt) else "85" if abs(tilt) > 85.0 else "is possible"
        yield exactly(f"tilt {tilt:g} deg: refused with the limit", limit in told)
    for tilt in (68.16, -68.16):
        design = Design.model_validate({"legs": {"tilt_deg": tilt}})
        yield exactly(f"tilt {tilt:g} deg, the limit told: accepted", design.tilt_deg == tilt)


CASES = [
    Case("legs hardly tilted, and the steepest", "6.1", "first law: energy book", EVERY, _steep),
    Case("legs laid flat", "6.1", "geometry of the design, by hand", ("geometry",), _laid_flat),
    Case("every law at e = 0 and 1", "6.4", "first law: energy book", EVERY, _laws),
    Case(
        "stronge: impacts never gain energy",
        "6.4",
        "Stronge, Proc. R. Soc. A 431, 169 (1990)",
        (*RIGID, *COMPLIANT),
        _never_gains,
    ),
    Case("legs of any mass", "6.5", "first law: energy book", ("relaxed", *COMPLIANT), _any_mass),
    Case("below one g: never leaves", "6.6", "statics: below 1 g nothing lifts off", EVERY, _below_one_g),
    Case("just at one g, and fifty", "6.6", "first law: energy book", EVERY, _drives),
    Case("falling over", "6.11", "geometry: angle at which a corner touches", EVERY, _topples),
    Case("stiff legs: towards the braced walker", "6.14", "statics: load x lever^2 / k_t", COMPLIANT, _stiff),
    Case("hinges 1e12 times as stiff", "6.14", "first law: energy book", COMPLIANT, _rigid_hinges),
    Case("soft legs fold", "6.14", "statics: load beyond a spring", COMPLIANT, _soft),
    Case("damping 0, critical and beyond", "6.14", "damped oscillator", COMPLIANT, _damping),
]
