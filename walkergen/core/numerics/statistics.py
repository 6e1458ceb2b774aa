"""Errors of measured quantities: weighted mean, quantiles, correlation time, error of a mean, jackknife."""

import math
from collections.abc import Sequence

import numpy as np

from walkergen.core.numerics import Array
from walkergen.core.numerics.distributions import student_quantile

MIN_SERIES_LENGTH = 32
"""Length of a series below which its correlation time cannot be estimated."""

MIN_SAMPLES = 30
"""Number of independent samples (pairs of correlation times) below which the error of a mean is refused. Near it the
correlation time, and the error with it, come out too small in those series that pass: by 30 % at 25 samples (4 of 10
series pass), 20 % at 30, 5 % at 50 and 2 % at 100, measured with Ornstein-Uhlenbeck processes."""

MIN_VALUES_FOR_95 = 39
"""Number of values whose least and largest are the ends of bounds that hold another with 95 %."""

WINDOW_CORRELATION_TIMES = 5.0
"""Number of correlation times over which products are summed (Sokal 1997, section 3)."""


def weighted_mean(values: Array, weights: Array | None = None) -> tuple[float, float, float]:
    """Return mean, standard error and degrees of freedom of n >= 2 values, shape (n,), with `weights` (None: equal).

    Weights are the times measured. With w_i their shares, the squared error is sum w_i^2 (x_i - mean)^2 / (1 - sum
    w_i^2), and the degrees of freedom are 1/(sum w_i^2) - 1 (Satterthwaite 1946, Biometrics Bull. 2, 110, for variances
    that fall as 1/w). With equal weights this is the spread over the root of n, with n - 1.
    """
    share = np.full(len(values), 1.0 / len(values)) if weights is None else weights / weights.sum()
    value = float(share @ values)
    squares = float(share @ share)
    se = math.sqrt(float(share**2 @ (values - value) ** 2) / (1.0 - squares))
    return value, se, 1.0 / squares - 1.0


def prediction_quantiles(values: Array, shares: Sequence[float]) -> Array:
    """Return quantiles, at the probabilities `shares`, for the next value after n >= 2 independent `values`.

    Between the least and the largest value they follow Weibull's plotting positions i / (n + 1), which hold for any
    continuous distribution. Quantiles rarer than 1 / (n + 1) lie outside the values: their distance from the median is
    that of the outermost value times the ratio of Student's t (n - 1 degrees of freedom) at both probabilities. So
    bounds of 95 % hold 92.5 to 98.5 % of tested distributions from 16 to 38 values, 91 to 98 % from 8 and 88 to 94 %
    from 4. The outermost values hold (n - 1) / (n + 1).
    """
    count, wanted = len(values), np.asarray(shares, dtype=float)
    rarest = 1.0 / (count + 1)
    within = np.clip(wanted, rarest, 1.0 - rarest)
    middle = np.median(values)
    ends = np.quantile(values, within, method="weibull")
    beyond = wanted != within
    further, outermost = ([student_quantile(count - 1, p) for p in levels[beyond]] for levels in (wanted, within))
    ends[beyond] = middle + np.divide(further, outermost) * (ends[beyond] - middle)
    return np.asarray(ends)


def correlation_time(series: Sequence[Array], interval: float) -> float | None:
    """Return the integrated autocorrelation time (s) of series sampled every `interval` seconds.

    Deviations are from the mean of all series. Deviations from each series' mean would hide changes slower than a
    series. Products of deviations are summed in Sokal's self-consistent window (A. Sokal, in Functional Integration,
    1997, section 3), with the correction for the mean's error (U. Wolff, Comput. Phys. Commun. 156, 143, 2004, section
    3.2). At least half an interval. None if no series has MIN_SERIES_LENGTH values, or if the window does not close
    within half of the longest series.
    """
    longest = max((len(values) for values in series), default=0)
    if longest < MIN_SERIES_LENGTH:
        return None
    count = sum(len(values) for values in series)
    middle = sum(float(values.sum()) for values in series) / count
    centred = [values - middle for values in series]
    variance = sum(float(values @ values) for values in centred) / count
    if variance == 0.0:
        return 0.5 * interval
    time = 0.5
    for lag in range(1, longest // 2):
        long = [values for values in centred if len(values) > lag]
        products = sum(float(values[:-lag] @ values[lag:]) for values in long)
        time += products / sum(len(values) - lag for values in long) / variance
        if lag >= WINDOW_CORRELATION_TIMES * time:
            return max(time * (1.0 + (2 * lag + 1) / count), 0.5) * interval
    return None


def error_of_mean(series: Sequence[Array], interval: float, correlation: float) -> float | None:
    """Estimate the standard error of the mean over all series, sampled every `interval` seconds.

    Two correlation times (`correlation`, s) make one independent sample. Returns None with fewer than MIN_SAMPLES. Use
    it if there are too few series for an error from the scatter of their means. It misses changes slower than a series.
    """
    values = np.concatenate(list(series))
    independent = len(values) * interval / (2.0 * correlation)
    if independent < MIN_SAMPLES:
        return None
    return float(values.std(ddof=1) / math.sqrt(independent))


def jackknife_error(replicates: Array) -> Array:
    """Compute standard errors, shape (k,), from leave-one-out values of shape (n, k) with n >= 2.

    Efron and Stein (1981); the n groups left out must be independent and of similar size.
    """
    count = len(replicates)
    spread = replicates - replicates.mean(axis=0)
    error: Array = np.sqrt((count - 1) / count * np.sum(spread**2, axis=0))
    return error
