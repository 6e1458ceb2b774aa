"""Numbers that series of simulated speeds give: peak, ratio, proportionality, with errors."""

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from evidence import curves, quantities
from evidence.curves import Top
from evidence.reproduce.runs import Point
from walkergen.core.numerics import Array
from walkergen.core.numerics.quantity import Quantity, mean

NO_TOP = Top(Quantity("tilt", "deg", None, refused="no peak between the tilts"), Quantity("speed", "mm_s", None))
"""Top of a curve that may rise on beyond its ends."""


def group_points(points: Sequence[Point]) -> list[list[Point]]:
    """Group points by assumption and model, in the order of first appearance."""
    series = dict[tuple[str, str], list[Point]]()
    for point in points:
        series.setdefault((point.assumption.name, point.model), []).append(point)
    return list(series.values())


def group_by_restitution(points: Sequence[Point]) -> dict[float, list[Point]]:
    """Series in space by restitution, those with the friction of the first, each restitution once."""
    restitutions = dict[float, list[Point]]()
    for series in group_points([point for point in points if point.model == "space"]):
        contact = series[0].assumption.scene.contact
        if contact.friction == points[0].assumption.scene.contact.friction:
            restitutions.setdefault(contact.restitution, series)
    return dict(sorted(restitutions.items()))


def size(quantity: Quantity) -> float:
    """Distance of a quantity from zero; -1 of one without a value."""
    return -1.0 if quantity.value is None else abs(quantity.value)


def smallest_share(series: Sequence[Point], counting: str, kind: str) -> Quantity:
    """Smallest share over tilts above 0: an upright walker slides backward as often as forward."""
    shares = [point.shares[counting, kind] for point in series if point.shares and point.tilt_deg > 0.0]
    return min(shares, key=size, default=Quantity(kind, "", None, refused="no impacts"))


def impact_speed(series: Sequence[Point]) -> Quantity:
    """Impact speed over the plate's peak speed: mean and standard error over the tilts."""
    speeds = [(point.impact_speed.value, point.plate_speed_mm_s) for point in series]
    ratios = [speed / plate for speed, plate in speeds if speed is not None]
    return mean("impact_speed", "", ratios if len(ratios) > 1 else [])


def speed_ratio(series: Sequence[Point], over: float, under: float) -> Quantity:
    """Speed at one tilt over that at another, with the error that theirs give it."""
    at = {point.tilt_deg: point.speed for point in series}
    if over not in at or under not in at or not at[under].value:
        return Quantity("ratio", "", None, refused="no speed at both tilts")
    return quantities.ratio(at[over], at[under])


def find_peak(series: Sequence[Point]) -> Top:
    """Top of the measured speeds over the tilts (see `curves.top`).

    Tilts without a speed are left out; none where the largest speed lies at the first or last of
    the others: the top may lie beyond.
    """
    tilts, speeds = _known_speeds([point.tilt_deg for point in series], series)
    highest = max(range(len(speeds)), key=lambda at: speeds[at].value or 0.0, default=0)
    if len(speeds) < 3 or highest in (0, len(speeds) - 1):
        return NO_TOP
    return curves.top(tilts, speeds)


def running_points(series: Sequence[Point], plate_speed: float) -> list[Point]:
    """Points at this speed of the plate (mm/s) and above, where walkers in space run."""
    return [point for point in series if point.plate_speed_mm_s > 0.999 * plate_speed]


def slope_through_zero(series: Sequence[Point]) -> Quantity:
    """Slope of the least-squares line through zero of speed against plate speed."""
    plate, speeds = _known_speeds([point.plate_speed_mm_s for point in series], series)
    return curves.slope(plate, speeds) if len(plate) > 1 else Quantity("slope", "", None, refused="too few speeds")


def proportionality(series: Sequence[Point]) -> Quantity:
    """Rms distance from the line through zero over the mean |speed|, %; 0: proportional.

    None with fewer than two speeds, or for a walker that always rests.
    """
    plate, speeds = _known_speeds([point.plate_speed_mm_s for point in series], series)
    if len(plate) < 2 or not any(speed.value for speed in speeds):
        return Quantity("off_line", "percent", None, refused="too few speeds, or none but zero")
    return curves.distance_from_line(plate, speeds)


def _known_speeds(places: Sequence[float], series: Sequence[Point]) -> tuple[Array, list[Quantity]]:
    """Places and speeds of the points that have a speed."""
    pairs = [(place, point.speed) for place, point in zip(places, series, strict=True) if point.speed.value is not None]
    return np.array([place for place, _ in pairs]), [speed for _, speed in pairs]


def restitution_of_peak(restitutions: Mapping[float, Sequence[Point]], stated: float) -> Quantity:
    """Restitution that gives the peak the stated speed (mm/s), interpolated between those simulated."""
    tops = [(restitution, find_peak(series).height) for restitution, series in sorted(restitutions.items())]
    heights = [(restitution, top.value, top.se or 0.0) for restitution, top in tops if top.value is not None]
    for (low, below, below_se), (high, above, above_se) in pairwise(heights):
        if below <= stated <= above and below < above:
            step, share = (high - low) / (above - below), (stated - below) / (above - below)
            error = step * math.hypot((1.0 - share) * below_se, share * above_se)
            return Quantity("restitution", "", low + (high - low) * share, error)
    return Quantity("restitution", "", None, refused="no two restitutions with the peak between")
