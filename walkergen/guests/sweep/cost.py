"""Expected cost of a sweep, extrapolated from a few of its points."""

from collections.abc import Iterator
from itertools import islice
from typing import NamedTuple

from walkergen.core import WalkergenError, format_duration, format_number
from walkergen.guests.sweep.sweep_points import SweepPoints
from walkergen.points import model_kinds, run_time
from walkergen.points.point import PREDICTION, Point, point_key
from walkergen.points.store import Store

MAX_UNCONFIRMED_POINTS = 100_000
"""Largest number of points in a sweep that starts without confirmation of its cost."""

PILOT_POINTS, PREDICTED_PILOTS, PILOT_DIVISOR = 5, 8, 3
"""Number of simulated and of predicted points whose cost is measured, and smallest ratio of all points to these if the
measurement needs first runs of each, as for a requested or an accepted error."""

MIN_SWEEP_S, MIN_SIMULATION_S = 100.0, 0.1
"""Simulated time of a sweep below which its cost is not estimated; CPU time above which a point is simulated, s."""

BYTES_PER_POINT = 300
"""Most bytes that a point takes in table and store together, plus the same for each group of quantities."""


class Cost(NamedTuple):
    """Expected time and disk space of a sweep."""

    points: int
    seconds: float
    """Time by the clock, s."""
    bytes: float
    note: str = ""
    """Reason why a predicted sweep takes long."""


def estimate(sweep: SweepPoints, store: Store, workers: int) -> Cost | None:
    """Estimate time and disk space of a sweep from a few points at even distances.

    Invalid and stored points cost nothing. Returns None for a small sweep, which takes little longer than an estimate.
    """
    points, run = sweep.space.point_count, sweep.scene.run
    costly = sweep.wanted is not None or (sweep.model != PREDICTION and run.accepted_error is not None)
    predicted = sweep.model == PREDICTION
    count = PREDICTED_PILOTS if predicted else min(PILOT_POINTS, points // PILOT_DIVISOR) if costly else PILOT_POINTS
    if count == 0 or (not predicted and points * run.runs * run.seconds < MIN_SWEEP_S):
        return None
    pilots = list(_pilot_points(sweep, count))
    stored = store.get([point_key(pilot) for pilot in pilots])
    costs = [0.0 if point_key(pilot) in stored else _point_cost(pilot) for pilot in pilots]
    total_s = run_time.wall_time(sum(costs) / count, points, workers)
    simulated = round(points * sum(cpu_s > MIN_SIMULATION_S for cpu_s in costs) / count)
    text = f"the surrogate has no speed for {simulated} of {points} points: they are simulated"
    note = text if predicted and simulated else ""
    return Cost(points, total_s, BYTES_PER_POINT * (1.0 + len(sweep.keep)) * points, note)


def _pilot_points(sweep: SweepPoints, count: int) -> Iterator[Point]:
    """Yield up to `count` valid points, to measure their cost, evenly spread over the first MAX_UNCONFIRMED_POINTS."""
    total = min(sweep.space.point_count, MAX_UNCONFIRMED_POINTS)
    chosen = {total * (2 * number + 1) // (2 * count) for number in range(count)}
    for index, row in enumerate(islice(sweep.space.rows(), total)):
        if index in chosen:
            point = sweep.try_point(dict(zip(sweep.space.keys, row, strict=True)))
            if isinstance(point, Point):
                yield point


def _point_cost(point: Point) -> float:
    """Estimate the CPU seconds of a point; 0 if it cannot be evaluated."""
    try:
        return model_kinds.load_kind(point.kind).cost(point)
    except WalkergenError:
        return 0.0


def format_cost(cost: Cost | None, points: int) -> str:
    """Format number of points, time and disk space as a line; only `points` if the cost is unknown (None)."""
    if cost is None:
        return f"{format_number(points, 4)} points"
    needed = f"about {format_duration(cost.seconds)} and {format_number(cost.bytes / 1e6, 3)} MB on the disk"
    return f"{format_number(cost.points, 4)} points: {needed}"
