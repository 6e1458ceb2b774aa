"""Claims on bouncing balls: published results, by our event-driven kernel on a body that is a ball.

The ball's linear stability is derived here anew. With takeoff velocity U at time t, plate velocity
V and acceleration a at the impact, an orbit of one impact a period T has U = g T / 2, so that
Gamma cos(phase) = pi (1 - e)/(1 + e), and the map (t, U) has determinant e^2 and trace
1 + e^2 + (1 + e)^2 a / g. The orbit is born where a = 0 and doubles its period where
Gamma sin(phase) = 2 (1 + e^2)/(1 + e)^2.
"""

import math
from collections.abc import Callable, Iterator

import numpy as np

from evidence.validate import bodies
from evidence.validate.bodies import HALF, Array, advance
from evidence.validate.claim import Claim, Effort, Outside
from walkergen.scene import AT_REST, GRAVITY
from walkergen.simulation import record
from walkergen.simulation.model import Plan
from walkergen.simulation.world import PHASE, PITCH, SPIN, V_X, V_Y, Y

TUFILLARO = (
    "N. B. Tufillaro, T. M. Mello, Y. M. Choi, A. M. Albano, Period doubling boundaries of a "
    "bouncing ball, J. Physique 47, 1477 (1986); derived anew"
)
MEHTA = (
    "A. Mehta, J. M. Luck, Novel temporal behavior of a nonlinear dynamical system: the completely "
    "inelastic bouncing ball, Phys. Rev. Lett. 65, 393 (1990); derived anew"
)
BERNSTEIN = "A. D. Bernstein, Listening to the coefficient of restitution, Am. J. Phys. 45, 41 (1977)"
HOUSNER = (
    "G. W. Housner, The behavior of inverted pendulum structures during earthquakes, Bull. "
    "Seismol. Soc. Am. 53, 403 (1963)"
)
ELGAWADY = (
    "M. A. ElGawady, Q. Ma, J. M. Butterworth, J. M. Ingham, Effects of interface material on the "
    "dynamic behaviour of rigid blocks, doi 10.1201/9781003060888-45, abstract: about 0.97 (3 times as high as wide) "
    "and 0.95 (5 times) of the predicted value on concrete, 0.67 (5 times) on rubber"
)
REAL_BASE = (
    "A rigid block on two corners, plastic, loses only what changing corners costs; a real "
    "base takes more, rubber most. Others found more kept than by Housner's formula "
    "(Kalliontzis, Sritharan, Schultz, J. Struct. Eng. 142, 06016002, 2016)."
)

PERIOD = 1.0 / bodies.FREQUENCY_HZ
OMEGA = 2.0 * math.pi * bodies.FREQUENCY_HZ


def bisect(holds: Callable[[float], bool], low: float, high: float, width: float) -> float:
    """Value between `low`, where a condition fails, and `high`, where it holds, at its border."""
    while high - low > width:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return 0.5 * (low + high)


def lift_off(effort: Effort) -> Iterator[Claim]:
    """Claim that a body leaves the plate where the plate falls away faster than it."""

    def leaves(gamma: float) -> bool:
        plan = bodies.plan(gamma, 0.0)
        state = plan.start(0.0, 0.0, 0.0)
        state[V_Y] = gamma * GRAVITY / OMEGA
        advance(plan, state, PERIOD)
        tally = advance(plan, state, PERIOD)
        return bool(tally.sums[record.CONTACT_TIME] < PERIOD * (1.0 - 1e-9))

    reason = "a hop just above 1 g is too short for the kernel's tolerance of a gap"
    outside = Outside("Newton's second law: plate acceleration -g", 1e-4, reason)
    yield outside.claim("acceleration at which a ball leaves the plate", "g", bisect(leaves, 0.9, 1.1, 1e-6), 1.0)


