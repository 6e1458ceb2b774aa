"""Predictions for published walkers, over all values that their authors do not state.

A draw is a walker and a plate with values for all unstated inputs. It runs at each point of the sweep's grid.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from evidence.walkers_published.published import Statement
from walkergen.core.numerics import Array

Speeds = Mapping[tuple[tuple[str, Any], ...], float | None]
"""Speed of a draw, mm/s, at each point of the grid; None where it does not run."""

QUANTILES = (0.025, 0.5, 0.975)
"""Shares of the draws below the low bound, the median and the high bound."""

MIN_DRAWS = 40
"""Smallest number of draws for bounds of 95 %: one lies beyond each."""

RESAMPLES, SEED = 400, 1
"""Number of resampled sets of draws for the errors of the bounds, and their seed."""


class Predicted(NamedTuple):
    """A statement and the results of all draws of our walkers."""

    statement: Statement
    low: float | None = None
    median: float | None = None
    high: float | None = None
    """Bounds of 95 % of the draws, and their median."""
    low_se: float | None = None
    high_se: float | None = None
    """Standard errors of the bounds, by resampling the draws."""
    draws: int = 0
    ran: int = 0
    """Draws, and draws that run without their body touching the plate. The bounds come from these."""
    note: str = ""

    @property
    def inside(self) -> str:
        """Whether the published number lies in the bounds: yes, no, in part; nothing without either."""
        published = self.statement
        if self.low is None or self.high is None or published.low is None or published.high is None:
            return ""
        if self.low <= published.low and published.high <= self.high:
            return "yes"
        return "no" if published.high < self.low or self.high < published.low else "in part"


def group_draws(columns: Sequence[str], rows: Iterable[Mapping[str, Any]], grid: Sequence[str]) -> list[Speeds]:
    """Return the speeds of each draw of a sweep's rows. Keys outside the grid identify a draw."""
    found: dict[tuple[Any, ...], dict[tuple[tuple[str, Any], ...], float | None]] = {}
    drawn = [key for key in columns if key not in grid]
    for row in rows:
        speed = row["speed_mm_s"]
        whole = speed is not None and row["status"] == "ok"
        place = tuple((key, row[key]) for key in grid)
        found.setdefault(tuple(row[key] for key in drawn), {})[place] = float(speed) if whole else None
    return list(found.values())


def predict_statement(statement: Statement, speeds: Sequence[Speeds]) -> Predicted:
    """Compare a statement with the draws of its sweep."""
    if statement.missing:
        return Predicted(statement, note=f"not predicted: {statement.missing}")
    values = [value for each in speeds if (value := _compute_number(statement, each)) is not None]
    counts = Predicted(statement, draws=len(speeds), ran=len(values))
    if len(values) < MIN_DRAWS:
        return counts._replace(note=f"{len(values)} of {len(speeds)} draws run: too few for bounds")
    numbers = np.array(values)
    low, median, high = (float(end) for end in np.quantile(numbers, QUANTILES))
    low_se, high_se = _bound_errors(numbers)
    return counts._replace(low=low, median=median, high=high, low_se=low_se, high_se=high_se)


def _bound_errors(numbers: Array) -> tuple[float, float]:
    """Estimate the standard errors of the bounds of 95 % by resampling."""
    chosen = np.random.default_rng(SEED).integers(len(numbers), size=(RESAMPLES, len(numbers)))
    ends = np.quantile(numbers[chosen], [QUANTILES[0], QUANTILES[2]], axis=1)
    low, high = ends.std(axis=1, ddof=1)
    return float(low), float(high)


def _compute_number(statement: Statement, speeds: Speeds) -> float | None:
    """Compute a statement's number from one draw; None if the walker does not run."""
    if statement.number == "range":
        sizes = _speed_sizes(statement, speeds)
        return None if sizes is None else 100.0 * float(np.ptp(sizes) / sizes.mean())
    here = _speed_at(speeds, statement.at)
    if here is None or statement.number == "speed":
        return here
    if statement.number == "size":
        return abs(here)
    sizes = _speed_sizes(statement, speeds)
    return None if sizes is None else abs(here) / float(sizes.mean())


def _speed_sizes(statement: Statement, speeds: Speeds) -> Array | None:
    """Sizes of a draw's speeds over which a mean is taken; None where it does not run at one of them."""
    ((key, places),) = statement.over.items()
    found = [speed for place in places if (speed := _speed_at(speeds, {key: place})) is not None]
    return np.abs(np.array(found)) if len(found) == len(places) else None


def _speed_at(speeds: Speeds, values: Mapping[str, Any]) -> float | None:
    """Speed of a draw at the one point of the grid that has these values."""
    (speed,) = [speed for place, speed in speeds.items() if values.items() <= dict(place).items()] or (None,)
    return speed
