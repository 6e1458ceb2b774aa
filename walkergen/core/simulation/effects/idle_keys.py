"""Idle keys: keys that a scene gives and its simulation does not read, reported in one line."""

from collections.abc import Callable, Iterator

from walkergen.core.scene import DEPENDENT_KEYS
from walkergen.core.simulation.effects.effect import LID, WALLS, Case

WALL_KEYS = ("arena.wall_friction", "arena.wall_restitution")
FOOT_KEYS = ("contact.restitution", "contact.friction")


def describe_idle_keys(case: Case, on: Callable[[str], bool]) -> str:
    """Return a line on a scene's non-default keys that have no part in a case; "" without any.

    Keys of an effect switched off are not reported. Keys of other jobs, and standard
    deviations, do not concern a single simulation.
    """
    given: dict[str, list[str]] = {}
    for key, why in _find_idle_keys(case, on):
        table, _, own = key.partition(".")
        section = getattr(case.scene, table)
        if own in section.model_fields_set and getattr(section, own) != type(section).model_fields[own].default:
            given.setdefault(why, []).append(key)
    told = "; ".join(f"{', '.join(keys)} ({why})" for why, keys in given.items())
    return f"no part here: {told}" if told else ""


def _find_idle_keys(case: Case, on: Callable[[str], bool]) -> Iterator[tuple[str, str]]:
    """Yield the keys that a case does not read, each with the reason, whether the scene gives them or not."""
    scene, limbs = case.scene, case.design.limbs
    if case.design.rigid:
        yield "legs.damping_ratio", "no leg swings"
    for number, keys in DEPENDENT_KEYS.items():
        if not scene.value(number):
            yield from ((key, f"{number} = 0") for key in keys)
    if not on(WALLS) and "lane_walls" not in scene.effects.off:
        yield "arena.gap_mm", "no walls"
        if not on(LID):
            yield from ((key, "no walls") for key in WALL_KEYS)
    for key in FOOT_KEYS:
        if all(getattr(limb, key.partition(".")[2]) is not None for limb in limbs):
            yield key, "every leg has its own"
