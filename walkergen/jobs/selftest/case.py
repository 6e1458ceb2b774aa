"""What a hard case is: something to run, on which models and methods, and what must hold."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

Pair = tuple[str, str]

EVERY: tuple[Pair, ...] = (
    ("relaxed", "event"),
    ("rigid", "event"),
    ("rigid", "step"),
    ("compliant", "event"),
    ("compliant", "step"),
)
"""Every model with every method that it has."""

THREE_COORDINATES = EVERY[:2]
"""The event-driven plan without leg coordinates: instants in finite work, stands in one step."""

RIGID = EVERY[1:3]
COMPLIANT = EVERY[3:]
IMPACT_LAW: tuple[Pair, ...] = (("impact law", "closed form"),)
CASCADE: tuple[Pair, ...] = (("cascade", "event"),)
GEOMETRY: tuple[Pair, ...] = (("geometry", "solids"),)


class Check(NamedTuple):
    """One thing checked: it holds when value <= limit (NaN does not)."""

    what: str
    value: float
    limit: float
    reason: str
    """Of the limit: why it is not tighter."""

    @property
    def holds(self) -> bool:
        """True when the value is within its limit."""
        return self.value <= self.limit


class Case(NamedTuple):
    """One hard case, over every model and method to which it applies."""

    name: str
    section: str
    """Number in physics.md ("6.7"), or "geometry"."""
    runs_on: tuple[Pair, ...]
    """(model, method)."""
    check: Callable[[str, str], Iterator[Check]]
    """check(model, method) -> what was checked, with how much room."""


def exactly(what: str, holds: bool, reason: str = "a matter of yes or no") -> Check:
    """A check of a fact: value 0 when it holds and 1 when not, limit 0."""
    return Check(what, 0.0 if holds else 1.0, 0.0, reason)
