"""A ladder: settings from cheap to dear, each with the error it makes and the time it takes."""

import math
import os
import platform
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np


class Rung(NamedTuple):
    """One setting."""

    series: str
    """Settings of one series make a line of the figure."""
    setting: str
    error: float | None
    """What the ladder's `error` says; None where no error is known."""
    error_sd: float | None
    """Standard error of the error; None for a deterministic one."""
    cpu_s: float
    """What the ladder's `cost` says, s."""
    details: Mapping[str, float | str | None]
    """Further columns, the same for all rungs of a ladder."""


class Ladder(NamedTuple):
    """A work-precision study: its rungs, and against what the errors count."""

    name: str
    title: str
    error: str
    """What `Rung.error` is."""
    cost: str
    """What `Rung.cpu_s` is."""
    reference: str
    """What is taken as true, and how that was certified."""
    rungs: Sequence[Rung]
    notes: Sequence[str] = ()


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

    One call goes first, untimed: it compiles, imports and fills caches.
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


def machine() -> str:
    """The machine that timings are from, in words."""
    import numba

    return (
        f"{_processor()}, {os.cpu_count()} cores, {platform.system()}, "
        f"Python {platform.python_version()}, numba {numba.__version__}"
    )


def _processor() -> str:
    told = Path("/proc/cpuinfo")
    lines = told.read_text(encoding="utf-8").splitlines() if told.exists() else []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor() or platform.machine())
