"""Progress: how a job that takes long says how far it is."""

from collections.abc import Callable

Progress = Callable[[str, int, int], None]
"""Called with what is being done, how many steps are done, and of how many."""


def silent(what: str, done: int, total: int) -> None:
    """Progress that reports nothing."""


def part(progress: Progress, number: int, count: int, title: str = "") -> Progress:
    """Progress of a part, the `number`-th (from 0) of `count` equal ones, as a share of the whole.

    A title stands in place of what the part says it does.
    """
    return lambda what, done, total: progress(title or what, number * total + done, count * total)


def stretch(progress: Progress, begin: float, end: float) -> Progress:
    """Progress of a stretch of a job, from one share of the whole to another, in percent."""
    return lambda what, done, total: progress(what, int(100.0 * (begin + (end - begin) * done / max(total, 1))), 100)
