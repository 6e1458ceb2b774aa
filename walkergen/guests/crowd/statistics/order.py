"""Order of headings: polar, nematic, and about the middle of a dish, at each time.

The polar and nematic order of N random headings is not 0 but `random_order(N)` on average: only larger values show
order. Means over pairs of walkers (`pairs.alignment`) have no such bias.
"""

import math

import numpy as np

from walkergen.core import Array
from walkergen.guests.crowd.statistics.film import CrowdFilm, mean_over_walkers


def polar_order(film: CrowdFilm) -> Array:
    """Return |mean of e^(i theta)| over the walkers in each frame, shape (F,): 1 if all headings agree."""
    return np.asarray(np.abs(mean_over_walkers(np.exp(1j * film.theta))))


def nematic_order(film: CrowdFilm) -> Array:
    """Return |mean of e^(2 i theta)| over the walkers in each frame, shape (F,): 1 if all lie along one line."""
    return np.asarray(np.abs(mean_over_walkers(np.exp(2j * film.theta))))


def circulation(film: CrowdFilm) -> Array:
    """Return the mean circulation of headings about the dish's middle in each frame, shape (F,).

    It is r x e / |r| with a walker's position r and heading e: 1 if all circle counter-clockwise, -1 if all clockwise.
    """
    about = np.sin(film.theta - np.arctan2(film.y, film.x))
    return np.asarray(mean_over_walkers(about))


def random_order(walkers: float) -> float:
    """Return the mean polar or nematic order of N walkers with random headings: sqrt(pi / (4 N)), 1 for one.

    The sum of N > 10 unit vectors is normal in two directions, with variance N / 2 in each.
    """
    return 1.0 if walkers <= 1.0 else 0.5 * math.sqrt(math.pi / walkers)


def random_circulation(walkers: float) -> float:
    """Return the mean |circulation| of N walkers with random headings: 1 / sqrt(pi N), as of a half-normal number."""
    return 1.0 / math.sqrt(math.pi * walkers)
