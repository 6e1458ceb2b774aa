"""Processes that answer what pages ask of shapes and numbers: one that takes too long ends alone.

A page that has gone ends the work for it; a shape that fills the memory, or that nobody can build in the
time, is refused. Each process keeps what it has built, so that the next step of a slider is quick.
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
"""Processes at most: one begins at the start, others where work takes long, so that no page waits for another's."""

QUEUE_WAIT_S = 0.3
"""Time for which work waits for a process before another one begins."""

MAX_ANSWER_CPU_S, MAX_START_S = 30.0, 120.0
"""Longest time of a core for an answer, and by the clock for a process to begin, s."""

CLOCK_FACTOR = 4.0
"""Times longer by the clock that an answer may take, as on a machine that is busy."""

GRACE_S = 0.5
"""Time that work for a page that has gone may go on, which is cheaper than another process."""

POLL_S = 0.05

START_METHOD = "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
PRELOADED_MODULES = [
    f"walkergen.app.{name}" for name in ("walker_answers", "curves", "form", "downloads", "crowd_playback", "effects")
]
"""Modules that answers need: where processes can be copied, one imports them for all."""

DEFERRED_MODULE, IDLE_S = "walkergen.points.short_simulation", 3.0
"""Module for walkers that only runs know, imported once nobody has asked for so long, s: it takes half a second, and
what compares the triangles of a mesh, loaded then as well, another one; a page that loads needs the cores itself."""

MAX_ADDRESS_BYTES = 6 * 2**30
"""Addresses that a process may use: where a system has such a limit."""

ABANDONED_ERROR = InputError("nobody waits for this any more")

Result = TypeVar("Result")


class Worker(NamedTuple):
    """Process, and the way to it."""

    process: Any
    connection: Connection
    ready: list[Any]
    """What it said when it had begun; empty until then."""


class Workers:
    """Processes that make answers, begun when they are needed."""

    def __init__(self) -> None:
        self._idle: queue.LifoQueue[Worker] = queue.LifoQueue()
        self._threads = ThreadPoolExecutor(MAX_WORKERS)
        self._count = 0
        self._counting = threading.Lock()

    def start(self) -> None:
        """Start the first process, which imports while the page loads."""
        self._count = 1
        self._idle.put(_start_worker())

    async def answer(self, work: Callable[..., Result], *given: Any) -> Result:
        """Run work in a process and return its result; cancelling it ends the work. Raises WalkergenError."""
        gone = threading.Event()
        try:
            running = self._threads.submit(self._answer, work, given, gone)
            return await asyncio.wrap_future(running)
        except asyncio.CancelledError:
            gone.set()
            raise

    def _answer(self, work: Callable[..., Any], given: Any, gone: threading.Event) -> Any:
        worker = self._acquire_worker()
        try:
            answer = _request_answer(worker, work, given, gone)
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
        """Idle process, or another one where all are at work for long."""
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
        """End all processes that are idle; those at work end with this one."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        while not self._idle.empty():
            _stop_worker(self._idle.get())


def _start_worker() -> Worker:
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


def _request_answer(worker: Worker, work: Callable[..., Any], given: Any, gone: threading.Event) -> Any:
    """Send work to a process; return its result, or its error. Raises InputError if it is lost or too slow."""
    late = InputError(f"{SOURCE}: this takes longer than {MAX_ANSWER_CPU_S:g} s: make the shape simpler, or smaller")
    try:
        if not worker.ready:
            worker.ready.append(_receive(worker, MAX_START_S, late))
        if gone.is_set():
            return ABANDONED_ERROR
        worker.connection.send((work, given))
        return _receive(worker, CLOCK_FACTOR * MAX_ANSWER_CPU_S, late, gone)
    except (EOFError, OSError):
        raise InputError(f"{SOURCE}: too large for this machine: make the shape simpler, or ask for less") from None


def _receive(worker: Worker, longest: float, late: InputError, gone: threading.Event | None = None) -> Any:
    """Receive the next message of a process. Raises InputError if it takes too long, EOFError if it has ended."""
    begun, spent = time.monotonic(), _cpu_seconds(worker)
    while not worker.connection.poll(POLL_S):
        passed = time.monotonic() - begun
        if gone is not None and gone.is_set() and passed > GRACE_S:
            raise ABANDONED_ERROR
        if passed > longest or _cpu_seconds(worker) - spent > MAX_ANSWER_CPU_S:
            raise late
    return worker.connection.recv()


def _cpu_seconds(worker: Worker) -> float:
    """Time of a core that a process has taken, s; by the clock where the system does not tell."""
    try:
        times = Path(f"/proc/{worker.process.pid}/stat").read_text().rpartition(")")[2].split()[11:13]
    except OSError:
        return time.monotonic()
    return sum(map(int, times)) / os.sysconf("SC_CLK_TCK")


def _serve(connection: Connection) -> None:
    """Answer until the server ends."""
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
        gc.freeze()  # to look for garbage among all that is imported takes a tenth of a second
        calm = False
        while True:
            if not calm and not connection.poll(IDLE_S):
                _preload_meshes()
                calm = True
            work, given = connection.recv()
            connection.send(_run_work(work, given))


def _preload_meshes() -> None:
    """Load what only some walkers need."""
    import numpy as np

    from walkergen.readers.drawings import crossings

    importlib.import_module(DEFERRED_MODULE)
    corners = np.concatenate([np.zeros((1, 3)), np.eye(3)])
    crossings.find(corners, np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]), 1e-6)
    gc.collect()
    gc.freeze()


def _run_work(work: Callable[..., Any], given: Any) -> Any:
    """Run work, and return its result or the error that it raises."""
    try:
        return work(*given)
    except InputError as error:
        return error.resolve_remedies()
    except WalkergenError as error:
        return error
    except (MemoryError, RecursionError):
        return InputError(f"{SOURCE}: too large for this machine: ask for less")
