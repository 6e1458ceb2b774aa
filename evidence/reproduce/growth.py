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

PER_DECADE = 8
"""Number of lags in a decade; an exponent is the slope over two steps, a quarter of a decade."""

SHORTEST = 0.04
"""Shortest lag of the exponents, s: that of figure 6c, some four periods of the drive."""

LATE = 1.0
"""Lag from which the paper's slow walker is diffusive, s (stated)."""

HALFWAY = 1.5
"""Local exponent at the crossover, halfway from ballistic to diffusive."""

NONE = np.zeros(0)


class Growth(NamedTuple):
    """Growth of the mean squared displacement with the lag."""

    exponents: Curve = Curve(NONE, NONE, NONE)
    """Local exponents d log MSD / d log lag by lag (s); empty for runs too short, or at rest."""
    first: Quantity = Quantity("exponent", "", None)
    """Exponent at the shortest lag."""
    smallest: Quantity = Quantity("exponent", "", None)
    """Smallest exponent at any lag."""
    late: Quantity = Quantity("exponent", "", None)
    """Exponent from LATE to the longest lag; none when that is shorter than 1.5 LATE."""
    crossover: Quantity = Quantity("crossover", "s", None)
    """Lag at which the exponent first falls to HALFWAY; none when it does not in every run."""


def of(tracks: Tracks) -> Growth:
    """Local exponents at lags from SHORTEST to a quarter of the shortest track, and what they say.

    An exponent is the slope over two neighbouring steps of lags on the logarithmic scale. Errors
    are those of a jackknife over the tracks.
    """
    longest = min(len(track.position) for track in tracks.tracks) // motion.FITTED_LAG_DIVISOR
    shortest = max(round(SHORTEST / tracks.interval), 1)
    count = round(PER_DECADE * math.log10(max(longest / shortest, 1.0))) + 1
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
        _of_replicates("exponent", "", slopes[:, 0]),
        _of_replicates("exponent", "", slopes[:, lowest]),
        _of_replicates("exponent", "", [_late(log_lags, logs) for logs in log_sums]),
        _of_replicates("crossover", "s", [_crossover(log_lags[1:-1], exponents) for exponents in slopes]),
    )


def _of_replicates(key: str, unit: str, replicates: "Sequence[float] | Array") -> Quantity:
    """Value of the whole, which comes first, with the error that the rest give it."""
    numbers = np.asarray(replicates)
    if not np.isfinite(numbers).all():
        return Quantity(key, unit, None, refused="not in every run")
    error = float(statistics.jackknife_error(numbers[1:, None])[0])
    return Quantity(key, unit, float(numbers[0]), error, len(numbers) - 2)


def _late(log_lag: Array, log_squares: Array) -> float:
    """Slope of log MSD from LATE to the longest lag; NaN when that is shorter than 1.5 LATE."""
    first, last = math.log(LATE), float(log_lag[-1])
    if last < first + math.log(1.5):
        return math.nan
    return float((log_squares[-1] - np.interp(first, log_lag, log_squares)) / (last - first))


def _crossover(log_lag: Array, slopes: Array) -> float:
    """Lag (s) at which the slopes first fall to HALFWAY; NaN when they do not."""
    below = np.flatnonzero(slopes <= HALFWAY)
    if not len(below) or below[0] == 0:
        return math.nan
    at = int(below[0])
    share = (slopes[at - 1] - HALFWAY) / (slopes[at - 1] - slopes[at])
    return math.exp(log_lag[at - 1] + share * (log_lag[at] - log_lag[at - 1]))
