"""Claims on closed forms: mechanics that a textbook, or the paper, gives in a formula."""

import math
from collections.abc import Iterator

import numpy as np

from evidence.validate import bodies
from evidence.validate.bodies import Array, advance
from evidence.validate.claim import Claim, Effort, Outside
from evidence.validate.claims_bounce import bisect
from walkergen.numerics.quantity import exact
from walkergen.scene import AT_REST, GRAVITY
from walkergen.simulation.effects import compliance
from walkergen.simulation.world import V_X, X
from walkergen.theory import impact, speed, tensors
from walkergen.walker import solids
from walkergen.walker.design import Design
from walkergen.walker.mass import LegMass, MassProperties, weigh

PAPER = "Koumakis et al. 2016, eqs {}, written out with matrices"
ROUNDING = "rounding"
ONE_NUMBER = (
    "A stiff leg on a spring keeps one number of the beam, and ours is its static stiffness; "
    "a modulus 1.37 times as large keeps the frequency."
)


def box(effort: Effort) -> Iterator[Claim]:
    """Claim on mass and inertia of a meshed body, a box."""
    design = Design()
    size, density = design.body, 1e-3 * design.material.density_g_cm3
    length, depth, height = size.length_mm, size.depth_mm, size.thickness_mm
    meshed = weigh(solids.build(design.unmarked).body, density)
    M = density * length * depth * height
    for name, ours, theirs in (
        ("mass of the body, a box", meshed.mass, M),
        ("its moment of inertia", meshed.inertia, M * (length**2 + height**2) / 12.0),
    ):
        unit = "g" if "mass" in name else "g mm²"
        yield Outside("closed form of a box", 1e-12, ROUNDING).claim(name, unit, ours, theirs)


def perpendicular(lever: Array) -> Array:
    """Velocity of the end of a lever (2,) at unit spin."""
    return np.array([-lever[1], lever[0]])


def published_tensor(mass: MassProperties, leg: LegMass) -> Array:
    """Inverse mass at a foot, shape (2, 2), 1/g: I/m + P(c)/j - R^T K^-1 R as the paper has it."""

    def spin(lever: Array) -> Array:
        return np.outer(perpendicular(lever), perpendicular(lever))

    identity = np.eye(2)
    K = identity / mass.M + spin(leg.anchor) / mass.J + identity / leg.m + spin(leg.c_A) / leg.j
    R = identity / leg.m - np.outer(perpendicular(leg.c_A), perpendicular(leg.c_T)) / leg.j
    return np.asarray(identity / leg.m + spin(leg.c_T) / leg.j - R.T @ np.linalg.solve(K, R))


def tensor(effort: Effort) -> Iterator[Claim]:
    """Claim on the inverse mass that an impact meets at a flexible leg's foot."""
    outside = Outside(PAPER.format("8-12"), 1e-9, "the printed form subtracts numbers of order 1/m")
    for tilt in (10.0, 35.0):
        mass = solids.mass_of(Design().variant(tilt_deg=tilt))
        ours, theirs = tensors.feet(mass)[0], published_tensor(mass, mass.legs[0])
        for name, value, place in (("xx", ours.xx, (0, 0)), ("xy", ours.xy, (0, 1)), ("yy", ours.yy, (1, 1))):
            quantity = f"inverse mass H_{name}, back foot, {tilt:g} deg"
            yield outside.claim(quantity, "1/g", float(value), float(theirs[place]))


def stationary(effort: Effort) -> Iterator[Claim]:
    """Claim on the stationary speed, by eq. 15 where feet slide back, as at μ = 0.1."""
    e, mu = 0.9, 0.1
    for tilt in (10.0, 20.0, 35.0):
        mass = solids.mass_of(Design().variant(tilt_deg=tilt))
        ours = speed.factors(mass, e, mu)
        feet = zip(("back", "front"), (ours.feet[0], ours.feet[1]), mass.legs, strict=True)
        for name, value, leg in feet:
            H = published_tensor(mass, leg)
            theirs = 0.5 * (1 + e) * (mu * H[0, 0] - H[0, 1]) / (H[1, 1] - e * mu * H[0, 1])
            outside = Outside(PAPER.format("12, 15 at e = 0.9, μ = 0.1"), 1e-9, "as above")
            quantity = f"speed over impact speed, {name} foot, {tilt:g} deg"
            yield outside.claim(quantity, "", float(value), float(theirs))


