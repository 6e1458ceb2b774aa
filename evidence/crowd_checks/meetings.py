"""Meetings of two walkers: how they come together, and what is seen of them afterwards."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import shapely

from evidence.crowd_checks.setting import RATE_HZ
from walkergen.core.numerics import Array

MIN_WAY_MM, MAX_WAY_MM = 18.0, 24.0
"""Way (mm) that each of both has to go until they meet, drawn evenly between: those in space, which
are let go at rest, have by then all of their speed but 1 %."""

CONTACT_GAP_MM = 0.7
"""Gap (mm) below which two touch: at one frame in a period of the plate no blow is missed."""

FRAMES_BEFORE, FRAMES_AFTER = (-4, -1), (1, 3)
"""Frames after the first touch, over which velocities are taken."""

EARLY_FRAMES, LATE_FRAMES = 5, 27
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


EDGE_ANGLE = math.radians(15.0)

MEETINGS = (
    Meeting("head on", 0.0, math.pi, 0.0, None),
    Meeting("glancing", 0.0, math.pi, 6.0, (0.5, 0.5)),
    Meeting("edge on edge", EDGE_ANGLE, -EDGE_ANGLE, 0.0, (-0.5, 0.5)),
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
both; share of 0.3 s during which they touch; path of each, and its part across the heading at the
touch."""


def approach_direction(meeting: Meeting) -> Array:
    """Direction of the first's approach to the second, shape (2,)."""
    velocity = _heading_vector(meeting.first) - _heading_vector(meeting.second)
    return np.asarray(velocity / np.hypot(*velocity))


def start_places(meeting: Meeting, outline: Array, rng: np.random.Generator) -> Array:
    """Start places of two that will meet, shape (2, 3): x, y (mm) of C and headings (rad)."""
    way = approach_direction(meeting)
    aside = meeting.left_mm * np.array([-way[1], way[0]])
    second = np.array([0.0, 0.0, meeting.second])
    near, far = 0.0, 4.0 * float(np.ptp(outline, axis=0).max())
    for _ in range(40):  # until they touch
        middle = 0.5 * (near + far)
        first = np.array([*(aside - middle * way), meeting.first])
        apart = float(body_gaps(outline, first, second)) > 0.0
        near, far = (near, middle) if apart else (middle, far)
    two = np.array([[*(aside - far * way), meeting.first], second])
    two[:, :2] -= rng.uniform(MIN_WAY_MM, MAX_WAY_MM) * np.array([_heading_vector(angle) for angle in two[:, 2]])
    return two


def body_gaps(outline: Array, first: Array, second: Array) -> Array:
    """Gaps (mm) between two bodies of one outline, from C, at poses of shape (..., 3)."""
    return np.asarray(shapely.distance(_body_polygons(outline, first), _body_polygons(outline, second)))


def _body_polygons(outline: Array, poses: Array) -> npt.NDArray[np.object_]:
    """Polygons at poses of shape (..., 3)."""
    cos, sin = np.cos(poses[..., 2])[..., None], np.sin(poses[..., 2])[..., None]
    x = poses[..., :1] + cos * outline[:, 0] - sin * outline[:, 1]
    y = poses[..., 1:2] + sin * outline[:, 0] + cos * outline[:, 1]
    return np.asarray(shapely.polygons(np.stack((x, y), axis=-1)))


def measure_meeting(meeting: Meeting, outline: Array, two: Array) -> dict[str, float] | None:
    """Measure one meeting by the keys of UNITS, from poses of shape (F, 2, 3) at RATE_HZ.

    None if the two missed each other, or met before they were at speed.
    """
    apart = body_gaps(outline, two[:, 0], two[:, 1])
    touched = np.flatnonzero(apart < CONTACT_GAP_MM)
    if not touched.size or not -FRAMES_BEFORE[0] <= touched[0] < len(two) - LATE_FRAMES:
        return None
    start = int(touched[0])
    along = (two[:, 0, :2] - two[:, 1, :2]) @ approach_direction(meeting)

    def velocity(frames: tuple[int, int]) -> float:
        first, last = (start + frame for frame in frames)
        return float(along[last] - along[first]) / (last - first) * RATE_HZ

    def turn(frames: int) -> float:
        turns = np.degrees(two[start + frames, :, 2] - two[start, :, 2])
        return float(np.abs(turns).mean() if meeting.turns is None else turns @ meeting.turns)

    ways = two[start + LATE_FRAMES, :, :2] - two[start, :, :2]
    across = np.array([_heading_vector(angle + 0.5 * math.pi) for angle in two[start, :, 2]])
    numbers = (
        -velocity(FRAMES_AFTER) / velocity(FRAMES_BEFORE),
        turn(EARLY_FRAMES),
        turn(LATE_FRAMES),
        float((apart[start : start + LATE_FRAMES + 1] < CONTACT_GAP_MM).mean()),
        float(np.hypot(*ways.T).mean()),
        float(np.abs((ways * across).sum(axis=1)).mean()),
    )
    return dict(zip(UNITS, numbers, strict=True))


def _heading_vector(angle: float) -> Array:
    return np.array([math.cos(angle), math.sin(angle)])
