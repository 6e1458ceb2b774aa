"""Lane walls and a lid: edges of the body touch walls, and its upper corners a lid, that ride on the plate.

Both are as stiff as a foot's corner, with a friction and restitution of their own. Limits: a wide lane is the plane,
and edges touch at the height of the body's middle. A lid above every hop changes nothing, and legs, caps and mounted
parts pass through it.
"""

import math

from walkergen.core.errors import InputError
from walkergen.core.scene import GRAVITY, Arena
from walkergen.core.simulation.effects import turning
from walkergen.core.simulation.effects.effect import Case, Effect, Rule, absence_reason, apply_switch, decide_from_key

NAME, SWITCH = "lane walls", "lane_walls"
LID, LID_KEY = "lid", "arena.lid_mm"
"""Name of the lid, which is also its switch, and its key."""

DEFAULT_PLAY_MM = 0.5
"""Default gap of a lane over the depth of the body, mm."""

MIN_PLAY_RATIO = 4e-3
"""Least gap of a lane over the body's depth, over the walker's height: twice what the roll of its
first drop takes, so that it does not start inside a wall."""


DROP_AMPLITUDES, TILT_ALLOWANCE_RAD = 1.5, 2e-3
"""Space above a walker at its release: amplitudes that it drops, and twice its tilt by then, rad."""


def check_arena(case: Case) -> None:
    """Raise InputError for a plane that is smaller than the walker, or a lane that it does not fit in."""
    arena, body = case.scene.arena, case.design.body
    if arena.kind == "lane":
        decide(case)
    for key, size, needed, extent in (
        ("length_mm", arena.length_mm, body.length_mm, "long"),
        ("width_mm", arena.width_mm, body.depth_mm, "deep"),
    ):
        if arena.kind == "plane" and size is not None and size < needed:
            raise InputError(
                f"arena.{key} = {size:g}: must be at least {needed:g}, since the walker is "
                f"{needed:g} mm {extent}. Take a larger plane, or leave the key out (endless)"
            )


def gap(case: Case) -> float:
    """Return the distance between the lane's walls, mm. Raises InputError if the walker does not fit."""
    size, legs = case.design.size, case.design.limbs
    depth, wanted = size.depth, case.scene.arena.gap_mm
    if wanted is None:
        return depth + DEFAULT_PLAY_MM
    least = depth + MIN_PLAY_RATIO * (max(leg.length for leg in legs) + size.thickness)
    if wanted < least:
        raise InputError(
            f"arena.gap_mm = {wanted:g}: the walker is {depth:g} mm deep and needs {least:.6g} mm. "
            f"Widen the lane, or leave the key out ({depth + DEFAULT_PLAY_MM:g} mm)"
        )
    return wanted


def _check_headings(case: Case) -> None:
    """Raise InputError for an initial heading at which the body would cut into the walls."""
    size, headings, width = case.design.size, case.scene.run.heading_deg, gap(case)
    widest = [math.degrees(math.atan2(size.length, size.depth))]
    for heading in widest if headings == "uniform" else headings:
        turn = math.radians(heading)
        across = size.depth * abs(math.cos(turn)) + size.length * abs(math.sin(turn))
        if heading and across > width - MIN_PLAY_RATIO * size.length:
            words = headings if headings == "uniform" else list(headings)
            raise InputError(
                f"run.heading_deg = {words}: at {heading:.3g} deg the walker is {across:.4g} mm wide and the lane "
                f"{width:g} mm. Widen it (arena.gap_mm), or use arena.kind = 'plane'"
            )


def decide(case: Case) -> Effect:
    """Return the effect "lane walls": on if the walker may turn in a lane. Its number is the possible turn, rad."""
    arena, size = case.scene.arena, case.design.size
    meaning = "turn (rad) at which both walls are touched"
    if arena.kind != "lane":
        return Effect(NAME, False, 0.0, meaning, absence_reason(case, SWITCH, "the arena is a plane"), "")
    play = gap(case) - size.depth
    turn = min(play / size.length, 0.5 * math.pi)
    if not turning.decide(case).on:
        return Effect(NAME, False, turn, meaning, absence_reason(case, SWITCH, "the walker is held in its plane"), "")
    on, reason = apply_switch(case.scene.effects.forced_state(SWITCH), True, "the walker yaws")
    if on:
        _check_headings(case)
    return Effect(NAME, on, turn, meaning, reason, SWITCH)


RULE = Rule(decide, SWITCH, absent_values={"arena": Arena(kind="plane")}, typical_values={"arena.kind": "lane"})


def decide_lid(case: Case) -> Effect:
    """Return the effect "lid". Its number is a hop's height, at the plate's peak speed, over the space below the lid.

    Raises InputError where the walker does not fit.
    """
    meaning = "height of a hop over the room above the walker"
    on, reason = decide_from_key(case, LID_KEY, LID)
    wanted = case.scene.arena.lid_mm
    if wanted is None:
        return Effect(LID, on, 0.0, meaning, reason, LID)
    size, shaken = case.design.size, case.equivalent_drive
    height = 0.5 * size.thickness - min(limb.foot_height for limb in case.design.limbs)
    least = height + DROP_AMPLITUDES * shaken.amplitude + TILT_ALLOWANCE_RAD * max(size.length, size.depth)
    if on and wanted < least:
        raise InputError(
            f"{LID_KEY} = {wanted:g}: the walker is {height:g} mm high and needs {least:.6g} mm to start. "
            "Raise the lid, or leave the key out for an open top"
        )
    hop = shaken.peak_speed**2 / (2.0 * GRAVITY)
    return Effect(LID, on, hop / max(wanted - height, 1e-9), meaning, reason, LID)


LID_RULE = Rule(decide_lid, LID, absent_values={LID_KEY: None})
