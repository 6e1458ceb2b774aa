"""Many points: in order, stored ones not again, the same bits from any pool in spite of failures."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Executor, Future
from concurrent.futures.process import BrokenProcessPool

import pytest

from walkergen.core import measure
from walkergen.core.errors import WalkergenError
from walkergen.core.scene import Scene
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.sweep import axes
from walkergen.guests.sweep import evaluation as run
from walkergen.guests.sweep.axes import Space
from walkergen.guests.sweep.sweep_points import SweepPoints
from walkergen.points import worker_pool
from walkergen.points.model_kinds import evaluate
from walkergen.points.point import Point, point_key
from walkergen.points.store import Store
from walkergen.points.worker_pool import WorkerPool

SHORT_RUN = {"seconds": 0.5, "discard_seconds": 0.1, "runs": 4}
LANE = templates.load("lane-90hz", "scenes", Scene)
LANE = LANE.model_copy(update={"run": LANE.run.model_copy(update=SHORT_RUN)})
PAPER = templates.load("koumakis2016", "walkers", Design)


def request_of(*varied, model="prediction", scene=LANE):
    return SweepPoints(PAPER, scene, Space(tuple(axes.parse(text) for text in varied)), model)


MANY_POINTS = request_of("legs.tilt_deg=5:26:0.25,86,87,88,89", "scene.contact.friction=0.2,0.3")
"""178 points, three tasks, all with a certain speed but the steep ones, which are refused."""


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "points.sqlite")


@pytest.fixture(scope="module")
def two_workers():
    with worker_pool.local_pool(2) as found:
        yield found


class Faults(Executor):
    """Executor that runs immediately, with the faults that tests request."""

    def __init__(self, *fail_at, error=None, sources=None, ended=False):
        self.calls, self.fail_at, self.error, self.sources, self.ended = 0, fail_at, error, sources, ended

    def submit(self, function, /, *args, **kwargs):
        future = Future()
        self.calls += 1
        if self.calls in self.fail_at:
            if self.ended:
                raise self.error
            future.set_exception(self.error)
        else:
            found = function(*args, **kwargs)
            future.set_result((self.sources or found[0], found[1]))
        return future


def count_evaluations(monkeypatch):
    """List that grows by a point with every evaluation here."""
    seen = []

    def record_point(point):
        seen.append(point)
        return evaluate(point)

    monkeypatch.setattr(run, "evaluate", record_point)
    return seen


def test_points_come_in_their_order_refused_ones_among_them(store):
    found = list(run.evaluate_points(MANY_POINTS.points(), store))
    assert len(found) == MANY_POINTS.space.point_count
    rows = list(MANY_POINTS.space.rows())
    refused = [row for row, one in zip(rows, found, strict=True) if not one.key]
    assert 0 < len(refused) < 100
    assert min(refused) > max(row for row, one in zip(rows, found, strict=True) if one.key)
    for values, one in list(zip(rows, found, strict=True))[::25]:
        asked = MANY_POINTS.try_point(dict(zip(MANY_POINTS.space.keys, values, strict=True)))
        assert one.record == (asked if isinstance(asked, dict) else evaluate(asked))


def test_stored_points_are_not_evaluated_again(store, monkeypatch):
    seen = count_evaluations(monkeypatch)
    few = request_of("legs.tilt_deg=5:15:1")
    first = list(run.evaluate_points(few.points(), store))
    assert len(seen) == 11
    again = list(run.evaluate_points(few.points(), store))
    assert len(seen) == 11
    assert [one.record for one in again] == [one.record for one in first]
    assert {one.stored for one in first} == {False}
    assert {one.stored for one in again} == {True}
    more = list(run.evaluate_points(request_of("legs.tilt_deg=5:17:1").points(), store))
    assert len(seen) == 13  # an extended exploration evaluates what is new
    assert [one.stored for one in more] == [True] * 11 + [False] * 2
    # From another folder, another program: the file is all it takes.
    assert all(one.stored for one in run.evaluate_points(few.points(), Store(store.path)))


def test_points_requested_twice_are_evaluated_once_by_a_pool(store, monkeypatch):
    seen = count_evaluations(monkeypatch)
    asked = list(request_of("legs.tilt_deg=5,6,7").points())
    found = list(run.evaluate_points(asked * 3, store, WorkerPool(Faults(), 2)))
    assert len(seen) == 3
    assert [one.key for one in found] == [one.key for one in found[:3]] * 3


def test_finished_points_are_stored_when_no_more_are_requested(store, monkeypatch):
    seen = count_evaluations(monkeypatch)
    stream = run.evaluate_points(request_of("legs.tilt_deg=5:15:0.05").points(), store)
    next(stream)
    stream.close()
    assert 1 <= len(seen) <= run.LOOKUP_BLOCK
    assert all(one.stored for one in run.evaluate_points(seen, store))


@pytest.mark.parametrize("workers", [0, 2])
def test_slow_points_are_stored_as_soon_as_they_are_made(store, monkeypatch, workers):
    """The store is read from outside before each evaluation: of a pool, only its two tasks may be missing."""
    asked = list(request_of("legs.tilt_deg=5:16:1").points())
    stored = []

    def evaluate_slowly(point):
        stored.append(len(Store(store.path).get(keys)))
        return evaluate(point)

    keys = [point_key(point) for point in asked]
    monkeypatch.setattr(run, "MAX_UNSAVED_S", 0.0)
    monkeypatch.setattr(run, "evaluate", evaluate_slowly)
    found = list(run.evaluate_points(asked, store, WorkerPool(Faults(), workers) if workers else None))
    assert [one.key for one in found] == keys
    assert [one.record for one in found] == [evaluate(point) for point in asked]
    assert all(0 <= made - count <= workers for made, count in enumerate(stored))


def test_processes_give_the_same_bits_in_the_same_order(store, two_workers, tmp_path):
    here = list(run.evaluate_points(MANY_POINTS.points(), store))
    there = list(run.evaluate_points(MANY_POINTS.points(), Store(tmp_path / "other.sqlite"), two_workers))
    assert [one._replace(stored=False) for one in there] == here
    known = list(run.evaluate_points(MANY_POINTS.points(), store, two_workers))
    assert all(one.stored for one in known if one.key)
    assert [one.record for one in known] == [one.record for one in here]


def test_simulations_give_the_same_bits_in_processes(store, two_workers, tmp_path):
    request = request_of("legs.tilt_deg=5,12,88,20", model="space")
    here = list(run.evaluate_points(request.points(), store))
    there = list(run.evaluate_points(request.points(), Store(tmp_path / "other.sqlite"), two_workers))
    assert there == here
    assert [one.record["status"][:7] for one in here] == ["ok", "ok", "refused", "ok"]


def test_other_sources_on_a_worker_are_refused(store):
    asked = list(request_of("legs.tilt_deg=5").points())
    with pytest.raises(WalkergenError, match=r"version old of walkergen, and this machine [0-9a-f]+"):
        list(run.evaluate_points(asked, store, WorkerPool(Faults(sources="old"), 1)))
    assert not any(one.stored for one in run.evaluate_points(asked, store))


def test_a_worker_without_walkergen_is_reported(store):
    lost = Faults(1, error=ModuleNotFoundError("No module named 'walkergen'"))
    with pytest.raises(WalkergenError, match="a worker cannot import this version of walkergen: No module"):
        list(run.evaluate_points(MANY_POINTS.points(), store, WorkerPool(lost, 1)))


@pytest.mark.parametrize("error", [ValueError("a defect"), ModuleNotFoundError("walkergen")])
def test_points_finished_by_other_workers_are_stored_after_any_failure(store, error):
    broken = Faults(2, 10, error=error)  # the second of nine tasks, and when it is sent again
    with pytest.raises((ValueError, WalkergenError)):
        list(run.evaluate_points(MANY_POINTS.points(), store, WorkerPool(broken, 2)))
    known = [one.stored for one in run.evaluate_points(MANY_POINTS.points(), store) if one.key]
    assert known.count(True) >= 1 + 7 * run.POINTS_PER_TASK  # all that was sent but the broken task


def test_a_lost_answer_is_requested_again(store):
    """As *distributed* loses one, rarely, when a worker dies just after it has answered."""
    faults = Faults(2, error=ValueError("not enough values to unpack (expected 3, got 2)"))
    records = [done.record for done in run.evaluate_points(MANY_POINTS.points(), store, WorkerPool(faults, 2))]
    assert records == [evaluate(point) if isinstance(point, Point) else point for point in MANY_POINTS.points()]


def test_workers_that_have_ended_before_a_task_is_sent_are_one_line(store):
    ended = Faults(2, error=BrokenProcessPool("a child process terminated abruptly"), ended=True)
    with pytest.raises(WalkergenError, match="a worker process ended, perhaps"):
        list(run.evaluate_points(MANY_POINTS.points(), store, WorkerPool(ended, 2)))
    assert next(run.evaluate_points(MANY_POINTS.points(), store)).stored


def endless_points(scene=LANE):
    """Points: the first takes no time, the others hours."""
    first = list(request_of("legs.tilt_deg=10", model="space").points())
    long = scene.model_copy(update={"run": scene.run.model_copy(update={"seconds": 1e6})})
    others = request_of("legs.tilt_deg=11:20:1", model="space", scene=long)
    return [*first, *others.points()]


def test_a_dead_worker_gives_one_clear_error_and_finished_points_are_stored(store):
    pids = []

    def explore():
        with worker_pool.local_pool(1) as one:
            for done in run.evaluate_points(endless_points(), store, one):
                pids.append(done.key)
                (process,) = active_children_of(one)
                os.kill(process, signal.SIGKILL)

    started = time.monotonic()
    with pytest.raises(WalkergenError) as told:
        explore()
    assert time.monotonic() - started < 20
    assert "a worker process ended, perhaps" in str(told.value)
    assert "\n" not in str(told.value)
    assert len(pids) == 1
    assert list(store.get(pids)) == pids


def active_children_of(one):
    """Process numbers of a pool's workers."""
    return list(one.executor._processes)


