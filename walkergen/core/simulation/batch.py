"""Batches of runs: the one loop of threads, with Ctrl-C and progress.

Random numbers of a run depend on its number alone, so results do not depend on the number of threads.
"""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from typing import TypeVar

from walkergen.core.files.progress import Progress, silent

Made = TypeVar("Made")
"""Type of the result of one run."""

Stopped = Callable[[], bool]
"""Returns whether a run is to stop."""

Tell = Callable[[float], None]
"""Called by a run with the share of it that is done, 0 to 1."""

OneRun = Callable[[int, Stopped, Tell], Made]
"""Function that makes the run with a given number and returns its result."""

POLL_INTERVAL_S = 0.2
"""Time between two looks at the runs under way, s."""


def run_parallel(
    make_run: OneRun[Made], numbers: Iterable[int], progress: Progress = silent, threads: int | None = None
) -> dict[int, Made]:
    """Make the runs of the given numbers on `threads` threads (None: every core). Return them by number, in order.

    `make_run(number, stopped, tell)` makes one run and returns its result: `stopped()` returns whether to stop,
    `tell(share)` reports progress. `progress` gets percent. Ctrl-C stops the runs under way and returns the finished
    ones. It is raised again if none has finished. Any other error of a run is always raised.
    """
    stop: list[bool] = []
    done_shares = dict.fromkeys(numbers, 0.0)
    finished: dict[int, Made] = {}

    def make_stoppable_run(number: int) -> Made:
        """Make one run, which stops once `stop` has an entry and writes its progress to `done_shares`."""
        return make_run(number, lambda: bool(stop), lambda share: done_shares.update({number: share}))

    with ThreadPoolExecutor(threads or os.cpu_count() or 1) as pool:
        pending: dict[Future[Made], int] = {pool.submit(make_stoppable_run, number): number for number in done_shares}
        try:
            while pending:
                for future in wait(pending, timeout=POLL_INTERVAL_S, return_when=FIRST_COMPLETED).done:
                    number = pending.pop(future)
                    finished[number], done_shares[number] = future.result(), 1.0
                progress("runs", int(100.0 * sum(done_shares.values()) / len(done_shares)), 100)
        except BaseException as error:
            stop.append(True)
            pool.shutdown(cancel_futures=True)
            if not (isinstance(error, KeyboardInterrupt) and finished):
                raise
    return dict(sorted(finished.items()))


def run_all(make_run: OneRun[Made], count: int, progress: Progress = silent, threads: int | None = None) -> list[Made]:
    """Return the results of runs 0 to `count` - 1, from `run_parallel`. Raises KeyboardInterrupt if any is missing."""
    finished = run_parallel(make_run, range(count), progress, threads)
    if len(finished) < count:
        raise KeyboardInterrupt
    return list(finished.values())
