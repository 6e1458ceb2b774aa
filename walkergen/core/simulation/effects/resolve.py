"""Effects that are simulated in a scene, by their rules, and keys of the scene that no simulated effect reads."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from walkergen.core.errors import InputError
from walkergen.core.scene import DEPENDENT_KEYS, Scene, forced_effect_line
from walkergen.core.simulation.effects import turning, walls
from walkergen.core.simulation.effects.active_effects import (
    RARE_EFFECTS,
    Acting,
    acting_parameters,
    all_rules,
    applicable_rules,
)
from walkergen.core.simulation.effects.effect import Case, Effect

WALL_KEYS = ("arena.wall_friction", "arena.wall_restitution")
FOOT_KEYS = ("contact.restitution", "contact.friction")


class Resolved(NamedTuple):
    """Effects on a walker in a scene, simulated or not, with their parameters."""

    effects: tuple[Effect, ...]
    acting: Acting
    idle: str = ""
    """Line on keys that the scene gives and its simulation does not use; "" if it uses all."""

    def is_on(self, name: str) -> bool:
        """Return whether the effect `name` is simulated. Raises KeyError for an unknown name."""
        return _effect_states(self.effects)[name]


def _effect_states(effects: Sequence[Effect]) -> dict[str, bool]:
    """Return by name whether each effect is on. Rare effects that are not among `effects` are off."""
    return dict.fromkeys(RARE_EFFECTS, False) | {effect.name: effect.on for effect in effects}


def resolve(case: Case) -> Resolved:
    """Return the effects on a walker in a scene: which are simulated, their parameters, and keys without use.

    Raises InputError where the scene's choices contradict each other or the design.
    """
    walls.check_arena(case)
    effects = tuple(rule.decide(case) for rule in applicable_rules(case))
    on = _effect_states(effects)
    _check_headings(case.scene, on[turning.NAME])
    return Resolved(effects, acting_parameters(case, on), describe_idle_keys(case, on))


def without_plate_effects(scene: Scene) -> Scene:
    """Return the scene without the effects whose rules have `absent_values`: walls, lid, slope, noise and others."""
    for rule in all_rules():
        if rule.absent_values:
            scene = replace_without_validation(scene, {**rule.absent_values, f"effects.{rule.switch}": None})
    return scene


def replace_without_validation(scene: Scene, values: Mapping[str, Any]) -> Scene:
    """Return the scene with other values of tables or keys, which were validated before.

    The key effects.NAME forces the effect NAME on (True) or off (False), or leaves it to the scene (None).
    """
    for key, value in values.items():
        table, _, name = key.partition(".")
        if table == "effects":
            changed: Any = scene.effects.force(name, value)
        else:
            changed = getattr(scene, table).model_copy(update={name: value}) if name else value
        scene = scene.model_copy(update={table: changed})
    return scene


def _check_headings(scene: Scene, can_turn: bool) -> None:
    """Raise InputError if the scene gives initial headings to a walker that is held in its plane."""
    headings = scene.run.heading_deg
    words = headings if headings == "uniform" else list(headings)
    if (headings == "uniform" or any(headings)) and not can_turn:
        raise InputError(
            f"run.heading_deg = {words}: {forced_effect_line(turning.SWITCH, False)} holds the walker in its "
            "plane along x. Leave one of them out"
        )


def describe_idle_keys(case: Case, on: Mapping[str, bool]) -> str:
    """Return a line on keys that a scene sets and its simulation does not use; "" without any.

    Standard deviations, and keys of other commands or of effects that are switched off (`on`), are not reported.
    """
    keys_by_reason: dict[str, list[str]] = {}
    for key, reason in _find_idle_keys(case, on):
        table, _, name = key.partition(".")
        section = getattr(case.scene, table)
        if name in section.model_fields_set and getattr(section, name) != type(section).model_fields[name].default:
            keys_by_reason.setdefault(reason, []).append(key)
    listed = "; ".join(f"{', '.join(keys)} ({reason})" for reason, keys in keys_by_reason.items())
    return f"not used here: {listed}" if listed else ""


def _find_idle_keys(case: Case, on: Mapping[str, bool]) -> Iterator[tuple[str, str]]:
    """Yield the scene's keys that the simulation does not read, each with the reason, even keys that are not given."""
    scene, limbs = case.scene, case.design.limbs
    if case.design.rigid:
        yield "legs.damping_ratio", "no leg swings"
    for number, keys in DEPENDENT_KEYS.items():
        if scene.is_zero(number):
            yield from ((key, f"{number} = 0") for key in keys)
    if not on[walls.NAME] and walls.SWITCH not in scene.effects.off:
        yield "arena.gap_mm", "no walls"
        if not on[walls.LID]:
            yield from ((key, "no walls") for key in WALL_KEYS)
    for key in FOOT_KEYS:
        if all(getattr(limb, key.partition(".")[2]) is not None for limb in limbs):
            yield key, "every leg has its own"
