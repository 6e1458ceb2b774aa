"""Pluck of a leg: frequency and damping of a leg that is bent and let go, its body held.

A printed leg is a cantilever; its first mode swings at (1.8751^2 / 2 pi) sqrt(E I / (m l^3)), m the
mass of the leg (Euler-Bernoulli; Blevins, Formulas for natural frequency and mode shape, 1979,
table 8-1). The model's leg is rigid on a hinge of stiffness c E I / l, which swings at
(1 / 2 pi) sqrt(c E I / (l J)), J = m l^2 / 3: for c = 3, the stiffness of a cantilever under a slow
load, at 3.000 / 3.516 of it. So a microphone's frequency is compared with the cantilever's, never
with the hinge's.
"""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.errors import InputError
from walkergen.lab import resting
from walkergen.lab.beams import FIRST_MODE, damping_ratio, decrement_of
from walkergen.numerics.quantity import Quantity
from walkergen.scene import Scene
from walkergen.simulation import record
from walkergen.simulation.effects import compliance
from walkergen.simulation.model import Plan
from walkergen.simulation.plan import prepare
from walkergen.simulation.space.state import LEGS
from walkergen.walker import names, solids
from walkergen.walker.design import Design
from walkergen.walker.mass import scaled

Array = npt.NDArray[np.float64]

HELD = 1e9
"""Mass of a body that is held, over its own."""

BENT = 0.01
"""Angle at which a leg is let go, rad."""

HIGH_MM = 100.0
"""Height over the plate, mm: nothing is touched while the leg rings."""

SHARES = (0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4)
"""Young's moduli of the table, over the design's own."""

RATIOS = (0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2)
"""Damping ratios of the table."""

RING_PERIODS, PER_PERIOD = 12, 64
"""Swings that are simulated, and samples of each."""


class Ringing(NamedTuple):
    """A leg of the model, let go and ringing."""

    times: Array
    """s."""
    angles: Array
    """Angle of the leg against the body, rad."""
    frequency: float
    """Frequency of the damped swings, Hz, from where the angle crosses zero."""
    decrement: float
    """Logarithm of a swing over the next on the same side; 0 when it is not damped."""


class Plucked(NamedTuple):
    """Frequencies of a leg, the first that is free, Hz."""

    leg_mass: float
    """Mass of the leg, g."""
    cantilever: float
    """First mode of the printed leg, its body held: what a microphone hears."""
    hinges: Mapping[str, float]
    """Of the model's leg by legs.spring, undamped, its body held."""
    held: Ringing
    """The model's leg, simulated with the scene's spring and damping, its body held."""
    free: tuple[float, ...]
    """Modes of all legs on a body that nobody holds, undamped, rising."""


def plucked_leg(design: Design) -> int:
    """Number of the leg that is plucked: the first that is not braced.

    Raises InputError where all are.
    """
    free = [number for number, limb in enumerate(design.limbs) if not limb.rigid]
    if not free:
        raise InputError(f"{design.name}: braced legs do not swing; pluck a flexible leg: --legs flexible")
    return free[0]


def which(design: Design) -> str:
    """Words that name the plucked leg where others differ from it; "" of two equal legs."""
    return "" if design.alike else f" ({names.legs(design)[plucked_leg(design)]})"


def cantilever(design: Design, leg_mass: float) -> float:
    """First natural frequency (Hz) of the plucked leg of `leg_mass` (g), its body held."""
    limb = design.limbs[plucked_leg(design)]
    bending = 1e9 * design.material.youngs_modulus_gpa * limb.section.second_moment(limb)
    return FIRST_MODE * math.sqrt(bending / (leg_mass * limb.length**3)) / (2.0 * math.pi)


class ByFrequency(NamedTuple):
    """What a frequency that was heard is turned into."""

    modulus: Quantity
    """Young's modulus, GPa, with the thickness taken from the design."""
    thickness: Quantity
    """Thickness, mm, with Young's modulus taken from the design."""
    bending: float
    """Relative error of the product E s^3, which is what the model's hinge needs."""


def by_frequency(design: Design, leg_mass: float, hertz: float, sd: float) -> ByFrequency:
    """Modulus, or thickness, at which a leg of this mass (g) rings at `hertz` ± `sd`.

    E I = f^2 m l^3 up to a number: I goes as s^3, and so does m as s where the mesh weighs the leg.
    """
    weighed, material = design.weighed.leg_mass_g is not None, design.material
    mass, heard = 0.01 * design.weighed.mass_sd_percent, 2.0 * sd / hertz
    limb, ratio = design.limbs[plucked_leg(design)], hertz / cantilever(design, leg_mass)
    thick, power = limb.thickness_sd / limb.thickness, 3.0 if weighed else 2.0
    modulus = material.youngs_modulus_gpa * ratio**2
    thickness = float(limb.thickness * ratio ** (2.0 / power))
    stiff = material.youngs_modulus_sd_gpa / material.youngs_modulus_gpa
    return ByFrequency(
        Quantity("youngs_modulus", "gpa", modulus, math.hypot(heard, power * thick, mass) * modulus),
        Quantity("thickness", "mm", thickness, math.hypot(heard, stiff, mass) / power * thickness),
        math.hypot(heard, 0.0 if weighed else thick, mass),
    )


