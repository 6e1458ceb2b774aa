"""Hard cases: something to run, the models and methods to run it on, and what must hold."""

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
"""Pairs of every model with every method that it has."""

THREE_COORDINATES = EVERY[:2]
"""The event-driven plan without leg coordinates: instants in finite work, stands in one step."""

RIGID = EVERY[1:3]
COMPLIANT = EVERY[3:]
IMPACT_LAW: tuple[Pair, ...] = (("impact law", "closed form"),)
CASCADE: tuple[Pair, ...] = (("cascade", "event"),)
GEOMETRY: tuple[Pair, ...] = (("geometry", "solids"),)


class Check(NamedTuple):
    """Checked quantity: it holds when value <= limit (NaN does not hold)."""

    what: str
    value: float
    limit: float
    reason: str
    """Reason why the limit is not tighter."""

    @property
    def holds(self) -> bool:
        """True when the value is within its limit."""
        return bool(self.value <= self.limit)  # numpy's would be no JSON


class Case(NamedTuple):
    """Hard case, for every model and method to which it applies."""

    name: str
    section: str
    """Section of docs/physics.md ("6.7"), or "geometry"."""
    runs_on: tuple[Pair, ...]
    """Pairs of model and method on which the case runs."""
    check: Callable[[str, str], Iterator[Check]]
    """Function of model and method that yields the checks."""


def exactly(what: str, holds: bool, reason: str = "a matter of yes or no") -> Check:
    """Check of a fact: value 0 when it holds, else 1; limit 0."""
    return Check(what, 0.0 if holds else 1.0, 0.0, reason)
