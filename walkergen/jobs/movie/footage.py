"""What a movie shows of one run: the walker's outline, its poses, the plate and the impacts."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.theory.impact import Kind
from walkergen.walker.solids import Polygon

Array = npt.NDArray[np.float64]

BACK, FRONT = 0, 1


class Shape(NamedTuple):
    """A walker's outline: polygons of shape (n, 2), mm."""

    body: Polygon
    """About the point O that the poses follow."""
    limb: tuple[Polygon, ...]
    """One leg, with its brace if it has one; its anchor at the origin."""
    anchors: Array
    """Shape (2, 2): O -> back and front anchor."""
    foot: Array
    """Shape (2,): anchor -> the point that the simulation lets touch the plate."""


class Impact(NamedTuple):
    """One impact of a foot on the plate."""

    time: float
    """s, since the first pose."""
    foot: int
    """BACK or FRONT."""
    impulse: Array
    """Shape (2,): on the foot, g mm/s."""
    kind: Kind


class Footage(NamedTuple):
    """One simulated run at a fixed rate, n poses."""

    name: str
    """Of the walker, as the picture shows it."""
    model: str
    """Of its legs in the simulation: compliant, relaxed or rigid."""
    shape: Shape
    times: Array
    """Shape (n,), s, from 0."""
    places: Array
    """Shape (n, 2): of O, mm; x from 0, y over the plate's mean height."""
    pitch: Array
    """Shape (n,), rad, counter-clockwise."""
    angles: Array
    """Shape (n, 2): of the back and front leg against the body, rad, counter-clockwise."""
    plate: Array
    """Shape (n,): height of the plate's surface over its mean, mm."""
    phase: Array
    """Shape (n,): of the drive, rad."""
    impacts: tuple[Impact, ...]
    """In the order of their times."""
    ended: str
    """Why the run ended early, in words; '' when it did not."""


def pace(slow: float) -> str:
    """How fast a movie plays, in words; `slow` seconds of it show one of the run."""
    if slow == 1.0:
        return "real time"
    return f"{slow:.3g} times slower" if slow > 1.0 else f"{1.0 / slow:.3g} times faster"


def polygons(footage: Footage, at: int) -> tuple[list[Polygon], Polygon]:
    """Limbs (the back one's parts, then the front one's) and body at pose `at`, mm."""
    shape, place, pitch = footage.shape, footage.places[at], footage.pitch[at]
    limbs = []
    for side in (BACK, FRONT):
        hinge = place + _turned(shape.anchors[side], pitch)
        turn = pitch + footage.angles[at, side]
        limbs += [hinge + _turned(part, turn) for part in shape.limb]
    return limbs, place + _turned(shape.body, pitch)


def feet(footage: Footage, relaxed: bool = False) -> Array:
    """Where the feet's contact points are, shape (n, 2 feet, 2), mm; `relaxed`: unbent legs."""
    found = np.empty((len(footage.times), 2, 2))
    for side in (BACK, FRONT):
        angle = 0.0 * footage.pitch if relaxed else footage.angles[:, side]
        anchor = _turned(footage.shape.anchors[side], footage.pitch)
        found[:, side] = (
            footage.places + anchor + _turned(footage.shape.foot, footage.pitch + angle)
        )
    return found


def strongest(
    footage: Footage, time: float, afterglow: float, side: int
) -> tuple[Impact, float] | None:
    """The impact that a foot shows at `time`, and how much of its flash is left (1 down to 0).

    Of those within the afterglow (s) the one whose impulse, faded linearly, is largest.
    """
    shown = [
        (hit, 1.0 - (time - hit.time) / afterglow)
        for hit in footage.impacts
        if hit.foot == side and time - afterglow < hit.time <= time
    ]
    if not shown:
        return None
    return max(shown, key=lambda one: float(np.hypot(*one[0].impulse)) * one[1])


def _turned(points: Array, angle: float | Array) -> Array:
    """Points (..., 2) turned counter-clockwise; many angles turn one point."""
    x, y = points[..., 0], points[..., 1]
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
