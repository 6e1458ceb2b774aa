"""Values with standard errors, and what a curve of them tells: its top, its slope through zero."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

DRAWS, SEED = 2000, 2016
"""Number of random draws of measured values within their standard errors, for what is not linear in
them (the place of a top, a distance): its spread is then known to 1.6 %."""


class Value(NamedTuple):
    """Mean over independent runs, or a number that follows from such means."""

    mean: float
    se: float
    """Standard error of the mean."""


class Top(NamedTuple):
    """Top of a curve: where it lies, and its height."""

    place: Value
    height: Value


def mean(values: Sequence[float]) -> Value:
    """Mean and standard error of at least two independent values."""
    return Value(float(np.mean(values)), float(np.std(values, ddof=1) / math.sqrt(len(values))))


def ratio(over: Value, under: Value) -> Value:
    """Ratio of two independent values, of which the second is not 0."""
    quotient = over.mean / under.mean
    return Value(quotient, math.hypot(over.se, quotient * under.se) / abs(under.mean))


def top(places: Array, values: Sequence[Value]) -> Top:
    """Top of at least three values, by a parabola through the largest and its two neighbours.

    Its errors are those of the values and, for the place, also a grid's (the spacing over sqrt 12).
    Where the largest is the first or the last it is the top, though that may lie beyond.
    """
    means, drawn = _drawn(values)
    tops = np.array([_vertex(places, sample) for sample in drawn])
    place, height = _vertex(places, means)
    at = min(max(int(means.argmax()), 1), len(places) - 2)
    grid = float(places[at + 1] - places[at - 1]) / 2.0 / math.sqrt(12.0)
    spread = tops.std(axis=0, ddof=1)
    return Top(Value(place, math.hypot(float(spread[0]), grid)), Value(height, float(spread[1])))


def _vertex(places: Array, values: Array) -> tuple[float, float]:
    at = int(values.argmax())
    if at in (0, len(places) - 1):
        return float(places[at]), float(values[at])
    a, b, c = np.polyfit(places[at - 1 : at + 2] - places[at], values[at - 1 : at + 2], 2)
    return float(places[at] - b / (2.0 * a)), float(c - b * b / (4.0 * a))


def slope(places: Array, values: Sequence[Value]) -> Value:
    """Slope of the least-squares line through zero."""
    means, drawn = _drawn(values)
    slopes = drawn @ places / (places @ places)
    return Value(float(means @ places / (places @ places)), float(slopes.std(ddof=1)))


def off_line(places: Array, values: Sequence[Value]) -> Value:
    """Rms distance from the line through zero over the mean size; 0: proportional."""

    def off(samples: Array) -> Array:
        slope = samples @ places / (places @ places)
        residuals = samples - slope[:, None] * places
        return np.asarray(np.sqrt((residuals**2).mean(axis=1)) / np.abs(samples).mean(axis=1))

    means, drawn = _drawn(values)
    return Value(float(off(means[None])[0]), float(off(drawn).std(ddof=1)))


def _drawn(values: Sequence[Value]) -> tuple[Array, Array]:
    """Means, and random values within their errors, shape (DRAWS, values)."""
    means, errors = np.array(values).reshape(-1, 2).T
    normal = np.random.default_rng(SEED).normal(size=(DRAWS, len(means)))
    return means, np.asarray(means + errors * normal)
