"""Progress: how a job that takes long says how far it is, and before that how long it will take."""

from collections.abc import Callable
from typing import NamedTuple

Progress = Callable[[str, int, int], None]
"""Called with what is being done, how many steps are done, and of how many."""


class Expected(NamedTuple):
    """Time that a job will take on this machine while nothing else runs."""

    seconds: float
    """Time by the clock from now on, s."""
    note: str = ""
    """What would take less, in words."""


Expect = Callable[[Callable[[], Expected | None]], None]
"""Called by a job with what finds how long it will take, or None where that is short; done where somebody hears."""


def ignore_estimate(find: Callable[[], Expected | None]) -> None:
    """Expect of whom nobody hears."""


def silent(what: str, done: int, total: int) -> None:
    """Progress that reports nothing."""


def part_progress(progress: Progress, number: int, count: int, title: str = "") -> Progress:
    """Progress of a part, the `number`-th (from 0) of `count` equal ones, as a share of the whole.

    A title stands in place of what the part says it does.
    """
    return lambda what, done, total: progress(title or what, number * total + done, count * total)


def range_progress(progress: Progress, begin: float, end: float) -> Progress:
    """Progress of a stretch of a job, from one share of the whole to another, in percent."""
    return lambda what, done, total: progress(what, int(100.0 * (begin + (end - begin) * done / max(total, 1))), 100)
