"""Many independent runs of a plan: threads, seeds, and the statistics of their mean speed.

Runs differ by height, pitch and phase of the drop, which each draws from its own random stream
(seed, number): the first n of N runs equal an ensemble of n, to the bit, on any number of threads.
"""

import functools
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from walkergen.core.numerics import Array, statistics
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.simulation import observables, record
from walkergen.core.simulation.batch import OneRun
from walkergen.core.simulation.plan import Plan
from walkergen.core.simulation.run import ENDED_WELL, Outcome, RunResult, simulate, simulate_with_impacts
from walkergen.core.simulation.space.state import TRAJECTORY_COLUMNS

MIN_RUNS = 4
"""Number of runs that ended well below which a mean has no error bar (see `mean_speed`), and their agreement may be
chance."""

MAX_SPEED_DIFFERENCE = 1e-4
"""Largest difference of two runs' speeds on one orbit, over the plate's peak speed. Runs that start at random fall into
an orbit within some hundred periods to rounding; those that do not repeat differ by 1e-2 and more after a minute."""

ORBIT, REST = "one periodic orbit", "at rest"
"""Names of orbits that runs end on."""


class Summary(NamedTuple):
    """Statistics of an ensemble: speeds over the runs that ended well, all else over every run."""

    runs: int
    simulated_s: float
    cpu_s: float
    wall_s: float
    numbers: Mapping[str, Quantity]
    """Observables, by the names of `observables`; no errors where runs are too few or share an orbit."""
    correlation_time_s: float | None
    """Integrated autocorrelation time of the speed; None when the runs are too short to tell."""
    max_pitch_deg: float
    energy_error: float
    """Largest energy error (`record.energy_error`) of a run."""
    outcomes: dict[str, int]

    @property
    def speed(self) -> Quantity:
        """Mean speed; no value when no run ended well."""
        return self.numbers[observables.SPEED]

    @property
    def facts(self) -> dict[str, Any]:
        """Statistics by their keys in the JSON output."""
        table, numbers = functools.partial(observables.table_values, self.numbers), self.numbers
        return {
            "runs": self.runs,
            "simulated_s": self.simulated_s,
            "cpu_s": self.cpu_s,
            "wall_s": self.wall_s,
            **self.speed.row(68, 95),
            "correlation_time_s": self.correlation_time_s,
            observables.IMPACTS: numbers[observables.IMPACTS].value,
            observables.BY_NUMBER: table(observables.BY_NUMBER),
            observables.BY_IMPULSE: table(observables.BY_IMPULSE),
            observables.CONTACT: numbers[observables.CONTACT].value,
            "max_pitch_deg": self.max_pitch_deg,
            "energy_error": self.energy_error,
            observables.POWERS: table(observables.POWERS),
            "errors": {name: numbers[name].se for name in observables.OBSERVABLE_NAMES if name != observables.SPEED},
            "outcomes": self.outcomes,
        }


def runner(plan: Plan, impacts: bool = False, sample_interval: float | None = None) -> OneRun[RunResult]:
    """Return a function that simulates one run of `plan`, with the arguments of `OneRun`. The run's number is its seed.

    If `impacts` is true, each run keeps a record of all its impacts. With a `sample_interval` (s) it also keeps samples
    of the entries of its state that a trajectory shows, `space.state.TRAJECTORY_COLUMNS`.
    """
    simulate_one = simulate_with_impacts if impacts else simulate
    return lambda number, stopped, tell: simulate_one(plan, number, stopped, sample_interval, len(TRAJECTORY_COLUMNS))


def summarise(results: Sequence[RunResult], plate_speed: float, wall_s: float) -> Summary:
    """Summarize finished runs. Statistical errors are left out if all runs share a periodic orbit.

    `plate_speed` is the plate's peak speed, mm/s, and `wall_s` the time that all runs together took, s.
    """
    outcomes = Counter(result.outcome.value for result in results)
    ended_well = [result for result in results if result.outcome in ENDED_WELL]
    speeds = np.array([result.speed for result in ended_well])
    if 0 < len(ended_well) < MIN_RUNS:
        outcomes[Outcome.TOO_FEW.value] = len(ended_well)
    numbers = {observables.SPEED: mean_speed(ended_well), **observables.compute_observables(results)}
    if common_orbit(speeds, plate_speed) == ORBIT:
        outcomes[Outcome.ORBIT.value] = len(ended_well)
        for name, number in numbers.items():
            numbers[name] = number._replace(se=None, freedom=0.0, refused=Outcome.ORBIT.value)
    max_pitch = max((result.tally.sums[record.LARGEST_PITCH] for result in results), default=0.0)
    energy_error = max((result.energy_error for result in results), default=0.0)
    simulated = sum(float(result.tally.sums[record.ELAPSED]) for result in results)
    return Summary(
        runs=len(results),
        simulated_s=simulated,
        cpu_s=sum(result.cpu_s for result in results),
        wall_s=wall_s,
        numbers=numbers,
        correlation_time_s=correlation_time(ended_well),
        max_pitch_deg=math.degrees(max_pitch),
        energy_error=energy_error,
        outcomes=dict(outcomes),
    )


def common_orbit(speeds: Array, plate_speed: float) -> str:
    """Return the name of the orbit that all runs end on: ORBIT, REST (no motion), or "" if their speeds differ.

    `speeds`: mean speeds of the runs, shape (n,), mm/s. `plate_speed`: the plate's peak speed, mm/s. Fewer than
    MIN_RUNS runs give "". A walker on a periodic plate that starts at random repeats its motion every whole number of
    drive periods, or never. Only in the first case can all runs have one speed.
    """
    if len(speeds) < MIN_RUNS or float(np.ptp(speeds)) > MAX_SPEED_DIFFERENCE * plate_speed:
        return ""
    return REST if not np.any(speeds) else ORBIT


def correlation_time(results: Sequence[RunResult]) -> float | None:
    """Return the integrated autocorrelation time (s) of the speeds of the runs' blocks; None if runs are too short."""
    if not results:
        return None
    series = [result.block_speeds for result in results]
    return statistics.correlation_time(series, results[0].block_s)


def mean_speed(results: Sequence[RunResult]) -> Quantity:
    """Return the mean of the runs' speeds, with an error from their scatter if there are MIN_RUNS or more.

    Runs are the samples. They are independent, since each has its own drop, printed feet and noise; pieces of one run
    are not, if a walker changes its direction slowly (C. Alexopoulos and D. Goldsman, ACM Trans. Model. Comput. Simul.
    14, 76, 2004, compare both). Limit: walkers that all keep the same direction show no scatter. With two equally
    likely directions, n runs of T seconds that turn every t seconds all agree with the probability 2^(1-n) exp(-n T/t).
    It is 12.5 % for 4 runs that never turn: hence MIN_RUNS, and 8 or more runs if directions may outlast a run.
    """
    if not results:
        return Quantity("speed", "mm_s", None, refused="no run ended well")
    speeds = np.array([result.speed for result in results])
    mean = Quantity("speed", "mm_s", float(speeds.mean()), refused=Outcome.TOO_FEW.value)
    if len(results) < MIN_RUNS:
        return mean
    _, se, freedom = statistics.weighted_mean(speeds, np.array([result.measured_s for result in results]))
    return mean._replace(se=se, freedom=freedom, refused="")


def format_outcomes(outcomes: Mapping[str, int]) -> str:
    """Describe the outcomes of an ensemble: "7 ok, 1 toppled"."""
    return ", ".join(f"{count} {name}" for name, count in outcomes.items())
