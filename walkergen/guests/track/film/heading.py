"""Headings: from a mark on the front, or from the long axis and the direction of running.

A long axis has no front. It is followed from frame to frame, so that one decision on the front holds until the walker
is lost. The mark in most frames decides or, without marks, the direction of running. A round walker needs a mark.
"""

import math
from itertools import pairwise
from typing import Literal, NamedTuple, get_args

import numpy as np

from walkergen.core.numerics import Array, Whole
from walkergen.guests.track.film.linking import Track

By = Literal["motion", "mark"]
HEADING_SOURCES: tuple[By, ...] = get_args(By)
"""Sources that decide which end is the front."""

MIN_ELONGATION = 1.2
"""Smallest length over width of a walker whose long axis can be measured."""

MAX_TURN = math.radians(40.0)
"""Largest turn of a long axis between two frames that show it; beyond 90 degrees it is ambiguous."""

MAX_GAP_FRAMES = 3
"""Longest gap, in frames, across which a lost walker's axis is followed."""

MIN_RUN_LENGTHS = 0.1
"""Shortest path along the axis, over a walker's length, that decides which end is the front."""


class Headings(NamedTuple):
    """Headings of a walker."""

    theta: Array
    """Headings in the frames that show the walker, shape (n,), rad, from x (to the right) toward y (up); whole turns
    are counted; NaN where the heading is unknown."""
    how: str
    """Source of the headings, or the reason why there is none."""


def find_headings(walker: Track, by: By) -> Headings:
    """Find the headings of one walker. `by`: whether its mark or its motion decides which end is the front."""
    axis, mark = walker.blobs.axis, walker.blobs.mark
    elongation = float(np.median(walker.blobs.length / walker.blobs.width))
    seen = ~np.isnan(mark)
    if by == "mark" and not seen.any():
        return _no_heading(walker, "no mark was seen")
    if elongation < MIN_ELONGATION and by == "mark":
        how = f"the mark, seen in {seen.sum()} of {len(seen)} frames"
        return Headings(unwrap(np.where(seen, mark, np.nan)), how)
    if elongation < MIN_ELONGATION:
        return _no_heading(walker, f"{elongation:.2f} times as long as wide: mark the front, ‹heading=›mark")
    theta = np.full(len(axis), np.nan)
    for part in _continuous_parts(walker.frames, axis):
        followed = np.unwrap(axis[part], period=math.pi)
        votes = _mark_votes(followed, mark[part]) if by == "mark" else _distance_ahead(followed, walker, part)
        if votes:
            theta[part] = followed + (math.pi if votes < 0 else 0.0)
    headed = int((~np.isnan(theta)).sum())
    if not headed:
        why = f"it ran less than {MIN_RUN_LENGTHS:g} of its length" if by == "motion" else "marks disagree"
        return _no_heading(walker, f"{why}, so that front and back are alike")
    front = "the mark" if by == "mark" else "the direction of running"
    return Headings(unwrap(theta), f"the long axis and {front}, in {headed} of {len(axis)} frames")


def _no_heading(walker: Track, why: str) -> Headings:
    """Return headings that are all NaN, with the reason `why`."""
    return Headings(np.full(len(walker.frames), np.nan), why)


def _continuous_parts(frames: Whole, axis: Array) -> list[slice]:
    """Return the parts of a track whose long axis, at angles `axis` (rad), can be followed from frame to frame."""
    turns = np.abs((np.diff(axis) + 0.5 * math.pi) % math.pi - 0.5 * math.pi)
    cuts = np.flatnonzero((turns > MAX_TURN) | (np.diff(frames) > MAX_GAP_FRAMES)) + 1
    ends = [0, *cuts.tolist(), len(axis)]
    return [slice(low, high) for low, high in pairwise(ends)]


def _mark_votes(axis: Array, mark: Array) -> float:
    """Count the frames with the mark ahead on the axis, minus those with it behind. Angles, rad, shape (n,)."""
    return float(np.nansum(np.sign(np.cos(mark - axis))))


def _distance_ahead(axis: Array, walker: Track, part: slice) -> float:
    """Return the path (pixels) of a walker along its `axis` (rad) in a part of its track, or 0 if it is too short.

    It is negative if the walker runs opposite to the axis. `axis`: angles in the frames of the part.
    """
    x, y = walker.blobs.x[part], -walker.blobs.y[part]
    middle = 0.5 * (axis[1:] + axis[:-1])
    run = float(np.diff(x) @ np.cos(middle) + np.diff(y) @ np.sin(middle))
    return run if abs(run) > MIN_RUN_LENGTHS * float(np.median(walker.blobs.length)) else 0.0


def unwrap(theta: Array) -> Array:
    """Unwrap angles (rad), skipping NaN, so that whole turns count. The first known angle is moved to -pi..pi."""
    unwrapped, certain = theta.copy(), ~np.isnan(theta)
    unwrapped[certain] = np.unwrap(theta[certain])
    if certain.any():
        unwrapped -= 2.0 * math.pi * round(float(unwrapped[certain][0]) / (2.0 * math.pi))
    return unwrapped
