"""Local contact stiffness: the tip of a foot gives as well, in series with its leg.

Its stiffness is that of the leg's corner times a ratio of the scene, and lowers the whole to
ratio / (1 + ratio). Limit: an infinite ratio (the key left out) is the leg alone.
"""

from walkergen.simulation.effects.effect import Case, Effect, Rule, absent, called_for

NAME, SWITCH, KEY = "local contact stiffness", "effects.local_stiffness", "feet.local_stiffness_ratio"


def judge(case: Case) -> Effect:
    """Rule: on when the scene gives its ratio. The number is the part of the stiffness left."""
    ratio, meaning = case.scene.feet.local_stiffness_ratio, "stiffness of a corner over its leg's"
    if case.model != "space":
        why = absent(case, SWITCH, f"the {case.model} model has rigid feet")
        return Effect(NAME, False, series(ratio), meaning, why, SWITCH)
    on, reason = called_for(case, KEY, SWITCH)
    return Effect(NAME, on, series(ratio), meaning, reason, SWITCH)


RULE = Rule(judge, SWITCH, planar=False, usual={KEY: 1.0})


def series(ratio: float | None) -> float:
    """Stiffness of leg and local contact over that of the leg alone."""
    return 1.0 if ratio is None else ratio / (1.0 + ratio)
