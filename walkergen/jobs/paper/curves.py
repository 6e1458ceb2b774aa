"""Numbers that series of simulated speeds give: peak, ratio, proportionality, with errors."""

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.jobs.paper.sweeps import Point, Value, mean

Array = npt.NDArray[np.float64]

DRAWS, SEED = 2000, 2016
"""Number of random draws of the measured speeds within their standard errors, for what is not
linear in them (the place of a peak, a ratio): its spread is then known to 1.6 %."""


class Peak(NamedTuple):
    """Top of a curve of speed against tilt."""

    tilt_deg: Value
    speed: Value


def series_of(points: Sequence[Point]) -> list[list[Point]]:
    """Group points by assumption and model, in the order of first appearance."""
    keys = dict.fromkeys((point.assumption, point.model) for point in points)
    return [[point for point in points if (point.assumption, point.model) == key] for key in keys]


def largest(series: Sequence[Point]) -> Value | None:
    """Mean speed farthest from zero."""
    speeds = [point.speed for point in series if point.speed is not None]
    return max(speeds, key=lambda speed: abs(speed.mean)) if speeds else None


def smallest(series: Sequence[Point], counting: str, kind: str) -> Value | None:
    """Smallest share over tilts above 0: an upright walker slides backward as often as forward."""
    shares = [
        point.shares[counting, kind] for point in series if point.shares and point.tilt_deg > 0.0
    ]
    return min(shares, key=lambda share: share.mean) if shares else None


def impact_speed(series: Sequence[Point]) -> Value | None:
    """Impact speed over the plate's peak speed: mean and standard error over the tilts."""
    ratios = [
        point.impact_speed.mean / point.plate_speed_mm_s
        for point in series
        if point.impact_speed is not None
    ]
    return mean(ratios) if len(ratios) > 1 else None


def _drawn(series: Sequence[Point]) -> tuple[Array, Array]:
    """Means of the known speeds, and random speeds within their errors, shape (DRAWS, points)."""
    known = np.array([point.speed for point in series if point.speed is not None])
    means, errors = known.reshape(-1, 2).T
    normal = np.random.default_rng(SEED).normal(size=(DRAWS, len(means)))
    return means, np.asarray(means + errors * normal)


def ratio(series: Sequence[Point], over: float, under: float) -> Value | None:
    """Speed at one tilt over that at another, with the error that theirs give it."""
    at = {point.tilt_deg: point.speed for point in series}
    first, second = at.get(over), at.get(under)
    if first is None or second is None or second.mean == 0.0:
        return None
    ratio = first.mean / second.mean
    return Value(ratio, math.hypot(first.se, ratio * second.se) / abs(second.mean))


def peak(series: Sequence[Point]) -> Peak | None:
    """Top of the measured speeds, by a parabola through the largest and its two neighbours.

    Its errors are those of the speeds and, for the tilt, also a grid's (the spacing over sqrt 12).
    Tilts without a speed are left out; None where the largest speed lies at the first or last of
    the others: the top may lie beyond.
    """
    tilts = np.array([point.tilt_deg for point in series if point.speed is not None])
    means, drawn = _drawn(series)
    if len(tilts) < 3 or int(means.argmax()) in (0, len(tilts) - 1):
        return None
    tops = np.array([_top(tilts, speeds) for speeds in drawn])
    tilt, speed = _top(tilts, means)
    at = int(means.argmax())
    grid = float(tilts[at + 1] - tilts[at - 1]) / 2.0 / math.sqrt(12.0)
    spread = tops.std(axis=0, ddof=1)
    return Peak(Value(tilt, math.hypot(float(spread[0]), grid)), Value(speed, float(spread[1])))


def _top(tilts: Array, speeds: Array) -> tuple[float, float]:
    at = int(speeds.argmax())
    if at in (0, len(tilts) - 1):
        return float(tilts[at]), float(speeds[at])
    a, b, c = np.polyfit(tilts[at - 1 : at + 2] - tilts[at], speeds[at - 1 : at + 2], 2)
    return float(tilts[at] - b / (2.0 * a)), float(c - b * b / (4.0 * a))


def lively(series: Sequence[Point], plate_speed: float) -> list[Point]:
    """Points at this speed of the plate (mm/s) and above, where walkers in space run."""
    return [point for point in series if point.plate_speed_mm_s > 0.999 * plate_speed]


def through_zero(series: Sequence[Point]) -> Value | None:
    """Slope of the least-squares line through zero of speed against plate speed."""
    plate = np.array([point.plate_speed_mm_s for point in series if point.speed is not None])
    if len(plate) < 2:
        return None
    means, drawn = _drawn(series)
    slopes = drawn @ plate / (plate @ plate)
    return Value(float(means @ plate / (plate @ plate)), float(slopes.std(ddof=1)))


def proportionality(series: Sequence[Point]) -> Value | None:
    """Rms distance from the line through zero over the mean |speed|; 0: proportional.

    None with fewer than two speeds, or for a walker that always rests.
    """
    plate = np.array([point.plate_speed_mm_s for point in series if point.speed is not None])
    means, drawn = _drawn(series)
    if len(plate) < 2 or not means.any():
        return None

    def off(speeds: Array) -> Array:
        slope = speeds @ plate / (plate @ plate)
        rest = speeds - slope[:, None] * plate
        return np.asarray(np.sqrt((rest**2).mean(axis=1)) / np.abs(speeds).mean(axis=1))

    return Value(float(off(means[None])[0]), float(off(drawn).std(ddof=1)))


def restitution_of_peak(labels: Mapping[float, Sequence[Point]], stated: float) -> Value | None:
    """Restitution with which the peak has the stated speed (mm/s), between those simulated."""
    tops = [(e, top.speed) for e, series in sorted(labels.items()) if (top := peak(series))]
    for (low, below), (high, above) in pairwise(tops):
        if below.mean <= stated <= above.mean and below.mean < above.mean:
            step = (high - low) / (above.mean - below.mean)
            share = (stated - below.mean) / (above.mean - below.mean)
            error = step * math.hypot((1.0 - share) * below.se, share * above.se)
            return Value(low + (high - low) * share, error)
    return None