INTERRUPTED_SCRIPT = """
import signal
import sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored by what a shell runs behind it
sys.path.insert(0, {tests!r})
from pathlib import Path
from walkergen.guests.sweep import evaluation
from walkergen.points import worker_pool
from walkergen.points.store import Store
import test_run

if __name__ == "__main__":
    store = Store(Path({path!r}))
    try:
        with worker_pool.local_pool(1) as one:
            for done in evaluation.evaluate_points(test_run.endless_points(), store, one):
                print(done.key, *one.executor._processes, flush=True)
    except KeyboardInterrupt:
        print("interrupted", flush=True)
"""


def is_alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize("ended_by", [signal.SIGINT, pytest.param(signal.SIGKILL, marks=pytest.mark.nightly)])
def test_no_worker_outlives_its_program(tmp_path, ended_by):
    script, path = tmp_path / "explore.py", tmp_path / "points.sqlite"
    here = os.path.dirname(__file__)  # noqa: PTH120
    script.write_text(INTERRUPTED_SCRIPT.format(tests=here, path=str(path)))
    with subprocess.Popen(
        [sys.executable, str(script)], stdout=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        try:
            key, *workers = process.stdout.readline().split()
            started = time.monotonic()
            process.send_signal(ended_by)
            told, _ = process.communicate(timeout=30)
        finally:
            process.kill()  # one that does not end fails, and is not waited for
    assert time.monotonic() - started < 30
    assert told == ("interrupted\n" if ended_by == signal.SIGINT else "")
    while any(is_alive(int(worker)) for worker in workers) and time.monotonic() - started < 30:
        time.sleep(0.05)
    assert not any(is_alive(int(worker)) for worker in workers)
    assert list(Store(path).get([key])) == [key]


def test_a_pool_has_a_sensible_number_of_workers():
    for count in (0, -1, worker_pool.MAX_WORKERS + 1):
        with pytest.raises(WalkergenError, match=rf"^workers={count}: must lie in 1\.\."):
            worker_pool.local_pool(count).__enter__()
    assert 1 <= measure.core_count() <= os.cpu_count()
