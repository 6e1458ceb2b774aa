"""Claims on bouncing balls and rocking blocks: published results, by the simulator of the paper's own model.

The body is a rigid block on two feet. Without friction, dropped level, it bounces on both together, as a ball does.

The ball's linear stability is derived here again. With takeoff velocity U at time t, plate velocity
V and acceleration a at the impact, an orbit of one impact a period T has U = g T / 2, so that
Gamma cos(phase) = pi (1 - e)/(1 + e), and the map (t, U) has determinant e^2 and trace
1 + e^2 + (1 + e)^2 a / g. The orbit is born where a = 0 and doubles its period where
Gamma sin(phase) = 2 (1 + e^2)/(1 + e)^2.
"""

import math
from collections.abc import Callable, Iterator

import numpy as np

from evidence import paper_simulation
from evidence.paper_simulation import CONTACT_S, OK, PHASE, PITCH, V_Y, World, Y, energy, initial_state
from evidence.validate.claim import Claim, Effort, Outside
from walkergen.core.numerics import Array
from walkergen.core.scene import GRAVITY, REST_GAMMA, Drive, Scene

TUFILLARO = (
    "N. B. Tufillaro, T. M. Mello, Y. M. Choi, A. M. Albano, Period doubling boundaries of a "
    "bouncing ball, J. Physique 47, 1477 (1986); derived again"
)
MEHTA = (
    "A. Mehta, J. M. Luck, Novel temporal behavior of a nonlinear dynamical system: the completely "
    "inelastic bouncing ball, Phys. Rev. Lett. 65, 393 (1990); derived again"
)
BERNSTEIN = "A. D. Bernstein, Listening to the coefficient of restitution, Am. J. Phys. 45, 41 (1977)"
HOUSNER = (
    "G. W. Housner, The behavior of inverted pendulum structures during earthquakes, Bull. "
    "Seismol. Soc. Am. 53, 403 (1963)"
)
ELGAWADY = (
    "M. A. ElGawady, Q. Ma, J. M. Butterworth, J. M. Ingham, Effects of interface material on the "
    "dynamic behaviour of rigid blocks, doi 10.1201/9781003060888-45, abstract. Stated: about 0.97 (3 times as high as "
    "wide) and 0.95 (5 times) of the predicted value on concrete, 0.67 (5 times) on rubber"
)
REAL_BASE = (
    "A rigid plastic block on two corners loses only the energy of changing corners. A real base takes more, and "
    "rubber takes most. Others measured less loss than Housner's formula (Kalliontzis, Sritharan, Schultz, J. "
    "Struct. Eng. 142, 06016002, 2016)."
)

HALF_SPACING_MM, HEIGHT_MM, MASS_G = 6.5, 9.0, 0.833
"""The paper's walker: half between the feet and height of O, mm; mass, g."""

FREQUENCY_HZ = 90.0
"""Frequency of every drive here, the paper's."""
PERIOD = 1.0 / FREQUENCY_HZ
OMEGA = 2.0 * math.pi * FREQUENCY_HZ


def block(gamma: float, restitution: float, friction: float = 0.0, tall: float = HEIGHT_MM) -> World:
    """Return a block with O `tall` mm above its feet, on a plate whose peak acceleration is `gamma` g."""
    drive = Drive.model_construct(frequency_hz=FREQUENCY_HZ, gamma=gamma)  # not validated: it may be at rest
    contact = {"restitution": restitution, "friction": friction}
    scene = Scene.model_validate({"drive": drive, "contact": contact})
    return paper_simulation.body_world(
        MASS_G,
        MASS_G * (HALF_SPACING_MM**2 + tall**2) / 3.0,
        ((-HALF_SPACING_MM, -tall), (HALF_SPACING_MM, -tall)),
        scene,
    )


def advance(own: World, state: Array, seconds: float) -> float:
    """Advance a state in place; return the time in contact, s. Raises ArithmeticError where the body falls."""
    before = float(state[CONTACT_S])
    status, _ = paper_simulation.advance(own, state, seconds)
    if status != OK:
        raise ArithmeticError(f"the rigid body's run ended with status {status}")
    return float(state[CONTACT_S]) - before


def level_energy(own: World) -> float:
    """Return the energy of a block at rest on a plate at rest, g mm^2/s^2."""
    return energy(own, initial_state(own, 0.0))


