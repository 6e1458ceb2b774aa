"""Progress: reports of a long job's expected duration and completed share."""

from collections.abc import Callable
from typing import NamedTuple

Progress = Callable[[str, int, int], None]
"""Called with the current task, the number of steps done and their total."""


class Expected(NamedTuple):
    """Time that a job will take on this machine while nothing else runs."""

    seconds: float
    """Time by the clock from now on, s."""
    note: str = ""
    """Advice that would save time."""


Expect = Callable[[Callable[[], Expected | None]], None]
"""Called by a job with a function that estimates its duration, None for a short job; run only if a caller listens."""


def ignore_estimate(find: Callable[[], Expected | None]) -> None:
    """Ignore `find`, the function that estimates a job's duration. Callers that need no estimate pass this `Expect`."""


def silent(what: str, done: int, total: int) -> None:
    """Ignore a report of progress. Callers that show none pass this function as `Progress`."""


def part_progress(progress: Progress, number: int, count: int, title: str = "") -> Progress:
    """Return a callback for the `number`-th (from 0) of `count` equal parts of a job, which reports to `progress`.

    A `title` replaces the description in the reports of the part.
    """
    return lambda what, done, total: progress(title or what, number * total + done, count * total)


def range_progress(progress: Progress, begin: float, end: float) -> Progress:
    """Return a callback for a part of a job that reports to `progress`, from `begin` to `end` percent of the whole."""
    return lambda what, done, total: progress(what, int(100.0 * (begin + (end - begin) * done / max(total, 1))), 100)
