"""Rows of legs under an outline seen from above: two rows across the walk, and more between rows that are far apart.

The feet are as far behind the centre of mass as before it, as wide as the outline allows. A hole or a notch divides a
row into pieces. The feet reach far enough in every direction that a walker that leans by MIN_LEAN_DEG falls back.
"""

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from walkergen.core.errors import GeometryError
from walkergen.core.numerics import Array

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

MIN_EDGE_MM = 0.2
"""Distance of a leg from the edge of the outline at least, mm: half a wall that printers draw."""

MIN_LEG_WIDTH_MM = 1.0
"""Least width of a leg, mm."""

SPAN_PER_LENGTH = 13.0 / 28.0
"""Distance of the rows' feet over the length of the body, that of the paper's walker, where it fits."""

MIN_LEAN_DEG = 10.0
"""Lean, in any direction, that a walker must at least recover from, deg."""

MIN_SPAN_PER_HEIGHT = 2.0 * math.tan(math.radians(MIN_LEAN_DEG))
"""Distance of the feet over the height of the centre of mass at least, by that angle."""

PREFERRED_SPAN_PER_HEIGHT = 0.5
"""Distance of the rows' feet over the height of the centre of mass that is wished where the body is short."""

MAX_ROW_DISTANCE_MM = 60.0
"""Distance of neighbouring rows at most: at 60 mm a plate of 3 mm of PLA has its lowest tone between them at
590 Hz, six times the paper's drive, so that the body counts as rigid."""

SPAN_STEPS = 61
"""Number of distances between back and front feet that are tried."""

MIDDLE_SHIFTS = (0.0, 0.05, -0.05, 0.15, -0.15)
"""Shifts of the middle between back and front feet from the centre of mass, over their distance, tried in turn."""

SIMPLIFY_MM = 0.01
"""Maximum change of a simplified outline, mm."""

MARGIN_TOLERANCE = 1e-9
"""Largest relative error of a margin."""


class Reach(NamedTuple):
    """Extent of a leg along the direction of running, mm from its foot."""

    back: float
    """Where the leg begins: at its foot for a brace, else at the back of its top."""
    front: float
    """Where the leg ends."""


class Row(NamedTuple):
    """Legs side by side."""

    along: float
    """Position of their feet along the run, mm."""
    legs: tuple[tuple[float, float], ...]
    """Position across and width of each leg, mm, in the order of their positions."""

    @property
    def width(self) -> float:
        """Sum of the widths of its legs, mm."""
        return sum(width for _, width in self.legs)

    @property
    def high(self) -> float:
        """Coordinate across of the outer edge of its last leg, mm."""
        return self.legs[-1][0] + 0.5 * self.legs[-1][1]


def find_rows(ground: "BaseGeometry", centre: tuple[float, float], height: float, reach: Reach) -> tuple[Row, ...]:
    """Return rows of legs behind and before the centre of mass (along, across), under the area `ground` from above.

    `height` is that of the centre of mass above the plate, mm. Feet are as far behind it as before it, or nearly so if
    no such rows exist. Raises GeometryError if no rows stand.
    """
    import shapely

    inner = ground.buffer(-MIN_EDGE_MM).simplify(SIMPLIFY_MM)
    left, _, right, _ = ground.bounds
    min_span, max_span = MIN_SPAN_PER_HEIGHT * height, right - left
    preferred_span = max(SPAN_PER_LENGTH * (right - left), PREFERRED_SPAN_PER_HEIGHT * height)
    spans = np.linspace(min_span, max(max_span, min_span), SPAN_STEPS)
    for share in MIDDLE_SHIFTS:
        middles = centre[0] + share * spans
        backs, fronts = (_widest_rows(inner, middles + side * spans, centre[1], reach) for side in (-0.5, 0.5))
        costs = {}  # pairs of rows by their cost: an unusual distance of the feet, narrow rows
        for number, (back, front) in enumerate(zip(backs, fronts, strict=True)):
            if back is not None and front is not None:
                narrowness = 1.0 - min(back.width, front.width) / (ground.bounds[3] - ground.bounds[1])
                costs[abs(math.log(spans[number] / preferred_span)) + narrowness] = _match_widths(back, front)
        for cost in sorted(costs):
            if stability_margin(costs[cost], centre) >= 0.5 * MIN_SPAN_PER_HEIGHT * height * (1.0 - MARGIN_TOLERANCE):
                return _add_middle_rows(costs[cost], inner, centre[1], reach)
    width = 2.0 * shapely.maximum_inscribed_circle(ground).length
    raise GeometryError(
        f"{right - left:.3g} mm long, {width:.2g} wide, centre of mass {height:.3g} mm up, it tips from any legs"
    )


