"""Walkers by a wall: their angle to it, and how it turns them.

A walker is by the wall if the point of its outline nearest to a wall is within WALL_RANGE_MM of it. The angle counts
from the dish's outward direction at that point to the heading: 0 head on, a quarter turn along the wall. A mean turning
rate there, with a relaxation time t, means a torque of the inertia times that rate over t.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.analysis.estimates import MIN_SAMPLES
from walkergen.core import Array, Dish, Quantity, jackknife_error

WALL_RANGE_MM = 0.5
"""Distance (mm) within which a walker is by a wall: some hops of a tenth of a millimetre."""

OBLIQUE_ANGLES = math.radians(20.0), math.radians(70.0)
"""Range of angles between heading and outward direction for an oblique run against a wall."""

ANGLE_BINS = 36
"""Number of angles between heading and way out, from -pi to pi."""


QUANTITY_UNITS = {"wall_share": "", "wall_alignment": "", "wall_turning": "rad_s"}
"""Names and units of the numbers of `ByWall`."""


class ByWall(NamedTuple):
    """How walkers stand by a wall and turn there, each number over independent runs."""

    share: Quantity
    """Share of the second half of the runs by a wall."""
    alignment: Quantity
    """Mean of -cos(2 angle) there: 1 along the wall, 0 for random directions, -1 head on."""
    turning: Quantity
    """Mean rate (rad/s) at which a wall turns obliquely incident walkers along itself; below 0 if it turns them head
    on."""
    angles: Array
    """Middles of bins of the angle, rad."""
    density: Array
    """Density of the angle by the wall in the second half of the runs, 1/rad."""
    rates: Array
    """Mean turning rate near the wall in these bins, rad/s; NaN in empty bins."""
    rates_se: Array


def measure(runs: Sequence[Array], interval: float, outline: Array, dish: Dish) -> ByWall:
    """Measure runs of a walker alone in a dish with walls.

    Each of `runs` has rows of x, y (mm, of the place that `outline`, shape (n, 2), is from) and
    heading (rad), `interval` s apart.
    """
    edges = np.linspace(-math.pi, math.pi, ANGLE_BINS + 1)
    angles, width = 0.5 * (edges[1:] + edges[:-1]), edges[1] - edges[0]
    if len(runs) < MIN_SAMPLES:
        few = f"{len(runs)} runs in a dish; at least {MIN_SAMPLES}"
        empty = np.full(ANGLE_BINS, np.nan)
        share, alignment, turning = (Quantity(key, unit, None, refused=few) for key, unit in QUANTITY_UNITS.items())
        return ByWall(share, alignment, turning, angles, empty, empty, empty)
    sums = np.array([_run_sums(rows, interval, outline, dish, edges) for rows in runs])
    of = zip(QUANTITY_UNITS, (1, 2, 3), (0, 1, 4), strict=True)
    share, alignment, turning = (_ratio(key, sums[:, over], sums[:, under]) for key, over, under in of)
    counts, turned, samples = np.split(sums[:, 5:], 3, axis=1)
    density = counts.sum(axis=0) / max(counts.sum(), 1.0) / width
    with np.errstate(invalid="ignore", divide="ignore"):
        rates = turned.sum(axis=0) / samples.sum(axis=0)
        others = (turned.sum(axis=0) - turned) / (samples.sum(axis=0) - samples)
    return ByWall(share, alignment, turning, angles, density, rates, jackknife_error(others))


def nearest_wall(rows: Array, outline: Array, dish: Dish) -> tuple[Array, Array]:
    """Compute an outline's distance from the nearest wall (mm), and the outward direction there (rad).

    Shape (n,) each, for places and headings `rows`, shape (n, 3).
    """
    cos, sin = np.cos(rows[:, 2:3]), np.sin(rows[:, 2:3])
    x = rows[:, 0:1] + cos * outline[:, 0] - sin * outline[:, 1]
    y = rows[:, 1:2] + sin * outline[:, 0] + cos * outline[:, 1]
    if dish.kind == "rectangle":
        length, width = dish.box
        gaps = np.stack([0.5 * length - x, 0.5 * width - y, 0.5 * length + x, 0.5 * width + y])
        least = gaps.min(axis=2)
        wall = least.argmin(axis=0)
        return least.min(axis=0), 0.5 * math.pi * wall
    far = np.hypot(x, y)
    outer = 0.5 * dish.sizes[0] - far
    point, every = outer.argmin(axis=1), np.arange(len(rows))
    gap, out = outer[every, point], np.arctan2(y, x)[every, point]
    if dish.kind == "ring":
        inner = far - 0.5 * dish.sizes[1]
        within = inner.argmin(axis=1)
        near = inner[every, within] < gap
        inward = np.arctan2(y, x)[every, within] + math.pi
        return np.where(near, inner[every, within], gap), np.where(near, inward, out)
    return gap, out


def _run_sums(rows: Array, interval: float, outline: Array, dish: Dish, edges: Array) -> Array:
    """Sum what a run shows by the wall, shape (5 + 3 bins,); the angle a is from the way out to the heading.

    First, of the second half: samples, those by a wall, and their -cos 2a. Then turning toward the wall of samples that
    run against it askew, and their number. Last, in the bins of a: samples of the second half, turning, and its
    samples.
    """
    gap, out = nearest_wall(rows, outline, dish)
    angle = np.mod(rows[:, 2] - out + math.pi, 2.0 * math.pi) - math.pi
    by_wall, half = gap < WALL_RANGE_MM, len(rows) // 2
    late = angle[half:][by_wall[half:]]
    both, rate = by_wall[:-1] & by_wall[1:], np.diff(rows[:, 2]) / interval
    before = angle[:-1]
    askew = both & (np.abs(before) > OBLIQUE_ANGLES[0]) & (np.abs(before) < OBLIQUE_ANGLES[1])
    toward = (np.sign(before) * rate)[askew]
    counts = np.histogram(late, edges)[0]
    turned = np.histogram(before[both], edges, weights=rate[both])[0]
    samples = np.histogram(before[both], edges)[0]
    first = [len(rows) - half, len(late), -np.cos(2.0 * late).sum(), toward.sum(), len(toward)]
    return np.array([*first, *counts, *turned, *samples], dtype=float)


def _ratio(key: str, over: Array, under: Array) -> Quantity:
    """Ratio of sums over runs, with the error of a jackknife."""
    left = under.sum() - under
    if not (left > 0.0).all():
        return Quantity(
            key, QUANTITY_UNITS[key], None, refused="hardly a run meets a wall: a smaller dish, or longer runs"
        )
    value = float(over.sum() / under.sum())
    se = float(jackknife_error(((over.sum() - over) / left)[:, None])[0])
    return Quantity(key, QUANTITY_UNITS[key], value, se, len(over) - 1.0)
