"""Square boxes that lie wholly inside a dish, side by side, and what is in them."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.dish import Dish

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

FEWEST = 3
"""Least number of boxes along the shorter side: of two none lies inside a disc."""


class Grid(NamedTuple):
    """Boxes of one size about the middle of a dish."""

    side: float
    """Side of a box, mm."""
    across: tuple[int, int]
    """Boxes along x and y, those that the walls cut included."""
    inside: Mask
    """True for boxes wholly inside the dish, shape `across`."""


def grid(dish: Dish, parts: int) -> Grid:
    """Grid of `parts` boxes along the shorter side of the smallest rectangle around a dish."""
    length, width = dish.box
    side = min(length, width) / parts
    across = int(length / side * (1.0 + 1e-12)), int(width / side * (1.0 + 1e-12))
    inside = np.ones(across, dtype=bool)
    if dish.kind in ("disc", "ring"):
        corner = [0.5 * side + side * np.abs(np.arange(n) - 0.5 * (n - 1)) for n in across]
        inside = np.hypot(*np.meshgrid(*corner, indexing="ij")) <= 0.5 * dish.sizes[0]
    if dish.kind == "ring":
        near = [np.maximum(edge - side, 0.0) for edge in corner]
        inside &= np.hypot(*np.meshgrid(*near, indexing="ij")) >= 0.5 * dish.sizes[1]
    return Grid(side, across, inside)


def sums(x: Array, y: Array, grid: Grid, weights: Array | None = None) -> Array:
    """Sum of the `weights` (N,) of the walkers in each inner box, shape (F, boxes); of 1 without.

    Places have shape (F, N); those that are NaN are in no box.
    """
    frames, count = x.shape
    columns, rows = (
        np.floor(places / grid.side + 0.5 * number)
        for places, number in zip((x, y), grid.across, strict=True)
    )
    within = (columns >= 0) & (columns < grid.across[0]) & (rows >= 0) & (rows < grid.across[1])
    cells = grid.across[0] * grid.across[1]
    frame = np.broadcast_to(np.arange(frames)[:, None], x.shape)[within]
    at = (frame * grid.across[0] + columns[within].astype(np.int64)) * grid.across[1]
    at += rows[within].astype(np.int64)
    values = None if weights is None else np.broadcast_to(weights, (frames, count))[within]
    total = np.bincount(at, values, minlength=frames * cells).reshape(frames, cells)
    return np.asarray(total[:, grid.inside.ravel()], dtype=float)