def bisect(holds: Callable[[float], bool], low: float, high: float, width: float) -> float:
    """Value between `low`, where a condition fails, and `high`, where it holds, at its border."""
    while high - low > width:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return 0.5 * (low + high)


def lift_off(effort: Effort) -> Iterator[Claim]:
    """Claim that a body leaves the plate where the plate falls away faster than it."""

    def leaves(gamma: float) -> bool:
        own = block(gamma, 0.0)
        state = initial_state(own, 0.0)
        state[V_Y] = gamma * GRAVITY / OMEGA
        advance(own, state, PERIOD)
        return advance(own, state, PERIOD) < PERIOD * (1.0 - 1e-9)

    reason = "a hop just above 1 g is shorter than a step of lasting contact"
    outside = Outside("Newton's second law: plate acceleration -g", 1e-4, reason)
    yield outside.claim("acceleration at which a ball leaves the plate", "g", bisect(leaves, 0.9, 1.1, 1e-6), 1.0)


def _orbit_state(own: World, gamma: float, restitution: float) -> Array:
    """State on the orbit of one impact a period, at the top of its flight."""
    phase = math.acos(min(math.pi * (1 - restitution) / (1 + restitution) / gamma, 1.0))
    state = initial_state(own, 0.0, 0.0, math.fmod(phase + math.pi, 2.0 * math.pi))
    # Level feet at the height of the impact, and the rise of half a period's free flight
    state[Y] = HEIGHT_MM + own.amplitude * math.sin(phase) + GRAVITY * PERIOD**2 / 8.0
    return state


def _return_map(own: World, orbit: Array, height: float, velocity: float) -> Array:
    """Return height and velocity (mm, mm/s) off an orbit, a period after being put off by these."""
    state = orbit.copy()
    state[Y] += height
    state[V_Y] += velocity
    advance(own, state, PERIOD)
    return np.array([state[Y] - orbit[Y], state[V_Y] - orbit[V_Y]])


def multipliers(gamma: float, restitution: float) -> tuple[float, float]:
    """Trace and determinant of a period's map about the orbit, by central differences."""
    own, columns = block(gamma, restitution), []
    orbit = _orbit_state(own, gamma, restitution)
    for off in ((1e-6, 0.0), (0.0, 1e-6 * OMEGA)):
        change = _return_map(own, orbit, *off) - _return_map(own, orbit, -off[0], -off[1])
        columns.append(change / (2.0 * max(off)))
    jacobian = np.array(columns).T
    return float(np.trace(jacobian)), float(np.linalg.det(jacobian))


def doubling_gamma(restitution: float) -> float:
    """Peak acceleration (g) at which one impact a period becomes two in two."""
    first = math.pi * (1 - restitution) / (1 + restitution)

    def is_doubled(gamma: float) -> bool:
        trace, determinant = multipliers(gamma, restitution)
        return 1.0 + trace + determinant < 0.0

    low = max(1.02, 1.001 * first)
    return bisect(is_doubled, low, low + 3.0, 1e-7)


def period_doubling(effort: Effort) -> Iterator[Claim]:
    """Claim on the end of the orbit of one impact a period."""
    for e in (0.0, 0.25, 0.5, 0.8):
        theirs = math.hypot(math.pi * (1 - e) / (1 + e), 2.0 * (1 + e * e) / (1 + e) ** 2)
        outside = Outside(MEHTA if e == 0.0 else TUFILLARO, 1e-5, "central differences over 1e-6 mm")
        yield outside.claim(f"period doubling, e = {e:g}", "g", doubling_gamma(e), theirs)


def landing_phase(effort: Effort) -> Iterator[Claim]:
    """Claim on the phase of the plate at which an attracted ball lands."""
    for e, gamma in ((0.5, 1.3), (0.8, 1.0)):
        own = block(gamma, e)
        state = _orbit_state(own, gamma, e)
        state[Y] += 1e-3
        advance(own, state, (60 if effort.quick else 240) * PERIOD)
        # In flight: back to the takeoff, where height and speed are those of the plate
        top = state[Y] - HEIGHT_MM + state[V_Y] ** 2 / (2.0 * GRAVITY)
        since = PERIOD / 2.0 + state[V_Y] / -GRAVITY
        phase = math.fmod(state[PHASE] - OMEGA * since + 4.0 * math.pi, 2.0 * math.pi)
        theirs = math.acos(math.pi * (1 - e) / (1 + e) / gamma)
        off = top - own.amplitude * math.sin(theirs) - GRAVITY * PERIOD**2 / 8.0
        reason = "what is left of the start after the contraction e^n of n impacts"
        why = f"Height of the flight off by {abs(off):.0e} mm." if abs(off) > 1e-6 else ""
        quantity = f"phase of landing, e = {e:g} at {gamma:g} g"
        yield Outside(TUFILLARO, 1e-6, reason, why).claim(quantity, "rad", phase, theirs)


