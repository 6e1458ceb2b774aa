"""Contours: closed curves of a drawing as polygons, from any kind of file."""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.numerics import Array

FLATNESS = 2e-5
"""Largest distance of a chord from its curve, over the drawing's longer side: half a micrometre on
a body of 28 mm, a twentieth of what printers resolve."""

MAX_POINTS = 100_000
"""Points of an outline at most: on a body of 28 mm one to a micrometre, beyond every printer."""

MAX_BYTES = 10_000_000
"""Size of a drawing at most: MAX_POINTS with all their digits are 4 MB."""

MAX_END_GAP = 1e-6
"""Maximum distance between two ends that meet, over the drawing's longer side: drawing
programs write six digits."""

MIN_CHORDS, MAX_CHORDS = 4, 4096


class NoUnitError(InputError):
    """Error for a drawing that states no unit of length."""


class Drawing(NamedTuple):
    """Contents of a file of drawings."""

    contours: Sequence[Array]
    """Polygons in mm, y up, shape (n, 2) each; the last point is joined to the first. Every second
    contour inward is a hole."""
    notes: tuple[str, ...] = ()
    """Notes on what was left out or mended, a few words each."""
    contacts: Sequence[Array] = ()
    """Points in mm in which drawn parts touch. The contours are open there."""


def area(polygon: Array) -> float:
    """Return the area enclosed by a polygon, shape (n, 2), negative when its points go clockwise."""
    x, y = (polygon - polygon[:1]).T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def flatten(curve: Callable[[Array], Array], tolerance: float) -> Array:
    """Return points on a curve from start to end, shape (n, 2), with chords within `tolerance` of the curve.

    `curve` takes parameters of 0 to 1, shape (n,), and returns points (n, 2). Chords are halved
    until the curve's points over their middles are within the tolerance, or there are MAX_CHORDS.
    """
    chords = MIN_CHORDS  # not one: the middle of an S lies on its chord
    while True:
        points = curve(np.linspace(0.0, 1.0, 2 * chords + 1))
        ends, middles = points[::2], points[1::2]
        sag = np.abs(middles - 0.5 * (ends[:-1] + ends[1:])).max()
        if not sag > tolerance or chords >= MAX_CHORDS:
            return ends
        chords *= 2


def is_within_gap(first: Sequence[float] | Array, last: Sequence[float] | Array, gap: float) -> bool:
    """Return whether two points are no further apart than `gap`."""
    return math.dist(first, last) <= gap
