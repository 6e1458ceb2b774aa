"""Footage of one run for a movie: the walker's outline, its poses, the plate and the impacts."""

from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from walkergen.theory.impact import Kind
from walkergen.walker.limbs import Polygon

Array = npt.NDArray[np.float64]

BACK, FRONT = 0, 1


class Shape(NamedTuple):
    """Outline of a walker: polygons of shape (n, 2), mm."""

    body: Polygon
    """Outline of the body about the point O that the poses follow."""
    limbs: tuple[tuple[Polygon, ...], ...]
    """Polygons of each leg, and of its brace if it has one, with the anchor at the origin."""
    anchors: Array
    """Vectors from O to the back and front anchor, shape (2, 2), mm."""
    feet: Array
    """Vectors from the anchors to the simulation's points of contact, shape (2, 2), mm."""


class Impact(NamedTuple):
    """Impact of a foot on the plate."""

    time: float
    """Time since the first pose, s."""
    foot: int
    """Foot that hits the plate: BACK or FRONT."""
    impulse: Array
    """Impulse on the foot, shape (2,), g mm/s."""
    kind: Kind


def impact_of(event: Array) -> Impact:
    """Impact of a row of the simulation's events (see `record.Events`)."""
    time, foot, along, upward, _, _, kind = event
    return Impact(time, int(foot), np.array((along, upward)), Kind(int(kind)))


class Title(NamedTuple):
    """Words by which a picture tells its walker from others."""

    design: str
    tilt: str
    """Tilt of its legs with its unit."""
    kind: str

    @property
    def legs(self) -> str:
        """Tilt and kind of its legs."""
        return f"{self.tilt} {self.kind}"

    def __str__(self) -> str:
        return f"{self.design}, {self.tilt}, {self.kind}"


class Footage(NamedTuple):
    """Poses of one simulated run at a fixed rate, n of them."""

    title: Title
    model: str
    """Model of the legs in the simulation: compliant, relaxed or rigid."""
    shape: Shape
    times: Array
    """Times of the poses, shape (n,), s, from 0."""
    places: Array
    """Places of O, shape (n, 2), mm; x from 0, y over the plate's mean height."""
    pitch: Array
    """Pitch of the body, shape (n,), rad, counter-clockwise."""
    angles: Array
    """Angles of the back and front leg to the body, shape (n, 2), rad, counter-clockwise."""
    plate: Array
    """Height of the plate's surface over its mean, shape (n,), mm."""
    phase: Array
    """Phase of the drive, shape (n,), rad."""
    impacts: tuple[Impact, ...]
    """Impacts in the order of their times."""
    ended: str
    """Reason why the run ended early; '' when it did not."""

    @property
    def name(self) -> str:
        """Name of the walker, as the picture shows it."""
        return str(self.title)

    @property
    def distance(self) -> float:
        """Distance run, mm."""
        return float(self.places[-1, 0])


class Struck(Protocol):
    """Footage or shot: whatever has impacts."""

    @property
    def impacts(self) -> tuple[Impact, ...]:
        """Impacts in the order of their times."""

    @property
    def times(self) -> Array:
        """Times of the poses, shape (n,), s."""

    @property
    def plate(self) -> Array:
        """Heights of the plate, shape (n,), mm."""


def pace(slow: float) -> str:
    """Pace of a movie in words; `slow` seconds of it show one second of the run."""
    if slow == 1.0:
        return "real time"
    return f"{slow:.3g} times slower" if slow > 1.0 else f"{1.0 / slow:.3g} times faster"


def polygons(footage: Footage, at: int, bend: float = 1.0) -> tuple[list[Polygon], Polygon]:
    """Polygons of limbs (back, then front, with their parts) and body at pose `at`, mm.

    Legs bend `bend` times as much as they did.
    """
    shape, place, pitch = footage.shape, footage.places[at], footage.pitch[at]
    limbs = []
    for side in (BACK, FRONT):
        hinge = place + _turned(shape.anchors[side], pitch)
        turn = pitch + bend * footage.angles[at, side]
        limbs += [hinge + _turned(part, turn) for part in shape.limbs[side]]
    return limbs, place + _turned(shape.body, pitch)


def feet(footage: Footage, relaxed: bool = False) -> Array:
    """Positions of the feet's contact points, shape (n, 2 feet, 2), mm; `relaxed`: legs unbent."""
    points = np.empty((len(footage.times), 2, 2))
    for side in (BACK, FRONT):
        angle = 0.0 * footage.pitch if relaxed else footage.angles[:, side]
        anchor = _turned(footage.shape.anchors[side], footage.pitch)
        points[:, side] = footage.places + anchor + _turned(footage.shape.feet[side], footage.pitch + angle)
    return points


def strongest(footage: Struck, time: float, afterglow: float, side: int) -> tuple[Impact, float] | None:
    """Impact that a foot shows at `time`, and the share of its flash that is left (1 down to 0).

    Among the impacts within the afterglow (s) it is that whose impulse, faded linearly, is largest.
    """
    shown = [
        (hit, 1.0 - (time - hit.time) / afterglow)
        for hit in footage.impacts
        if hit.foot == side and time - afterglow < hit.time <= time
    ]
    if not shown:
        return None
    return max(shown, key=lambda pair: float(np.hypot(*pair[0].impulse)) * pair[1])


def _turned(points: Array, angle: float | Array) -> Array:
    """Turn points (..., 2) counter-clockwise; an array of angles turns one point."""
    x, y = points[..., 0], points[..., 1]
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