def plastic_flight(effort: Effort) -> Iterator[Claim]:
    """Claim on a plastic ball: the acceleration at which its flight lasts a period."""

    def flies_on(gamma: float) -> bool:
        own = block(gamma, 0.0)
        state = initial_state(own, 0.0)
        state[V_Y] = gamma * GRAVITY / OMEGA
        advance(own, state, 20.0 * PERIOD)
        return advance(own, state, PERIOD) < 1.5 * PERIOD / paper_simulation.CONTACT_STEPS

    ours, theirs = bisect(flies_on, 3.0, 3.5, 1e-7), math.hypot(1.0, math.pi)
    outside = Outside(MEHTA, 1e-3, "a plastic foot stays for one step of lasting contact")
    yield outside.claim("plastic ball: flights of a whole period", "g", ours, theirs)


def time_to_rest(effort: Effort) -> Iterator[Claim]:
    """Claim on the time that a ball takes to come to rest on a plate at rest."""
    gap, outside = 1.0, Outside(BERNSTEIN, 1e-5, "bounces slower than a foot's speed of rest are left out")
    for e in (0.5, 0.8, 0.95):
        own = block(REST_GAMMA, e)
        state = initial_state(own, gap)
        theirs = math.sqrt(2.0 * gap / GRAVITY) * (1 + e) / (1 - e)
        ours = theirs + 1.0 - advance(own, state, theirs + 1.0)
        yield outside.claim(f"end of all bounces from 1 mm, e = {e:g}", "s", ours, theirs)


def elastic_energy(effort: Effort) -> Iterator[Claim]:
    """Claim on the energy of a ball that bounces with restitution 1."""
    own, gap, bounces = block(REST_GAMMA, 1.0), 0.1, 10_000
    state, at_rest = initial_state(own, gap), level_energy(own)
    before = energy(own, state) - at_rest
    advance(own, state, (2.0 * bounces + 1.0) * math.sqrt(2.0 * gap / GRAVITY))
    outside = Outside("conservation of energy", 1e-9, "rounding of a height, 1e-15 mm of 0.1 mm, in each bounce")
    yield outside.claim("energy kept in 10 000 elastic bounces", "", (energy(own, state) - at_rest) / before, 1.0)


def spin_ratio(slenderness: float) -> float:
    """Return the spin after over that before a rocking block changes feet.

    `slenderness`: height over width of the block.
    """
    own = block(REST_GAMMA, 0.0, 50.0, slenderness * HALF_SPACING_MM)
    state, level = initial_state(own, 0.0, 0.02), level_energy(own)
    before = energy(own, state) - level
    while state[PITCH] > 0.0:
        advance(own, state, 1e-3)
    return math.sqrt((energy(own, state) - level) / before)


def housner_ratio(slenderness: float) -> float:
    """Spin after over before by Housner's formula for a block."""
    return 1.0 - 1.5 / (1.0 + slenderness**2)


def rocking_blocks(effort: Effort) -> Iterator[Claim]:
    """Claim on blocks that rock from foot to foot: Housner's formula, and measured blocks."""
    formula = Outside(HOUSNER, 1e-5, "steps of lasting contact")
    for slenderness in (2.0, 3.0, 5.0):
        quantity = f"rocking block {slenderness:g} times as high as wide: spin kept"
        yield formula.claim(quantity, "", spin_ratio(slenderness), housner_ratio(slenderness))
    for slenderness, share, base in ((3.0, 0.97, "concrete"), (5.0, 0.95, "concrete"), (5.0, 0.67, "rubber")):
        quantity = f"rocking block {slenderness:g} times as high as wide on {base}: spin kept, over Housner's"
        measured = Outside(ELGAWADY, 0.02 / share, "our reading of 'about'", REAL_BASE)
        yield measured.claim(quantity, "", spin_ratio(slenderness) / housner_ratio(slenderness), share)


TESTS = (lift_off, period_doubling, landing_phase, plastic_flight, time_to_rest, elastic_energy, rocking_blocks)
