"""Number fluctuations: how much the number of walkers in a box varies with time, by the mean number.

Walkers that ignore each other have a standard deviation that grows as mean^(1/2) (Poisson); a
lattice varies at its boxes' edges only, mean^(1/4); flocks and phases by powers up to 1.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core import Array
from walkergen.guests.crowd.statistics import boxes, dish_geometry
from walkergen.guests.crowd.statistics.film import CrowdFilm

MAX_SIZES = 12
"""Largest number of box sizes."""

MIN_MEAN = 1.0
"""Mean number of walkers in the smallest boxes, at least: below it any law looks like Poisson's."""


class Fluctuations(NamedTuple):
    """Fluctuations of the number of walkers in boxes, by the size of the boxes."""

    sides: Array
    """Sides of the boxes, shape (sizes,), mm."""
    means: Array
    """Mean number of walkers in a box over all runs, shape (sizes,)."""
    variances: Array
    """Variance with time of the number of walkers in a box, in each run, shape (runs, sizes)."""
    exponents: Array
    """Growth of the standard deviation with the mean, d ln sd / d ln mean, of each run (runs,)."""


def measure(films: Sequence[CrowdFilm]) -> Fluctuations:
    """Compute the variance of the number of walkers in boxes, about each box's mean over all times and runs.

    A permanent difference of density, as at a wall, is therefore no fluctuation. As the dish holds a fixed number of
    walkers, a box with the share p of its area has 1 - p times the variance in a large dish. This is divided out. The
    result is too small by up to 1 / runs; with one run by more, unless it is much longer than the density's
    correlation.
    """
    film = films[0]
    parts = _box_counts(film)
    sides, means, variances = [], [], []
    for number in parts:
        grid = boxes.inner_grid(film.dish, number)
        counts = [boxes.sum_in_boxes(*dish_geometry.wrap_places(each.x, each.y, each.dish), grid) for each in films]
        box_means = np.concatenate(counts).mean(axis=0)
        finite_dish_factor = 1.0 - grid.side**2 / film.dish.area
        sides.append(grid.side)
        means.append(box_means.mean())
        variances.append([((count - box_means) ** 2).mean() / finite_dish_factor for count in counts])
    by_run = np.array(variances).reshape(len(parts), len(films)).T
    return Fluctuations(
        np.array(sides), np.array(means), by_run, np.array([_exponent(np.array(means), row) for row in by_run])
    )


def _box_counts(film: CrowdFilm) -> list[int]:
    """Return numbers of boxes along the dish's shorter side, from few large boxes to many of about one walker."""
    count = film.mean_walkers
    smallest = math.sqrt(MIN_MEAN * film.dish.area / max(count, 1.0))
    most = int(min(film.dish.box) / smallest)
    parts = np.unique(np.rint(np.geomspace(boxes.MIN_BOXES, max(most, boxes.MIN_BOXES), MAX_SIZES)))
    return [int(n) for n in parts if boxes.inner_grid(film.dish, int(n)).used.any()]


def _exponent(means: Array, variances: Array) -> float:
    """Fit d ln sd / d ln mean over box sizes. NaN for fewer than 3 sizes or where nothing varies."""
    use = (means > 0) & (variances > 0)
    if use.sum() < 3:
        return math.nan
    return float(np.polyfit(np.log(means[use]), 0.5 * np.log(variances[use]), 1)[0])
