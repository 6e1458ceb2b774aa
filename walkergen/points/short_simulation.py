"""A walker's speed by a short simulation: as designed to 5 %, and over printed walkers with its uncertain inputs.

Effects that change the speed by less than `run.accepted_error` are left out. The bounds include this change.

The store keeps the speed, so that a second request, from anywhere, gets the same immediately.
"""

import math
import time
from collections.abc import Iterator, Sequence
from contextlib import closing

from walkergen.core.drive import Drive
from walkergen.core.errors import InputError
from walkergen.core.files import formatting
from walkergen.core.files.progress import Progress, range_progress
from walkergen.core.measure import FIRST_RUNS, core_count
from walkergen.core.scene import Scene
from walkergen.core.simulation.effects.resolve import replace_without_validation
from walkergen.core.simulation.run import Outcome
from walkergen.core.theory import prediction
from walkergen.core.theory.prediction import By, PredictedSpeed, make_speed
from walkergen.core.theory.surrogate import NORMAL_95, SurrogateCase, UnknownError
from walkergen.core.tolerance import Tolerance
from walkergen.points import corrected_surrogate, print_ensemble, run_time, walkers
from walkergen.points.effect_selection import find_simplest
from walkergen.points.experiments import Walker
from walkergen.points.point import Record, digest
from walkergen.points.store import Store

NOMINAL_TOLERANCE = Tolerance(0.05, relative=True)
"""Error of the nominal speed of a short simulation."""

PRINT_COUNT = 32
"""Prints that are drawn for the bounds by uncertain inputs, each in one short run."""

PRINT_S, PRINT_DISCARD_S = 2.0, 0.5
"""Measured time of such a run, and the start of it that is not measured, s."""

MAX_RUN_S, MAX_RUNS = 4.0, 64
"""Measured time of a run of the nominal walker, s, and most of these runs."""

USUAL_S = 180.0, 20.0
"""Simulated time of a usual short simulation, and of one that corrects the surrogate, s."""

START_CPU_S = 1.0
"""CPU time until a walker and its prints are prepared, s."""

MAX_CPU_S = 150.0
"""Maximum CPU time, from the steps, of a walker that is simulated without a request, s: usual ones take 5 to 30."""

MAX_FULL_TIME_LEGS = 4
"""Maximum number of legs of walkers whose runs have their full time."""

BOUND_NAMES = ("low_95", "low_68", "high_68", "high_95")
"""Names of the ends of the bounds over prints in a record."""

MAX_FALL_SHARE = 0.5
"""Maximum share of runs that fall; with more, a walker has no speed."""


def _store_key(walker: Walker) -> str:
    """Return the key, in the store, of the record of a walker's short simulation."""
    return f"speed {walker.key} {digest()} {MAX_RUN_S:g} {MAX_RUNS} {PRINT_COUNT} {PRINT_S:g}"


def load_stored(walker: Walker) -> Record | None:
    """Load the record of a walker's short simulation from the store; None if there is none."""
    with closing(Store()) as store:
        return store.get([_store_key(walker)]).get(_store_key(walker))


def simulate_short(walker: Walker, case: SurrogateCase | None, progress: Progress) -> Record:
    """Compute the record of a walker's speeds (mm/s) by a short simulation, and save it in the store.

    `case`: the walker within the surrogate's domain, where a few runs may be enough; None outside it. Raises
    InputError for a walker with so many steps that it takes minutes.
    """
    if walker.scene.run.step_us is not None:  # the surrogate's ranges bound the steps of all others that it knows
        _check_run_length(walker)
    record = corrected_surrogate.correct_by_runs(walker, case, progress)
    if record is None:
        _check_run_length(walker)
        record = _simulate_runs(walker, progress)
    with closing(Store()) as store:
        store.save([(_store_key(walker), record)])
    return record


