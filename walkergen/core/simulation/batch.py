"""Batches of runs: the one loop of threads, with Ctrl-C and progress.

What a run draws comes from its number alone, so that any number of threads gives the same bits.
"""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from typing import TypeVar

from walkergen.core.files.progress import Progress, silent

Made = TypeVar("Made")

Stopped = Callable[[], bool]
"""Returns whether a run is to stop."""

Tell = Callable[[float], None]
"""Called by a run with the share of it that is done, 0 to 1."""

OneRun = Callable[[int, Stopped, Tell], Made]
"""Function that makes the run of a number."""

POLL_INTERVAL_S = 0.2
"""Time between two looks at the runs under way, s."""


def run_parallel(
    one: OneRun[Made], numbers: Iterable[int], progress: Progress = silent, threads: int | None = None
) -> dict[int, Made]:
    """Make runs by their numbers, and return them in order, on `threads` threads (None: every core).

    Progress is in percent. Ctrl-C stops the runs under way and returns the finished ones. Without any it is raised
    again, as is any other error of a run.
    """
    stop: list[bool] = []
    shares = dict.fromkeys(numbers, 0.0)
    finished: dict[int, Made] = {}

    def run_one(number: int) -> Made:
        return one(number, lambda: bool(stop), lambda share: shares.update({number: share}))

    with ThreadPoolExecutor(threads or os.cpu_count() or 1) as pool:
        pending: dict[Future[Made], int] = {pool.submit(run_one, number): number for number in shares}
        try:
            while pending:
                for future in wait(pending, timeout=POLL_INTERVAL_S, return_when=FIRST_COMPLETED).done:
                    number = pending.pop(future)
                    finished[number], shares[number] = future.result(), 1.0
                progress("runs", int(100.0 * sum(shares.values()) / len(shares)), 100)
        except BaseException as error:
            stop.append(True)
            pool.shutdown(cancel_futures=True)
            if not (isinstance(error, KeyboardInterrupt) and finished):
                raise
    return dict(sorted(finished.items()))


def run_all(one: OneRun[Made], count: int, progress: Progress = silent, threads: int | None = None) -> list[Made]:
    """Make all `count` runs with `run_parallel`. Raises KeyboardInterrupt instead of leaving some out."""
    finished = run_parallel(one, range(count), progress, threads)
    if len(finished) < count:
        raise KeyboardInterrupt
    return list(finished.values())
