"""Claims on closed forms: mechanics that a textbook, or the paper, gives in a formula."""

import math
from collections.abc import Iterator

import numpy as np

from evidence.validate.claim import Claim, Effort, Outside
from evidence.validate.claims_bounce import bisect
from walkergen.core.numerics import Array
from walkergen.core.scene import GRAVITY, Scene, still_plate_drive
from walkergen.core.simulation import record
from walkergen.core.simulation.effects import legs
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.space.state import SHOWN_X, V_X
from walkergen.core.theory import speed, tensors
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import LegMass, MassProperties, weigh

FRICTION, SLIDE_S = 0.25, 0.1
"""Friction of what slides, and its time, s."""

PAPER = "Koumakis et al. 2016, eqs {}, written out with matrices"
ROUNDING = "rounding"
ONE_NUMBER = (
    "A stiff leg on a spring keeps one number of the beam. Ours keeps the static stiffness. A modulus 1.37 times "
    "as large keeps the frequency."
)


def box_mass(effort: Effort) -> Iterator[Claim]:
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


def foot_inverse_mass(effort: Effort) -> Iterator[Claim]:
    """Claim on the inverse mass that an impact meets at a flexible leg's foot."""
    outside = Outside(PAPER.format("8-12"), 1e-9, "the printed form subtracts numbers of order 1/m")
    for tilt in (10.0, 35.0):
        mass = solids.mass_of(Design().variant(tilt_deg=tilt))
        ours, theirs = tensors.foot_tensors(mass)[0], published_tensor(mass, mass.legs[0])
        for name, value, place in (("xx", ours.xx, (0, 0)), ("xy", ours.xy, (0, 1)), ("yy", ours.yy, (1, 1))):
            quantity = f"inverse mass H_{name}, back foot, {tilt:g} deg"
            yield outside.claim(quantity, "1/g", float(value), float(theirs[place]))


def stationary_speed(effort: Effort) -> Iterator[Claim]:
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


def sliding_distance(slope_deg: float, speed: float = 0.0) -> float:
    """Return the way (mm) of an upright braced walker in 0.1 s, let go on an incline at rest with a speed along it."""
    tables = {
        "drive": still_plate_drive(90.0),
        "arena": {"kind": "plane"},
        "contact": {"restitution": 0.5, "friction": FRICTION},
        "feet": {"rigid_tips": True},
        "plate": {"slope_deg": slope_deg},
    }
    design = Design.model_validate({"legs": {"tilt_deg": 0.0, "kind": "braced"}})
    plan = prepare(Scene.model_validate(tables), design, solids.mass_of(design))
    state = plan.initial_state(0.0, 0.0, 0.0, 0.0)
    state[V_X] = speed
    began = float(state[SHOWN_X])
    plan.advance(state, SLIDE_S, record.new_tally(len(state)))
    return float(state[SHOWN_X]) - began


def sliding_on_slopes(effort: Effort) -> Iterator[Claim]:
    """Claim on a rigid walker on an incline at rest: where it starts to slide, how fast it goes."""
    angle = bisect(lambda slope: sliding_distance(slope) > 1e-3, 10.0, 20.0, 1e-5)
    outside = Outside("Coulomb's law on an incline", 1e-3, "a way of 1 um in 0.1 s counts as sliding")
    quantity = "slope at which a braced walker starts to slide, μ = 0.25"
    yield outside.claim(quantity, "deg", angle, math.degrees(math.atan(FRICTION)))
    slope = math.radians(20.0)
    theirs = 0.5 * GRAVITY * (math.sin(slope) - FRICTION * math.cos(slope)) * SLIDE_S**2
    outside = outside._replace(share=3e-4, reason="springs of the feet stretch first")
    yield outside.claim("way down 20 deg in 0.1 s", "mm", sliding_distance(20.0), theirs)


def sliding_stop(effort: Effort) -> Iterator[Claim]:
    """Claim on a walker that slides to a stop on a level plate at rest."""
    launched = 60.0
    quantity, theirs = "way of a walker that slides to a stop from 60 mm/s", launched**2 / (2.0 * FRICTION * GRAVITY)
    yield Outside("Coulomb's law", 1e-5, "as above").claim(quantity, "mm", sliding_distance(0.0, launched), theirs)


def leg_spring(effort: Effort) -> Iterator[Claim]:
    """Claim on a leg as a spring: its tip's stiffness, its first frequency."""
    design = Design()
    E, length = 1e9 * design.material.youngs_modulus_gpa, design.limbs[0].length
    second = design.size.depth * design.limbs[0].thickness ** 3 / 12.0
    density = 1e-3 * design.material.density_g_cm3
    k = legs.hinge_stiffness(design.limbs[0], E)
    beam = Outside("cantilever beam, Euler and Bernoulli", 1e-12, ROUNDING)
    yield beam.claim("stiffness of a leg's tip", "N/m", 1e-3 * k / length**2, 1e-3 * 3.0 * E * second / length**3)
    line = density * design.limbs[0].thickness * design.size.depth
    ours = math.sqrt(k / (line * length**3 / 3.0)) / (2.0 * math.pi)
    theirs = 1.8751040687**2 * math.sqrt(E * second / (line * length**4)) / (2.0 * math.pi)
    reason = "one per cent: no frequency is known better"
    ringing = Outside("cantilever beam, first root 1.8751", 0.01, reason, ONE_NUMBER)
    yield ringing.claim("first frequency of a leg on a held body", "Hz", ours, theirs)


TESTS = (box_mass, foot_inverse_mass, stationary_speed, sliding_on_slopes, sliding_stop, leg_spring)
