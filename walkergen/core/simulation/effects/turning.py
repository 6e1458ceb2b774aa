"""Roll and yaw: motion out of the plane, and across it, with its corners landing one by one.

Limit: a walker held in its plane lands on both corners of a foot simultaneously (docs/physics.md
section 7, which shows that the plane is not the limit of small roll).
"""

from walkergen.core.simulation.effects.effect import Case, Effect, Rule, apply_switch

NAME, SWITCH = "yaw and roll", "roll_and_yaw"


def decide(case: Case) -> Effect:
    """Return the effect "yaw and roll": on unless forced off. Its number is the body's depth over contact spacing."""
    depth = case.design.size.depth / case.design.foot_span
    meaning = "depth over contact spacing"
    reason = "a foot is an edge: one of its corners lands first"
    on, reason = apply_switch(case.scene.effects.forced_state(SWITCH), True, reason)
    return Effect(NAME, on, depth, meaning, reason, SWITCH)


RULE = Rule(decide, SWITCH, typical_values={f"effects.{SWITCH}": True})
