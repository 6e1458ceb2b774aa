"""Landings of feet among the impacts of a run."""

import math
from typing import NamedTuple

import numpy as np

from walkergen.core.numerics import Array, Mask, Whole

QUIET_S = 1e-3
"""Time without impacts before a foot's landing, s; a flexible leg's contact takes some 0.4 ms, a
period of the paper's drive 11 ms."""


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


def impacts_in(rows: Array) -> Impacts:
    """Impacts of a run from its record, rows of shape (n, 7) in the order of the fields."""
    time, foot, F_x, F_y, v_x, v_y, kind = rows.T
    return Impacts(time, foot.astype(np.int64), F_x, F_y, v_x, v_y, kind.astype(np.int64))


def find_landings(time: Array, foot: Whole) -> Mask:
    """Whether each impact is a landing: the first of its foot after QUIET_S without any."""
    landing = np.zeros(len(time), dtype=bool)
    for number in np.unique(foot):
        (of_foot,) = np.nonzero(foot == number)
        # In space impacts come in the order of their ends
        of_foot = of_foot[np.argsort(time[of_foot], kind="stable")]
        landing[of_foot] = np.diff(time[of_foot], prepend=-math.inf) > QUIET_S
    return landing
