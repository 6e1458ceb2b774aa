"""Cost of a sweep beforehand: a few of its points are evaluated, and their time counted up."""

import time
from itertools import islice
from typing import NamedTuple

from walkergen.files import words
from walkergen.points import run
from walkergen.points.request import Request
from walkergen.points.store import Store

UNASKED = 100_000
"""Number of points up to which a sweep begins without being asked for its cost."""

PILOTS = 3

BYTES = 300
"""Most bytes that a point takes in table and store together, and again for each group it keeps."""


class Cost(NamedTuple):
    """Time and room that a sweep will take."""

    points: int
    seconds: float
    """Time by the clock, s."""
    bytes: float


def estimate(request: Request, store: Store, workers: int) -> Cost:
    """Time the first points of a request, the first of all apart, which may compile."""
    stream = request.points()
    list(run.each(islice(stream, 1), store))
    pilots = list(islice(stream, PILOTS))
    started = time.perf_counter()
    list(run.each(pilots, store))
    per_point = (time.perf_counter() - started) / max(len(pilots), 1)
    points = request.space.points
    return Cost(points, per_point * points / workers, BYTES * (1.0 + len(request.keep)) * points)


def in_words(cost: Cost) -> str:
    """Cost as a line for a person."""
    needed = f"about {words.duration(cost.seconds)} and {_room(cost.bytes)} on the disk"
    return f"{words.number(cost.points, 4)} points: {needed}"


def _room(size: float) -> str:
    for unit in ("B", "kB", "MB", "GB"):
        if size < 1000.0:
            return f"{size:.3g} {unit}"
        size /= 1000.0
    return f"{size:.4g} TB"
