"""Curves of quantities: where one is highest, its slope through zero, how far from a line it lies."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core.numerics import Array
from walkergen.core.numerics.quantity import Quantity

DRAWS, SEED = 2000, 2016
"""Number of random draws of measured values within their standard errors, for nonlinear functions of them
(the place of a top, a distance). Their spread is then known to 1.6 %."""


class Top(NamedTuple):
    """Top of a curve: where it lies, and its height."""

    place: Quantity
    height: Quantity


def top(places: Array, heights: Sequence[Quantity]) -> Top:
    """Top of at least three known quantities, by a parabola through the largest and its two neighbours.

    Its errors are those of the quantities and, for the place, also a grid's (the spacing over sqrt 12).
    Where the largest is the first or the last it is the top, though that may lie beyond.
    """
    means, drawn = _sample_values(heights)
    tops = np.array([_vertex(places, sample) for sample in drawn])
    place, height = _vertex(places, means)
    at = min(max(int(means.argmax()), 1), len(places) - 2)
    grid = float(places[at + 1] - places[at - 1]) / 2.0 / math.sqrt(12.0)
    spread = tops.std(axis=0, ddof=1)
    where = Quantity("tilt", "deg", place, math.hypot(float(spread[0]), grid))
    return Top(where, Quantity(heights[0].key, heights[0].unit, height, float(spread[1])))


def _vertex(places: Array, values: Array) -> tuple[float, float]:
    at = int(values.argmax())
    if at in (0, len(places) - 1):
        return float(places[at]), float(values[at])
    a, b, c = np.polyfit(places[at - 1 : at + 2] - places[at], values[at - 1 : at + 2], 2)
    return float(places[at] - b / (2.0 * a)), float(c - b * b / (4.0 * a))


def slope(places: Array, heights: Sequence[Quantity]) -> Quantity:
    """Slope of the least-squares line through zero, of heights in the unit of the places."""
    means, drawn = _sample_values(heights)
    slopes = drawn @ places / (places @ places)
    return Quantity("slope", "", float(means @ places / (places @ places)), float(slopes.std(ddof=1)))


def distance_from_line(places: Array, heights: Sequence[Quantity]) -> Quantity:
    """Rms distance from the line through zero over the mean size, in per cent; 0: proportional."""

    def relative_rms(samples: Array) -> Array:
        slope = samples @ places / (places @ places)
        residuals = samples - slope[:, None] * places
        return np.asarray(np.sqrt((residuals**2).mean(axis=1)) / np.abs(samples).mean(axis=1))

    means, drawn = _sample_values(heights)
    return Quantity(
        "off_line",
        "percent",
        100.0 * float(relative_rms(means[None])[0]),
        100.0 * float(relative_rms(drawn).std(ddof=1)),
    )


def _sample_values(heights: Sequence[Quantity]) -> tuple[Array, Array]:
    """Means, and random values within their errors, shape (DRAWS, quantities)."""
    means = np.array([height.value for height in heights], dtype=float)
    errors = np.array([height.se for height in heights], dtype=float)
    normal = np.random.default_rng(SEED).normal(size=(DRAWS, len(means)))
    return means, np.asarray(means + errors * normal)
