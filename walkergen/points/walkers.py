"""Simulation of walkers: as many runs as their scenes request, or as an allowed error needs. Motion from these runs.

A relative error of the speed refers to at least MIN_SPEED_RATIO of the plate's peak speed.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from walkergen.analysis import motion
from walkergen.analysis.motion import Motion
from walkergen.analysis.tracks import Tracks, from_positions
from walkergen.core.drive import Drive
from walkergen.core.errors import InputError
from walkergen.core.files import formatting
from walkergen.core.files.progress import Expect, Progress, ignore_estimate, part_progress, silent
from walkergen.core.measure import FIRST_RUNS, Measured, Runs, Until, UntilError, measure
from walkergen.core.scene import Scene
from walkergen.core.simulation import batch, ensemble, observables
from walkergen.core.simulation.observables import SPEED
from walkergen.core.simulation.run import ENDED_WELL, RunResult
from walkergen.core.tolerance import Tolerance
from walkergen.points import experiments, run_time, step_errors, trajectory
from walkergen.points.experiments import Results, Walker
from walkergen.points.run_time import ErrorWithEstimate

MAX_RUN_S = 4.0
"""Maximum measured time of a run for an error: more runs give more than longer ones."""

MIN_SPEED_RATIO = 0.2
"""Ratio of speed and plate's peak speed: a relative error of a slower walker refers to this speed."""


STEADY_RATIO, REPEATED_RUNS, STEP_FACTOR = 0.3, 2, 2.0
"""Range of runs over their speed's tabulated error by the step, below which that error is measured; runs repeated for
it; and the error over the change by half the step: 2 at first order, 4/3 at second."""


def simulate(walker: Walker, progress: Progress = silent, threads: int | None = None) -> Results:
    """Simulate all runs that the walker's scene requests. Raises InputError if the scene contradicts itself."""
    return _to_results(measure(walker, Runs(walker.scene.run.runs), progress, threads))


def with_measured_step_error(results: Results) -> Results:
    """Return results whose speed has a measured error by the step, if its runs hardly scatter; else the same results.

    The first runs are repeated from the same drops at half the step (Richardson). The tabulated error of all walkers
    stays where runs scatter: it is then the smaller one.
    """
    speed, finer = results.summary.speed, results.walker.finer()
    speeds = [run.speed for run in results.results if run.outcome in ENDED_WELL]
    few = results.partial or len(speeds) < max(results.summary.runs, REPEATED_RUNS)
    if few or finer is None or math.isinf(speed.bias) or np.ptp(speeds) > STEADY_RATIO * speed.bias:
        return results
    plan = finer.plan()
    again = batch.run_all(ensemble.runner(plan), REPEATED_RUNS)
    changes = [abs(run.speed - own) for run, own in zip(again, speeds, strict=False)]
    measured = speed._replace(bias=STEP_FACTOR * max(changes))
    return results._replace(summary=results.summary._replace(numbers={**results.summary.numbers, SPEED: measured}))


def simulate_each(walkers: Sequence[Walker], titles: Sequence[str], progress: Progress) -> Iterator[Results]:
    """Yield the results of walkers in turn when finished; progress is reported under their titles.

    Raises KeyboardInterrupt rather than yield a walker with runs missing.
    """
    for number, walker in enumerate(walkers):
        results = simulate(walker, part_progress(progress, number, len(walkers), titles[number]))
        if results.partial:
            raise KeyboardInterrupt
        yield results


def simulate_parallel(walkers: Sequence[Walker], progress: Progress = silent) -> dict[int, Results]:
    """Simulate walkers in parallel, one thread each. Return results by index, without those unfinished after Ctrl-C."""
    return batch.run_parallel(
        lambda number, stopped, tell: simulate(walkers[number], silent, 1), range(len(walkers)), progress
    )


class ErrorResult(NamedTuple):
    """Results of a walker that was simulated until an allowed error was met, or no more runs could help."""

    results: Results
    of: str
    """Name of the observable that has the error."""
    allowed: float
    """Requested error, in its unit."""

    @property
    def error(self) -> float:
        """Half-width of the 95 % bounds from runs and time step, in the observable's unit; infinite if unknown."""
        return self.results.summary.numbers[self.of].half_width()

    @property
    def lines(self) -> list[tuple[str, str]]:
        """Settings chosen to meet the error, and the error obtained: names and values as text."""
        summary, step, run = self.results.summary, self.results.step_us, self.results.walker.scene.run
        unit = "mm/s" if self.of == SPEED else f"of {self.of}"
        within = "within" if self.error <= self.allowed else "NOT within"
        stepping = "" if step is None else f", step {formatting.format_number(step, 3)} us"
        by_step = formatting.format_number(self.results.summary.numbers[self.of].bias, 2)
        obtained = (
            f"{formatting.format_number(self.error, 2)} {unit}, {within} the "
            f"{formatting.format_number(self.allowed, 2)} requested"
        )
        return [
            ("chosen", f"{summary.runs} x {run.seconds:g} s{stepping}"),
            ("error, 95 %", f"{obtained} ({by_step} by the step)"),
        ]

    @property
    def facts(self) -> dict[str, Any]:
        """Settings that were chosen to meet the error, and the error obtained, by their keys in the JSON output."""
        return {
            "runs": self.results.summary.runs,
            "seconds": self.results.walker.scene.run.seconds,
            "step_us": self.results.step_us,
            "step_error": self.results.summary.numbers[self.of].bias,
            "of": self.of,
            "error": None if math.isinf(self.error) else self.error,
            "allowed": self.allowed,
        }


