"""Why a dense crowd in space is not that of the plane: it runs again in both, changed in one thing at a time."""

from collections.abc import Mapping
from functools import partial
from typing import NamedTuple

from evidence.crowd_checks import crowds, setting
from evidence.crowd_checks.parts import Parts
from evidence.crowd_checks.setting import PACKINGS, Size
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties
from walkergen.guests.crowd.cards.card import Card

DENSEST = max(PACKINGS)


class Change(NamedTuple):
    """One thing that is changed: keys of a scene's [crowd] in space and of the card in the plane."""

    name: str
    space: Mapping[str, float]
    """Empty: it is changed in the plane alone."""
    plane: Mapping[str, float]


CHANGES = (
    Change("bodies do not rub", {"friction": 0.0}, {"friction": 0.0}),
    Change("hits give little back", {"restitution": 0.1}, {"restitution": 0.1}),
    Change("the plane rubs five times as much", {}, {"friction": 0.9}),
)
"""Changes, each alone. In a plane bodies rub along their faces only, in space up and down them too."""


class Changed(NamedTuple):
    """Speeds of the densest crowd with a change, mm/s."""

    name: str
    space: Quantity | None
    """None: changed in the plane alone."""
    plane: Quantity


def measure_changes(size: Size, parts: Parts, design: Design, mass: MassProperties, card: Card) -> list[Changed]:
    """Speeds of the densest crowd with each change."""
    found = []
    for change in CHANGES:
        space = None
        if change.space:
            keys = {f"crowd.{key}": value for key, value in change.space.items()}
            crowd = partial(crowds.simulate_in_space, size, design, mass, card, DENSEST, size.changed_runs, **keys)
            space = parts.load_or_make(f"space, {change.name}", crowd).numbers["speed"]
        other = card.model_copy(update=change.plane)
        flat = partial(crowds.simulate_in_plane, size, other, DENSEST, setting.PLANE_RUNS_PER_RUN * size.changed_runs)
        plane = parts.load_or_make(f"plane, {change.name}", flat)
        found.append(Changed(change.name, space, plane.numbers["speed"]))
    return found
