"""Elastic feet: the legs' corners, the Hertzian tips in series with them, and the damper that gives a restitution.

A corner has half of its leg's axial stiffness, E D s / (2 l). A tip of effective radius R on the plate has Hertz's K
(theory/hertz.py). The damper gives one corner alone, without friction, the restitution e at every speed
(simulation/space/tips.py): as a linear oscillator whose force ends when it would pull, e = exp(-zeta t), t the time at
which the force vanishes (Schwager and Poeschel, Granular Matter 9, 2007, 465). Limits: e = 1 has no loss; rigid tips
leave the legs alone.

Corners differ in height from print to print: every run draws independent normal heights about their mean.
"""

import math
from typing import NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.numerics import Array
from walkergen.core.scene import GRAVITY, MIN_RESTITUTION, Scene
from walkergen.core.simulation.effects.effect import Case, Effect, Rule, decide_from_key
from walkergen.core.theory.hertz import landing_depth, tip_stiffness
from walkergen.core.walker.limbs import Limb
from walkergen.core.walker.sections import section_of
from walkergen.core.walker.spec import Material

NAME, KEY = "compliant tips", "feet.rigid_tips"
UNEVENNESS, UNEVENNESS_KEY = "unevenness", "feet.unevenness_um"
"""Name of the unevenness, which is also its switch, and its key."""

MAX_SD_RATIO = 0.1
"""Largest standard deviation over the length of a leg."""

LANDING_SPEED_RATIO = 2.0
"""Speed at which a corner lands, as the step and the surrogate take it, over the plate's peak speed."""


class Foot(NamedTuple):
    """Elastic contact of one corner of a foot."""

    spring: float
    """Axial stiffness of the leg behind it, g/s^2."""
    tip: float
    """Hertz stiffness of its tip, g/(mm^0.5 s^2); infinite: rigid."""
    damping_ratio: float
    """Damping ratio of a corner alone."""


def axial_stiffness(limb: Limb, modulus: float) -> float:
    """Compute the normal stiffness of one of a foot's two corners, g/s^2: half of that of its leg, with a brace if any.

    `modulus` is Young's, Pa.
    """
    return 0.5 * modulus * limb.width * section_of(limb).axial(limb)


def restitution(damping_ratio: float) -> float:
    """Return the restitution of a mass that lands on a spring and a damper, which never pull. Damping ratio >= 0."""
    z = damping_ratio
    if z < 1.0:
        fast = math.sqrt(1.0 - z * z)
        time = math.atan2(2.0 * z * fast, 2.0 * z * z - 1.0) / fast
    elif z == 1.0:
        time = 2.0
    else:
        fast = math.sqrt(z * z - 1.0)
        time = math.log((z + fast) / (z - fast)) / fast
    return math.exp(-z * time)


def damping_ratio(target: float) -> float:
    """Find the damping ratio that gives the restitution `target`, 0 < target <= 1, by bisection."""
    low, high = 0.0, 1.0
    while restitution(high) > target:
        high *= 2.0
    for _ in range(80):  # to rounding
        middle = 0.5 * (low + high)
        if restitution(middle) > target:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high) if target < 1.0 else 0.0


def corner_contact(scene: Scene, limb: Limb, material: Material) -> Foot:
    """Return the elastic contact of one corner of a leg's foot. Raises InputError for too small a restitution."""
    e = scene.contact.restitution if limb.restitution is None else limb.restitution
    if e < MIN_RESTITUTION:
        raise InputError(
            f"contact.restitution = {e:g}: an elastic foot always rebounds a little. Give {MIN_RESTITUTION:g}..1"
        )
    return Foot(axial_stiffness(limb, material.youngs_modulus), tip_stiffness(scene, material), damping_ratio(e))


def landing_stiffness(tip: float, mass: float, speed: float) -> float:
    """Return a tip's tangent stiffness (g/s^2) under a mass (g) that lands at a speed (mm/s). `tip`: Hertz's K."""
    return math.inf if math.isinf(tip) else 1.5 * tip * math.sqrt(landing_depth(tip, mass, speed, GRAVITY * mass))


def decide(case: Case) -> Effect:
    """Return the effect "compliant tips". Number: stiffness of a leg's corner over that of its tip, at a landing."""
    meaning = "stiffness of a leg's corner over that of its tip, at a landing"
    rigid, material, ratio = case.scene.feet.rigid_tips, case.design.material, 0.0
    if not rigid:
        tip, mass = tip_stiffness(case.scene, material), float(case.mass.total) / (2 * len(case.design.limbs))
        pressed_stiffness = landing_stiffness(tip, mass, LANDING_SPEED_RATIO * case.equivalent_drive.peak_speed)
        ratio = axial_stiffness(case.design.limbs[0], material.youngs_modulus) / pressed_stiffness
    return Effect(NAME, not rigid, ratio, meaning, f"{KEY} = {str(rigid).lower()}", KEY)


RULE = Rule(decide, off_values={KEY: True})


def decide_unevenness(case: Case) -> Effect:
    """Return the effect "unevenness". Number: standard deviation of corners' heights over the plate's amplitude.

    Raises InputError for corners that differ as much as legs are long.
    """
    height = case.scene.feet.unevenness_um
    on, reason = decide_from_key(case, UNEVENNESS_KEY, UNEVENNESS)
    shortest = min(limb.length for limb in case.design.limbs)
    most = 1e3 * MAX_SD_RATIO * shortest
    if on and height > most:
        raise InputError(
            f"feet.unevenness_um = {height:g}: must lie in 0..{most:g} for legs of "
            f"{shortest:g} mm; prints differ by some 10 um"
        )
    amplitude = 1e3 * case.equivalent_drive.amplitude
    meaning = "standard deviation of corners' heights over the plate's amplitude"
    return Effect(UNEVENNESS, on, height / amplitude, meaning, reason, UNEVENNESS)


UNEVENNESS_RULE = Rule(decide_unevenness, UNEVENNESS, typical_values={UNEVENNESS_KEY: 10.0})


def sample_heights(case: Case, corners: int, rng: np.random.Generator) -> Array:
    """Draw the heights of the corners of one print, mm, with mean zero, shape (corners,)."""
    heights = 1e-3 * case.scene.feet.unevenness_um * rng.normal(size=corners)
    return np.asarray(heights - heights.mean())
