"""Effects on a walker: their rules, the parameters of those that act, and their total force.

A new effect is a file of its own, its line in the rules, and three below: field, parameters, `+`.
"""

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

from walkergen.core.numerics.kernels import kernel, lean
from walkergen.core.scene import Scene
from walkergen.core.simulation.effects import (
    air_drag,
    always_on,
    feet,
    harmonic,
    legs,
    motor,
    noise,
    roughness,
    slope,
    sway,
    turning,
    walls,
)
from walkergen.core.simulation.effects.air_drag import Air
from walkergen.core.simulation.effects.effect import Case, Rule
from walkergen.core.simulation.effects.motor import Rotor
from walkergen.core.simulation.effects.noise import Noise
from walkergen.core.simulation.effects.roughness import Roughness
from walkergen.core.simulation.effects.slope import Gravity
from walkergen.core.simulation.effects.sway import Sway

COMMON_RULES: tuple[Rule, ...] = (
    Rule(legs.decide_tensor),
    Rule(legs.decide_compliance),
    Rule(always_on.decide_sticking),
    Rule(always_on.decide_sustained_contact),
    Rule(always_on.decide_pitch),
    harmonic.RULE,
    slope.RULE,
    turning.RULE,
    legs.TWIST_RULE,
    feet.RULE,
    feet.UNEVENNESS_RULE,
    roughness.RULE,
    Rule(always_on.decide_neighbours),
    air_drag.RULE,
)
"""Rules that apply to every scene, in the order that `explain` shows."""

RARE_RULES: tuple[tuple[Callable[[Scene], object], tuple[Rule, ...]], ...] = (
    (lambda scene: scene.arena.kind == "lane", (walls.RULE,)),
    (lambda scene: scene.arena.lid_mm, (walls.LID_RULE,)),
    (lambda scene: scene.plate.noise_ratio, (noise.RULE,)),
    (lambda scene: scene.plate.sways, sway.RULES),
    (lambda scene: scene.drive.kind == "motor", motor.RULES),
)
"""Rules that apply only to scenes that meet a condition, or force one of them on."""

RARE_EFFECTS = (walls.NAME, walls.LID, noise.NAME, *sway.NAMES, motor.NAME, motor.GYROSCOPIC)
"""Names of the effects of these rules."""


def applicable_rules(case: Case) -> tuple[Rule, ...]:
    """Return the rules of effects that a scene and walker may have: common ones, and rare ones that the scene needs."""
    scene, forced = case.scene, {*case.scene.effects.on}
    needed = [rules for is_met, rules in RARE_RULES if is_met(scene) or forced & {rule.switch for rule in rules}]
    return (*COMMON_RULES, *(rule for rules in needed for rule in rules))


def all_rules() -> tuple[Rule, ...]:
    """Return the rules of all effects, common and rare."""
    return (*COMMON_RULES, *(rule for _, rules in RARE_RULES for rule in rules))


_drag = air_drag.force_in_space


class Acting(NamedTuple):
    """Parameters of the effects that act on a walker in motion.

    Those of an effect that is off are neutral: a comparison skips its branch, so that no switch of
    an effect needs machine code of its own.
    """

    gravity: Gravity
    air: Air = air_drag.OFF
    noise: Noise = noise.OFF
    """Noise of one run, which draws it."""
    roughness: Roughness = roughness.OFF
    """Surface of one run, which draws it."""
    sway: Sway = sway.OFF
    """Horizontal motion of the plate, and its differences in height from point to point."""
    motor: Rotor = motor.OFF


def acting_parameters(case: Case, on: Mapping[str, bool]) -> Acting:
    """Return the parameters of all effects on a walker. `on`: by name, whether simulated; others have no influence."""
    return Acting(
        slope.gravity_of(math.radians(case.scene.plate.slope_deg) if on[slope.NAME] else 0.0),
        air_drag.parameters(case) if on[air_drag.NAME] else air_drag.OFF,
        sway=sway.parameters(case, on),
        motor=motor.parameters(case, on[motor.GYROSCOPIC], on[turning.NAME]) if on[motor.NAME] else motor.OFF,
    )


@kernel
def gravity_along(acting: Acting) -> float:
    """Return the component of gravity along the plate, toward +x, mm/s^2."""
    return acting.gravity.along


@kernel
def gravity_into(acting: Acting) -> float:
    """Return the component of gravity into the plate, mm/s^2, positive."""
    return acting.gravity.into


@lean
def force_in_space(acting, velocity):
    """Return the force (g mm/s^2) of air drag on a body moving at `velocity` (mm/s), both in body axes."""
    return _drag(acting.air, velocity)
