"""Clusters: walkers that touch each other, or touch others of the same cluster.

Two walkers touch if their outlines are nearer than `TOUCHING_GAP` times the mean outer radius. If only outer radii are
known, they touch if their positions are nearer than the sum of their radii.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import shapely

from walkergen.core import Array, Whole
from walkergen.guests.crowd.statistics import dish_geometry
from walkergen.guests.crowd.statistics.film import CrowdFilm

TOUCHING_GAP = 0.05
"""Largest gap between touching outlines, over the mean outer radius: the resolution of films."""


class Clusters(NamedTuple):
    """Clusters of one run at each time, shape (F,) each."""

    number: Array
    """Number of clusters, walkers alone included."""
    largest: Array
    """Share of the walkers in the largest cluster."""
    size: Array
    """Mean number of walkers in the cluster of a walker."""
    alone: Array
    """Share of the walkers that touch no other."""
    touching: Array
    """Mean number of other walkers that a walker touches."""
    shares: Array
    """Share of the walkers in clusters of 1, 2 to 3, 4 to 7, ... over all times."""


def measure(film: CrowdFilm) -> Clusters:
    """Measure the clusters of one run, whose outlines or outer radii are known."""
    rows, octaves = [], np.zeros(int(np.log2(film.x.shape[1])) + 1)
    for frame in range(len(film.times)):
        seen = np.flatnonzero(np.isfinite(film.x[frame]) & np.isfinite(film.y[frame]))
        if not len(seen):
            rows.append((math.nan,) * 5)
            continue
        links = touching_pairs(film, frame, seen)
        sizes = cluster_sizes(links, len(seen))
        own = np.repeat(sizes, sizes)  # size of each walker's cluster
        octaves += np.bincount(np.log2(own).astype(int), minlength=len(octaves)) / len(own)
        rows.append(
            (float(len(sizes)), sizes.max() / len(own), own.mean(), (own == 1).mean(), 2.0 * len(links) / len(own))
        )
    number, largest, size, alone, touching = np.array(rows, dtype=float).T
    return Clusters(number, largest, size, alone, touching, octaves / octaves.sum())


def touching_pairs(film: CrowdFilm, frame: int, seen: Whole) -> Whole:
    """Return the pairs of walkers that touch in a frame, shape (pairs, 2): indices into `seen`, the walkers in it."""
    x, y, radii = film.x[frame][seen], film.y[frame][seen], film.radii[seen]
    gap = TOUCHING_GAP * float(radii.mean()) if film.outlines else 0.0
    reach = 2.0 * float(radii.max()) + gap
    reach = min(reach, 0.5 * film.dish.period or reach)  # only the nearest image counts
    pairs, steps = dish_geometry.pairs_within(x, y, reach, film.dish)
    close = np.hypot(*steps.T) <= radii[pairs].sum(axis=1) + gap
    pairs, steps = pairs[close], steps[close]
    if not film.outlines or not len(pairs):
        return np.asarray(pairs)
    kinds, theta = [film.kinds[walker] for walker in seen], film.theta[frame][seen]
    first = _transform_outlines(film, kinds, theta, pairs[:, 0], 0.0 * steps)
    second = _transform_outlines(film, kinds, theta, pairs[:, 1], steps)
    touch: Whole = pairs[shapely.dwithin(first, second, gap)]
    return touch


def cluster_sizes(links: Whole, walkers: int) -> Whole:
    """Return the number of walkers in each cluster. `links`: touching pairs of indices, shape (pairs, 2)."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(links)), links.T), shape=(walkers, walkers))
    _, labels = connected_components(graph, directed=False)
    return np.bincount(labels).astype(np.int64)


def _transform_outlines(
    film: CrowdFilm, kinds: Sequence[str], theta: Array, walkers: Whole, places: Array
) -> npt.NDArray[np.object_]:
    """Return outlines of `walkers`, turned by headings and moved to `places` (x, y in mm, shape (n, 2)).

    `walkers`: indices into `kinds` and headings `theta` (rad), shape (n,).
    """
    shapes = {kind: _union(contours) for kind, contours in film.outlines.items()}
    outlines = np.array([shapes[kinds[walker]] for walker in walkers], dtype=object)
    corners = shapely.get_num_coordinates(outlines)
    angle = np.repeat(np.nan_to_num(theta[walkers]), corners)
    c, s, moved = np.cos(angle), np.sin(angle), np.repeat(places, corners, axis=0)

    def rotate_and_move(points: Array) -> Array:
        """Transform the corners of all outlines, one after the other, shape (corners, 2)."""
        x, y = points.T
        return np.column_stack([c * x - s * y, s * x + c * y]) + moved

    return np.asarray(shapely.transform(outlines, rotate_and_move), dtype=object)


def _union(contours: Sequence[Array]) -> object:
    """Return the union of contours as a polygon of shapely."""
    return shapely.union_all([shapely.Polygon(contour) for contour in contours])
