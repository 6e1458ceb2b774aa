"""Local contact stiffness: the tip of a foot gives as well, in series with its leg.

Its stiffness is that of the leg's corner times a ratio of the scene, and lowers the whole to
ratio / (1 + ratio). Limit: an infinite ratio (the key left out) is the leg alone.
"""

from walkergen.simulation.effects.effect import Case, Effect, forced

NAME, SWITCH = "local contact stiffness", "effects.local_stiffness"


def judge(case: Case) -> Effect:
    """Rule: on when the scene gives its ratio. The number is the part of the stiffness left."""
    ratio = case.scene.feet.local_stiffness_ratio
    reason = "feet.local_stiffness_ratio is " + ("not given" if ratio is None else "given")
    on, reason = forced(case.scene.effects.local_stiffness, ratio is not None, reason)
    on = on and ratio is not None and case.model == "space"
    if case.model != "space":
        reason = f"the {case.model} model has rigid feet"
    return Effect(NAME, on, series(ratio), "stiffness of a corner over its leg's", reason, SWITCH)


def series(ratio: float | None) -> float:
    """Stiffness of leg and local contact over that of the leg alone."""
    return 1.0 if ratio is None else ratio / (1.0 + ratio)
