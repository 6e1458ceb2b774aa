"""Ladders: settings from cheap to dear, each with its error and the time it takes."""

import math
import statistics
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

Details = dict[str, float | str | None]
"""Further columns of a rung: the same keys for all rungs of a ladder."""


class Rung(NamedTuple):
    """Setting of a ladder, with its error and its cost."""

    series: str
    """Name of the series: settings that differ in one number."""
    setting: str
    error: float | None
    """Error as the ladder's `error` defines it; None where it is not known."""
    error_sd: float | None
    """Standard error of the error; None when the error is deterministic."""
    cpu_s: float
    """Time as the ladder's `cost` defines it, s."""
    details: Details


class Ladder(NamedTuple):
    """Work-precision study: its rungs, and the reference for their errors."""

    name: str
    title: str
    error: str
    """Definition of `Rung.error`."""
    cost: str
    """Definition of `Rung.cpu_s`."""
    reference: str
    """Result that counts as true, and how it was certified."""
    rungs: Sequence[Rung]
    notes: Sequence[str] = ()


def order_in_words(values: Sequence[float], errors: Sequence[float]) -> str:
    """Measured order of errors in the values: "1.98 ± 0.05"."""
    slope, se = order(values, errors)
    return f"measured order {slope:.2f} ± {se:.2f}"


def order(values: Sequence[float], errors: Sequence[float]) -> tuple[float, float]:
    """Slope of log(error) over log(value) by least squares, and its standard error.

    The standard error is that of the scatter about the line: NaN for fewer than three points.
    """
    x, y = np.log(values), np.log(errors)
    slope, offset = np.polyfit(x, y, 1)
    if len(x) < 3:
        return float(slope), math.nan
    scatter = np.sum((y - slope * x - offset) ** 2) / (len(x) - 2)
    return float(slope), float(math.sqrt(scatter / np.sum((x - x.mean()) ** 2)))


def cpu_time(call: Callable[[], object], repeats: int = 5, at_least: float = 1e-2) -> float:
    """CPU time of one call, s: the median of `repeats` batches of at least `at_least` s each.

    An untimed call goes first: it compiles, imports and fills caches.
    """
    call()
    count = 1
    while (spent := _batch(call, count)) < at_least:
        count = max(2 * count, math.ceil(count * at_least / max(spent, 1e-6)))
    return statistics.median(_batch(call, count) for _ in range(repeats)) / count


def _batch(call: Callable[[], object], count: int) -> float:
    started = time.thread_time()
    for _ in range(count):
        call()
    return time.thread_time() - started