def simulate_to_error(
    walker: Walker,
    wanted: Tolerance,
    of: str = SPEED,
    progress: Progress = silent,
    threads: int | None = None,
    expect: Expect = ignore_estimate,
) -> ErrorResult:
    """Simulate short runs of a walker until the observable named `of` has the `wanted` error, or no run could help.

    The time step is halved if it takes up more of the error than runs could make good. `expect` receives the remaining
    time after the first runs. After Ctrl-C the finished runs are returned. Raises InputError if the scene
    contradicts itself or the design, and for an observable that no run gives, or that the step does not resolve.
    """
    if of not in observables.OBSERVABLE_NAMES:
        raise InputError(f"‹of=›{of[:60]!r}: must be one of {', '.join(observables.OBSERVABLE_NAMES)}")
    if of != SPEED and not wanted.relative:
        raise InputError(f"‹error=›{wanted}: only a mean speed is in mm/s. Write a share, such as 5%.")
    until = speed_rule(wanted, walker.equivalent_drive) if of == SPEED else UntilError(wanted, of)
    results = _simulate_short_runs(walker, ErrorWithEstimate(until, expect), progress, threads)
    number = results.summary.numbers[of]
    if reason := step_errors.reason(number):
        raise InputError(f"‹error=›{wanted}: {of} is {reason}")
    return ErrorResult(results, of, until.max_error(number.value))


def simulate_with_limit(walker: Walker, wanted: Tolerance, max_runs: int, progress: Progress = silent) -> Results:
    """Simulate short runs of a walker until its speed has the `wanted` error or `max_runs` runs are made."""
    return _simulate_short_runs(
        walker, speed_rule(wanted, walker.equivalent_drive)._replace(max_runs=max_runs), progress, None
    )


def cost_to_error(walker: Walker, wanted: Tolerance) -> float:
    """Estimate the CPU seconds of all runs that give the speed the `wanted` error. Simulates the first of them."""
    first = measure(_with_first_runs(walker), Runs(FIRST_RUNS))
    return run_time.total_cpu_s(first) + run_time.remaining_cpu_s(speed_rule(wanted, walker.equivalent_drive), first)


def _simulate_short_runs(walker: Walker, until: Until, progress: Progress, threads: int | None) -> Results:
    """Simulate runs of at most MAX_RUN_S until the rule `until` requests no more."""
    return _to_results(measure(_with_first_runs(walker), until, progress, threads))


def _with_first_runs(walker: Walker) -> Walker:
    """Return the walker with a scene that requests FIRST_RUNS runs of at most MAX_RUN_S."""
    return walker.with_run_settings(runs=FIRST_RUNS, seconds=min(walker.scene.run.seconds, MAX_RUN_S))


def speed_rule(wanted: Tolerance, drive: Drive) -> UntilError:
    """Return the rule that adds runs until the speed has the `wanted` error. `drive`: the plate's."""
    return UntilError(wanted, SPEED, MIN_SPEED_RATIO * drive.peak_speed)


def _to_results(measured: Measured[Walker]) -> Results:
    """Return the runs of a finished measurement with their statistics."""
    return experiments.from_records(measured.experiment, measured.records, measured.runs, measured.wall_s)


def tracks_of(results: Sequence[RunResult], lane: bool, interval: float | None) -> Tracks:
    """Return the tracks of runs, seen from above.

    Parameters
    ----------
    results
        Finished runs.
    lane
        True if only the position along a lane counts.
    interval
        Time between the runs' samples, s; None for the positions at the ends of the runs' blocks.
    """
    if interval is None:
        return from_positions([result.places for result in results], results[0].block_s, lane)
    return from_positions([trajectory.sample_rows(result)[:, 1:4] for result in results], interval, lane)


def motion_of(results: Sequence[RunResult], scene: Scene, interval: float | None = None) -> tuple[Motion | None, str]:
    """Return the motion estimated from tracks of runs, and ""; None and the reason if the runs are too short.

    Parameters
    ----------
    results
        Finished runs.
    scene
        Scene of the runs.
    interval
        Time between samples of the tracks, s; None for the ends of the runs' blocks.
    """
    slope = 0.0 if "plate_slope" in scene.effects.off else scene.plate.slope_deg
    descent = None if not slope else 0.0 if slope > 0.0 else math.pi  # heading downhill, rad
    tracks = tracks_of(results, scene.arena.kind == "lane", interval)
    longest = tracks.interval * max(len(track.position) - 1 for track in tracks.tracks)
    least = max(motion.DEFAULT_LAG_S, tracks.interval)
    if longest > 1.001 * least:  # beyond rounding
        return motion.analyse(tracks, descent=descent), ""
    return None, f"runs of {longest:.3g} s are too short; at least {2 * least:.2g} s"
