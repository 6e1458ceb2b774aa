"""Walkers at walls: their density, speed, and alignment with the nearest wall, by distance from it."""

from typing import NamedTuple

import numpy as np

from walkergen.core import Array
from walkergen.guests.crowd.statistics import dish_geometry, displacements, pairs
from walkergen.guests.crowd.statistics.film import CrowdFilm, mean_over_walkers

BINS = 20
"""Bins of the distance from the wall, over its whole range."""


class Walls(NamedTuple):
    """Statistics of one run by the distance of walkers' positions from the nearest wall."""

    at: Array
    """Middles of the bins of distance, shape (BINS,), mm."""
    density: Array
    """Number of walkers per area over the mean of the whole dish."""
    speed: Array
    """Mean speed, mm/s; NaN where no walker came."""
    alignment: Array
    """Mean cos 2(heading - wall): 1 along the wall, -1 across, 0 at random."""
    near_density: Array
    """Density within `near_distance` of the wall over the mean, in each frame, shape (F,)."""
    near_speed: Array
    """Mean speed within `near_distance`, shape (F - 1,), mm/s."""
    near_alignment: Array
    """Mean alignment within `near_distance`, shape (F,)."""


def near_distance(film: CrowdFilm) -> float:
    """Return the distance (mm) from a wall within which a walker counts as at the wall: at most a mean diameter."""
    return min(pairs.length_scale(film), 0.5 * dish_geometry.max_wall_distance(film.dish))


def measure(film: CrowdFilm) -> Walls:
    """Measure density, speed and alignment of one run by the distance from the walls of its dish."""
    dish, at_wall = film.dish, near_distance(film)
    edges = np.linspace(0.0, dish_geometry.max_wall_distance(dish), BINS + 1)
    distance = np.maximum(dish_geometry.wall_distance(film.x, film.y, dish), 0.0)
    seen = np.isfinite(distance)
    share = np.histogram(distance[seen], edges)[0] / max(seen.sum(), 1)
    area = -np.diff(dish_geometry.area_beyond(edges, dish)) / dish.area
    along = np.cos(2.0 * (film.theta - dish_geometry.wall_tangent(film.x, film.y, dish)))
    speed, _ = displacements.speeds(film)
    between = 0.5 * (distance[1:] + distance[:-1])
    at_wall_area = 1.0 - float(dish_geometry.area_beyond(np.array(at_wall), dish)) / dish.area
    near_share = (distance < at_wall).sum(axis=1) / np.maximum(seen.sum(axis=1), 1)
    return Walls(
        0.5 * (edges[1:] + edges[:-1]),
        share / area,
        _bin_means(between, speed, edges),
        _bin_means(distance, along, edges),
        near_share / at_wall_area,
        mean_over_walkers(speed, between < at_wall),
        mean_over_walkers(along, distance < at_wall),
    )


def _bin_means(distance: Array, values: Array, edges: Array) -> Array:
    """Average `values`, which belong to the distances, in each bin between `edges` (mm); NaN in empty bins."""
    known = np.isfinite(values) & np.isfinite(distance)
    counts = np.histogram(distance[known], edges)[0]
    sums = np.histogram(distance[known], edges, weights=values[known])[0]
    return np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)
