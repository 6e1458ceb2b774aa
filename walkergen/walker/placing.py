"""Legs that place themselves: two rows of them under a body of any outline.

What a person has drawn is taken as it is seen from above. The rows stand across the walk, their feet as
far behind the centre of mass as before it, as wide as the outline allows, and in pieces where a hole or
a notch divides it.
"""

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.errors import GeometryError

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

EDGE_MM = 0.2
"""Distance of a leg from the edge of the outline at least, mm: half a wall that printers draw."""

NARROWEST_MM = 1.0
"""Least width of a leg, mm."""

SPAN = 13.0 / 28.0
"""Distance of the rows' feet over the length of the body, that of the paper's walker, where it fits."""

STEADY = 0.5
"""Distance of the feet over the height of the centre of mass at least: a walker that leans by
atan(STEADY / 2), 14 deg, still falls back on its feet."""

TRIES = 61
"""Distances of the feet that are tried."""

SHIFTS = (0.0, 0.05, -0.05, 0.15, -0.15)
"""Distances of the middle of the feet from the centre of mass, over theirs, that are tried in turn."""

ROUNDED_MM = 0.01
"""Distance by which an outline may be simplified, mm."""

Array = npt.NDArray[np.float64]


class Reach(NamedTuple):
    """What a leg takes up along the run, mm, from its foot."""

    back: float
    """Where it begins: at its foot for a brace, else at the back of its top."""
    front: float


class Row(NamedTuple):
    """Legs side by side."""

    along: float
    """Place of their feet along the run, mm."""
    legs: tuple[tuple[float, float], ...]
    """Place across and width of each, mm, in the order of their places."""

    @property
    def width(self) -> float:
        """Width of all of them, mm."""
        return sum(width for _, width in self.legs)


def rows(ground: "BaseGeometry", centre: tuple[float, float], height: float, reach: Reach) -> tuple[Row, Row]:
    """Rows behind and before the centre of mass, (along, across), under a ground seen from above, mm.

    `height` is that of the centre of mass above the plate. Feet stand as far behind it as before it
    wherever such rows exist, else nearly so. Raises GeometryError, which says what would help, where
    none do.
    """
    import shapely

    inner = ground.buffer(-EDGE_MM).simplify(ROUNDED_MM)
    left, _, right, _ = ground.bounds
    least, most = STEADY * height, right - left
    wished = max(SPAN * (right - left), least)
    spans = np.linspace(least, max(most, least), TRIES)
    for share in SHIFTS:
        middles = centre[0] + share * spans
        backs, fronts = (_rows(inner, middles + side * spans, centre[1], reach) for side in (-0.5, 0.5))
        costs = {}
        for number, (back, front) in enumerate(zip(backs, fronts, strict=True)):
            if back is not None and front is not None:
                narrow = 1.0 - min(back.width, front.width) / (ground.bounds[3] - ground.bounds[1])
                costs[abs(math.log(spans[number] / wished)) + narrow] = back, front
        if costs:
            return _alike(*costs[min(costs)])
    wide = 2.0 * shapely.maximum_inscribed_circle(ground).length
    raise GeometryError(
        f"legs.place: no two rows of legs stand under a body of {right - left:.3g} mm, whose centre of mass is "
        f"{height:.3g} mm high and whose widest place is {wide:.2g} mm: make it larger, or its legs shorter"
    )


def _rows(inner: "BaseGeometry", places: Array, across: float, reach: Reach) -> list[Row | None]:
    """Legs whose feet stand at each place along the run, as wide as the ground allows; None for no room.

    They are their own mirror image about the centre of mass, where such pieces are wide enough.
    """
    found: list[Row | None] = []
    for along, pieces in zip(places.tolist(), _covered(inner, places + reach.back, places + reach.front), strict=True):
        mirrored = [(2.0 * across - high, 2.0 * across - low) for low, high in pieces]
        both = [(max(a, c), min(b, d)) for a, b in pieces for c, d in mirrored]
        found.append(_row(along, across, both) or _row(along, across, pieces))
    return found


def _row(along: float, across: float, pieces: Sequence[tuple[float, float]]) -> Row | None:
    """Legs in those pieces that are wide enough, if the centre of mass lies between the outer ones."""
    wide = sorted((low, high) for low, high in pieces if high - low >= NARROWEST_MM)
    if not wide or not wide[0][0] <= across <= wide[-1][1]:
        return None
    return Row(along, tuple((0.5 * (low + high), high - low) for low, high in wide))


def _covered(inner: "BaseGeometry", backs: Array, fronts: Array) -> list[list[tuple[float, float]]]:
    """Intervals across the run over which each strip along it is wholly under a ground."""
    import shapely

    if inner.is_empty:
        return [[] for _ in backs]
    _, low, _, high = inner.bounds
    free = shapely.difference(shapely.box(backs, low, fronts, high), inner)
    parts, owners = shapely.get_parts(free, return_index=True)
    shadows: list[list[tuple[float, float]]] = [[] for _ in backs]
    for owner, (_, begin, _, end), area in zip(owners, shapely.bounds(parts), shapely.area(parts), strict=True):
        if area > 0.0:
            shadows[owner].append((begin, end))
    return [list(_between(sorted(own), low, high)) for own in shadows]


def _between(shadows: Sequence[tuple[float, float]], low: float, high: float) -> Iterator[tuple[float, float]]:
    """Intervals of a range that no shadow, in their order, covers."""
    for begin, end in shadows:
        if begin > low:
            yield low, begin
        low = max(low, end)
    if low < high:
        yield low, high


def _alike(back: Row, front: Row) -> tuple[Row, Row]:
    """Rows of one leg each at one place across: both as wide as the narrower, so that they are equal."""
    if len(back.legs) != 1 or len(front.legs) != 1 or abs(back.legs[0][0] - front.legs[0][0]) > EDGE_MM:
        return back, front
    leg = front.legs[0][0], min(back.width, front.width)
    return back._replace(legs=(leg,)), front._replace(legs=(leg,))


def in_words(placed: Sequence[Row]) -> str:
    """What was chosen, in a line."""
    back, front = placed
    counts = [f"{len(row.legs)} of {row.width:.3g} mm" for row in (back, front)]
    return f"legs {front.along - back.along:.3g} mm apart: {counts[0]} behind, {counts[1]} ahead"
