"""Packing: the share of a dish's area that walkers cover, in the whole dish and in boxes of it."""

import math

import numpy as np

from walkergen.core import Array
from walkergen.guests.crowd.statistics import boxes, dish_geometry
from walkergen.guests.crowd.statistics.film import CrowdFilm

BOX_DIAMETERS = 4.0
"""Side of the boxes of the local packing, in mean outer diameters."""

BINS = 24
"""Bins of the local packing from 0 to 1.2. It may exceed 1: a box counts the whole area of walkers centred in it."""

MAX_PACKING = 1.2


def total_packing(film: CrowdFilm) -> Array:
    """Compute the area of all visible walkers over the area of the dish, in each frame, shape (F,)."""
    seen = np.isfinite(film.x)
    return np.asarray(seen @ film.areas / film.dish.area)


def local_packing(film: CrowdFilm) -> Array:
    """Return the packing of each box: area of the walkers centred in it over its area in the dish, shape (F, boxes).

    Its mean is near `total_packing`. Two peaks in its distribution show a dense and a thin phase.
    """
    parts = box_count(film)
    grid = boxes.clipped_grid(film.dish, parts)
    x, y = dish_geometry.wrap_places(film.x, film.y, film.dish)
    return boxes.sum_in_boxes(x, y, grid, film.areas) / grid.areas


def box_count(film: CrowdFilm) -> int:
    """Return the number of boxes along the dish's shorter side, about `BOX_DIAMETERS` mean outer diameters wide."""
    side = min(film.dish.box)
    return max(round(side / (BOX_DIAMETERS * 2.0 * float(film.radii.mean()))), boxes.MIN_BOXES)


def scatter(local_packing: Array) -> Array:
    """Compute the standard deviation of the local packing over the boxes, at each time, shape (F,)."""
    if local_packing.shape[1] < 2:
        return np.full(len(local_packing), math.nan)
    return np.asarray(local_packing.std(axis=1, ddof=1))


def probability_density(local_packing: Array) -> tuple[Array, Array]:
    """Return the middles of bins of local packing, and the probability density in each bin, shape (BINS,) both."""
    edges = np.linspace(0.0, MAX_PACKING, BINS + 1)
    counts, _ = np.histogram(np.minimum(local_packing, MAX_PACKING), edges)
    return 0.5 * (edges[1:] + edges[:-1]), counts / (counts.sum() * (edges[1] - edges[0]))
