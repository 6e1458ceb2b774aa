"""Budget of time: more runs where the error bars are worst."""

import math
import time

from walkergen.core import InputError, Progress, format_number
from walkergen.core.measure import FIRST_RUNS
from walkergen.guests.sweep import evaluation as run
from walkergen.guests.sweep.evaluation import Asked
from walkergen.guests.sweep.point_request import Request
from walkergen.points.point import PREDICTION, Point, Record, point_key
from walkergen.points.store import Store
from walkergen.points.walkers import MAX_RUN_S
from walkergen.points.worker_pool import WorkerPool

POINTS_PER_WORKER = 4
"""Points for each worker that get more runs together."""

BATCH_DIVISOR = 4
"""Share of the points, one in so many, that at most gets more runs at a time: the worst of them."""

MAX_DOUBLINGS = 12
"""Number of times that the runs of a point are doubled at most: to a bar 64 times narrower."""

MAX_POINTS = 100_000
"""Number of points that may share a budget: they are kept in memory."""


def spend(request: Request, seconds: float, store: Store, pool: WorkerPool | None, progress: Progress) -> list[Asked]:
    """Evaluate the points of a request, spending a number of seconds on runs.

    All points first get a few short runs, however long these take. Then the points with the widest bounds get double
    the runs, repeatedly. Runs from an earlier budget are kept. Raises InputError for predictions, which have no runs,
    and for too many points.
    """
    check_budget(request)
    until = time.monotonic() + seconds
    points = [_double_runs(point, 0) for point in request.points()]
    for number, point in enumerate(points):
        points[number] = _restore_runs(point, store)
    half = []
    for number, done in enumerate(run.evaluate_points(points, store, pool), start=1):
        half.append(_half_width(done.record))
        progress("one pass", number, len(points))
    hands = 1 if pool is None else pool.workers
    batch = max(1, min(POINTS_PER_WORKER * hands, len(points) // BATCH_DIVISOR))
    most = FIRST_RUNS * 2**MAX_DOUBLINGS
    while (left := until - time.monotonic()) > 0.0:
        open_ = [n for n, point in enumerate(points) if half[n] > 0.0 and _run_count(point) < most]
        worst = sorted(open_, key=lambda n: (-half[n], n))[:batch]
        if not worst:
            break
        progress(f"widest bars, ± {format_number(half[worst[0]], 2)} mm/s", round(seconds - left), round(seconds))
        more = [_double_runs(points[n], 1) for n in worst]
        for n, point, done in zip(worst, more, run.evaluate_points(more, store, pool), strict=True):
            points[n], half[n] = point, _half_width(done.record)
    return points


def check_budget(request: Request) -> None:
    """Refuse a budget that buys nothing. Raises InputError."""
    if request.model == PREDICTION:
        raise InputError("‹budget›: predictions have no runs to add: ‹model=›space")
    if not request.kind.MEETS_ERRORS:
        raise InputError("‹budget›: is for speeds of one walker: set scene.run.runs of crowds")
    if request.space.points > MAX_POINTS:
        raise InputError(f"‹budget›: {request.space.points} points; at most {MAX_POINTS} share a budget")


def _double_runs(point: Asked, times: int) -> Asked:
    """Double the runs of a point so many times; with 0 times return the first runs, short ones."""
    if not isinstance(point, Point):
        return point
    run_ = point.scene.run
    changed = {"runs": run_.runs * 2**times} if times else {"runs": FIRST_RUNS, "seconds": min(run_.seconds, MAX_RUN_S)}
    scene = point.scene.model_copy(update={"run": run_.model_copy(update=changed)})
    return point._replace(scene=scene, wanted=point.wanted if times else None)


def _restore_runs(point: Asked, store: Store) -> Asked:
    """Return a point with the most runs in the store, or with the first ones."""
    if not isinstance(point, Point):
        return point
    levels = [point, *(_double_runs(point, times) for times in range(1, MAX_DOUBLINGS + 1))]
    keys = [point_key(level) for level in levels if isinstance(level, Point)]
    stored = store.get(keys)
    best = max((number for number, name in enumerate(keys) if name in stored), default=0)
    return levels[best]


def _run_count(point: Asked) -> int:
    return point.scene.run.runs if isinstance(point, Point) else 0


def _half_width(record: Record) -> float:
    """Return the half-width of a point's bounds, mm/s; infinite with too few runs, 0 if more would not help."""
    low, high = record.get("low_95_mm_s"), record.get("high_95_mm_s")
    if isinstance(low, float) and isinstance(high, float):
        return 0.5 * (high - low)
    return 0.0 if record.get("speed_mm_s") is None else math.inf
