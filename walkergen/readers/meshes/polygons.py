"""Polygons of a surface cut into triangles. The polygons of all mesh files are counted, checked and cut here."""

from typing import NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.numerics import Array, Mask, Whole
from walkergen.core.shapes.threemf import MAX_TRIANGLES

MIN_TURN = 1e-9
"""Turn at a corner, over the square of twice a polygon's area, below which the corner is straight or reflex."""


class Polygons(NamedTuple):
    """Polygons of a file, unchanged, sound or not."""

    vertices: Array
    """Coordinates of the corners, shape (n, 3), in the file's unit."""
    corners: Whole
    """Corners of all polygons, one polygon after another, as indices into the vertices."""
    sizes: Whole
    """Number of corners of each polygon."""


def triangulate(polygons: Polygons, source: str) -> Whole:
    """Return triangles that fill the polygons, shape (k, 3). A polygon of fewer than three corners has none.

    Concave polygons are cut by manifold3d as they lie in their plane. Raises InputError, which begins with `source`,
    for too many triangles and for corners that do not exist.
    """
    vertices, corners, sizes = polygons
    check_count(int(np.maximum(sizes - 2, 0).sum()), source)
    if len(corners) and not 0 <= corners.min() <= corners.max() < len(vertices):
        raise InputError(f"{source}: a face has a corner that does not exist. Export the file again.")
    starts = np.cumsum(sizes) - sizes
    pieces = [np.empty((0, 3), np.int64)]
    for size in np.unique(sizes[sizes > 2]).tolist():
        rings = corners[starts[sizes == size, None] + np.arange(size)]
        fan = np.array([(0, corner, corner + 1) for corner in range(1, size - 1)])
        is_convex = _are_convex(vertices[rings]) if size > 3 else np.ones(len(rings), bool)
        pieces.append(rings[is_convex][:, fan].reshape(-1, 3))
        pieces += [
            ring[_cut_polygon(vertices[ring])] for ring in map(_drop_repeats, rings[~is_convex]) if len(ring) > 2
        ]
    return np.concatenate(pieces)


def check_count(count: int, source: str) -> None:
    """Raise InputError, which begins with `source`, for more than MAX_TRIANGLES triangles."""
    if count > MAX_TRIANGLES:
        raise InputError(
            f"{source}: {count} triangles, at most {MAX_TRIANGLES}. Simplify the mesh: 100000 are enough for any print."
        )


def _are_convex(corners: Array) -> Mask:
    """Return whether polygons, shape (k, n, 3), turn the same way at each corner, seen along their normals."""
    ahead = np.roll(corners, -1, axis=1) - corners
    spokes = corners - corners[:, :1]
    normals = np.cross(spokes, np.roll(spokes, -1, axis=1)).sum(axis=1)  # Newell's, twice the area
    turns = np.einsum("kni,ki->kn", np.cross(ahead, np.roll(ahead, -1, axis=1)), normals)
    return np.asarray((turns > MIN_TURN * np.einsum("ki,ki->k", normals, normals)[:, None]).all(axis=1))


def _drop_repeats(ring: Whole) -> Whole:
    """Return the vertex indices of a polygon without those that repeat the index before."""
    distinct: Whole = ring[ring != np.roll(ring, 1)]
    return distinct


def _cut_polygon(corners: Array) -> Whole:
    """Return triangles that fill a plane polygon, shape (n, 3), in its sense of rotation, as indices of corners."""
    import manifold3d

    spokes = corners - corners.mean(axis=0)
    normal = np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)
    _, _, axes = np.linalg.svd(spokes)
    plane = spokes @ axes[:2].T
    if np.cross(axes[0], axes[1]) @ normal < 0.0:
        plane[:, 1] *= -1.0
    return np.asarray(manifold3d.triangulate([plane]), np.int64).reshape(-1, 3)
