"""Square boxes side by side about the middle of a dish, and their content."""

import math
from typing import NamedTuple

import numpy as np
import shapely

from walkergen.core import Array, Dish, Mask

MIN_BOXES = 3
"""Least number of boxes along the shorter side: of two none lies inside a disc."""

MIN_INSIDE_SHARE = 0.5
"""Smallest share of a box inside the dish with which the box counts."""

QUARTER_SEGMENTS = 128
"""Corners of a quarter of a round wall, whose area is then exact to 3e-5."""


class Grid(NamedTuple):
    """Boxes of one size."""

    side: float
    """Side of a box, mm."""
    used: Mask
    """True for boxes that count, shape (along x, along y)."""
    areas: Array
    """Areas inside the dish of the boxes that count, shape (boxes,), mm^2."""


def inner_grid(dish: Dish, parts: int) -> Grid:
    """Return square boxes wholly inside a dish. `parts`: boxes along the shorter side of its bounding rectangle."""
    side = min(dish.box) / parts
    across = [int(length / side * (1.0 + 1e-12)) for length in dish.box]
    used = np.ones(across, dtype=bool)
    if dish.kind in ("disc", "ring"):
        outer_edges = [0.5 * side + side * np.abs(np.arange(n) - 0.5 * (n - 1)) for n in across]
        used = np.hypot(*np.meshgrid(*outer_edges, indexing="ij")) <= 0.5 * dish.sizes[0]
    if dish.kind == "ring":
        inner_edges = [np.maximum(edge - side, 0.0) for edge in outer_edges]
        used &= np.hypot(*np.meshgrid(*inner_edges, indexing="ij")) >= 0.5 * dish.sizes[1]
    return Grid(side, used, np.full(used.sum(), side**2))


def clipped_grid(dish: Dish, parts: int) -> Grid:
    """Return square boxes over a dish, cut by walls. Boxes mostly outside are left out. `parts`: as in `inner_grid`."""
    side = min(dish.box) / parts
    across = [math.ceil(length / side * (1.0 - 1e-12)) for length in dish.box]
    low = [side * (np.arange(n) - 0.5 * n) for n in across]
    x, y = np.meshgrid(*low, indexing="ij")
    areas = shapely.area(shapely.intersection(shapely.box(x, y, x + side, y + side), _dish_polygon(dish)))
    used = areas >= MIN_INSIDE_SHARE * side**2
    return Grid(side, used, areas[used])


def sum_in_boxes(x: Array, y: Array, grid: Grid, weights: Array | None = None) -> Array:
    """Sum the `weights` (N,) of the walkers in each used box of each frame, shape (F, boxes). Default weights: 1.

    `x`, `y`: positions from the middle of the dish, shape (F, N), mm. Positions that are NaN are in no box.
    """
    frames, count = x.shape
    across = grid.used.shape
    columns, rows = (np.floor(places / grid.side + 0.5 * number) for places, number in zip((x, y), across, strict=True))
    within = (columns >= 0) & (columns < across[0]) & (rows >= 0) & (rows < across[1])
    cells = across[0] * across[1]
    frame = np.broadcast_to(np.arange(frames)[:, None], x.shape)[within]
    index = (frame * across[0] + columns[within].astype(np.int64)) * across[1]
    index += rows[within].astype(np.int64)
    values = None if weights is None else np.broadcast_to(weights, (frames, count))[within]
    total = np.bincount(index, values, minlength=frames * cells).reshape(frames, cells)
    return np.asarray(total[:, grid.used.ravel()], dtype=float)


def _dish_polygon(dish: Dish) -> shapely.Geometry:
    """Return the dish as a polygon of shapely. Round walls have many corners."""
    if dish.kind in ("rectangle", "periodic"):
        half_x, half_y = (0.5 * side for side in dish.box)
        return shapely.box(-half_x, -half_y, half_x, half_y)
    outer, *inner = (shapely.Point(0, 0).buffer(0.5 * size, QUARTER_SEGMENTS) for size in dish.sizes)
    return outer.difference(inner[0]) if inner else outer