def expected_cpu_s(walker: Walker) -> float:
    """Estimate the CPU seconds of a walker's short simulation, from its beginning; 0 if it is not needed."""
    try:
        prediction.predict(walker.design, walker.mass, walker.scene, "coulomb")
    except UnknownError as reason:
        if load_stored(walker) is not None:
            return 0.0
        started = time.thread_time()
        rate = run_time.measure_rate(walker.plan())
        moment_s = time.thread_time() - started  # short if the walker falls: its other runs are then short too
        corrected = reason.near is not None and corrected_surrogate.can_correct(reason.near)
        return min(rate * USUAL_S[corrected], MAX_RUNS * moment_s)
    return 0.0


def expected_wall_s(cases: Sequence[Walker]) -> float:
    """Estimate the clock time (s) of short simulations of a family's walkers. Only the first one is timed."""
    rate = run_time.measure_rate(cases[0].plan())
    cpu_s = 0.0
    for walker in cases:
        try:
            prediction.predict(walker.design, walker.mass, walker.scene, "coulomb")
        except UnknownError as reason:
            corrected = reason.near is not None and corrected_surrogate.can_correct(reason.near)
            cpu_s += rate * USUAL_S[corrected] + START_CPU_S
    return cpu_s / core_count()


def _simulate_runs(walker: Walker, progress: Progress) -> Record:
    """Return the record of speeds, mm/s, from runs of the walker as designed and of its prints."""
    first = 0.0 if walker.scene.run.accepted_error is None else 0.33
    simple = find_simplest(
        _with_short_runs(walker), range_progress(progress, 0.0, first), simulated_s=_simulated_s(walker)
    )
    short_walker = simple.walker
    results = walkers.simulate_with_limit(
        short_walker, NOMINAL_TOLERANCE, MAX_RUNS, range_progress(progress, first, 0.5)
    )
    if results.partial:
        raise KeyboardInterrupt
    summary = results.summary
    low, high = summary.speed.interval() or (None, None)
    record: Record = {
        "by": "runs",
        "nominal": summary.speed.value,
        "low": low,
        "high": high,
        "falls": summary.outcomes.get(Outcome.TOPPLED.value, 0) / summary.runs,
        "left_out": dict(simple.lines).get("left out"),
        "left_out_mm_s": simple.error_mm_s,
    }
    return record | _simulate_prints(short_walker, progress)


def _with_short_runs(walker: Walker) -> Walker:
    """Return the walker with runs of at most MAX_RUN_S, shorter with many legs, for its speed as designed."""
    return walker.with_run_settings(seconds=min(walker.scene.run.seconds, MAX_RUN_S * _run_length_ratio(walker)))


def _estimate_cpu_s(walker: Walker) -> float:
    """Return an upper limit, from the number of time steps, of the CPU time of a simulation with the fewest runs, s."""
    return _simulated_s(walker) * run_time.rate_from_steps(walker.plan())


def _simulated_s(walker: Walker) -> float:
    """Return the simulated time of a simulation with the fewest runs, s."""
    run = _with_short_runs(walker).scene.run
    prints_s = PRINT_DISCARD_S + PRINT_S * _run_length_ratio(walker)
    return FIRST_RUNS * (run.discard_seconds + run.seconds) + PRINT_COUNT * prints_s


def _check_run_length(walker: Walker) -> None:
    """Raise InputError, which names the key that slows it, if a short simulation takes more than MAX_CPU_S."""
    cpu_s = _estimate_cpu_s(walker)
    if cpu_s <= MAX_CPU_S:
        return
    faster = [
        (_estimate_cpu_s(walker._replace(scene=scene)), key, value) for key, value, scene in _usual_scenes(walker.scene)
    ]
    least_s, key, value = min(faster)
    takes = (
        f"a prediction by runs takes {formatting.format_duration(cpu_s)} of CPU time, "
        f"{formatting.format_duration(MAX_CPU_S)} at most"
    )
    advice = "`simulate --seconds 0.1 --runs 2`"
    if least_s > 0.5 * cpu_s:
        raise InputError(f"{walker.design.name}: {takes}, because its parts are stiff, light or small. Use {advice}")
    raise InputError(f"scene.{key} = {value:g}: {takes}. Give another value, or use {advice}", f"scene.{key}")


