"""Growth of the mean squared displacement with the lag: local exponents, and where they cross over."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.analysis import lag_sums, motion
from walkergen.analysis.motion import Curve
from walkergen.analysis.tracks import Tracks
from walkergen.core.numerics import Array, statistics
from walkergen.core.numerics.quantity import Quantity

LAGS_PER_DECADE = 8
"""Number of lags in a decade; an exponent is the slope over two steps, a quarter of a decade."""

MIN_LAG_S = 0.04
"""Shortest lag of the exponents, s: that of figure 6c, some four periods of the drive."""

LATE_LAG_S = 1.0
"""Shortest lag at which the paper's slow walker is diffusive, s (stated)."""

CROSSOVER_EXPONENT = 1.5
"""Local exponent at the crossover, halfway from ballistic to diffusive."""

EMPTY = np.zeros(0)


class Growth(NamedTuple):
    """Growth of the mean squared displacement with the lag."""

    exponents: Curve = Curve(EMPTY, EMPTY, EMPTY)
    """Local exponents d log MSD / d log lag by lag (s); empty for runs too short, or at rest."""
    first: Quantity = Quantity("exponent", "", None)
    """Exponent at the shortest lag."""
    smallest: Quantity = Quantity("exponent", "", None)
    """Smallest exponent at any lag."""
    late: Quantity = Quantity("exponent", "", None)
    """Exponent from LATE to the longest lag; none when that is shorter than 1.5 LATE."""
    crossover: Quantity = Quantity("crossover", "s", None)
    """Lag at which the exponent first falls to HALFWAY; none when it does not in every run."""


def measure_growth(tracks: Tracks) -> Growth:
    """Local exponents at lags from SHORTEST to a quarter of the shortest track, and what they say.

    An exponent is the slope over two neighbouring steps of lags on the logarithmic scale. Errors
    are those of a jackknife over the tracks.
    """
    longest = min(len(track.position) for track in tracks.tracks) // motion.FITTED_LAG_DIVISOR
    shortest = max(round(MIN_LAG_S / tracks.interval), 1)
    count = round(LAGS_PER_DECADE * math.log10(max(longest / shortest, 1.0))) + 1
    lags = lag_sums.log_spaced_lags(longest, count, shortest)
    sums = np.array([lag_sums.sum_squares(track.position, lags) for track in tracks.tracks])
    whole = sums.sum(axis=0)
    if len(lags) < 3 or not (whole - sums > 0.0).all():
        return Growth()
    log_sums = [np.log(squares / pairs) for squares, pairs in (whole, *(whole - sums))]
    log_lags = np.log(lags * tracks.interval)
    slopes = np.array([(logs[2:] - logs[:-2]) / (log_lags[2:] - log_lags[:-2]) for logs in log_sums])
    lowest = int(slopes[0].argmin())
    return Growth(
        Curve(np.exp(log_lags[1:-1]), slopes[0], np.asarray(statistics.jackknife_error(slopes[1:]))),
        _jackknife_quantity("exponent", "", slopes[:, 0]),
        _jackknife_quantity("exponent", "", slopes[:, lowest]),
        _jackknife_quantity("exponent", "", [_late_exponent(log_lags, logs) for logs in log_sums]),
        _jackknife_quantity("crossover", "s", [_crossover_lag(log_lags[1:-1], exponents) for exponents in slopes]),
    )


def _jackknife_quantity(key: str, unit: str, replicates: "Sequence[float] | Array") -> Quantity:
    """Value of the whole, which comes first, with the error that the rest give it."""
    numbers = np.asarray(replicates)
    if not np.isfinite(numbers).all():
        return Quantity(key, unit, None, refused="not in every run")
    error = float(statistics.jackknife_error(numbers[1:, None])[0])
    return Quantity(key, unit, float(numbers[0]), error, len(numbers) - 2)


def _late_exponent(log_lag: Array, log_squares: Array) -> float:
    """Slope of log MSD from LATE to the longest lag; NaN when that is shorter than 1.5 LATE."""
    first, last = math.log(LATE_LAG_S), float(log_lag[-1])
    if last < first + math.log(1.5):
        return math.nan
    return float((log_squares[-1] - np.interp(first, log_lag, log_squares)) / (last - first))


def _crossover_lag(log_lag: Array, slopes: Array) -> float:
    """Lag (s) at which the slopes first fall to HALFWAY; NaN when they do not."""
    below = np.flatnonzero(slopes <= CROSSOVER_EXPONENT)
    if not len(below) or below[0] == 0:
        return math.nan
    at = int(below[0])
    share = (slopes[at - 1] - CROSSOVER_EXPONENT) / (slopes[at - 1] - slopes[at])
    return math.exp(log_lag[at - 1] + share * (log_lag[at] - log_lag[at - 1]))
