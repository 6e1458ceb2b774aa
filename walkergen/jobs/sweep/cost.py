"""Cost of a sweep beforehand: a few of its points are evaluated, and their time counted up."""

import time
from itertools import islice
from typing import NamedTuple

from walkergen.exploring import run
from walkergen.exploring.request import Request
from walkergen.exploring.store import Store

UNASKED = 100_000
"""Number of points up to which a sweep begins without being asked for its cost."""

PILOTS = 3

BYTES = 300
"""Room of a point in the table and in the store together, at most of the columns that it has."""


class Cost(NamedTuple):
    """Time and room that a sweep will take."""

    points: int
    seconds: float
    """Time by the clock, s."""
    bytes: float


def estimate(request: Request, store: Store, workers: int) -> Cost:
    """Time the first points of a request, the first of all apart, which may compile."""
    asked = request.asked()
    list(run.each(islice(asked, 1), store))
    pilots = list(islice(asked, PILOTS))
    started = time.perf_counter()
    list(run.each(pilots, store))
    each = (time.perf_counter() - started) / max(len(pilots), 1)
    points = request.space.points
    return Cost(points, each * points / workers, BYTES * (1.0 + len(request.keep)) * points)


def in_words(cost: Cost) -> str:
    """Cost as a line for a person."""
    return (
        f"{cost.points:.4g} points: about {_time(cost.seconds)} and {_room(cost.bytes)} on the disk"
    )


def _time(seconds: float) -> str:
    for size, unit in ((3.15576e7, "years"), (86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 2.0 * size:
            return (
                f"{seconds / size:.2g} {unit}"
                if seconds < 1e3 * size
                else f"{seconds / size:.0f} {unit}"
            )
    return f"{seconds:.2g} s"


def _room(size: float) -> str:
    for unit in ("B", "kB", "MB", "GB"):
        if size < 1000.0:
            return f"{size:.3g} {unit}"
        size /= 1000.0
    return f"{size:.4g} TB"
