"""Worker pools: where points are evaluated, in processes of this machine or on a cluster of dask's.

A pool is an executor of `concurrent.futures` and its number of workers. Results are the same bits
in every pool, since every point runs on one thread from its own seed.
"""

import multiprocessing
import os
import re
import signal
import socket
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import wait
from typing import Any, NamedTuple

from walkergen import extras
from walkergen.core import measure
from walkergen.core.errors import InputError
from walkergen.points.point import digest

MAX_WORKERS = 1024
ANSWER_TIMEOUT_S = 10.0
"""Maximum time until a scheduler answers, s."""

MAX_GREETING_BYTES, GREETING_WORD = 10_000, b"pickle-protocol"
"""Longest first message of a scheduler, bytes, and a text that it contains."""


class WorkerPool(NamedTuple):
    """Executor of points, and how many it evaluates at a time."""

    executor: Executor
    workers: int


@contextmanager
def local_pool(workers: int | None = None) -> Iterator[WorkerPool]:
    """Start worker processes on this machine, by default one for each core, and end them after the `with` block."""
    count = measure.core_count() if workers is None else workers
    if not 1 <= count <= MAX_WORKERS:
        raise InputError(f"‹workers=›{count}: must lie in 1..{MAX_WORKERS}")
    context = multiprocessing.get_context("spawn")
    executor = ProcessPoolExecutor(count, mp_context=context, initializer=init_worker)
    try:
        with _ignore_ctrl_c():  # a process that starts takes over what is ignored
            for _ in range(count):
                executor.submit(os.getpid)
        yield WorkerPool(executor, count)
    except BaseException:
        executor.shutdown(wait=False, cancel_futures=True)
        for process in multiprocessing.active_children():
            process.terminate()
        raise
    executor.shutdown()


@contextmanager
def _ignore_ctrl_c() -> Iterator[None]:
    """Ignore Ctrl-C within the `with` block. In a thread other than the main one this is impossible and omitted."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def init_worker() -> None:
    """Prepare a worker process: ignore Ctrl-C, and end when the parent process ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def exit_with_parent() -> None:
        """Wait until the parent process has ended, then end this one."""
        wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=exit_with_parent, daemon=True).start()


@contextmanager
def dask_pool(address: str) -> Iterator[WorkerPool]:
    """Connect to an existing cluster of dask.distributed at the address of its scheduler, and yield its workers.

    Raises InputError when dask is not installed, the scheduler is not reached, there is no worker,
    or a worker has another version of walkergen, or none.
    """
    extras.require("cluster", "‹dask›")
    from distributed import Client

    host, port = _parse_address(address)
    try:
        _check_greeting(host, port)
        client = Client(f"tcp://{host}:{port}", timeout=ANSWER_TIMEOUT_S, set_as_default=False)
    except Exception as error:  # for invalid replies dask raises any exception
        reason = str(error).partition("\n")[0][:200] or "no answer"
        raise InputError(f"‹dask=›{address[:80]!r}: no scheduler answers there: {reason}") from None
    try:
        threads = client.nthreads()
        if not threads:
            raise InputError(f"‹dask=›{address[:80]!r}: the scheduler has no worker; start some")
        check_digests(_worker_digests(client))
        yield WorkerPool(client.get_executor(pure=False, retries=3), sum(threads.values()))
    finally:
        client.close(timeout=ANSWER_TIMEOUT_S)


def _parse_address(address: str) -> tuple[str, int]:
    """Return host and port from the address tcp://HOST:PORT of a scheduler. Raises InputError for another form."""
    scheme, _, rest = address.rpartition("://")
    host, _, port = rest.rpartition(":")
    if scheme not in ("", "tcp") or not host or not re.fullmatch("[0-9]{1,5}", port):
        raise InputError(f"‹dask=›{address[:80]!r}: write tcp://HOST:PORT, the scheduler's address")
    return host, int(port)


def _check_greeting(host: str, port: int) -> None:
    """Raise OSError unless the server at this host and port first sends the greeting of a dask scheduler.

    The client of dask waits for ever for a server that accepts a connection and sends nothing, and takes the first
    eight bytes of any other server for the length of a message.
    """
    until = time.monotonic() + ANSWER_TIMEOUT_S
    with socket.create_connection((host.strip("[]"), port), ANSWER_TIMEOUT_S) as connection:

        def receive(size: int) -> bytes:
            """Return the next `size` bytes. Raises OSError after the time limit or at the end."""
            data = b""
            while len(data) < size:
                connection.settimeout(max(until - time.monotonic(), 1e-3))
                if not (more := connection.recv(size - len(data))):
                    raise OSError("what listens there has hung up")
                data += more
            return data

        size = int.from_bytes(receive(8), sys.byteorder)
        if not 0 < size <= MAX_GREETING_BYTES or GREETING_WORD not in receive(size):
            raise OSError("what listens there is no scheduler of dask")


def _worker_digests(client: Any) -> dict[str, str]:
    """Return the hash of walkergen's sources on each worker, or the text of an error, by the worker's name."""
    answers = client.run(digest, on_error="return")
    return {
        name: answer if isinstance(answer, str) else f"{type(answer).__name__}: {answer}"
        for name, answer in answers.items()
    }


def check_digests(digests: dict[str, str]) -> None:
    """Raise InputError for the first worker whose digest of walkergen's sources differs from that of this machine."""
    for worker, reply in digests.items():
        if reply != digest():
            what = "another version of walkergen" if len(reply) == 16 else reply[:120]  # else an error
            raise InputError(
                f"‹dask›: worker {worker} has {what}, this machine {digest()}: install the same "
                f"walkergen there, for Python {sys.version_info.major}.{sys.version_info.minor}"
            )