def _orbit(plan: Plan, gamma: float, restitution: float) -> Array:
    """State on the orbit of one impact a period, at the top of its flight."""
    phase = math.acos(min(math.pi * (1 - restitution) / (1 + restitution) / gamma, 1.0))
    amplitude = plan.world.drive.amplitude
    state = plan.start(0.0, 0.0, math.fmod(phase + math.pi, 2.0 * math.pi))
    # Level feet at the height of the impact, and the rise of half a period's free flight
    state[Y] = bodies.TALL + amplitude * math.sin(phase) + GRAVITY * PERIOD**2 / 8.0
    state[V_Y] = 0.0
    return state


def _map(plan: Plan, start: Array, height: float, velocity: float, periods: int = 1) -> Array:
    """Height and velocity (mm, mm/s) off the start, periods after being put off by these."""
    state = start.copy()
    state[Y] += height
    state[V_Y] += velocity
    advance(plan, state, periods * PERIOD)
    return np.array([state[Y] - start[Y], state[V_Y] - start[V_Y]])


def multipliers(gamma: float, restitution: float) -> tuple[float, float]:
    """Trace and determinant of a period's map about the orbit, by central differences."""
    plan = bodies.plan(gamma, restitution)
    start, columns = _orbit(plan, gamma, restitution), []
    for off in ((1e-6, 0.0), (0.0, 1e-6 * OMEGA)):
        change = _map(plan, start, *off) - _map(plan, start, -off[0], -off[1])
        columns.append(change / (2.0 * max(off)))
    jacobian = np.array(columns).T
    return float(np.trace(jacobian)), float(np.linalg.det(jacobian))


def doubling(restitution: float) -> float:
    """Peak acceleration (g) at which one impact a period becomes two in two, by our kernel."""
    first = math.pi * (1 - restitution) / (1 + restitution)

    def doubled(gamma: float) -> bool:
        trace, determinant = multipliers(gamma, restitution)
        return 1.0 + trace + determinant < 0.0

    low = max(1.02, 1.001 * first)
    return bisect(doubled, low, low + 3.0, 1e-7)


def period_doubling(effort: Effort) -> Iterator[Claim]:
    """Claim on the end of the orbit of one impact a period."""
    for e in (0.0, 0.25, 0.5, 0.8):
        theirs = math.hypot(math.pi * (1 - e) / (1 + e), 2.0 * (1 + e * e) / (1 + e) ** 2)
        outside = Outside(MEHTA if e == 0.0 else TUFILLARO, 1e-5, "central differences over 1e-6 mm")
        yield outside.claim(f"period doubling, e = {e:g}", "g", doubling(e), theirs)


def landing_phase(effort: Effort) -> Iterator[Claim]:
    """Claim on the phase of the plate at which an attracted ball lands."""
    for e, gamma in ((0.5, 1.3), (0.8, 1.0)):
        plan = bodies.plan(gamma, e)
        state = _orbit(plan, gamma, e)
        state[Y] += 1e-3
        advance(plan, state, (60 if effort.quick else 240) * PERIOD)
        # In flight: back to the takeoff, where height and speed are those of the plate
        top = state[Y] - bodies.TALL + state[V_Y] ** 2 / (2.0 * GRAVITY)
        since = PERIOD / 2.0 + state[V_Y] / -GRAVITY
        phase = math.fmod(state[PHASE] - OMEGA * since + 4.0 * math.pi, 2.0 * math.pi)
        theirs = math.acos(math.pi * (1 - e) / (1 + e) / gamma)
        off = top - plan.world.drive.amplitude * math.sin(theirs) - GRAVITY * PERIOD**2 / 8.0
        reason = "what is left of the start after the contraction e^n of n impacts"
        why = f"Height of the flight off by {abs(off):.0e} mm." if abs(off) > 1e-6 else ""
        quantity = f"phase of landing, e = {e:g} at {gamma:g} g"
        yield Outside(TUFILLARO, 1e-6, reason, why).claim(quantity, "rad", phase, theirs)


