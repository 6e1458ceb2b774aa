"""Landings of feet among their impacts: corners that land alone, as an edge, or with the other foot."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]

MAX_GROUP_S = 50e-6
"""Time within which corners land together, s: about as long as one contact lasts."""

CORNERS_PER_FOOT = 2
"""Number of corners of a foot: 0 and 1 belong to the first foot, 2 and 3 to the second."""


MIN_QUIET_S = 1e-3
"""Time without impacts before a foot's landing, s; a flexible leg's contact takes some 0.4 ms, a
period of the paper's drive 11 ms."""


class Landings(NamedTuple):
    """Numbers of landings of one walker in a time."""

    duration: float
    """Time in which they were counted, s."""
    corners: Whole
    """Landings of each corner, shape (2 feet,)."""
    alone: int
    """Groups of landings within `TOGETHER_S` in which only one corner landed."""
    edges: Whole
    """Groups in which both corners of a foot landed, shape (feet,)."""
    pairs: int
    """Groups in which two feet landed, or more."""
    groups: int


class Impacts(NamedTuple):
    """Impacts of a run's feet, arrays of shape (n,)."""

    time: Array
    """Time, s; in space not ascending: contacts are noted when they end."""
    foot: Whole
    """Number of the foot, in space of the corner."""
    F_x: Array
    """Impulse along the plate, g mm/s."""
    F_y: Array
    """Impulse off the plate, g mm/s."""
    v_x: Array
    """Velocity of the foot along the plate before, mm/s."""
    v_y: Array
    """Velocity of the foot off the plate before, mm/s."""
    kind: Whole
    """Type of impact, one of `walkergen.core.theory.impact.Kind`."""


def from_record(rows: Array) -> Impacts:
    """Impacts of a run from its record, rows of shape (n, 7) in the order of the fields."""
    time, foot, F_x, F_y, v_x, v_y, kind = rows.T
    return Impacts(time, foot.astype(np.int64), F_x, F_y, v_x, v_y, kind.astype(np.int64))


def is_landing(time: Array, foot: Whole) -> npt.NDArray[np.bool_]:
    """Whether each impact is a landing: the first of its foot after QUIET_S without any."""
    landing = np.zeros(len(time), dtype=bool)
    for number in np.unique(foot):
        (of_foot,) = np.nonzero(foot == number)
        # In space impacts come in the order of their ends
        of_foot = of_foot[np.argsort(time[of_foot], kind="stable")]
        landing[of_foot] = np.diff(time[of_foot], prepend=-math.inf) > MIN_QUIET_S
    return landing


def count(time: Array, corner: Whole, duration: float, feet: int = 2) -> Landings:
    """Count the landings of a walker on `feet` feet in `duration` seconds, one entry a landing.

    `time` of the first touch (s), in any order; number of the `corner`. A group begins with a
    landing and takes in all that follow within `TOGETHER_S` of it.
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


def _group_corners(time: Array, corner: Whole, corners: int) -> npt.NDArray[np.bool_]:
    """Corners that land in each group, shape (groups, corners); times are sorted."""
    firsts, at = [], 0
    while at < len(time):
        firsts.append(at)
        at = int(np.searchsorted(time, time[at] + MAX_GROUP_S, side="right"))
    landed = np.zeros((len(firsts), corners), dtype=bool)
    if firsts:
        group = np.searchsorted(firsts, np.arange(len(time)), side="right") - 1
        landed[group, corner] = True
    return landed
