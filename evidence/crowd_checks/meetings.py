"""Meetings of two walkers: how they come together, and what is seen of them afterwards."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import shapely

from evidence.crowd_checks.setting import RATE_HZ
from walkergen.core.numerics import Array

NEAREST, FARTHEST = 18.0, 24.0
"""Way (mm) that each of both has to go until they meet, drawn evenly between: those in space, which
are let go at rest, have by then all of their speed but 1 %."""

NEAR = 0.7
"""Gap (mm) below which two touch: at one frame in a period of the plate no blow is missed."""

BEFORE, AFTER = (-4, -1), (1, 3)
"""Frames, from the first in which they touch, over which velocities are taken."""

SOON, LATER = 5, 27
"""Frames after which turns are taken: 0.06 and 0.3 s."""


class Meeting(NamedTuple):
    """How two bodies of 28 x 8 mm meet."""

    name: str
    first: float
    """Heading of the first, rad."""
    second: float
    left_mm: float
    """Place of the first to the left of a way that would lead it, seen from the second, to it."""
    turns: tuple[float, float] | None
    """Weights of the two turns by symmetry; None: mean size, where neither sense is preferred."""


LEAN = math.radians(15.0)

MEETINGS = (
    Meeting("head on", 0.0, math.pi, 0.0, None),
    Meeting("glancing", 0.0, math.pi, 6.0, (0.5, 0.5)),
    Meeting("edge on edge", LEAN, -LEAN, 0.0, (-0.5, 0.5)),
    Meeting("corner on face", math.radians(30.0), math.radians(90.0), -10.0, (0.5, -0.5)),
)

UNITS = {
    "velocity_kept": "",
    "turn_in_0.06_s": "deg",
    "turn_in_0.3_s": "deg",
    "time_together": "",
    "way_in_0.3_s": "mm",
    "aside_in_0.3_s": "mm",
}
"""Units of what is seen of a meeting: velocity apart over that of the approach, along it; turns of
both; share of 0.3 s in which they touch; way of each, and of it what is across the heading that it
had at the touch."""


def approach(meeting: Meeting) -> Array:
    """Direction in which the first nears the second, shape (2,)."""
    velocity = _ahead(meeting.first) - _ahead(meeting.second)
    return np.asarray(velocity / np.hypot(*velocity))


def places(meeting: Meeting, outline: Array, rng: np.random.Generator) -> Array:
    """Places from which two come together, shape (2, 3): x, y (mm) of C and headings (rad)."""
    way = approach(meeting)
    aside = meeting.left_mm * np.array([-way[1], way[0]])
    second = np.array([0.0, 0.0, meeting.second])
    near, far = 0.0, 4.0 * float(np.ptp(outline, axis=0).max())
    for _ in range(40):  # until they touch
        middle = 0.5 * (near + far)
        first = np.array([*(aside - middle * way), meeting.first])
        apart = float(gaps(outline, first, second)) > 0.0
        near, far = (near, middle) if apart else (middle, far)
    two = np.array([[*(aside - far * way), meeting.first], second])
    two[:, :2] -= rng.uniform(NEAREST, FARTHEST) * np.array([_ahead(angle) for angle in two[:, 2]])
    return two


def gaps(outline: Array, first: Array, second: Array) -> Array:
    """Gaps (mm) between two bodies of one outline, from C, at poses of shape (..., 3)."""
    return np.asarray(shapely.distance(_bodies(outline, first), _bodies(outline, second)))


def _bodies(outline: Array, poses: Array) -> npt.NDArray[np.object_]:
    """Polygons at poses of shape (..., 3)."""
    cos, sin = np.cos(poses[..., 2])[..., None], np.sin(poses[..., 2])[..., None]
    x = poses[..., :1] + cos * outline[:, 0] - sin * outline[:, 1]
    y = poses[..., 1:2] + sin * outline[:, 0] + cos * outline[:, 1]
    return np.asarray(shapely.polygons(np.stack((x, y), axis=-1)))


def seen(meeting: Meeting, outline: Array, two: Array) -> dict[str, float] | None:
    """Measure one meeting by the keys of UNITS, from poses of shape (F, 2, 3) at RATE_HZ.

    None if the two missed each other, or met before they were at speed.
    """
    apart = gaps(outline, two[:, 0], two[:, 1])
    touched = np.flatnonzero(apart < NEAR)
    if not touched.size or not -BEFORE[0] <= touched[0] < len(two) - LATER:
        return None
    start = int(touched[0])
    along = (two[:, 0, :2] - two[:, 1, :2]) @ approach(meeting)

    def velocity(frames: tuple[int, int]) -> float:
        first, last = (start + frame for frame in frames)
        return float(along[last] - along[first]) / (last - first) * RATE_HZ

    def turn(frames: int) -> float:
        turns = np.degrees(two[start + frames, :, 2] - two[start, :, 2])
        return float(np.abs(turns).mean() if meeting.turns is None else turns @ meeting.turns)

    ways = two[start + LATER, :, :2] - two[start, :, :2]
    across = np.array([_ahead(angle + 0.5 * math.pi) for angle in two[start, :, 2]])
    numbers = (
        -velocity(AFTER) / velocity(BEFORE),
        turn(SOON),
        turn(LATER),
        float((apart[start : start + LATER + 1] < NEAR).mean()),
        float(np.hypot(*ways.T).mean()),
        float(np.abs((ways * across).sum(axis=1)).mean()),
    )
    return dict(zip(UNITS, numbers, strict=True))


def _ahead(angle: float) -> Array:
    return np.array([math.cos(angle), math.sin(angle)])
