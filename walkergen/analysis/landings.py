"""Landings of corners: which land alone, as an edge, or with the other foot; types by impulse."""

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
    """Numbers of landings in a time, and the normal impulses of each type."""

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
    kinds: Whole
    """Types of impact that occur, sorted, shape (k,)."""
    numbers: Whole
    """Landings of each of the `kinds`."""
    impulses: Array
    """Sum of the normal impulses (g mm/s) of each of the `kinds`."""


def count(time: Array, corner: Whole, impulse: Array, kind: Whole, duration: float) -> Landings:
    """Count the landings of one walker in `duration` seconds; arrays have one entry a landing.

    `time` of the first touch (s), in any order; number of the `corner`; normal `impulse` (g mm/s);
    `kind` of impact (`impact.Kind`). A group begins with a landing and takes in all that follow
    within `TOGETHER_S` of it.
    """
    order = np.argsort(time, kind="stable")
    landed = _groups(time[order], corner[order])
    edges = np.stack([landed[:, foot].all(axis=1) for foot in ([0, 1], [2, 3])])
    feet = landed[:, :2].any(axis=1) & landed[:, 2:].any(axis=1)
    kinds, place = np.unique(kind, return_inverse=True)
    return Landings(
        duration=duration,
        corners=np.bincount(corner, minlength=CORNERS),
        alone=int(np.count_nonzero(landed.sum(axis=1) == 1)),
        edges=edges.sum(axis=1),
        pairs=int(np.count_nonzero(feet)),
        groups=len(landed),
        kinds=kinds,
        numbers=np.bincount(place, minlength=len(kinds)),
        impulses=np.asarray(np.bincount(place, impulse, len(kinds)), dtype=np.float64),
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


def total(parts: list[Landings]) -> Landings:
    """Landings of several walkers, or of several times, taken together; at least one part."""
    kinds = np.unique(np.concatenate([one.kinds for one in parts]))
    numbers, impulses = np.zeros(len(kinds), np.int64), np.zeros(len(kinds))
    for one in parts:
        place = np.searchsorted(kinds, one.kinds)
        numbers[place] += one.numbers
        impulses[place] += one.impulses
    return Landings(
        duration=sum(one.duration for one in parts),
        corners=np.sum([one.corners for one in parts], axis=0),
        alone=sum(one.alone for one in parts),
        edges=np.sum([one.edges for one in parts], axis=0),
        pairs=sum(one.pairs for one in parts),
        groups=sum(one.groups for one in parts),
        kinds=kinds,
        numbers=numbers,
        impulses=impulses,
    )


def shares_by_impulse(landings: Landings) -> dict[int, float]:
    """Share of each type of impact in the normal impulse; empty when there is none."""
    whole = float(landings.impulses.sum())
    if not whole > 0:
        return {}
    pairs = zip(landings.kinds, landings.impulses, strict=True)
    return {int(kind): float(impulse) / whole for kind, impulse in pairs}