def _usual_scenes(scene: Scene) -> Iterator[tuple[str, float, Scene]]:
    """Yield each key that may slow a simulation, with its value and the scene with the key's usual value."""
    yield (
        "drive.frequency_hz",
        scene.drive.frequency,
        replace_without_validation(scene, {"drive": Drive(frequency_hz=90.0, gamma=1.8)}),
    )
    for table in ("feet", "contact", "run"):
        section = getattr(scene, table)
        for name, field in type(section).model_fields.items():
            value = getattr(section, name)
            if isinstance(value, float) and value != field.default:
                key = f"{table}.{name}"
                yield key, value, replace_without_validation(scene, {key: field.default})


def _run_length_ratio(walker: Walker) -> float:
    """Return the walker's run length over the usual one: below 1 with many legs, as runs repeat themselves sooner."""
    return min(1.0, MAX_FULL_TIME_LEGS / len(walker.design.limbs))


def _simulate_prints(walker: Walker, progress: Progress) -> Record:
    """Return a record of the speed over prints, mm/s: mean, standard deviation, bounds; {} if too few prints walk."""
    seconds = PRINT_S * _run_length_ratio(walker)
    run = walker.scene.run.model_copy(update={"seconds": seconds, "discard_seconds": PRINT_DISCARD_S})
    scene = walker.scene.model_copy(update={"run": run})
    try:
        drawn = print_ensemble.simulate_prints(scene, walker.design, PRINT_COUNT, range_progress(progress, 0.5, 1.0))
    except InputError:
        return {}
    speeds = drawn.halves.mean(axis=1)
    ends = print_ensemble.speed_bounds(speeds, print_ensemble.statistical_error(drawn.halves))
    mean = float(speeds.mean())
    ends = print_ensemble.add_step_error(ends, mean, drawn.by_step_mm_s)
    record: Record = dict(zip(BOUND_NAMES, ends, strict=True))
    return record | {"mean": mean, "sd": float(speeds.std(ddof=1))}


def speed_from_record(record: Record, scene: Scene) -> PredictedSpeed | None:
    """Return the speeds in a record, as designed and over prints; None if it has none, or if half of the runs fell.

    Bounds over prints include the model's own error. All bounds include the change by effects that are left out.
    """
    value, low, high = (_float_or_none(record, name) for name in ("nominal", "low", "high"))
    if value is None or float(record["falls"] or 0.0) >= MAX_FALL_SHARE:
        return None
    left_out = _float_or_none(record, "left_out_mm_s") or 0.0
    first, last = value if low is None else low, value if high is None else high  # one orbit has no scatter
    first, _, _, last = print_ensemble.add_step_error((first, value, value, last), value, left_out)
    half = 0.5 * (last - first)
    bounds = first, value - half / 2.0, value + half / 2.0, last
    nominal = make_speed("nominal", value, half / NORMAL_95, bounds)
    mean = _float_or_none(record, "mean")
    if mean is None:  # nothing is uncertain, or too few prints walk
        mean, sd, ends = value, half / NORMAL_95, bounds
    else:
        sd = math.hypot(float(record["sd"] or 0.0), left_out / NORMAL_95)
        low2, low1, high1, high2 = (float(record[name] or 0.0) for name in BOUND_NAMES)
        ends = print_ensemble.add_step_error((low2, low1, high1, high2), mean, left_out)
    model_sd = float(prediction.model_error_sd(mean, scene))
    ends = print_ensemble.add_error(ends, mean, (NORMAL_95 * model_sd, model_sd, model_sd, NORMAL_95 * model_sd))
    return PredictedSpeed(nominal, make_speed("speed", mean, math.hypot(sd, model_sd), ends), _speed_source(record))


def _speed_source(record: Record) -> By:
    """Return the source of a record's speeds: runs alone, or the surrogate corrected by runs."""
    return "corrected" if record.get("by") == "corrected" else "runs"


def _float_or_none(record: Record, name: str) -> float | None:
    value = record.get(name)
    return None if value is None else float(value)
