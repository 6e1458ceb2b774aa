"""Order of headings: polar, nematic, and about the middle of a dish, at each time.

Of N headings at random each modulus is not 0 but `by_chance(N)` on average: an order is one only
beyond it. Means over pairs of walkers (`pairs.alignment`) have no such bias.
"""

import math

import numpy as np

from walkergen.core import Array
from walkergen.guests.crowd.statistics.film import CrowdFilm, mean_over_walkers


def polar(film: CrowdFilm) -> Array:
    """Compute |mean of e^(i theta)| over walkers, shape (F,): 1 if all head one way."""
    return np.asarray(np.abs(mean_over_walkers(np.exp(1j * film.theta))))


def nematic(film: CrowdFilm) -> Array:
    """Compute |mean of e^(2 i theta)| over walkers, shape (F,): 1 if all lie along one line."""
    return np.asarray(np.abs(mean_over_walkers(np.exp(2j * film.theta))))


def circulation(film: CrowdFilm) -> Array:
    """Compute the mean of r x e / |r| over walkers, shape (F,), r from the dish's middle to the walker.

    1 where all circle counter-clockwise, -1 clockwise, 0 where neither wins.
    """
    about = np.sin(film.theta - np.arctan2(film.y, film.x))
    return np.asarray(mean_over_walkers(about))


def random_order(walkers: float) -> float:
    """Return the mean modulus of the mean of N random unit vectors: 1 of one, sqrt(pi / (4 N)) for N above ten.

    Their sum is then normal in two directions, with variance N / 2 in each.
    """
    return 1.0 if walkers <= 1.0 else 0.5 * math.sqrt(math.pi / walkers)


def random_circulation(walkers: float) -> float:
    """Return the mean |circulation| of N random headings: a half-normal of variance 1 / (2 N)."""
    return 1.0 / math.sqrt(math.pi * walkers)