def damping(decrement: Quantity) -> Quantity:
    """Damping ratio of a leg whose swings have this logarithmic decrement."""
    value, sd = decrement.pair
    ratio = damping_ratio(value)
    return Quantity("damping_ratio", "", ratio, ratio * (1.0 - ratio * ratio) * sd / value)


def by_modulus(design: Design, leg_mass: float) -> list[tuple[float, float]]:
    """Young's moduli (GPa) about the design's, and the frequencies (Hz) that they give."""
    own, frequency = design.material.youngs_modulus_gpa, cantilever(design, leg_mass)
    return [(share * own, frequency * math.sqrt(share)) for share in SHARES]


def by_damping() -> list[tuple[float, float, float]]:
    """Damping ratios, their logarithmic decrements, and what is left of a swing at the next."""
    pairs = [(ratio, decrement_of(ratio)) for ratio in RATIOS]
    return [(ratio, decrement, math.exp(-decrement)) for ratio, decrement in pairs]


def pluck(scene: Scene, design: Design) -> Plucked:
    """Pluck a leg of a walker in the model, and compare it with the cantilever that it stands for.

    Raises InputError for braced legs, and for a damping that lets no leg swing.
    """
    number = plucked_leg(design)
    ratio = scene.legs.damping_ratio
    if ratio >= 1.0:
        raise InputError(f"legs.damping_ratio = {ratio:g}: a leg without swings; must be below 1 to be plucked")
    mass = solids.mass_of(design)
    limb, modulus = design.limbs[number], design.material.youngs_modulus
    inertia = float(mass.legs[number].inertia)
    hinges: dict[str, float] = {
        name: compliance.natural_frequency(compliance.stiffness(limb, modulus, name), inertia)
        for name in compliance.SPRING_FACTORS
    }
    loose = resting.plan_of(scene, design)
    held = prepare(resting.resting(scene), design, scaled(mass, HELD, 1.0))
    own = hinges[scene.legs.spring]
    leg = float(mass.legs[number].m)
    return Plucked(leg, cantilever(design, leg), hinges, ring(held, own), _modes(loose))


def ring(plan: Plan, about: float) -> Ringing:
    """Ringing of the first free leg of a plan's walker, which swings at `about` Hz, in the air."""
    state = plan.start(HIGH_MM, 0.0, 0.0)
    state[LEGS] = BENT
    seconds = RING_PERIODS / about
    tally = record.new(LEGS + 1, seconds, 1.0 / (about * PER_PERIOD))
    plan.advance(state, seconds, tally)
    rows = tally.samples.rows[: tally.samples.cursor[0]]
    times, angles = rows[:, 0], rows[:, 1 + LEGS]
    frequency = _crossings(times, angles)
    return Ringing(times, angles, frequency, _decrement(times, angles, frequency))


def _crossings(times: Array, angles: Array) -> float:
    """Frequency (Hz) from the first and the last downward crossing of zero."""
    at = np.flatnonzero((angles[:-1] > 0.0) & (angles[1:] <= 0.0))
    share = angles[at] / (angles[at] - angles[at + 1])
    crossed = times[at] + share * (times[at + 1] - times[at])
    return float((len(crossed) - 1) / (crossed[-1] - crossed[0])) if len(crossed) > 1 else math.nan


def _decrement(times: Array, angles: Array, frequency: float) -> float:
    """Logarithmic decrement, by a line through the logarithms of the tops of the swings."""
    inner = angles[1:-1]
    tops = 1 + np.flatnonzero((inner > 0.0) & (inner >= angles[:-2]) & (inner > angles[2:]))
    if len(tops) < 2:
        return math.nan
    slope = np.polyfit(times[tops], np.log(angles[tops]), 1)[0]
    return float(max(-slope / frequency, 0.0))


def _modes(plan: Plan) -> tuple[float, ...]:
    """Natural frequencies (Hz) of the hinges on a free body, rising; not those of the twists."""
    walker = plan.world.walker
    squares, shapes = np.linalg.eig(walker.hinge_mobility * walker.stiffness)
    energy = walker.stiffness[:, None] * np.abs(shapes) ** 2
    bends = energy[:: walker.freedoms].sum(axis=0) > 0.5 * energy.sum(axis=0)
    frequencies = np.sqrt(np.sort(squares.real[bends])) / (2.0 * math.pi)
    return tuple(float(hertz) for hertz in frequencies)
