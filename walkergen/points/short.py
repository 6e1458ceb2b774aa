"""A walker's speed by a short simulation: as designed to 5 %, and over prints of what is not known of it.

The store keeps it, so that whoever asks again, and whoever asks elsewhere, gets the same at once.
"""

import math

from walkergen.errors import InputError
from walkergen.files.progress import Progress, part
from walkergen.points import draws, walkers
from walkergen.points.point import Record, digest
from walkergen.points.store import Store
from walkergen.points.tolerance import Tolerance
from walkergen.scene import Scene
from walkergen.simulation.experiments import Walker
from walkergen.simulation.run import Outcome
from walkergen.theory import prediction
from walkergen.theory.prediction import Spread
from walkergen.theory.surrogate import NORMAL_95

ERROR = Tolerance(0.05, relative=True)
"""Error of the nominal speed of a short simulation."""

PRINTS = 32
"""Prints that are drawn for the bounds of what is not known, each in one short run."""

PRINT_S, PRINT_DISCARD_S = 2.0, 0.5
"""Measured time of such a run, and the start of it that is not measured, s."""

LONGEST_S, MOST_RUNS = 4.0, 64
"""Measured time of a run of the nominal walker, s, and most of these runs."""

FEW_LEGS = 4
"""Legs up to which runs have their full time."""

ENDS = ("low_95", "low_68", "high_68", "high_95")
"""Names of the ends of the bounds over prints in a record."""

FALLS_ALL = 0.5
"""Share of the runs that fall from which on a walker has no speed."""


def _key(walker: Walker) -> str:
    """Key of a walker's numbers, and of how long it runs for them."""
    return f"speed {walker.key} {digest()} {LONGEST_S:g} {MOST_RUNS} {PRINTS} {PRINT_S:g}"


def kept(walker: Walker) -> Record | None:
    """Numbers of a short simulation of a walker that the store has; None without."""
    store = Store()
    try:
        return store.get([_key(walker)]).get(_key(walker))
    finally:
        store.close()


def simulated(walker: Walker, progress: Progress) -> Record:
    """Numbers of a short simulation of a walker, which the store then has."""
    few = walker.with_run(seconds=min(walker.scene.run.seconds, LONGEST_S * _light(walker)))
    results = walkers.short(few, ERROR, MOST_RUNS, part(progress, 0, 2, "as designed"))
    if results.partial:
        raise KeyboardInterrupt
    summary = results.summary
    record: Record = {
        "nominal": summary.speed_mm_s,
        "low": summary.speed_low_95_mm_s,
        "high": summary.speed_high_95_mm_s,
        "falls": summary.outcomes.get(Outcome.TOPPLED.value, 0) / summary.runs,
    }
    record |= _of_prints(few, progress)
    store = Store()
    try:
        store.put([(_key(walker), record)])
    finally:
        store.close()
    return record


def _light(walker: Walker) -> float:
    """Share of the usual time for which a walker runs: with many legs it takes longer, and repeats itself sooner."""
    return min(1.0, FEW_LEGS / len(walker.design.limbs))


def _of_prints(walker: Walker, progress: Progress) -> Record:
    """Mean, scatter and bounds over prints, mm/s; none of walkers of which too few prints walk."""
    seconds = PRINT_S * _light(walker)
    run = walker.scene.run.model_copy(update={"seconds": seconds, "discard_seconds": PRINT_DISCARD_S})
    scene = walker.scene.model_copy(update={"run": run})
    try:
        drawn = draws.simulated(scene, walker.design, PRINTS, part(progress, 1, 2, "as you will get it"))
    except InputError:
        return {}
    speeds = drawn.halves.mean(axis=1)
    ends = draws.bounds(speeds, draws.statistical_error(drawn.halves))
    mean = float(speeds.mean())
    ends = draws.widened(ends, mean, drawn.by_step_mm_s)
    record: Record = dict(zip(ENDS, ends, strict=True))
    return record | {"mean": mean, "sd": float(speeds.std(ddof=1))}


def spread(record: Record, scene: Scene) -> Spread | None:
    """Speeds of a record, with the model's own error in the bounds; None of a walker that falls."""
    nominal, low, high = (_number(record, name) for name in ("nominal", "low", "high"))
    if nominal is None or float(record["falls"] or 0.0) >= FALLS_ALL:
        return None
    bounds = nominal if low is None else low, nominal if high is None else high  # one orbit has no scatter
    mean = _number(record, "mean")
    if mean is None:  # nothing is unknown, or too few prints walk to tell
        half = 0.5 * (bounds[1] - bounds[0])
        mean, sd = nominal, half / NORMAL_95
        ends = bounds[0], nominal - half / 2.0, nominal + half / 2.0, bounds[1]
    else:
        sd = float(record["sd"] or 0.0)
        low2, low1, high1, high2 = (float(record[name] or 0.0) for name in ENDS)
        ends = low2, low1, high1, high2
    own = float(prediction.with_model_sd(mean, scene))
    ends = draws.added(ends, mean, (NORMAL_95 * own, own, own, NORMAL_95 * own))
    return Spread(nominal, bounds, mean, math.hypot(sd, own), ends, "runs")


def _number(record: Record, name: str) -> float | None:
    value = record.get(name)
    return None if value is None else float(value)
