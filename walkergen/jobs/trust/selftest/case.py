"""Hard cases: something to run, the models to run it on, and what must hold."""

from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

from walkergen.simulation.effects import effect

SPACE, IMPACT_LAW, GEOMETRY = ("space",), ("impact law",), ("geometry",)

METHODS: Mapping[str, str] = {**effect.METHODS, "impact law": "closed form", "geometry": "solids"}
"""Methods of what cases run on: of models, and of parts of them."""


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
    """Hard case, for every model to which it applies."""

    name: str
    section: str
    """Section of docs/physics.md ("6.4"), or "geometry"."""
    source: str
    """Where the right value comes from, outside this code: a law, a closed form, a publication."""
    runs_on: tuple[str, ...]
    """Models on which the case runs, or parts of them."""
    check: Callable[[str], Iterator[Check]]
    """Function of the model that yields the checks."""


def exactly(what: str, holds: bool, reason: str = "a matter of yes or no") -> Check:
    """Check of a fact: value 0 when it holds, else 1; limit 0."""
    return Check(what, 0.0 if holds else 1.0, 0.0, reason)