def energy_of_impacts(effort: Effort) -> Iterator[Claim]:
    """Claim on energy: Newton's law can create it where slip reverses, Stronge's cannot."""
    rng, gains = np.random.default_rng(1991), {impact.Law.NEWTON: -1.0, impact.Law.STRONGE: -1.0}
    for _ in range(400):
        root = rng.normal(size=(2, 2))
        H = root @ root.T + 1e-3 * np.eye(2)
        velocity = float(rng.normal()), -float(rng.uniform(0.1, 1.0))
        for law in gains:
            entries = float(H[0, 0]), float(H[0, 1]), float(H[1, 1])
            outcome = impact.resolve(entries, velocity, 0.9, 0.3, law)
            gain = impact.energy_change(velocity, outcome) / (math.hypot(*velocity) * outcome.F_y)
            gains[law] = max(gains[law], gain)
    source = "W. J. Stronge, Unraveling paradoxical theories for rigid body collisions, J. Appl. Mech. 58, 1049 (1991)"
    for law, below, above in ((impact.Law.STRONGE, math.inf, 1e-12), (impact.Law.NEWTON, 1e-12, math.inf)):
        quantity = (
            f"largest gain of energy in 400 impacts, e = 0.9, over impulse × speed: {law.name.capitalize()}'s law"
        )
        yield Claim(quantity, exact("gain", "", gains[law]), exact("gain", "", 0.0), below, above, ROUNDING, source)


def slopes(effort: Effort) -> Iterator[Claim]:
    """Claim on a rigid block on an incline at rest: where it starts to slide, how fast it goes."""
    mu, seconds = 0.25, 0.1

    def way(slope_deg: float) -> float:
        plan = bodies.plan(AT_REST, 0.0, mu, slope_deg)
        state = plan.start(0.0, 0.0, 0.5 * math.pi)
        advance(plan, state, seconds)
        return float(state[X])

    angle = bisect(lambda slope: way(slope) > 1e-4, 10.0, 20.0, 1e-5)
    outside = Outside("Coulomb's law on an incline", 1e-4, "a way of 0.1 um in 0.1 s counts as sliding")
    quantity = "slope at which a block starts to slide, μ = 0.25"
    yield outside.claim(quantity, "deg", angle, math.degrees(math.atan(mu)))
    slope = math.radians(20.0)
    theirs = 0.5 * GRAVITY * (math.sin(slope) - mu * math.cos(slope)) * seconds**2
    outside = outside._replace(share=1e-5, reason="it lands first, within the tolerance of a gap")
    yield outside.claim("way down 20 deg in 0.1 s", "mm", way(20.0), theirs)


def sliding_stop(effort: Effort) -> Iterator[Claim]:
    """Claim on a block that slides to a stop on a level plate at rest."""
    mu, launched = 0.25, 60.0
    plan = bodies.plan(AT_REST, 0.0, mu)
    state = plan.start(0.0, 0.0, 0.5 * math.pi)
    state[V_X] = launched
    advance(plan, state, 0.1)
    quantity, theirs = "way of a block that slides to a stop from 60 mm/s", launched**2 / (2.0 * mu * GRAVITY)
    yield Outside("Coulomb's law", 1e-5, "as above").claim(quantity, "mm", float(state[X]), theirs)


def leg(effort: Effort) -> Iterator[Claim]:
    """Claim on a leg as a spring: its tip's stiffness, its first frequency."""
    design = Design()
    E, length = 1e9 * design.material.youngs_modulus_gpa, design.limbs[0].length
    second = design.size.depth * design.limbs[0].thickness ** 3 / 12.0
    density = 1e-3 * design.material.density_g_cm3
    k = compliance.stiffness(design.limbs[0], E)
    beam = Outside("cantilever beam, Euler and Bernoulli", 1e-12, ROUNDING)
    yield beam.claim("stiffness of a leg's tip", "N/m", 1e-3 * k / length**2, 1e-3 * 3.0 * E * second / length**3)
    line = density * design.limbs[0].thickness * design.size.depth
    ours = math.sqrt(k / (line * length**3 / 3.0)) / (2.0 * math.pi)
    theirs = 1.8751040687**2 * math.sqrt(E * second / (line * length**4)) / (2.0 * math.pi)
    reason = "one per cent: no frequency is known better"
    ringing = Outside("cantilever beam, first root 1.8751", 0.01, reason, ONE_NUMBER)
    yield ringing.claim("first frequency of a leg on a held body", "Hz", ours, theirs)


TESTS = (box, tensor, stationary, energy_of_impacts, slopes, sliding_stop, leg)
