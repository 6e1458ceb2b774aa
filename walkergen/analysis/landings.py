"""Landings of corners: which land alone, as an edge, or with the other foot."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]

TOGETHER_S = 50e-6
"""Time within which corners land together, s: about as long as one contact lasts."""

CORNERS = 4
"""Number of corners: 0 and 1 belong to the back foot, 2 and 3 to the front one."""


class Landings(NamedTuple):
    """Numbers of landings of one walker in a time."""

    duration: float
    """Time in which they were counted, s."""
    corners: Whole
    """Landings of each corner, shape (4,)."""
    alone: int
    """Groups of landings within `TOGETHER_S` in which only one corner landed."""
    edges: Whole
    """Groups in which both corners of the back foot landed, and of the front foot, shape (2,)."""
    pairs: int
    """Groups in which both feet landed."""
    groups: int


def count(time: Array, corner: Whole, duration: float) -> Landings:
    """Count the landings of one walker in `duration` seconds; arrays have one entry a landing.

    `time` of the first touch (s), in any order; number of the `corner`. A group begins with a
    landing and takes in all that follow within `TOGETHER_S` of it.
    """
    order = np.argsort(time, kind="stable")
    landed = _groups(time[order], corner[order])
    edges = np.stack([landed[:, foot].all(axis=1) for foot in ([0, 1], [2, 3])])
    feet = landed[:, :2].any(axis=1) & landed[:, 2:].any(axis=1)
    return Landings(
        duration=duration,
        corners=np.bincount(corner, minlength=CORNERS),
        alone=int(np.count_nonzero(landed.sum(axis=1) == 1)),
        edges=edges.sum(axis=1),
        pairs=int(np.count_nonzero(feet)),
        groups=len(landed),
    )


def _groups(time: Array, corner: Whole) -> npt.NDArray[np.bool_]:
    """Corners that land in each group, shape (groups, 4); times are sorted."""
    firsts, at = [], 0
    while at < len(time):
        firsts.append(at)
        at = int(np.searchsorted(time, time[at] + TOGETHER_S, side="right"))
    landed = np.zeros((len(firsts), CORNERS), dtype=bool)
    if firsts:
        group = np.searchsorted(firsts, np.arange(len(time)), side="right") - 1
        landed[group, corner] = True
    return landed
