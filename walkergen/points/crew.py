"""Crews: where points are evaluated, in processes of this machine or on a cluster of dask's.

A crew is an executor of `concurrent.futures` and its number of workers; results are the same bits
whatever it is, since every point runs on one thread from its own seed.
"""

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import wait
from typing import Any, NamedTuple

from walkergen.errors import InputError
from walkergen.points.point import digest

MOST_WORKERS = 1024
ANSWER_S = 10.0
"""Time in which a scheduler must answer, s."""


class Crew(NamedTuple):
    """Executor of points, and how many it evaluates at a time."""

    executor: Executor
    workers: int


def cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def local(workers: int | None = None) -> Iterator[Crew]:
    """Processes of this machine, one for each core by default; ended whatever happens."""
    count = cores() if workers is None else workers
    if not 1 <= count <= MOST_WORKERS:
        raise InputError(f"--workers {count}: must lie in 1..{MOST_WORKERS}")
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(count, mp_context=context, initializer=_begin)
    try:
        yield Crew(pool, count)
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        for process in multiprocessing.active_children():
            process.terminate()
        raise
    pool.shutdown()


def _begin() -> None:
    """Leave Ctrl-C to the parent, and end with it, even when it is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


@contextmanager
def dask(address: str) -> Iterator[Crew]:
    """Workers of an existing cluster of dask.distributed, by the address of its scheduler.

    Raises InputError when dask is not installed, the scheduler is not reached, there is no worker,
    or a worker has another version of walkergen, or none.
    """
    try:
        from distributed import Client
    except ModuleNotFoundError:
        raise InputError(
            "--dask: dask is not installed: pip install 'walkergen[cluster]'"
        ) from None
    try:
        client = Client(address, timeout=ANSWER_S, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        reason = str(error).partition("\n")[0][:200]
        raise InputError(f"--dask {address[:80]!r}: no scheduler answers there: {reason}") from None
    try:
        threads = client.nthreads()
        if not threads:
            raise InputError(f"--dask {address[:80]!r}: the scheduler has no worker; start some")
        check(_digests(client))
        yield Crew(client.get_executor(pure=False, retries=3), sum(threads.values()))
    finally:
        client.close(timeout=ANSWER_S)


def _digests(client: Any) -> dict[str, str]:
    """Digest of the sources of each worker; the reason where there is none."""
    answers = client.run(digest, on_error="return")
    return {
        name: answer if isinstance(answer, str) else f"{type(answer).__name__}: {answer}"
        for name, answer in answers.items()
    }


def check(digests: dict[str, str]) -> None:
    """Raise InputError for the first worker whose walkergen is not this one."""
    for worker, reply in digests.items():
        if reply != digest():
            what = "another version of walkergen" if len(reply) == 16 else reply[:120]
            raise InputError(
                f"--dask: worker {worker} has {what}, this machine {digest()}: install the same "
                f"walkergen there, for Python {sys.version_info.major}.{sys.version_info.minor}"
            )
