"""Rules of effects: whether a scene calls for each, and the number that decides."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from walkergen.core.drive import Drive
from walkergen.core.errors import InputError
from walkergen.core.scene import Scene, forced_effect_line
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties


class Case(NamedTuple):
    """Scene and walker for which a rule decides on an effect."""

    scene: Scene
    design: Design
    mass: MassProperties

    @property
    def equivalent_drive(self) -> Drive:
        """Drive of the plate. For a walker with a motor: the drive of a plate that would move it in the same way."""
        return self.scene.drive.equivalent_plate_drive(float(self.mass.total))


class Effect(NamedTuple):
    """Effect on a walker in a scene: whether it is simulated, and the number that decides."""

    name: str
    on: bool
    number: float
    """Dimensionless number that decides."""
    meaning: str
    """Description of the number."""
    reason: str
    """Why the effect is on or off."""
    switch: str
    """Name in effects.on and effects.off, or key of the scene, that forces it; "" when nothing does."""


class Rule(NamedTuple):
    """Function that decides whether an effect is simulated, and the effect's keys in a scene."""

    decide: Callable[[Case], Effect]
    """Function that decides on the effect. Raises InputError where the scene contradicts itself or the design."""
    switch: str = ""
    """Name in effects.on and effects.off, or key of the scene, that forces it."""
    absent_values: Mapping[str, Any] = MappingProxyType({})
    """Values of the scene's keys that exclude it from a still plate, such as a bench's; empty if it remains."""
    typical_values: Mapping[str, Any] = MappingProxyType({})
    """Values of keys that give an effect that is off its usual size; empty if it has none."""
    off_values: Mapping[str, Any] = MappingProxyType({})
    """Values of keys that switch it off; empty if its switch in effects.off does."""

    @property
    def off(self) -> Mapping[str, Any]:
        """Values of the scene's keys that switch the effect off. Empty for an effect that cannot be switched."""
        return self.off_values or ({f"effects.{self.switch}": False} if self.switch else {})


def decide_from_key(case: Case, key: str, switch: str) -> tuple[bool, str]:
    """Return whether an effect is on, and why: on if the scene's `key` is not zero, or as `switch` forces.

    `switch` is the effect's name in effects.on and effects.off. Raises InputError if it is forced on with `key` zero.
    """
    is_zero, reason = case.scene.is_zero(key), describe_number(case.scene, key)
    if is_zero:
        absence_reason(case, switch, f"{reason}, so it would change nothing: set it")
    return apply_switch(case.scene.effects.forced_state(switch), not is_zero, reason)


def describe_number(scene: Scene, key: str) -> str:
    """Return a key of the scene with its value as text, such as "plate.slope_deg = 2"."""
    value = scene.value(key)
    if isinstance(value, list):
        return f"{key} = [{', '.join(f'{number:g}' for number in value)}]"
    return f"{key} is not given" if value is None else f"{key} = {value:g}"


def absence_reason(case: Case, switch: str, why: str) -> str:
    """Return `why`, the reason why an effect is off. Raises InputError with it if the scene forces the effect on."""
    if case.scene.effects.forced_state(switch):
        raise InputError(f"{forced_effect_line(switch, True)}: {why}. Remove {switch} from effects.on.")
    return why


def apply_switch(forced: bool | None, default: bool, reason: str) -> tuple[bool, str]:
    """Return whether an effect is on, and why: `forced`, or `default` with its `reason` if `forced` is None."""
    if forced is None:
        return default, reason
    return forced, f"forced {'on' if forced else 'off'}; otherwise: {reason}"
