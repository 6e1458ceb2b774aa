"""Landings of feet among their impacts: corners that land alone, as an edge, or with the other foot."""

from typing import NamedTuple

import numpy as np

from walkergen.core.numerics import Array, Mask, Whole

MAX_GROUP_S = 50e-6
"""Time within which corners land together, s: about as long as one contact lasts."""

CORNERS_PER_FOOT = 2
"""Number of corners of a foot: 0 and 1 belong to the first foot, 2 and 3 to the second."""


class Landings(NamedTuple):
    """Numbers of landings of one walker in a time."""

    duration: float
    """Duration of the count, s."""
    corners: Whole
    """Landings of each corner, shape (2 feet,)."""
    alone: int
    """Groups of landings within `MAX_GROUP_S` with only one corner."""
    edges: Whole
    """Groups with both corners of a foot, shape (feet,)."""
    pairs: int
    """Groups with two feet or more."""
    groups: int


def count(time: Array, corner: Whole, duration: float, feet: int = 2) -> Landings:
    """Count the landings of a walker with this number of feet, in `duration` seconds.

    `time` (s, in any order) and `corner` (its number): one entry for each first touch of a corner. A group begins with
    a landing and contains all that follow within `MAX_GROUP_S` of it.
    """
    order = np.argsort(time, kind="stable")
    landed = _group_corners(time[order], corner[order], feet * CORNERS_PER_FOOT)
    by_foot = landed.reshape(-1, feet, CORNERS_PER_FOOT)
    several = by_foot.any(axis=2).sum(axis=1) > 1
    return Landings(
        duration=duration,
        corners=np.bincount(corner, minlength=feet * CORNERS_PER_FOOT),
        alone=int(np.count_nonzero(landed.sum(axis=1) == 1)),
        edges=by_foot.all(axis=2).sum(axis=0),
        pairs=int(np.count_nonzero(several)),
        groups=len(landed),
    )


def _group_corners(time: Array, corner: Whole, corners: int) -> Mask:
    """Return whether each corner lands in each group, shape (groups, corners).

    `time` (s, sorted) and `corner` have an entry for each landing; `corners` is the number of corners.
    """
    firsts, index = [], 0
    while index < len(time):
        firsts.append(index)
        index = int(np.searchsorted(time, time[index] + MAX_GROUP_S, side="right"))
    landed = np.zeros((len(firsts), corners), dtype=bool)
    if firsts:
        group = np.searchsorted(firsts, np.arange(len(time)), side="right") - 1
        landed[group, corner] = True
    return landed
