"""The ladder of statistics: standard error of the mean speed against time and number of runs."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from walkergen.commands.accuracy.report import Ladder, Rung
from walkergen.commands.accuracy.survey import STATISTICS, StepMeasurement, Survey
from walkergen.core.files import formatting
from walkergen.core.files.progress import Progress
from walkergen.core.measure import Runs
from walkergen.core.simulation import ensemble
from walkergen.core.simulation.run import RunResult

ENSEMBLE_SIZES = ((32, 4.0), (16, 2.0), (8, 1.0))
"""Numbers of runs whose parts are compared, each with the shortest useful measured time of a run, s."""

MAX_RUN_S = 50.0
"""Longest run that is compared, s."""

RUN_COUNTS = (4, 8, 16)
LENGTHS_S = (0.5, 1.0, 2.0, 5.0, 10.0, 25.0, 50.0)
"""Lengths of the parts' runs, s."""


def compare_parts(survey: Survey, progress: Progress) -> Ladder:
    """Compare stated with actual errors of parts of one long ensemble.

    Every part's mean speed has its own error bar as `ensemble.mean_speed` states it; the root mean
    square of the parts' deviations from the whole is the actual error.
    """
    survey.measure_reference(progress)
    (own,) = survey.measure([survey.own], progress)
    unit, bias = survey.unit, survey.bias_bound(own)
    granted_s = survey.claim_budget(STATISTICS)
    runs_in_all, seconds = _affordable_runs(granted_s, own)
    made = survey.simulate(survey.own, seconds, Runs(runs_in_all), progress)
    survey.too_short |= (runs_in_all, seconds) == ENSEMBLE_SIZES[-1] and made.summary.wall_s > granted_s
    results = made.results
    cpu_per_s = made.summary.cpu_s / (runs_in_all * (seconds + own.discard_s))
    correlation = ensemble.correlation_time(results)
    rungs = []
    for runs in (runs for runs in RUN_COUNTS if 2 * runs <= runs_in_all):
        for length in (length for length in LENGTHS_S if 2.0 * length <= seconds):
            parts = _split_into_parts(results, runs, length)
            rungs.append(_rung(parts, results, unit, cpu_per_s, own.discard_s))
    correlation_text = "longer than the runs tell" if correlation is None else f"{1e3 * correlation:.0f} ms"
    notes = [f"Correlation time of the speed: {correlation_text}."]
    if math.isfinite(bias):
        notes.append(
            f"Bias of {own.label}: at most {bias / unit:.2g}, with 95 % confidence. Where the "
            "statistical error is below that, more time does not help: take a smaller step."
        )
    return Ladder(
        "statistics",
        "Standard error of the mean speed against simulated time",
        f"standard error actually made, share of {formatting.format_number(unit)} mm/s",
        "CPU time, s",
        f"mean of the whole ensemble, {runs_in_all} runs of {seconds:g} s by {own.label}",
        rungs,
        notes,
    )


def _affordable_runs(granted_s: float, own: StepMeasurement) -> tuple[int, float]:
    """Return the number of runs that a wall time allows, and their length: fewer where they would be too short."""
    simulated_s = granted_s / own.wall_s * own.runs * (own.seconds + own.discard_s)
    for runs, least_s in ENSEMBLE_SIZES:
        seconds = float(f"{min(max(simulated_s / runs - own.discard_s, 0.1), MAX_RUN_S):.2g}")
        if seconds >= least_s:
            return runs, seconds
    return ENSEMBLE_SIZES[-1]


def _split_into_parts(results: Sequence[RunResult], runs: int, length: float) -> list[list[RunResult]]:
    """Cut the ensemble into parts of `runs` runs of `length` s each, without overlap."""
    blocks = max(1, round(length / results[0].block_s))
    groups = [results[at : at + runs] for at in range(0, len(results) - runs + 1, runs)]
    starts = range(0, len(results[0].block_speeds) + 1, blocks)
    return [[_window(result, low, high) for result in group] for group in groups for low, high in pairwise(starts)]


def _window(result: RunResult, low: int, high: int) -> RunResult:
    speeds = result.block_speeds[low:high]
    measured = (high - low) * result.block_s
    return result._replace(measured_s=measured, speed=float(speeds.mean()), block_speeds=speeds)


def _rung(
    parts: Sequence[Sequence[RunResult]], whole: Sequence[RunResult], unit: float, cpu_per_s: float, discard: float
) -> Rung:
    true = float(np.mean([result.speed for result in whole]))
    stated = [mean for mean in map(ensemble.mean_speed, parts) if mean.known]
    # The whole contains each part: a deviation from it is smaller by the part's share of the data.
    freedom = max(len(parts) - 1, 1) / len(parts)
    deviations = np.array([mean.number - true for mean in stated]) / math.sqrt(freedom)
    actual = math.sqrt(float(np.mean(deviations**2)))
    halves = [mean.half_width() for mean in stated]
    runs, length = len(parts[0]), parts[0][0].measured_s
    return Rung(
        f"{runs} runs",
        f"{runs} x {length:.3g} s",
        actual / unit,
        actual / unit / math.sqrt(2.0 * len(parts)),
        cpu_per_s * runs * (length + discard),
        {
            "runs": runs,
            "seconds": length,
            "parts": len(parts),
            "stated_se_mm_s": math.sqrt(float(np.mean([mean.pair[1] ** 2 for mean in stated]))),
            "inside_95": float(np.mean(np.abs(deviations) <= halves)),
            "actual_se_mm_s": actual,
        },
    )
