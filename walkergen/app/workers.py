"""Worker processes that compute answers for pages. Ending a slow one leaves the others unchanged.

Closing a page ends the work for it. A shape that needs too much memory or time
is refused. Each process caches its solids, so that the next step of a slider is fast.
"""

import asyncio
import contextlib
import gc
import importlib
import importlib.util
import multiprocessing
import os
import queue
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from walkergen.app.document import SOURCE
from walkergen.core.errors import InputError, WalkergenError
from walkergen.points import worker_pool

MAX_WORKERS = 6
"""Largest number of processes. One is started with the server, others when work is slow, so that pages do not wait."""

QUEUE_WAIT_S = 0.3
"""Time that work waits for an idle process before another one is started, s."""

MAX_ANSWER_CPU_S, MAX_START_S = 30.0, 120.0
"""Longest CPU time of an answer, and wall time of a process's start, s."""

CLOCK_FACTOR = 4.0
"""Largest ratio of wall time to CPU time of an answer, as on a busy machine."""

GRACE_S = 0.5
"""Time that work for a closed page may continue, s: this is cheaper than another process."""

POLL_S = 0.05

START_METHOD = "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
PRELOADED_MODULES = [
    f"walkergen.app.{name}" for name in ("walker_answers", "curves", "form", "downloads", "command_results")
]
"""Modules that compute answers. If processes can be forked, one process imports them for all."""

DEFERRED_MODULE, IDLE_S = "walkergen.points.short_simulation", 3.0
"""Module for walkers that must be simulated, imported after this idle time, s. The import takes half a second, and the
collision code of meshes, loaded then as well, another half. A loading page needs the cores itself."""

MAX_ADDRESS_BYTES = 6 * 2**30
"""Bytes of address space for a process, on systems with such a limit."""

ABANDONED_ERROR = InputError("the page no longer waits for this")

Result = TypeVar("Result")


class Worker(NamedTuple):
    """Worker process and the connection to it."""

    process: Any
    connection: Connection
    ready: list[Any]
    """First message of the process after its start; empty until it has arrived."""


