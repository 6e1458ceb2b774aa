"""An effect as a verdict: whether a scene calls for it, and by which number."""

from typing import Literal, NamedTuple

from walkergen.scene import Scene
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

ModelName = Literal["rigid", "relaxed", "compliant"]


class Case(NamedTuple):
    """What a verdict is made of."""

    scene: Scene
    design: Design
    mass: MassProperties
    model: ModelName
    """Model of the legs that the scene has been found to call for."""


class Effect(NamedTuple):
    """One effect, its size in a scene, and the verdict on it."""

    name: str
    on: bool
    number: float
    """Dimensionless number that decides."""
    meaning: str
    """What the number is."""
    reason: str
    """Why the effect is on or off."""
    switch: str
    """Key of the scene that forces the effect; "" when nothing does."""


def forced(wanted: bool | None, decided: bool, reason: str) -> tuple[bool, str]:
    """Verdict and reason after the scene's switch, which overrules what was decided."""
    if wanted is None:
        return decided, reason
    return wanted, f"forced {'on' if wanted else 'off'}; otherwise: {reason}"
