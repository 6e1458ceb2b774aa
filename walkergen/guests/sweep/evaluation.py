"""Evaluation of many points in order: stored records come from the store, others from a pool of processes.

The pool evaluates tasks of one or several points. A slot is a point's position in the order, filled by its task.
"""

import time
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from dataclasses import dataclass, field
from itertools import islice
from typing import NamedTuple

from walkergen.core import WalkergenError
from walkergen.points.model_kinds import evaluate
from walkergen.points.point import Point, Record, digest, point_key
from walkergen.points.store import Store
from walkergen.points.worker_pool import WorkerPool

TASKS_PER_WORKER = 4
"""Number of tasks for each worker that wait at the same time, so that no worker is idle."""

LOOKUP_BLOCK, POINTS_PER_TASK = 64, 8
"""Number of points that are looked up in the store together, and number of predicted points in a task. A prediction
takes 2 to 30 ms, and sending a task 1 ms."""

MAX_UNSAVED_S = 0.5
"""Time after which finished points are saved, s. A worker then returns its finished points, and the task goes on."""

MAX_PENDING = 4096
"""Largest number of finished points that wait for an earlier, slow one. Points are yielded in their order."""

WORKER_LOST = (
    "a worker process ended, perhaps because the memory is full ({}). Finished points are kept. "
    "Repeat the command with fewer ‹workers›."
)

PointOrRefusal = Point | Record
"""Point, or the record of one that was refused before it can be evaluated."""

Answer = tuple[str, list[Record]]
"""Result of a task: hash of the worker's source files, and the records of its points."""


class Done(NamedTuple):
    """Evaluated point."""

    key: str
    """Key of the point; "" for one that was refused."""
    record: Record
    stored: bool
    """True if the record comes from the store."""


@dataclass(eq=False)
class _Task:
    """Points that are evaluated together."""

    points: dict[str, Point]
    """Points by their keys in the store."""
    future: "Future[Answer]"
    """Records of the first points without a saved one."""
    records: list[Record] = field(default_factory=list)
    """Records of the first points, which are saved."""
    again: bool = False
    """Whether points of the task were submitted a second time, after their first result was lost."""

    def save(self, store: Store) -> None:
        """Save the records of `future`. Raises WalkergenError if it failed or its worker has another version."""
        records = _read_records(self.future)
        store.save(zip(self.remaining, records, strict=False))
        self.records += records

    @property
    def remaining(self) -> dict[str, Point]:
        """Points without a saved record, by their keys."""
        return dict(islice(self.points.items(), len(self.records), None))


class _Slot(NamedTuple):
    """Position in the order of points. It has the evaluated point `done`, or the index of its point in a `task`."""

    done: Done | None
    task: _Task | None = None
    position: int = 0


def evaluate_points(points: Iterable[PointOrRefusal], store: Store, pool: WorkerPool | None = None) -> Iterator[Done]:
    """Yield the evaluated points in their order. Points that are not in the store are evaluated and saved there.

    Without a pool this process evaluates them. Raises OutputError if the store fails, and WalkergenError if a worker is
    lost or has another version of walkergen. Finished records are then in the store.
    """
    stream = iter(points)
    if pool is None:
        while block := list(islice(stream, LOOKUP_BLOCK)):
            yield from _evaluate_here(block, store)
        return
    under_way: dict[Future[Answer], _Task] = {}
    try:
        yield from _evaluate_by_pool(stream, store, pool, under_way)
    finally:  # after an error, Ctrl-C, or an early stop: the finished results are kept
        for future, task in under_way.items():
            if future.done() and not future.cancelled() and future.exception() is None:
                task.save(store)


def _evaluate_by_pool(
    stream: Iterator[PointOrRefusal], store: Store, pool: WorkerPool, under_way: dict["Future[Answer]", _Task]
) -> Iterator[Done]:
    """Yield the points in their order, evaluated by a pool. `under_way`: receives the tasks that are not saved yet."""
    slots: deque[_Slot] = deque()
    remaining, max_tasks = True, 1  # the first point alone: where kernels are new, it compiles for all
    while remaining or slots:
        while remaining and len(under_way) < max_tasks and len(slots) < MAX_PENDING:
            block = list(islice(stream, LOOKUP_BLOCK if max_tasks > 1 else 1))
            remaining = bool(block)
            for slot in _send_block(block, store, pool):
                slots.append(slot)
                if slot.task is not None:
                    under_way[slot.task.future] = slot.task
        if under_way and slots[0].task is not None and slots[0].task.future in under_way:
            finished, _ = wait(under_way, return_when=FIRST_COMPLETED)
            max_tasks = TASKS_PER_WORKER * pool.workers
            for future in finished:
                task = under_way.pop(future)
                if _can_retry(task):
                    task.again = True
                else:
                    task.save(store)
                if task.remaining:
                    task.future = _submit_task(task.remaining, pool)
                    under_way[task.future] = task
        while slots and (slots[0].task is None or slots[0].task.future not in under_way):
            yield _finish_slot(slots.popleft())


