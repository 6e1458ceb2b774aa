"""Flexible foot tensor: the legs' joints carry force but no torque in an impact (paper, eqs 8-12).

Limit: locked joints give the tensor of one rigid body (paper, eq. 4).
"""

from walkergen.core.simulation.effects.effect import Case, Effect, Rule

NAME = "flexible foot tensor"


def judge(case: Case) -> Effect:
    """Judge the effect: on for flexible legs. The number is m/M."""
    if case.design.rigid:
        return Effect(NAME, False, 0.0, f"legs are {case.design.kind}", "the rigid tensor is exact", "")
    heaviest = max(float(leg.m) for leg in case.mass.legs)
    ratio, meaning = heaviest / float(case.mass.M), "mass of a leg over the body's"
    return Effect(NAME, True, ratio, meaning, "part of the chain of body and legs", "")


RULE = Rule(judge)
