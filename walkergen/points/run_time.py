"""Estimates of the time that runs will take on this machine.

A moment, the start of one run, is simulated and timed. So every effect and every model is included. The number of runs
for an error follows from the scatter of the first runs. Times by the clock are those of an idle machine.
"""

import math
import time
from collections.abc import Sequence
from typing import Any, NamedTuple

from walkergen.core.files import formatting
from walkergen.core.files.progress import Expect, Expected, ignore_estimate
from walkergen.core.measure import Measured, UntilError, core_count
from walkergen.core.numerics import statistics
from walkergen.core.simulation.batch import Stopped
from walkergen.core.simulation.observables import SPEED
from walkergen.core.simulation.plan import Plan
from walkergen.core.simulation.run import ENDED_WELL, compile_kernels, simulate
from walkergen.core.tolerance import Tolerance
from walkergen.points.experiments import Walker

MOMENT_S = 0.4
"""CPU time of a moment, s."""

SETTLING_S, MAX_MOMENT_S = 0.1, 60.0
"""Start of a moment, until the walker has landed, and the moment's longest time after that, s."""

STEP_CPU_S = 2.5e-7
"""CPU time of a step, or of a period of the plate, s: 0.1 to 0.3 us were measured."""

MAX_START_S = 2.0
"""Maximum CPU time of the start of a simulated moment, s. The start cannot be stopped."""

MIN_RUNS_S = 10.0
"""Simulated time of all runs below which they take no time that is worth a moment, s."""


def stop_after_moment() -> Stopped:
    """Return a function that stops a run: it returns True once MOMENT_S of CPU time have passed from now."""
    ends = time.thread_time() + MOMENT_S
    return lambda: time.thread_time() >= ends


def rate_from_steps(plan: Plan) -> float:
    """Return an upper limit of the CPU seconds per simulated second, from the number of time steps or plate periods."""
    step = getattr(plan.world.options, "step", None)  # none of models that go from event to event
    return STEP_CPU_S * max(0.0 if step is None else 1.0 / step, plan.equivalent_drive.frequency)


def measure_rate(plan: Plan) -> float:
    """Estimate the CPU seconds per simulated second by simulating the first run for MOMENT_S of CPU time.

    Return `rate_from_steps` instead if even the start of that run would take longer than MAX_START_S.
    """
    by_steps = rate_from_steps(plan)
    if SETTLING_S * by_steps > MAX_START_S:
        return by_steps
    compile_kernels(plan)
    result = simulate(plan.with_run_settings(seconds=MAX_MOMENT_S, discard_seconds=SETTLING_S), 0, stop_after_moment())
    return result.cpu_s / (SETTLING_S + result.measured_s)


def run_cpu_s(walker: Walker) -> float:
    """Estimate the CPU seconds of one run of a walker, from the rate that `measure_rate` returns."""
    run = walker.scene.run
    return measure_rate(walker.plan()) * (run.discard_seconds + run.seconds)


def wall_time(task_cpu_s: float, tasks: int, workers: int | None = None) -> float:
    """Return the clock time (s) of equal tasks that run in parallel on `workers` cores; None: all cores."""
    return task_cpu_s * math.ceil(tasks / (workers or core_count()))


def total_time(walkers: Sequence[Walker]) -> Expected | None:
    """Estimate the clock time of all runs of walkers, one walker after the other; None below MIN_RUNS_S."""
    runs = [walker.scene.run for walker in walkers]
    if sum(run.runs * (run.discard_seconds + run.seconds) for run in runs) < MIN_RUNS_S:
        return None
    return Expected(sum(wall_time(run_cpu_s(walker), walker.scene.run.runs) for walker in walkers))


class ErrorWithEstimate(NamedTuple):
    """Rule that adds runs until an error is met, and reports the remaining time after the first runs."""

    until: UntilError
    expect: Expect = ignore_estimate

    @property
    def first_runs(self) -> int:
        """Number of runs to begin with."""
        return self.until.first_runs

    def request_more(self, measured: Measured[Walker]) -> Measured[Walker] | None:
        """Return the measurement with more runs or a finer step requested; None if the error is met or cannot fall.

        After the first runs, call `expect` with a function that estimates the remaining time.
        """
        more = self.until.request_more(measured)
        if more is not None and measured.runs == self.until.first_runs:
            self.expect(lambda: remaining_time(self.until, measured))
        return more


def remaining_time(until: UntilError, measured: Measured[Walker]) -> Expected:
    """Estimate the remaining clock time until the error is met, from the first runs `measured`.

    A note compares the total time with the total time for the next larger error.
    """
    cheaper = until._replace(tolerance=next_larger_error(until.tolerance))
    cores, left = core_count(), remaining_cpu_s(until, measured)
    whole, other = (
        formatting.format_duration((total_cpu_s(measured) + cost) / cores)
        for cost in (left, remaining_cpu_s(cheaper, measured))
    )
    return Expected(
        left / cores, "" if whole == other else f"{until.tolerance} {whole} in all, {cheaper.tolerance} {other}"
    )


def remaining_cpu_s(until: UntilError, measured: Measured[Walker]) -> float:
    """Estimate the remaining CPU seconds until the error is met, from the first runs `measured`; 0 if it is met."""
    if until.request_more(measured) is None:
        return 0.0
    finer = until.select_resolution(measured)
    runs = _runs_needed(until, measured, finer)
    if finer is measured.experiment:
        return total_cpu_s(measured) * max(runs - measured.runs, 0) / measured.runs
    return run_cpu_s(finer) * runs


def total_cpu_s(measured: Measured[Any]) -> float:
    """Return the CPU seconds that the finished runs took."""
    return float(sum(record.cpu_s for record in measured.records))


def _runs_needed(until: UntilError, measured: Measured[Walker], finer: Walker) -> int:
    """Estimate the number of runs of the walker `finer` that meet an error, from the scatter of the finished runs.

    `finer`: the measured walker, or the same with a smaller time step.
    """
    quantity = measured._replace(experiment=finer).quantities[until.column]
    scatter = _run_scatter(measured, until.column, quantity.se or 0.0)
    for runs in range(until.first_runs, until.max_runs):
        if quantity._replace(se=scatter / math.sqrt(runs), freedom=runs - 1.0).half_width() <= until.max_error(
            quantity.value
        ):
            return runs
    return until.max_runs


def _run_scatter(measured: Measured[Walker], of: str, se: float) -> float:
    """Return the standard deviation from run to run of the quantity named `of`. `se`: standard error of its mean.

    For the speed, a more precise `se` is computed from blocks of all runs.
    """
    good = [record for record in measured.records if record.outcome in ENDED_WELL]
    if of == SPEED and good:
        series, block_s = [record.block_speeds for record in good], good[0].block_s
        correlation = statistics.correlation_time(series, block_s)
        known = None if correlation is None else statistics.error_of_mean(series, block_s, correlation)
        se = se if known is None else known
    return se * math.sqrt(len(good) or 1)


def next_larger_error(wanted: Tolerance) -> Tolerance:
    """Return the tolerance with the next larger error of the series 1, 2, 5, 10."""
    digit = 10.0 ** math.floor(math.log10(wanted.value) + 1e-9)
    larger = next(step * digit for step in (2.0, 5.0, 10.0) if step * digit > wanted.value * (1.0 + 1e-9))
    return wanted._replace(value=float(f"{larger:.6g}"))