def plastic_flight(effort: Effort) -> Iterator[Claim]:
    """Claim on a plastic ball: the acceleration at which its flight lasts a period."""

    def flies_on(gamma: float) -> bool:
        plan = bodies.plan(gamma, 0.0)
        state = plan.start(0.0, 0.0, 0.0)
        state[V_Y] = gamma * GRAVITY / OMEGA
        advance(plan, state, 20.0 * PERIOD)
        tally = advance(plan, state, PERIOD)
        return bool(tally.sums[record.CONTACT_TIME] < 1e-9 * PERIOD)

    ours, theirs = bisect(flies_on, 3.0, 3.5, 1e-7), math.hypot(1.0, math.pi)
    yield Outside(MEHTA, 1e-6, "bisection").claim("plastic ball: flights of a whole period", "g", ours, theirs)


def zeno(effort: Effort) -> Iterator[Claim]:
    """Claim on the time in which a ball comes to rest on a plate at rest."""
    gap, outside = 1.0, Outside(BERNSTEIN, 1e-5, "bounces slower than the kernel's speed of rest are left out")
    for e in (0.5, 0.8, 0.95):
        plan = bodies.plan(AT_REST, e)
        state = plan.start(gap, 0.0, 0.0)
        state[V_Y] = 0.0
        theirs = math.sqrt(2.0 * gap / GRAVITY) * (1 + e) / (1 - e)
        tally = advance(plan, state, theirs + 1.0)
        ours = theirs + 1.0 - float(tally.sums[record.CONTACT_TIME])
        yield outside.claim(f"end of all bounces from 1 mm, e = {e:g}", "s", ours, theirs)


def elastic(effort: Effort) -> Iterator[Claim]:
    """Claim on the energy of a ball that bounces with restitution 1."""
    plan, gap, bounces = bodies.plan(AT_REST, 1.0), 0.1, 10_000
    state = plan.start(gap, 0.0, 0.0)
    state[V_Y] = 0.0
    at_rest = plan.energy(plan.start(0.0, 0.0, 0.0))
    before = plan.energy(state) - at_rest
    advance(plan, state, (2.0 * bounces + 1.0) * math.sqrt(2.0 * gap / GRAVITY))
    outside = Outside("conservation of energy", 1e-9, "rounding of a height, 1e-15 mm of 0.1 mm, in each bounce")
    yield outside.claim("energy kept in 10 000 elastic bounces", "", (plan.energy(state) - at_rest) / before, 1.0)


def rocking(slenderness: float) -> float:
    """Spin after over before a rocking block changes feet, by our kernel.

    `slenderness`: height over width of the block.
    """
    plan = bodies.plan(AT_REST, 0.0, 50.0, mass=bodies.body(tall=slenderness * HALF))
    level = plan.energy(plan.start(0.0, 0.0, 0.5 * math.pi))
    state = plan.start(0.0, 0.02, 0.5 * math.pi)
    state[PITCH], state[SPIN], state[V_X], state[V_Y] = 0.02, 0.0, 0.0, 0.0
    before = plan.energy(state) - level
    while state[PITCH] > 0.0:
        advance(plan, state, 1e-3)
    return math.sqrt((plan.energy(state) - level) / before)


def housner(slenderness: float) -> float:
    """Spin after over before by Housner's formula for a block."""
    return 1.0 - 1.5 / (1.0 + slenderness**2)


def rocking_blocks(effort: Effort) -> Iterator[Claim]:
    """Claim on blocks that rock from foot to foot: Housner's formula, and measured blocks."""
    formula = Outside(HOUSNER, 1e-6, "event times")
    for slenderness in (2.0, 3.0, 5.0):
        quantity = f"rocking block {slenderness:g} times as high as wide: spin kept"
        yield formula.claim(quantity, "", rocking(slenderness), housner(slenderness))
    for slenderness, share, base in ((3.0, 0.97, "concrete"), (5.0, 0.95, "concrete"), (5.0, 0.67, "rubber")):
        quantity = f"rocking block {slenderness:g} times as high as wide on {base}: spin kept, over Housner's"
        measured = Outside(ELGAWADY, 0.02 / share, "our reading of 'about'", REAL_BASE)
        yield measured.claim(quantity, "", rocking(slenderness) / housner(slenderness), share)


TESTS = (lift_off, period_doubling, landing_phase, plastic_flight, zeno, elastic, rocking_blocks)
