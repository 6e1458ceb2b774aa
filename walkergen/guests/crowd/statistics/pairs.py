"""Pairs of walkers by their distance: pair correlation g(r), and correlation of their headings.

g is 1 at every distance for walkers that ignore each other, in every dish. Of each ring about a walker only the part
inside the dish counts (exact areas; no walker is left out at walls). g is relative to the density of the whole dish. So
where walkers gather at walls, or bodies keep their centres off walls, g is above 1 at distances as large as the dish.
"""

from typing import NamedTuple

import numpy as np

from walkergen.core import Array
from walkergen.guests.crowd.statistics import dish_geometry
from walkergen.guests.crowd.statistics.film import CrowdFilm

BINS = 60
"""Bins of the distance."""

MAX_DIAMETERS, NEIGHBOUR_DIAMETERS = 6.0, 1.25
"""Longest distance of curves, and distance of neighbours, in mean outer diameters (without outlines
in sides of the square that a walker has on average)."""

GAUSS_NODES = np.array([0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0)])
"""Positions in a bin, 0 to 1, at which the share of a circle inside the dish is computed (Gauss, two nodes)."""


class Pairs(NamedTuple):
    """Curves over all frames of one run, at the middles of the bins of distance; shape (BINS,)."""

    at: Array
    """Distances, mm."""
    g: Array
    """Number of pairs over its expected value for walkers spread evenly over the dish."""
    polar: Array
    """Mean cos(theta_i - theta_j): 1 if all point one way, 0 at random; NaN where there are no pairs."""
    nematic: Array
    """Mean cos 2(theta_i - theta_j)."""
    near_polar: Array
    """Mean cos(theta_i - theta_j) over neighbours in each frame, shape (F,): local order, 0 at random for any N."""
    near_nematic: Array


def length_scale(film: CrowdFilm) -> float:
    """Compute the mean outer diameter, mm; without outlines the side of the square area per walker."""
    if film.has_sizes:
        return 2.0 * float(film.radii.mean())
    return float(np.sqrt(film.dish.area / max(film.mean_walkers, 1.0)))


def bin_edges(film: CrowdFilm) -> Array:
    """Return the edges of the bins of distance, mm, up to half the dish's shorter side at most."""
    far = min(MAX_DIAMETERS * length_scale(film), 0.5 * min(film.dish.box))
    return np.linspace(0.0, far, BINS + 1)


def measure(film: CrowdFilm, edges: Array) -> Pairs:
    """Compute pair correlation and alignments of one run, in bins of distance between `edges` (mm)."""
    bins = len(edges) - 1
    counts, expected = np.zeros(bins), np.zeros(bins)
    heading_pairs, cosine_sums = np.zeros(bins), np.zeros((2, bins))
    near_distance = min(NEIGHBOUR_DIAMETERS * length_scale(film), edges[-1])
    near_means = np.full((2, len(film.times)), np.nan)
    for frame in range(len(film.times)):
        seen = np.isfinite(film.x[frame]) & np.isfinite(film.y[frame])
        x, y, theta = (part[frame][seen] for part in (film.x, film.y, film.theta))
        pairs, steps = dish_geometry.pairs_within(x, y, float(edges[-1]), film.dish)
        distance = np.hypot(*steps.T)
        counts += np.histogram(distance, edges)[0]
        expected += _random_pair_counts(x, y, edges, film)
        turn = theta[pairs[:, 1]] - theta[pairs[:, 0]]
        known = np.isfinite(turn)
        cosines = np.cos(turn[known]), np.cos(2.0 * turn[known])
        distance = distance[known]
        heading_pairs += np.histogram(distance, edges)[0]
        close = distance < near_distance
        for row, values in enumerate(cosines):
            cosine_sums[row] += np.histogram(distance, edges, weights=values)[0]
            if close.any():
                near_means[row, frame] = values[close].mean()
    polar, nematic = np.where(heading_pairs > 0, cosine_sums / np.maximum(heading_pairs, 1.0), np.nan)
    g = np.where(expected > 0, counts / np.where(expected > 0, expected, 1.0), np.nan)
    return Pairs(0.5 * (edges[1:] + edges[:-1]), g, polar, nematic, near_means[0], near_means[1])


def _random_pair_counts(x: Array, y: Array, edges: Array, film: CrowdFilm) -> Array:
    """Return the expected number of pairs in each bin, (bins,), of walkers at `x`, `y` (mm) with others at random."""
    low, width = edges[:-1, None], np.diff(edges)[:, None]
    radius = low + width * GAUSS_NODES
    middle_x, middle_y = dish_geometry.wrap_places(x, y, film.dish)
    share = dish_geometry.share_inside(middle_x[:, None, None], middle_y[:, None, None], radius[None], film.dish)
    rings = (2.0 * np.pi * radius * width * share.sum(axis=0)).mean(axis=1)
    return np.asarray(0.5 * (len(x) - 1) / film.dish.area * rings)
