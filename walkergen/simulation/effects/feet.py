"""Elastic feet: stiffness of a foot's corner, and the damper that a restitution label stands for.

A corner has half of its leg's axial stiffness, E D s / (2 l). Viscous feet have a damper such that
one corner alone, without friction, rebounds with the label e; the force ends when it would pull, so
that e = exp(-zeta t), t the time at which the force vanishes (Schwager and Poeschel, Granular
Matter 9, 2007, 465). Hysteretic feet unload 1 / e^2 times as stiffly as they load (Walton and
Braun, Journal of Rheology 30, 1986, 949), whatever the mass. Limit: e = 1 has no loss.
"""

import math
from typing import NamedTuple

from walkergen.errors import InputError
from walkergen.scene import LEAST_LABEL, Scene
from walkergen.simulation.effects import local_contact
from walkergen.simulation.effects.effect import Case, Effect, Rule
from walkergen.walker.limbs import Limb

NAME, SWITCH = "hysteretic feet", "feet.damping"


class Foot(NamedTuple):
    """Elastic contact of a corner; stiffnesses in g/s^2."""

    normal: float
    tangential: float
    damping_ratio: float
    """Damping ratio of a corner alone; 0 for hysteretic feet."""
    unloading: float
    """Stiffness of unloading over that of loading; 1 for viscous feet."""


def axial_stiffness(limb: Limb, modulus: float) -> float:
    """Normal stiffness of a corner of a foot, g/s^2: half of that of its leg, and brace if any.

    `modulus`: Young's, Pa.
    """
    return 0.5 * modulus * limb.width * limb.section.axial(limb)


def restitution(damping_ratio: float) -> float:
    """Restitution of a mass on a viscous foot that never pulls, for any damping ratio >= 0."""
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


def damping_ratio(label: float) -> float:
    """Damping ratio whose `restitution` is `label`, 0 < label <= 1, by bisection."""
    low, high = 0.0, 1.0
    while restitution(high) > label:
        high *= 2.0
    for _ in range(80):
        middle = 0.5 * (low + high)
        if restitution(middle) > label:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high) if label < 1.0 else 0.0


def foot_of(scene: Scene, limb: Limb, modulus: float, local: bool) -> Foot:
    """Elastic contact of a corner of a leg's foot; `local`: with the local contact.

    `modulus`: Young's, Pa. Raises InputError.
    """
    label, feet = scene.contact.restitution, scene.feet
    if limb.restitution is not None:
        label = limb.restitution
    if label < LEAST_LABEL:
        raise InputError(
            f"contact.restitution = {label:g}: an elastic foot always rebounds a little; the model "
            f"'space' takes {LEAST_LABEL:g}..1 (legs.model = 'compliant' takes 0 as well)"
        )
    normal = feet.stiffness_ratio * axial_stiffness(limb, modulus)
    if local:
        normal *= local_contact.series(feet.local_stiffness_ratio)
    viscous = feet.damping == "viscous"
    return Foot(
        normal,
        feet.tangential_ratio * normal,
        damping_ratio(label) if viscous else 0.0,
        1.0 if viscous else label**-2.0,
    )


def judge(case: Case) -> Effect:
    """Rule: on in space when the scene asks for it. The number is a ratio of stiffnesses."""
    scene, space = case.scene, case.model == "space"
    number = max(scene.contact.restitution, LEAST_LABEL) ** -2.0
    reason = f"feet.damping = {scene.feet.damping!r}" if space else f"the {case.model} model has rigid feet"
    on = space and scene.feet.damping == "hysteretic"
    return Effect(NAME, on, number, "stiffness of unloading over that of loading", reason, SWITCH)


RULE = Rule(judge, SWITCH, usual={SWITCH: "hysteretic"}, without={SWITCH: "viscous"})
