"""Numbers that series of simulated speeds give: peak, ratio, proportionality, with errors."""

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from walkergen.analysis import values
from walkergen.analysis.values import Top, Value, mean
from walkergen.jobs.trust.reproduce.sweeps import Point

Array = npt.NDArray[np.float64]


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
    shares = [point.shares[counting, kind] for point in series if point.shares and point.tilt_deg > 0.0]
    return min(shares, key=lambda share: share.mean) if shares else None


def impact_speed(series: Sequence[Point]) -> Value | None:
    """Impact speed over the plate's peak speed: mean and standard error over the tilts."""
    ratios = [point.impact_speed.mean / point.plate_speed_mm_s for point in series if point.impact_speed is not None]
    return mean(ratios) if len(ratios) > 1 else None


def ratio(series: Sequence[Point], over: float, under: float) -> Value | None:
    """Speed at one tilt over that at another, with the error that theirs give it."""
    at = {point.tilt_deg: point.speed for point in series}
    first, second = at.get(over), at.get(under)
    if first is None or second is None or second.mean == 0.0:
        return None
    return values.ratio(first, second)


def peak(series: Sequence[Point]) -> Top | None:
    """Top of the measured speeds over the tilts (see `values.top`).

    Tilts without a speed are left out; None where the largest speed lies at the first or last of
    the others: the top may lie beyond.
    """
    ended = [point for point in series if point.speed is not None]
    speeds = [point.speed for point in ended if point.speed is not None]
    highest = max(range(len(speeds)), key=lambda at: speeds[at].mean, default=0)
    if len(speeds) < 3 or highest in (0, len(speeds) - 1):
        return None
    return values.top(np.array([point.tilt_deg for point in ended]), speeds)


def lively(series: Sequence[Point], plate_speed: float) -> list[Point]:
    """Points at this speed of the plate (mm/s) and above, where walkers in space run."""
    return [point for point in series if point.plate_speed_mm_s > 0.999 * plate_speed]


def through_zero(series: Sequence[Point]) -> Value | None:
    """Slope of the least-squares line through zero of speed against plate speed."""
    plate, speeds = _driven(series)
    return values.slope(plate, speeds) if len(plate) > 1 else None


def proportionality(series: Sequence[Point]) -> Value | None:
    """Rms distance from the line through zero over the mean |speed|; 0: proportional.

    None with fewer than two speeds, or for a walker that always rests.
    """
    plate, speeds = _driven(series)
    moved = any(speed.mean for speed in speeds)
    return values.off_line(plate, speeds) if len(plate) > 1 and moved else None


def _driven(series: Sequence[Point]) -> tuple[Array, list[Value]]:
    """Speeds of the plate and of walkers, where these have one."""
    pairs = [(point.plate_speed_mm_s, point.speed) for point in series if point.speed is not None]
    return np.array([plate for plate, _ in pairs]), [speed for _, speed in pairs]


def restitution_of_peak(labels: Mapping[float, Sequence[Point]], stated: float) -> Value | None:
    """Restitution with which the peak has the stated speed (mm/s), between those simulated."""
    tops = [(e, top.height) for e, series in sorted(labels.items()) if (top := peak(series))]
    for (low, below), (high, above) in pairwise(tops):
        if below.mean <= stated <= above.mean and below.mean < above.mean:
            step = (high - low) / (above.mean - below.mean)
            share = (stated - below.mean) / (above.mean - below.mean)
            error = step * math.hypot((1.0 - share) * below.se, share * above.se)
            return Value(low + (high - low) * share, error)
    return None
