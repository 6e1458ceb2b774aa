"""Hard cases: a function to run, conditions that must hold, and the common way to run them."""

import time
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

SPACE, IMPACT_LAW, GEOMETRY = "space", "impact law", "geometry"
"""Subjects of the cases: the model in space, and parts of it."""


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
    """Hard case."""

    name: str
    section: str
    """Section of docs/physics.md ("6.4"), or "geometry"."""
    source: str
    """Source of the right value, outside this code: a law, a closed form, a publication."""
    on: str
    """Subject of the case: SPACE, IMPACT_LAW or GEOMETRY."""
    check: Callable[[], Iterator[Check]]
    """Function that yields the checks."""


class Result(NamedTuple):
    """Result of a case."""

    section: str
    case: str
    source: str
    on: str
    checks: tuple[Check, ...]
    """Checks that were made before an error, or all of them."""
    error: str
    """Error that the case raised, in one line; empty if it finished."""
    seconds: float

    @property
    def failing(self) -> list[Check]:
        """Checks that do not hold."""
        return [check for check in self.checks if not check.holds]

    @property
    def holds(self) -> bool:
        """True when the case finished and all its checks hold."""
        return not (self.error or self.failing)


def make_result(case: Case, checks: Sequence[Check], error: str, seconds: float) -> Result:
    """Return the result of a case from its checks."""
    return Result(case.section, case.name, case.source, case.on, tuple(checks), error, seconds)


def run_case(case: Case) -> Result:
    """Run a case; an error that it raises is reported as its failure."""
    started, checks, error = time.perf_counter(), list[Check](), ""
    try:
        checks.extend(case.check())
    except Exception as raised:  # any error at all: the table must name it
        error = f"{type(raised).__name__}: {' '.join(str(raised).split())}"
    if not (checks or error):
        error = "it checked nothing"
    return make_result(case, checks, error, time.perf_counter() - started)


def check_fact(what: str, holds: bool, reason: str = "a matter of yes or no") -> Check:
    """Return the check of a fact: value 0 when it holds, else 1; limit 0."""
    return Check(what, 0.0 if holds else 1.0, 0.0, reason)