def _evaluate_here(block: Sequence[PointOrRefusal], store: Store) -> Iterator[Done]:
    """Yield the points in their order, evaluated by this process. Simulated points are saved one by one."""
    keys = [point_key(point) if isinstance(point, Point) else "" for point in block]
    stored = store.get([key for key in keys if key])
    unsaved: list[tuple[str, Record]] = []
    finished: list[Done] = []
    saved = time.monotonic()
    for point, key in zip(block, keys, strict=True):
        if not isinstance(point, Point):
            finished.append(Done(key, point, False))
        elif key in stored:
            finished.append(Done(key, stored[key], True))
        else:
            finished.append(Done(key, evaluate(point), False))
            unsaved.append((key, finished[-1].record))
            if point.simulated or time.monotonic() - saved > MAX_UNSAVED_S:
                store.save(unsaved)
                saved = time.monotonic()
                unsaved.clear()
                yield from finished
                finished.clear()
    store.save(unsaved)
    yield from finished


def _send_block(block: Sequence[PointOrRefusal], store: Store, pool: WorkerPool) -> list[_Slot]:
    """Send the points that are not stored to the pool as tasks, and return a slot for each point of the block."""
    keys = [point_key(point) if isinstance(point, Point) else "" for point in block]
    stored = store.get([key for key in keys if key])
    fresh = {
        key: point for key, point in zip(keys, block, strict=True) if isinstance(point, Point) and key not in stored
    }
    simulated = any(point.simulated for point in fresh.values())
    size = 1 if simulated else POINTS_PER_TASK
    fresh_keys = list(fresh)
    positions: dict[str, tuple[_Task, int]] = {}
    for first in range(0, len(fresh_keys), size):
        part = {key: fresh[key] for key in fresh_keys[first : first + size]}
        task = _Task(part, _submit_task(part, pool))
        positions |= {key: (task, index) for index, key in enumerate(part)}
    slots = []
    for key, point in zip(keys, block, strict=True):
        if not isinstance(point, Point):
            slots.append(_Slot(Done(key, point, False)))
        elif key in stored:
            slots.append(_Slot(Done(key, stored[key], True)))
        else:
            slots.append(_Slot(None, *positions[key]))
    return slots


def _evaluate_task(points: Sequence[Point]) -> Answer:
    """Evaluate points on a worker, the first of them if they take long. Return its sources' hash, and the records."""
    started = time.monotonic()
    records: list[Record] = []
    while len(records) < len(points) and (not records or time.monotonic() - started < MAX_UNSAVED_S):
        records.append(evaluate(points[len(records)]))
    return digest(), records


def _submit_task(points: dict[str, Point], pool: WorkerPool) -> "Future[Answer]":
    """Submit points to the pool as a task and return its future. Raises WalkergenError if the workers have ended."""
    try:
        return pool.executor.submit(_evaluate_task, list(points.values()))
    except BrokenExecutor as error:
        raise WalkergenError(WORKER_LOST.format(error)) from error


def _can_retry(task: _Task) -> bool:
    """Return whether a finished task failed for the first time, and may succeed if it is submitted again.

    While a worker of a cluster ends, *distributed* can fail on a valid answer. An error in the points themselves is
    raised again by the second try.
    """
    error = task.future.exception()
    return not task.again and error is not None and not isinstance(error, (BrokenExecutor, ImportError))


def _read_records(future: "Future[Answer]") -> list[Record]:
    """Return the records of a finished task. Raises WalkergenError if it failed or its worker has another version."""
    try:
        sources, records = future.result()
    except BrokenExecutor as error:
        raise WalkergenError(WORKER_LOST.format(error)) from error
    except ImportError as error:
        raise WalkergenError(f"a worker cannot import this version of walkergen: {error}. Install it there.") from error
    if sources != digest():
        raise WalkergenError(
            f"a worker has version {sources} of walkergen, and this machine {digest()}. Its numbers are not used. "
            "Install the same version there."
        )
    return records


def _finish_slot(slot: _Slot) -> Done:
    """Return the evaluated point of a slot. If the slot has a task, it must be finished."""
    if slot.done is not None:
        return slot.done
    assert slot.task is not None
    return Done(list(slot.task.points)[slot.position], slot.task.records[slot.position], False)