class Workers:
    """Pool of worker processes that compute answers. Processes are started on demand."""

    def __init__(self) -> None:
        self._idle: queue.LifoQueue[Worker] = queue.LifoQueue()
        self._threads = ThreadPoolExecutor(MAX_WORKERS)
        self._count = 0
        self._counting = threading.Lock()

    def start(self) -> None:
        """Start the first process, which imports modules while the page loads."""
        self._count = 1
        self._idle.put(_start_worker())

    async def answer(self, work: Callable[..., Result], *arguments: Any) -> Result:
        """Call `work` in a process and return its result, or raise its WalkergenError. Cancelling ends the work."""
        gone = threading.Event()
        try:
            running = self._threads.submit(self._answer, work, arguments, gone)
            return await asyncio.wrap_future(running)
        except asyncio.CancelledError:
            gone.set()
            raise

    def _answer(self, work: Callable[..., Any], arguments: Any, gone: threading.Event) -> Any:
        """Call `work` in a process and return its result or raise its error. `gone`: set when the page is closed."""
        worker = self._acquire_worker()
        try:
            answer = _request_answer(worker, work, arguments, gone)
        except BaseException:
            _stop_worker(worker)
            with self._counting:
                self._count -= 1
            raise
        self._idle.put(worker)
        if isinstance(answer, BaseException):
            raise answer
        return answer

    def _acquire_worker(self) -> Worker:
        """Return an idle process, or a new one if none is idle within QUEUE_WAIT_S."""
        while True:
            with contextlib.suppress(queue.Empty):
                return self._idle.get(timeout=QUEUE_WAIT_S if self._count else 0.0)
            with self._counting:
                more = self._count < MAX_WORKERS
                if more:
                    self._count += 1
            if more:
                return _start_worker()

    def stop(self) -> None:
        """End all idle processes. Busy ones end with this process."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        while not self._idle.empty():
            _stop_worker(self._idle.get())


def _start_worker() -> Worker:
    """Start a process that answers requests through a pipe."""
    context: Any = multiprocessing.get_context(START_METHOD)
    if START_METHOD == "forkserver":
        context.set_forkserver_preload(PRELOADED_MODULES)
    ours, theirs = context.Pipe()
    process = context.Process(target=_serve, args=(theirs,), daemon=True)
    process.start()
    theirs.close()
    return Worker(process, ours, [])


def _stop_worker(worker: Worker) -> None:
    worker.process.kill()
    worker.process.join()
    worker.connection.close()


def _request_answer(worker: Worker, work: Callable[..., Any], arguments: Any, gone: threading.Event) -> Any:
    """Let a process call `work`. Return the result or, also as a value, the error that `work` raised.

    Return ABANDONED_ERROR if `gone` is set: the page is closed. Raises InputError if the process ends or is too slow.
    """
    late = InputError(f"{SOURCE}: this takes longer than {MAX_ANSWER_CPU_S:g} s. Make the shape simpler, or smaller.")
    try:
        if not worker.ready:
            worker.ready.append(_receive(worker, MAX_START_S, late))
        if gone.is_set():
            return ABANDONED_ERROR
        worker.connection.send((work, arguments))
        return _receive(worker, CLOCK_FACTOR * MAX_ANSWER_CPU_S, late, gone)
    except (EOFError, OSError):
        raise InputError(
            f"{SOURCE}: too large for the memory of this machine. Make the shape simpler, or smaller."
        ) from None


def _receive(worker: Worker, max_wait_s: float, late: InputError, gone: threading.Event | None = None) -> Any:
    """Receive the next message of a process. Raises EOFError if the process has ended.

    Raises the error `late` if it takes too long, and ABANDONED_ERROR if `gone` is set, as when the page is closed.
    """
    begun, spent = time.monotonic(), _cpu_seconds(worker)
    while not worker.connection.poll(POLL_S):
        passed = time.monotonic() - begun
        if gone is not None and gone.is_set() and passed > GRACE_S:
            raise ABANDONED_ERROR
        if passed > max_wait_s or _cpu_seconds(worker) - spent > MAX_ANSWER_CPU_S:
            raise late
    return worker.connection.recv()


def _cpu_seconds(worker: Worker) -> float:
    """Return the CPU time of a process, s, or the wall time if the system does not report it."""
    try:
        times = Path(f"/proc/{worker.process.pid}/stat").read_text().rpartition(")")[2].split()[11:13]
    except OSError:
        return time.monotonic()
    return sum(map(int, times)) / os.sysconf("SC_CLK_TCK")


def _serve(connection: Connection) -> None:
    """Run a worker process: receive pairs (work, arguments) and send the results, until the server ends."""
    worker_pool.init_worker()
    if importlib.util.find_spec("resource"):
        import resource

        _, most = resource.getrlimit(resource.RLIMIT_AS)
        limit = MAX_ADDRESS_BYTES if most == resource.RLIM_INFINITY else min(MAX_ADDRESS_BYTES, most)
        with contextlib.suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_AS, (limit, most))
    for name in PRELOADED_MODULES:
        importlib.import_module(name)
    with contextlib.suppress(EOFError, OSError):
        connection.send("ready")
        gc.freeze()  # garbage collection over all imports would take a tenth of a second
        preloaded = False
        while True:
            if not preloaded and not connection.poll(IDLE_S):
                _preload_meshes()
                preloaded = True
            work, arguments = connection.recv()
            connection.send(_run_work(work, arguments))


def _preload_meshes() -> None:
    """Import modules that only some walkers need, and run the collision code of meshes once."""
    import numpy as np

    from walkergen.readers.drawings import crossings

    importlib.import_module(DEFERRED_MODULE)
    corners = np.concatenate([np.zeros((1, 3)), np.eye(3)])
    crossings.find(corners, np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]), 1e-6)
    gc.collect()
    gc.freeze()


def _run_work(work: Callable[..., Any], arguments: Any) -> Any:
    """Call `work`. Return its result or, as a value, the error that it raises."""
    try:
        return work(*arguments)
    except InputError as error:
        return error.resolve_remedies()
    except WalkergenError as error:
        return error
    except (MemoryError, RecursionError):
        return InputError(f"{SOURCE}: too large for the memory of this machine. Try a smaller job.")
