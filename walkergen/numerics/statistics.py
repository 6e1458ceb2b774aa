"""Errors of measured quantities: correlation time, jackknife, a line through the origin."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

FEWEST_VALUES = 32
"""Length of a series below which its correlation time cannot be estimated."""

FEWEST_SAMPLES = 30
"""Number of independent samples (pairs of correlation times) below which the error of a mean is
refused: the correlation time, and the error with it, then come out too small (by 40 % at 10
samples, 30 % at 25 and 10 % at 50, in simulated runs; `walkergen accuracy` measures it)."""


def correlation_time(series: Sequence[Array], interval: float) -> float | None:
    """Integrated autocorrelation time (s) of series sampled every `interval` seconds.

    Uses Sokal's self-consistent window over all series together. At least half an interval; None
    when no series has FEWEST_VALUES values.
    """
    long = [values for values in series if len(values) >= FEWEST_VALUES]
    if not long:
        return None
    centred = [values - values.mean() for values in long]
    variance = float(np.mean([np.mean(values**2) for values in centred]))
    if variance == 0.0:
        return 0.5 * interval
    time = 0.5
    for lag in range(1, min(len(values) for values in centred) // 4):
        product = float(np.mean([np.mean(values[:-lag] * values[lag:]) for values in centred]))
        time += product / variance
        if lag >= 5.0 * time:
            break
    return max(time, 0.5) * interval


def error_of_mean(series: Sequence[Array], interval: float, correlation: float) -> float | None:
    """Standard error of the mean over all series, sampled every `interval` seconds.

    Two correlation times (s) make one independent sample; None with fewer than FEWEST_SAMPLES.
    """
    values = np.concatenate(list(series))
    independent = len(values) * interval / (2.0 * correlation)
    if independent < FEWEST_SAMPLES:
        return None
    return float(values.std(ddof=1) / math.sqrt(independent))


def jackknife_error(replicates: Array) -> Array:
    """Standard errors, shape (k,), from leave-one-out values of shape (n, k) with n >= 2.

    Efron and Stein (1981); the n groups left out must be independent and of similar size.
    """
    count = len(replicates)
    spread = replicates - replicates.mean(axis=0)
    error: Array = np.sqrt((count - 1) / count * np.sum(spread**2, axis=0))
    return error


class Line(NamedTuple):
    """Straight line through the origin, fitted to points with errors."""

    slope: float
    slope_se: float
    chi2: float
    """Sum of the weighted squared residuals."""
    p_value: float
    """Probability of a chi2 at least as large if the points lie on a line through the origin."""
    points: int


def line_through_origin(x: Array, y: Array, errors: Array) -> Line:
    """Fit y = slope x by weighted least squares; shapes (n,) with n >= 2, errors > 0."""
    from scipy.stats import chi2 as chi2_law

    weights = errors**-2.0
    norm = float(np.sum(weights * x**2))
    slope = float(np.sum(weights * x * y)) / norm
    rest = float(np.sum(weights * (y - slope * x) ** 2))
    return Line(slope, norm**-0.5, rest, float(chi2_law.sf(rest, len(x) - 1)), len(x))
