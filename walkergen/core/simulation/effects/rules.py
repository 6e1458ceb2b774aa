"""Rules of effects: those that a scene may call for, and every one.

Walls, lid, noise, sway and motor are imported with the first scene that has them.
"""

from walkergen.core.simulation.effects import (
    air_drag,
    always_on,
    compliance,
    feet,
    harmonic,
    roughness,
    slope,
    tensor,
    turning,
    twist,
    unevenness,
)
from walkergen.core.simulation.effects.effect import (
    ALONG,
    GRADIENT,
    GYROSCOPIC,
    LID,
    MOTOR,
    NOISE,
    ROCKING,
    WALLS,
    Case,
    Rule,
)

COMMON_RULES: tuple[Rule, ...] = (
    tensor.RULE,
    compliance.RULE,
    Rule(always_on.judge_sticking),
    Rule(always_on.judge_sustained_contact),
    Rule(always_on.judge_pitch),
    harmonic.RULE,
    slope.RULE,
    turning.RULE,
    twist.RULE,
    feet.RULE,
    unevenness.RULE,
    roughness.RULE,
    Rule(always_on.judge_neighbours),
    air_drag.RULE,
)
"""Rules that are judged in every scene, in the order that `explain` shows."""

RARE_EFFECTS = (WALLS, LID, NOISE, ALONG, GRADIENT, ROCKING, MOTOR, GYROSCOPIC)
"""Names of the effects of all other rules."""


def applicable_rules(case: Case) -> tuple[Rule, ...]:
    """Return the rules that are judged in a case."""
    scene, rules, on = case.scene, list(COMMON_RULES), set(case.scene.effects.on)
    if scene.arena.kind == "lane" or "lane_walls" in on:
        from walkergen.core.simulation.effects import walls

        rules.append(walls.RULE)
    if scene.arena.lid_mm or "lid" in on:
        from walkergen.core.simulation.effects import lid

        rules.append(lid.RULE)
    if scene.plate.noise_ratio or "plate_noise" in on:
        from walkergen.core.simulation.effects import noisy_plate

        rules.append(noisy_plate.RULE)
    if scene.plate.sways or on & {"plate_along", "plate_gradient", "plate_rocking"}:
        from walkergen.core.simulation.effects import swaying_plate

        rules += swaying_plate.RULES
    if scene.drive.kind == "motor" or "gyroscopic_torque" in on:
        from walkergen.core.simulation.effects import motor

        rules += [motor.RULE, motor.SPIN_RULE]
    return tuple(rules)


def all_rules() -> tuple[Rule, ...]:
    """Return all rules, also of effects outside the scene."""
    from walkergen.core.simulation.effects import lid, motor, noisy_plate, swaying_plate, walls

    return (*COMMON_RULES, walls.RULE, lid.RULE, noisy_plate.RULE, *swaying_plate.RULES, motor.RULE, motor.SPIN_RULE)
