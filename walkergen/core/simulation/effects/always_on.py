"""Effects that no key switches; their numbers show how much they matter."""

import math

from walkergen.core.simulation.effects.effect import Case, Effect
from walkergen.core.theory.tensors import foot_tensors

RARE_CONTACT_GAMMA = 50.0
"""Peak acceleration over g above which feet hardly rest on the plate."""


def decide_sticking(case: Case) -> Effect:
    """Return the effect "sticking in impacts" (docs/physics.md section 3): on if friction can hold a foot."""
    friction = case.scene.contact.friction
    ratios = [
        (friction if limb.friction is None else limb.friction) * float(H.xx) / abs(float(H.xy))
        if H.xy != 0.0
        else math.inf
        for limb, H in zip(case.design.limbs, foot_tensors(case.mass), strict=True)
    ]
    on = max(ratios) >= 1.0
    reason = "friction can hold a foot" if on else "feet always slide on in single impacts"
    meaning = "friction over |H_xy|/H_xx, the largest of all feet"
    number = min(max(ratios), 1e9)  # infinite for an upright leg: written as a large number
    return Effect("sticking in impacts", on, number, meaning, reason, "")


def decide_sustained_contact(case: Case) -> Effect:
    """Return the effect "sustained contact", always on. Its number is the plate's peak acceleration over g."""
    gamma = case.equivalent_drive.peak_gamma
    reason = "bounces die out and feet rest on the plate" if gamma < RARE_CONTACT_GAMMA else "rare at this drive"
    return Effect("sustained contact", True, gamma, "peak acceleration over g", reason, "")


def decide_pitch(case: Case) -> Effect:
    """Return the effect "pitch" (turning in side view), always on. Its number is foot spacing over body length."""
    number = case.design.foot_span / case.design.size.length
    return Effect("pitch", True, number, "contact spacing over body length", _format_foot_count(case), "")


def _format_foot_count(case: Case) -> str:
    """Return the number of feet in words, such as "two feet"."""
    count = len(case.design.limbs)
    return {1: "one foot", 2: "two feet"}.get(count, f"{count} feet")


def decide_neighbours(case: Case) -> Effect:
    """Return the effect "neighbours", always off here. Number: how far feet stick out of the body, over its length."""
    size, overhang = case.design.size, 0.0
    for limb in case.design.limbs:
        ahead = abs(limb.anchor[0] - limb.length * math.sin(limb.tilt)) - 0.5 * size.length
        aside = abs(limb.across) + 0.5 * limb.width - 0.5 * size.depth
        overhang = max(overhang, ahead, aside)
    meaning = "how far feet stick out of the body's box, over its length: legs would touch above 0"
    reason = "one walker alone; `walkergen crowd` lets bodies meet, not legs"
    return Effect("neighbours", False, overhang / size.length, meaning, reason, "")
