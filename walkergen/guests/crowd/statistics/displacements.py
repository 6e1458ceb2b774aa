"""Speeds and mean squared displacements of the walkers of a crowd."""

import math

import numpy as np

from walkergen.analysis import lag_sums
from walkergen.core import Array
from walkergen.guests.crowd.statistics.film import CrowdFilm

MAX_LAGS = 24
"""Lags of the mean squared displacement, at most."""

LAG_DIVISOR = 4
"""Divisor of a film's length that gives the longest lag: longer ones have few pairs."""


def speeds(film: CrowdFilm) -> tuple[Array, Array]:
    """Return speeds and velocity components along the heading, from frame to frame, (F - 1, N) each, mm/s."""
    x, y = (np.diff(places, axis=0) / film.interval for places in (film.x, film.y))
    heading = 0.5 * (film.theta[1:] + film.theta[:-1])
    ahead: Array = x * np.cos(heading) + y * np.sin(heading)
    return np.hypot(x, y), ahead


def squared_displacement(film: CrowdFilm) -> tuple[Array, Array]:
    """Return lags (s) and the mean squared displacement (mm^2) of each lag, over walkers and times."""
    longest = max((len(film.times) - 1) // LAG_DIVISOR, 1)
    lags = lag_sums.log_spaced_lags(longest, MAX_LAGS)
    total, pairs = np.zeros(len(lags)), np.zeros(len(lags))
    for walker in range(film.x.shape[1]):
        places = np.column_stack([film.x[:, walker], film.y[:, walker]])
        sums, count = lag_sums.sum_squares(places, lags)
        total += sums
        pairs += count
    mean = np.where(pairs > 0, total / np.maximum(pairs, 1.0), np.nan)
    return np.asarray(lags * film.interval, dtype=float), mean


def growth_exponent(lags: Array, msd: Array) -> float:
    """Fit d ln MSD / d ln lag in the last half decade: 2 for straight runs, 1 for diffusion, NaN for too few lags."""
    use = (lags >= lags[-1] / math.sqrt(10.0)) & (msd > 0)
    if use.sum() < 3:
        return math.nan
    return float(np.polyfit(np.log(lags[use]), np.log(msd[use]), 1)[0])
