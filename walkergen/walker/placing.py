"""Legs that place themselves: two rows of them under a body of any outline.

What a person has drawn is taken as it is seen from above. The rows stand across the walk, their feet as
far behind the centre of mass as before it, as wide as the outline allows, and in pieces where a hole or
a notch divides it.
"""

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.errors import GeometryError
from walkergen.walker.body import Body
from walkergen.walker.limbs import Legs, Limb, pair_of

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


INSETS = (0.0, 0.04, 0.08, 0.12, 0.16, 0.2)
"""Shares of a mesh's depth by which its outline is drawn in, in turn, until all legs meet the mesh."""

DIGITS = 6
"""Decimals of places and widths, mm: what is symmetric is so to the last bit."""


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


@lru_cache(maxsize=4096)
def limbs(body_key: str, legs_key: str) -> tuple[Limb, ...]:
    """Legs found for a body, the rear row first; both as their JSON.

    They are turned and long as those that are written, at other places and of other widths. Raises
    GeometryError where none stand.
    """
    import shapely

    from walkergen.walker import landing

    body, legs = Body.model_validate_json(body_key), Legs.model_validate_json(legs_key)
    size = body.shape.size
    leg = pair_of(legs, size.depth, -0.5 * size.thickness)[0]
    ground, (along, up, across) = _ground(body, body_key)
    centre, height = (along, across), up - leg.foot_height
    reach = _reach(leg)
    if body.flat:
        return _limbs(leg, rows(ground, centre, height, reach))
    problem: GeometryError | None = None
    for inset in INSETS:
        drawn_in = shapely.buffer(ground, -inset * size.depth)
        try:
            return landing.landed(body_key, _limbs(leg, rows(drawn_in, centre, height, reach)))
        except GeometryError as error:
            problem = problem or error
    assert problem is not None
    raise problem


def _ground(body: Body, body_key: str) -> "tuple[BaseGeometry, tuple[float, float, float]]":
    """What a body covers, (along, across), and its centre of mass: along, up and across from its middle."""
    import shapely

    from walkergen.walker import landing, mass

    shape = body.shape
    if body.flat:
        outer, *holes = (contour * (1.0, -1.0) for contour in shape.plan)  # the page's up is to the left
        ground = shapely.Polygon(outer, holes)
        return ground, (ground.centroid.x, 0.0, ground.centroid.y)
    ready = landing.ready(body_key)
    rings = ready.solid.rotate((-90.0, 0.0, 0.0)).project().to_polygons()  # z to y
    ground = shapely.Polygon()
    for ring in rings:
        ground = ground.symmetric_difference(shapely.Polygon(ring).buffer(0.0))
    along, up, across = mass.weigh(ready.mesh, 1.0).centre.tolist()
    return shapely.affinity.translate(ground, 0.0, -0.5 * shape.size.depth), (
        along,
        up,
        across - 0.5 * shape.size.depth,
    )


def _reach(leg: Limb) -> Reach:
    """What a leg takes up along the run, from its foot."""
    anchor = -leg.anchor_to_foot[0]
    ends = [anchor - leg.half_width, anchor + leg.half_width]
    for strut in leg.section.struts(leg):
        ends += [anchor + strut.offset - 0.5 * strut.thickness, anchor + strut.offset + 0.5 * strut.thickness]
    return Reach(min(ends), max(ends))


def _limbs(leg: Limb, placed: Sequence[Row]) -> tuple[Limb, ...]:
    """Legs of rows, each like `leg`."""
    return tuple(
        leg._replace(along=round(row.along, DIGITS), across=round(across, DIGITS), width=round(width, DIGITS))
        for row in placed
        for across, width in row.legs
    )


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
    bounds = shapely.bounds(parts).tolist()
    for owner, (_, begin, _, end), area in zip(owners, bounds, shapely.area(parts), strict=True):
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
