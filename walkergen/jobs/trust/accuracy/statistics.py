"""The ladder of statistics: standard error of the mean speed against time and number of runs."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from walkergen.files.progress import Progress
from walkergen.jobs.trust.accuracy.budget import Runs
from walkergen.jobs.trust.accuracy.ladder import Ladder, Rung
from walkergen.jobs.trust.accuracy.survey import Survey
from walkergen.simulation import ensemble
from walkergen.simulation.run import RunResult

KINDS = (Runs(32, 4.0), Runs(16, 2.0), Runs(8, 1.0))
"""Numbers of runs whose parts are compared, each with the time from which it is worth it: of two
runs that are too short the fewer are taken, as the budget allows."""

LONGEST = 50.0
"""Longest run that is compared, s."""

WEIGHT = 0.4
"""Weight of the ladder in the survey's budget, where all settings together have 1."""

RUN_COUNTS = (4, 8, 16)
LENGTHS = (0.5, 1.0, 2.0, 5.0, 10.0, 25.0, 50.0)
"""Lengths of the parts' runs, s."""


def ladder(survey: Survey, progress: Progress) -> Ladder:
    """Compare stated with actual errors of parts of one long ensemble.

    Every part's mean speed has its own error bar as `ensemble.mean_speed` states it; the root mean
    square of the parts' deviations from the whole is the actual error.
    """
    reference = survey.reference(progress)
    unit = survey.unit(reference)
    (own,) = survey.measure([survey.own], progress)
    bias = survey.bias(own, reference)
    ensemble_runs = _affordable(survey)
    results, cpu_per_s = survey.ensemble(survey.own, ensemble_runs, progress)
    correlation = ensemble.correlation_time(results)
    rungs = []
    for runs in (runs for runs in RUN_COUNTS if 2 * runs <= ensemble_runs.number):
        for length in (length for length in LENGTHS if 2.0 * length <= ensemble_runs.seconds):
            parts = _parts(results, runs, length)
            rungs.append(_rung(parts, results, unit.size, cpu_per_s, own.discard_seconds))
    correlation_text = "longer than the runs tell" if correlation is None else f"{1e3 * correlation:.0f} ms"
    ensemble_text = f"{ensemble_runs.number} runs of {ensemble_runs.seconds:g} s"
    notes = [f"Correlation time of the speed: {correlation_text}."]
    if bias is not None:
        share = bias.bound / unit.size
        notes.append(
            f"Bias of {survey.own.label}: at most {share:.2g}, with 95 % confidence. Where the "
            "statistical error is below that, more time does not help: take a smaller step."
        )
    return Ladder(
        "statistics",
        "Standard error of the mean speed against simulated time",
        f"standard error actually made, {unit.name}",
        "CPU time, s",
        f"mean of the whole ensemble, {ensemble_text} by {survey.own.label}",
        rungs,
        notes,
    )


def least(survey: Survey) -> float:
    """Wall time of the least ensemble whose parts can be compared, s."""
    return survey.budget.cost(KINDS[-1], survey.rate(survey.own), survey.scene.run.discard_seconds)


def _affordable(survey: Survey) -> Runs:
    """Runs within the ladder's share of the budget, which it takes."""
    granted, rate = survey.take("statistics"), survey.rate(survey.own)
    runs = survey.budget.affords(granted, rate, survey.scene.run.discard_seconds, KINDS)
    return runs._replace(seconds=min(runs.seconds, LONGEST))


def _parts(results: Sequence[RunResult], runs: int, length: float) -> list[list[RunResult]]:
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
    stated = [mean for mean in map(ensemble.mean_speed, parts) if mean is not None]
    # The whole contains each part: a deviation from it is smaller by the part's share of the data.
    freedom = max(len(parts) - 1, 1) / len(parts)
    deviations = np.array([mean.value - true for mean in stated]) / math.sqrt(freedom)
    actual = math.sqrt(float(np.mean(deviations**2)))
    halves = [0.5 * (high - low) for low, high in (mean.interval(0.95) for mean in stated)]
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
            "stated_se_mm_s": math.sqrt(float(np.mean([mean.se**2 for mean in stated]))),
            "inside_95": float(np.mean(np.abs(deviations) <= halves)),
            "actual_se_mm_s": actual,
        },
    )
