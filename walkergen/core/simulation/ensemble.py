"""Many independent runs of a plan: threads, seeds, and the statistics of their mean speed.

Runs differ by height, pitch and phase of the drop, which each draws from its own random stream
(seed, number): the first n of N runs equal an ensemble of n, to the bit, on any number of threads.
"""

import functools
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core.files.progress import Progress
from walkergen.core.numerics import statistics
from walkergen.core.simulation import batch, observables, orbits, record
from walkergen.core.simulation.batch import OneRun
from walkergen.core.simulation.plan import Plan
from walkergen.core.simulation.run import ENDED_WELL, Outcome, RunResult, simulate, simulate_with_impacts
from walkergen.core.simulation.space.state import TRAJECTORY_COLUMNS

MIN_RUNS = 4
"""Number of runs that ended well below which a mean has no error bar (see `mean_speed`)."""


class Summary(NamedTuple):
    """Statistics of an ensemble: speeds over the runs that ended well, all else over every run."""

    runs: int
    simulated_s: float
    cpu_s: float
    wall_s: float
    speed_mm_s: float | None
    """Mean speed; None when no run ended well."""
    speed_se_mm_s: float | None
    """Standard error; None when runs are too few or share an orbit (`outcomes` says so)."""
    speed_low_68_mm_s: float | None
    """Lower bound of the mean speed with 68 % confidence, by Student's t, as the next three."""
    speed_high_68_mm_s: float | None
    speed_low_95_mm_s: float | None
    speed_high_95_mm_s: float | None
    correlation_time_s: float | None
    """Integrated autocorrelation time of the speed; None when the runs are too short to tell."""
    impacts_per_s: float
    type_fractions: dict[str, float]
    """Share of each type in the number of impacts; "sticking": of those in which a foot sticks."""
    type_fractions_by_impulse: dict[str, float]
    """Share of each type in the normal impulse of the feet's landings."""
    contact_fraction: float
    max_pitch_deg: float
    energy_error: float
    """Largest energy error (`record.energy_error`) of a run."""
    energies_per_s: dict[str, float]
    """Mean powers in g mm^2/s^3 (nW): from the plate, lost to impacts, friction and damping."""
    errors: dict[str, float | None]
    """Standard errors by the runs' scatter, by the names of `observables`; None: too few runs."""
    outcomes: dict[str, int]


def simulate_runs(
    plan: Plan,
    progress: Progress,
    threads: int | None = None,
    impacts: bool = False,
    sample_interval: float | None = None,
) -> list[RunResult]:
    """Simulate scene.run.runs runs (see `runner`), sorted by number, as `batch.run` does."""
    one = runner(plan, impacts, sample_interval)
    return list(batch.run_parallel(one, range(plan.scene.run.runs), progress, threads).values())


def runner(plan: Plan, impacts: bool = False, sample_interval: float | None = None) -> OneRun[RunResult]:
    """Return a function that simulates the run of a number.

    With `impacts` each run keeps all its impacts. With a `sample_interval` (s) it also keeps samples of the entries of
    its state that a trajectory shows, `space.state.COLUMNS`.
    """
    simulate_one = simulate_with_impacts if impacts else simulate
    return lambda number, stopped, tell: simulate_one(plan, number, stopped, sample_interval, len(TRAJECTORY_COLUMNS))


def summarise(results: Sequence[RunResult], plate_speed: float, wall_s: float) -> Summary:
    """Summarize finished runs on a plate of this peak speed (mm/s), which together took `wall_s` seconds.

    Runs that share a periodic orbit have no statistical errors.
    """
    outcomes = Counter(result.outcome.value for result in results)
    good = [result for result in results if result.outcome in ENDED_WELL]
    speeds = np.array([result.speed for result in good])
    mean = mean_speed(good)
    if good and mean is None:
        outcomes[Outcome.TOO_FEW.value] = len(good)
    locked = orbits.common_orbit(speeds, plate_speed) == orbits.ORBIT
    if locked:
        mean, outcomes[Outcome.ORBIT.value] = None, len(good)
    ends = () if mean is None else (*mean.interval(0.68), *mean.interval(0.95))
    bounds = [*ends] if ends and all(map(math.isfinite, ends)) else [None] * 4
    observed = observables.observe(results)
    table = functools.partial(observables.table_values, observed)
    pitch = max((result.tally.sums[record.LARGEST_PITCH] for result in results), default=0.0)
    energy_error = max((result.energy_error for result in results), default=0.0)
    simulated = sum(float(result.tally.sums[record.ELAPSED]) for result in results)
    return Summary(
        runs=len(results),
        simulated_s=simulated,
        cpu_s=sum(result.cpu_s for result in results),
        wall_s=wall_s,
        speed_mm_s=float(speeds.mean()) if good else None,
        speed_se_mm_s=None if mean is None else mean.se,
        speed_low_68_mm_s=bounds[0],
        speed_high_68_mm_s=bounds[1],
        speed_low_95_mm_s=bounds[2],
        speed_high_95_mm_s=bounds[3],
        correlation_time_s=correlation_time(good),
        impacts_per_s=observables.observed_value(observed, observables.IMPACTS),
        type_fractions=table(observables.BY_NUMBER),
        type_fractions_by_impulse=table(observables.BY_IMPULSE),
        contact_fraction=observables.observed_value(observed, observables.CONTACT),
        max_pitch_deg=math.degrees(pitch),
        energy_error=energy_error,
        energies_per_s=table(observables.POWERS),
        errors={name: None if locked else observable.se for name, observable in observed.items()},
        outcomes=dict(outcomes),
    )


def correlation_time(results: Sequence[RunResult]) -> float | None:
    """Integrated autocorrelation time of the block speeds (s); None when the runs are too short."""
    if not results:
        return None
    series = [result.block_speeds for result in results]
    return statistics.correlation_time(series, results[0].block_s)


def mean_speed(results: Sequence[RunResult]) -> statistics.Mean | None:
    """Mean speed, mm/s, of runs of any lengths; None for fewer than FEWEST_RUNS.

    Runs are the samples: other drops, prints and noise make them independent however slowly a
    walker changes its direction, and no piece of a run is (C. Alexopoulos and D. Goldsman, ACM
    Trans. Model. Comput. Simul. 14, 76, 2004, weigh the two). Limit: walkers that all keep the
    direction they started in show no spread. With two directions alike, n runs of T seconds that
    turn every t seconds all agree with a probability of 2^(1-n) exp(-n T/t), 12.5 % of 4 runs that
    never turn: hence FEWEST_RUNS, and 8 runs or more where directions may last longer than a run.
    """
    if len(results) < MIN_RUNS:
        return None
    speeds = np.array([result.speed for result in results])
    return statistics.weighted_mean(speeds, np.array([result.measured_s for result in results]))


def format_outcomes(outcomes: Mapping[str, int]) -> str:
    """Outcomes of an ensemble in words: "7 ok, 1 toppled"."""
    return ", ".join(f"{count} {name}" for name, count in outcomes.items())
