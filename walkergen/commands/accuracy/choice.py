"""Choice of the cheapest setting that meets an error: a step, a number of runs and their length.

Errors are half-widths of 95 %, as shares of the speed, or of a fifth of the plate's where that is more
(`step_law.speed_scale`).
"""

import math
from collections.abc import Iterable
from typing import NamedTuple, TypeVar

import numpy as np

from walkergen.core.files import formatting
from walkergen.core.numerics import Array
from walkergen.core.numerics.distributions import student_quantile
from walkergen.core.theory.surrogate import NORMAL_95

RUN_COUNTS, MIN_RUN_S = (8, 16, 32), 1.0
"""Numbers of runs to choose from, and the shortest measured time of a run, s."""

TIME_SAFETY_FACTOR = 1.2
"""Safety factor on the simulated time, because the scatter is itself estimated."""

MAX_BIAS_SHARE = 0.7
"""Largest share of the error that the bias may use."""

STARTUP_S = 1.2
"""Start-up time of a command on an idle machine, s: imports, and kernels read from the cache."""

MIN_CURVE_S = 0.5
"""Shortest measured time of all runs of a candidate in the curve, s."""


Seconds = TypeVar("Seconds", float, Array)


class Candidate(NamedTuple):
    """Step that may be chosen, with the errors and the cost of its runs."""

    step_us: float | None
    """Time step, us; None for the one that resolves the feet."""
    bias: float
    """Largest bias (95 %)."""
    variance_time: float
    """Squared standard error of the mean speed times measured time, (share)^2 s."""
    cpu_per_s: float
    """CPU time of a simulated second, s."""
    discard_s: float
    """Discarded start of every run, s."""

    @property
    def flags(self) -> str:
        """Options of the command line that select the step."""
        return "own step" if self.step_us is None else f"‹step=›{self.step_us:g}"

    def scatter_error(self, cpu_s: Array) -> Array:
        """Return the error from the scatter of the fewest runs in CPU times (s); infinite if the time is too short."""
        measured_s = cpu_s / self.cpu_per_s - RUN_COUNTS[0] * self.discard_s
        with np.errstate(divide="ignore", invalid="ignore"):
            half = NORMAL_95 * np.sqrt(self.variance_time / measured_s)
        return np.where(measured_s >= MIN_CURVE_S, half, np.inf)


class Choice(NamedTuple):
    """Candidate that meets an error, and the runs that it needs."""

    candidate: Candidate
    runs: int
    seconds: float
    """Measured time of each run."""
    se: float
    """Standard error that the runs will have."""
    error: float
    """Error that bias and runs will have together."""
    cpu_s: float
    """CPU time of all runs, s."""

    def wall_time_s(self, cores: int) -> float:
        """Return the wall time of the command on an idle machine, s."""
        return wall_time_s(self.cpu_s, self.runs, cores)

    @property
    def reason(self) -> str:
        """Parts of the error, in words."""
        bias, se = (formatting.format_number(100.0 * part, 2) for part in (self.candidate.bias, self.se))
        return f"bias at most {bias} %, ± {se} % for the runs"


def wall_time_s(cpu_s: Seconds, runs: int, cores: int) -> Seconds:
    """Return the wall time, s, of a command on an idle machine whose runs take a CPU time (s) in all."""
    return STARTUP_S + cpu_s / runs * math.ceil(runs / cores)


def choose(candidates: Iterable[Candidate], allowed: float) -> Choice | None:
    """Return the choice that meets the `allowed` error in the least CPU time; None if no candidate does."""
    good = [candidate for candidate in candidates if candidate.bias <= MAX_BIAS_SHARE * allowed]
    choices = (_size_runs(candidate, allowed, runs) for candidate in good for runs in RUN_COUNTS)
    return min(choices, key=lambda choice: choice.cpu_s, default=None)


def _size_runs(candidate: Candidate, allowed: float, runs: int) -> Choice:
    """Return the choice of the shortest runs that meet the `allowed` error; bias and scatter add in squares."""
    bias, variance_time = candidate.bias, candidate.variance_time
    quantile = student_quantile(runs - 1.0, 0.975)
    variance = (allowed**2 - bias**2) / quantile**2
    seconds = _round_up(max(TIME_SAFETY_FACTOR * variance_time / variance / runs, MIN_RUN_S))
    se = math.sqrt(variance_time / (runs * seconds))
    cpu_s = candidate.cpu_per_s * runs * (seconds + candidate.discard_s)
    return Choice(candidate, runs, seconds, se, math.hypot(bias, quantile * se), cpu_s)


def _round_up(seconds: float) -> float:
    """Round up to two significant digits."""
    digit = 10.0 ** (math.floor(math.log10(seconds)) - 1)
    return float(f"{math.ceil(seconds / digit - 1e-9) * digit:.2g}")
