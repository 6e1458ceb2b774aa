"""Evaluation of many points: those that are known come from the store, others from a pool."""

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from dataclasses import dataclass
from itertools import islice
from typing import NamedTuple

from walkergen.core import WalkergenError
from walkergen.points.model_kinds import evaluate
from walkergen.points.point import Point, Record, digest, point_key
from walkergen.points.store import Store
from walkergen.points.worker_pool import WorkerPool

TASKS_PER_WORKER = 4
"""Tasks for each worker that are sent ahead, so that none is idle."""

LOOKUP_BLOCK, POINTS_PER_TASK = 64, 8
"""Number of points that are looked up together, and of predicted ones in a task: a prediction takes
2 to 30 ms, and as a task of its own 1 ms more to be sent."""

MAX_PENDING = 4096
"""Most points that are kept while an earlier one takes long: all are yielded in their order."""

WORKER_LOST = (
    "a worker process ended, perhaps because the memory is full ({}). Finished points are kept. "
    "Repeat the command with fewer ‹workers›."
)

PointOrRefusal = Point | Record
"""Point, or the record of one that was refused before it can be evaluated."""

Answer = tuple[str, list[Record]]


class Done(NamedTuple):
    """Evaluated point."""

    key: str
    """Key of the point; "" for one that was refused."""
    record: Record
    stored: bool
    """True when the store had it."""


@dataclass(eq=False)
class _Task:
    """Points that are evaluated together."""

    points: dict[str, Point]
    """By their keys."""
    future: "Future[Answer]"
    again: bool = False
    """True where a first answer was lost on its way."""


class _Slot(NamedTuple):
    """Place of a point in the order: done, or under way as the n-th of a task."""

    done: Done | None
    task: _Task | None = None
    place: int = 0


def evaluate_points(points: Iterable[PointOrRefusal], store: Store, pool: WorkerPool | None = None) -> Iterator[Done]:
    """Yield the records of points in their order, from the store or, after they were evaluated, saved in it.

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
                store.save(zip(task.points, _task_records(future), strict=True))


def _evaluate_by_pool(
    stream: Iterator[PointOrRefusal], store: Store, pool: WorkerPool, under_way: dict["Future[Answer]", _Task]
) -> Iterator[Done]:
    """Yield the records of points in order, evaluated by a pool. Tasks with unsaved records are in `under_way`."""
    slots: deque[_Slot] = deque()
    more, most = True, 1  # the first point alone: where kernels are new, it compiles for all
    while more or slots:
        while more and len(under_way) < most and len(slots) < MAX_PENDING:
            block = list(islice(stream, LOOKUP_BLOCK if most > 1 else 1))
            more = bool(block)
            for slot in _send_block(block, store, pool):
                slots.append(slot)
                if slot.task is not None:
                    under_way[slot.task.future] = slot.task
        if under_way and slots[0].task is not None and slots[0].task.future in under_way:
            finished, _ = wait(under_way, return_when=FIRST_COMPLETED)
            most = TASKS_PER_WORKER * pool.workers
            for future in finished:
                task = under_way[future]
                if _is_lost(task):
                    task.future, task.again = _submit_task(task.points, pool), True
                    under_way[task.future] = task
                else:
                    store.save(zip(task.points, _task_records(future), strict=True))
                del under_way[future]
        while slots and (slots[0].task is None or slots[0].task.future not in under_way):
            yield _finish_slot(slots.popleft())


def _evaluate_here(block: Sequence[PointOrRefusal], store: Store) -> Iterator[Done]:
    """Yield the records of points in their order, evaluated by this process. Simulated points are saved one by one."""
    keys = [point_key(point) if isinstance(point, Point) else "" for point in block]
    stored = store.get([name for name in keys if name])
    unsaved: list[tuple[str, Record]] = []
    finished: list[Done] = []
    for point, name in zip(block, keys, strict=True):
        if not isinstance(point, Point):
            finished.append(Done(name, point, False))
        elif name in stored:
            finished.append(Done(name, stored[name], True))
        else:
            finished.append(Done(name, evaluate(point), False))
            unsaved.append((name, finished[-1].record))
            if point.simulated:
                store.save(unsaved)
                unsaved.clear()
                yield from finished
                finished.clear()
    store.save(unsaved)
    yield from finished


def _send_block(block: Sequence[PointOrRefusal], store: Store, pool: WorkerPool) -> list[_Slot]:
    """Send the points that are not stored to the pool as tasks, and return a slot for each point of the block."""
    keys = [point_key(point) if isinstance(point, Point) else "" for point in block]
    stored = store.get([name for name in keys if name])
    fresh = {
        name: point for name, point in zip(keys, block, strict=True) if isinstance(point, Point) and name not in stored
    }
    simulated = any(point.simulated for point in fresh.values())
    size = 1 if simulated else POINTS_PER_TASK
    names = list(fresh)
    places: dict[str, tuple[_Task, int]] = {}
    for first in range(0, len(names), size):
        part = {name: fresh[name] for name in names[first : first + size]}
        task = _Task(part, _submit_task(part, pool))
        places |= {name: (task, place) for place, name in enumerate(part)}
    slots = []
    for name, point in zip(keys, block, strict=True):
        if not isinstance(point, Point):
            slots.append(_Slot(Done(name, point, False)))
        elif name in stored:
            slots.append(_Slot(Done(name, stored[name], True)))
        else:
            slots.append(_Slot(None, *places[name]))
    return slots


def _evaluate_task(points: Sequence[Point]) -> Answer:
    """Evaluate points on a worker. Return a hash of its walkergen's sources, and the records."""
    return digest(), [evaluate(point) for point in points]


def _submit_task(points: dict[str, Point], pool: WorkerPool) -> "Future[Answer]":
    """Submit points to the pool as a task and return its future. Raises WalkergenError if the workers have ended."""
    try:
        return pool.executor.submit(_evaluate_task, list(points.values()))
    except BrokenExecutor as error:
        raise WalkergenError(WORKER_LOST.format(error)) from error


def _is_lost(task: _Task) -> bool:
    """Return whether a finished task failed for the first time, so that it should be submitted again.

    While a worker of a cluster ends, *distributed* can fail on a valid answer. An error in the points themselves is
    raised again by the second try.
    """
    error = task.future.exception()
    return not task.again and error is not None and not isinstance(error, (BrokenExecutor, ImportError))


def _task_records(future: "Future[Answer]") -> list[Record]:
    """Return the records of a finished task. Raises WalkergenError if it failed or its worker has other sources."""
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
    """Return the evaluated point of a slot. Its task, if it has one, has ended."""
    if slot.done is not None:
        return slot.done
    assert slot.task is not None
    _, records = slot.task.future.result()
    return Done(list(slot.task.points)[slot.place], records[slot.place], False)
