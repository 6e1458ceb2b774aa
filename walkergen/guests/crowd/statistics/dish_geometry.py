"""Geometry of a dish for statistics: walls, the part of a circle inside, neighbours across edges.

`x` and `y` are arrays of positions from the middle of the dish, mm. Other lengths are in mm too.
"""

import math

import numpy as np
from scipy.spatial import cKDTree

from walkergen.core import Array, Dish, Whole


def wrap_places(x: Array, y: Array, dish: Dish) -> tuple[Array, Array]:
    """Wrap positions into a periodic square, from -side/2 to side/2; keep them in other dishes."""
    if not dish.period:
        return x, y
    half = 0.5 * dish.period
    return (x + half) % dish.period - half, (y + half) % dish.period - half


def wall_distance(x: Array, y: Array, dish: Dish) -> Array:
    """Return the distance of positions from the nearest wall, negative outside and infinite without walls."""
    if dish.kind == "periodic":
        return np.full(np.shape(x), math.inf)
    if dish.kind == "rectangle":
        length, width = dish.sizes
        return np.asarray(np.minimum(0.5 * length - np.abs(x), 0.5 * width - np.abs(y)))
    radius = np.hypot(x, y)
    out = 0.5 * dish.sizes[0] - radius
    return np.asarray(out if dish.kind == "disc" else np.minimum(out, radius - 0.5 * dish.sizes[1]))


def wall_tangent(x: Array, y: Array, dish: Dish) -> Array:
    """Compute the direction along the nearest wall, rad, modulo half a turn."""
    if dish.kind == "rectangle":
        length, width = dish.sizes
        nearer_end = 0.5 * length - np.abs(x) < 0.5 * width - np.abs(y)
        return np.where(nearer_end, 0.5 * math.pi, 0.0)
    return np.asarray(np.arctan2(y, x) + 0.5 * math.pi)


def max_wall_distance(dish: Dish) -> float:
    """Compute the largest distance that a point of the dish can have from its nearest wall."""
    if dish.kind == "ring":
        return 0.25 * (dish.sizes[0] - dish.sizes[1])
    return 0.5 * min(dish.box)


def area_beyond(depth: Array, dish: Dish) -> Array:
    """Compute the area (mm^2) of the part of the dish that is farther than `depth` from all walls."""
    depth = np.clip(depth, 0.0, max_wall_distance(dish))
    if dish.kind == "rectangle":
        length, width = dish.sizes
        return np.asarray((length - 2.0 * depth) * (width - 2.0 * depth))
    area = math.pi * (0.5 * dish.sizes[0] - depth) ** 2
    return area if dish.kind == "disc" else area - math.pi * (0.5 * dish.sizes[1] + depth) ** 2


def share_inside(x: Array, y: Array, radius: Array, dish: Dish) -> Array:
    """Return the share of the circumference of circles about (x, y), of this radius, that lies inside the dish.

    Exact in closed form. In a periodic square the share is 1, for radii up to half the side.
    """
    if dish.kind == "periodic":
        return np.ones(np.broadcast_shapes(np.shape(x), np.shape(radius)))
    if dish.kind == "rectangle":
        return _share_in_rectangle(x, y, radius, *dish.sizes)
    distance = np.hypot(x, y)
    share = _share_in_disc(distance, radius, 0.5 * dish.sizes[0])
    if dish.kind == "ring":
        share = share - _share_in_disc(distance, radius, 0.5 * dish.sizes[1])
    return np.clip(share, 0.0, 1.0)


def _share_in_disc(distance: Array, radius: Array, disc_radius: float) -> Array:
    """Return the share of a circle's circumference in a disc (cosine law). `distance`: between their centres."""
    cosine = (disc_radius**2 - distance**2 - radius**2) / np.maximum(2.0 * distance * radius, 1e-150)
    return np.asarray(1.0 - np.arccos(np.clip(cosine, -1.0, 1.0)) / math.pi)


def _share_in_rectangle(x: Array, y: Array, radius: Array, length: float, width: float) -> Array:
    """Compute the share of a circle's circumference that no side of a rectangle cuts off."""
    gaps = 0.5 * length - x, 0.5 * width - y, 0.5 * length + x, 0.5 * width + y
    half_angles = [np.arccos(np.clip(gap / radius, 0.0, 1.0)) for gap in gaps]
    outside = 2.0 * sum(half_angles)  # arcs beyond two sides are subtracted below
    for one, other in zip(half_angles, [*half_angles[1:], half_angles[0]], strict=True):
        outside = outside - np.maximum(one + other - 0.5 * math.pi, 0.0)
    return np.clip(1.0 - outside / (2.0 * math.pi), 0.0, 1.0)


def pairs_within(x: Array, y: Array, reach: float, dish: Dish) -> tuple[Whole, Array]:
    """Return pairs of positions nearer than `reach`: their indices, shape (pairs, 2), and vectors (pairs, 2), mm.

    Each pair is listed once. The vector leads from the first to the nearest image of the second. All positions are
    finite. In a periodic square `reach` is at most half the side.
    """
    period = dish.period
    places = np.column_stack(wrap_places(x, y, dish))
    if period:
        places = np.where(places >= 0.5 * period, places - period, places) + 0.5 * period
        places = np.clip(places, 0.0, np.nextafter(period, 0.0))
    tree = cKDTree(places, boxsize=period or None)
    pairs = tree.query_pairs(reach, output_type="ndarray").astype(np.int64)
    steps = places[pairs[:, 1]] - places[pairs[:, 0]]
    if period:
        steps -= period * np.rint(steps / period)
    return pairs, steps