def _add_middle_rows(outer: tuple[Row, Row], inner: "BaseGeometry", across: float, reach: Reach) -> tuple[Row, ...]:
    """Add rows between outer rows that are far apart. `inner`: area for legs. `across`: of the centre of mass, mm."""
    back, front = outer
    number = math.ceil((front.along - back.along) / MAX_ROW_DISTANCE_MM - MARGIN_TOLERANCE)
    positions = np.linspace(back.along, front.along, number + 1)[1:-1]
    middle = _widest_rows(inner, positions, across, reach) if len(positions) else []
    return back, *(row for row in middle if row is not None), front


def _widest_rows(inner: "BaseGeometry", positions: Array, across: float, reach: Reach) -> list[Row | None]:
    """Return the row of legs with feet at each of the positions along the run, as wide as `inner` allows, or None.

    Rows are symmetric about the centre of mass, at `across` (mm), if their legs are wide enough.
    """
    rows: list[Row | None] = []
    for along, pieces in zip(
        positions.tolist(), covered_intervals(inner, positions + reach.back, positions + reach.front), strict=True
    ):
        mirrored = [(2.0 * across - high, 2.0 * across - low) for low, high in pieces]
        symmetric = [(max(a, c), min(b, d)) for a, b in pieces for c, d in mirrored]
        rows.append(_build_row(along, across, symmetric) or _build_row(along, across, pieces))
    return rows


def _build_row(along: float, across: float, pieces: Sequence[tuple[float, float]]) -> Row | None:
    """Return a row with a leg in each piece (low, high) that is wide enough; None unless the legs enclose `across`."""
    wide_pieces = sorted((low, high) for low, high in pieces if high - low >= MIN_LEG_WIDTH_MM)
    if not wide_pieces or not wide_pieces[0][0] <= across <= wide_pieces[-1][1]:
        return None
    return Row(along, tuple((0.5 * (low + high), high - low) for low, high in wide_pieces))


def covered_intervals(inner: "BaseGeometry", backs: Array, fronts: Array) -> list[list[tuple[float, float]]]:
    """Return the intervals (low, high) across the run, mm, in which each of n strips lies wholly inside an area.

    The strips run across. `backs` and `fronts`, shape (n,), mm, are their limits along the run.
    """
    import shapely

    if inner.is_empty:
        return [[] for _ in backs]
    _, low, _, high = inner.bounds
    outside = shapely.difference(shapely.box(backs, low, fronts, high), inner)
    parts, owners = shapely.get_parts(outside, return_index=True)
    shadows: list[list[tuple[float, float]]] = [[] for _ in backs]
    bounds = shapely.bounds(parts).tolist()
    for owner, (_, begin, _, end), area in zip(owners, bounds, shapely.area(parts), strict=True):
        if area > 0.0:
            shadows[owner].append((begin, end))
    return [list(_free_intervals(sorted(strip_shadows), low, high)) for strip_shadows in shadows]


def _free_intervals(shadows: Sequence[tuple[float, float]], low: float, high: float) -> Iterator[tuple[float, float]]:
    """Yield the intervals from `low` to `high` that no shadow, (begin, end), covers. Shadows are in order."""
    for begin, end in shadows:
        if begin > low:
            yield low, begin
        low = max(low, end)
    if low < high:
        yield low, high


def _match_widths(back: Row, front: Row) -> tuple[Row, Row]:
    """Make two rows of one leg each, at one position across, as wide as the narrower. Return other rows unchanged."""
    if len(back.legs) != 1 or len(front.legs) != 1 or abs(back.legs[0][0] - front.legs[0][0]) > MIN_EDGE_MM:
        return back, front
    leg = front.legs[0][0], min(back.width, front.width)
    return back._replace(legs=(leg,)), front._replace(legs=(leg,))


def stability_margin(rows: Sequence[Row], centre: tuple[float, float]) -> float:
    """Return the distance, mm, of the centre of mass (along, across) from the edge of the feet's hull, or 0 outside."""
    import shapely

    corners = [(row.along, edge) for row in rows for edge in (row.legs[0][0] - 0.5 * row.legs[0][1], row.high)]
    hull = shapely.MultiPoint(corners).convex_hull
    point = shapely.Point(centre)
    return float(hull.boundary.distance(point)) if hull.contains(point) else 0.0
