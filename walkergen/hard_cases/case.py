"""What a hard case is: something checked, its value, the limit it must keep, and why that limit."""

from collections.abc import Callable, Iterator
from typing import NamedTuple


class Check(NamedTuple):
    """One thing checked: it holds when value <= limit (NaN does not)."""

    what: str
    value: float
    limit: float
    reason: str
    """Of the limit: why it is not tighter."""


class Case(NamedTuple):
    """One hard case, over every model and method to which it applies."""

    name: str
    section: str
    runs_on: tuple[tuple[str, str], ...]
    check: Callable[[str, str], Iterator[Check]]
