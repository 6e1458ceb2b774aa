"""Lid: a second plane over the walker, which rides on the plate; the body's upper corners touch it.

It is as stiff as a foot's corner, with the friction and restitution of walls (a label, as that of viscous
feet). Limits: legs, caps and mounted parts pass through it; a lid above every hop changes nothing.
"""

from walkergen.core.errors import InputError
from walkergen.core.scene import GRAVITY
from walkergen.core.simulation.effects.effect import LID, Case, Effect, Rule, decide_from_key

NAME, SWITCH, KEY = LID, "lid", "arena.lid_mm"

DROP_AMPLITUDES, TILT_ALLOWANCE_RAD = 1.5, 2e-3
"""Room over a walker that is let go: amplitudes that it drops, and twice what it is tilted by then, rad."""


def judge(case: Case) -> Effect:
    """Judge the effect: on under a lid. The number is the height of a throw at the plate's peak speed over the room.

    Raises InputError where the walker does not fit.
    """
    meaning = "height of a hop over the room above the walker"
    on, reason = decide_from_key(case, KEY, SWITCH)
    wanted = case.scene.arena.lid_mm
    if wanted is None:
        return Effect(NAME, on, 0.0, meaning, reason, SWITCH)
    size, shaken = case.design.size, case.shaken
    height = 0.5 * size.thickness - min(limb.foot_height for limb in case.design.limbs)
    least = height + DROP_AMPLITUDES * shaken.amplitude + TILT_ALLOWANCE_RAD * max(size.length, size.depth)
    if on and wanted < least:
        raise InputError(
            f"{KEY} = {wanted:g}: the walker is {height:g} mm high and needs {least:.6g} mm to be let go; "
            "raise the lid, or leave the key out (open)"
        )
    hop = shaken.peak_speed**2 / (2.0 * GRAVITY)
    return Effect(NAME, on, hop / max(wanted - height, 1e-9), meaning, reason, SWITCH)


RULE = Rule(judge, SWITCH, away={KEY: None})
