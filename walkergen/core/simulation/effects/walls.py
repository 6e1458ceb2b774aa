"""Lane walls: the four upright edges of the body touch walls that ride on the plate.

A wall is as stiff as a foot's corner, with its own friction and restitution (a label, as that of
viscous feet). Limits: a wide lane is the plane; edges touch at the height of the body's middle.
"""

import math

from walkergen.core.errors import InputError
from walkergen.core.scene import Arena
from walkergen.core.simulation.effects import turning
from walkergen.core.simulation.effects.effect import WALLS, Case, Effect, Rule, absence_reason, apply_switch

NAME, SWITCH = WALLS, "lane_walls"

DEFAULT_PLAY_MM = 0.5
"""Default gap of a lane over the depth of the body, mm."""

MIN_PLAY_RATIO = 4e-3
"""Least gap of a lane over the body's depth, over the walker's height: twice what the roll of its
first drop takes, so that it does not start inside a wall."""


def gap(case: Case) -> float:
    """Return the distance of the walls, mm. Raises InputError if the walker does not fit."""
    size, legs = case.design.size, case.design.limbs
    depth, wanted = size.depth, case.scene.arena.gap_mm
    if wanted is None:
        return depth + DEFAULT_PLAY_MM
    least = depth + MIN_PLAY_RATIO * (max(leg.length for leg in legs) + size.thickness)
    if wanted < least:
        raise InputError(
            f"arena.gap_mm = {wanted:g}: the walker is {depth:g} mm deep and needs {least:.6g} mm; "
            f"widen the lane, or leave the key out ({depth + DEFAULT_PLAY_MM:g} mm)"
        )
    return wanted


def _check_headings(case: Case) -> None:
    """Raise InputError for a heading at which a run would start inside the walls."""
    size, wanted, room = case.design.size, case.scene.run.heading_deg, gap(case)
    widest = [math.degrees(math.atan2(size.length, size.depth))]
    for heading in widest if wanted == "uniform" else wanted:
        turn = math.radians(heading)
        across = size.depth * abs(math.cos(turn)) + size.length * abs(math.sin(turn))
        if heading and across > room - MIN_PLAY_RATIO * size.length:
            words = wanted if wanted == "uniform" else list(wanted)
            raise InputError(
                f"run.heading_deg = {words}: at {heading:.3g} deg the walker is {across:.4g} mm wide and the lane "
                f"{room:g} mm; widen it (arena.gap_mm), or use arena.kind = 'plane'"
            )


def judge(case: Case) -> Effect:
    """Judge the effect: on in a lane that the walker may turn in. The number is the turn it allows, rad."""
    arena, size = case.scene.arena, case.design.size
    meaning = "turn (rad) at which both walls are touched"
    if arena.kind != "lane":
        return Effect(NAME, False, 0.0, meaning, absence_reason(case, SWITCH, "the arena is a plane"), "")
    play = gap(case) - size.depth
    turn = min(play / size.length, 0.5 * math.pi)
    if not turning.judge(case).on:
        return Effect(NAME, False, turn, meaning, absence_reason(case, SWITCH, "the walker is held in its plane"), "")
    on, reason = apply_switch(case.scene.effects.forced_state(SWITCH), True, "the walker yaws")
    if on:
        _check_headings(case)
    return Effect(NAME, on, turn, meaning, reason, SWITCH)


RULE = Rule(judge, SWITCH, away={"arena": Arena(kind="plane")}, usual={"arena.kind": "lane"})
