"""Flexible foot tensor: the legs' joints carry force but no torque in an impact (paper, eqs 8-12).

Limit: locked joints (legs.model = "rigid") give the tensor of one rigid body (paper, eq. 4).
"""

from walkergen.simulation.effects.effect import Case, Effect, Rule

NAME, SWITCH = "flexible foot tensor", "legs.model"


def judge(case: Case) -> Effect:
    """Rule: on for flexible legs unless their model is rigid. The number is m/M."""
    if case.design.rigid:
        return Effect(NAME, False, 0.0, f"legs are {case.design.kind}", "the rigid tensor is exact", "")
    heaviest = max(float(leg.m) for leg in case.mass.legs)
    ratio, meaning = heaviest / float(case.mass.M), "mass of a leg over the body's"
    if case.model in ("compliant", "space"):
        return Effect(NAME, True, ratio, meaning, "part of the chain of body and legs", "")
    on = case.model != "rigid"
    reason = "legs are flexible" if on else "legs.model = 'rigid'"
    return Effect(NAME, on, ratio, meaning, reason, SWITCH)


RULE = Rule(judge, SWITCH, without={SWITCH: "rigid"})
