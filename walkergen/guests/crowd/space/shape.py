"""Shapes of a crowd's bodies for contacts: rounded polygons, seen from above, at two heights.

A body is upright: its outline over its height. It is kept as a core, the outline moved inward by the radius of its
corners, so that bodies a radius or less into each other still have a distance, and with it a normal (F.
Alonso-Marroquin, EPL 83, 14001, 2008). Concave outlines need no parts. Where two bodies meet, their outlines are
compared at the bottom and at the top of the heights that both have, each moved as the body pitches and rolls: upright
edges touch by either end. Limit: bodies tilt by a few hundredths of a radian; the outline itself is not foreshortened.
"""

import math
from typing import NamedTuple

import numpy as np
from shapely.geometry import MultiPolygon, Polygon

from walkergen.core import Array, Design, InputError, MassProperties, Whole
from walkergen.core.simulation.space.state import Walker as InSpace
from walkergen.readers.walkers.top_outline import outline_of

CORNER_MM = 0.2
"""Radius of a printed corner: half of a common nozzle's line."""

CIRCLE_TOLERANCE_MM = 0.01
"""Largest distance of an outline from a circle that counts as one."""


class Shape(NamedTuple):
    """Shape of one design's body, relative to C: x forward, z to the right, mm."""

    corners: Array
    """Corners of the core, shape (v, 2)."""
    edges: Whole
    """Indices in `corners` of both ends of each edge of the core, shape (e, 2). A disc has one edge of length 0."""
    radius: float
    """Rounding radius of the core."""
    reach: float
    """Largest distance of the outline from C."""
    area: float
    """Area of the outline, mm^2."""
    bottom: float
    top: float
    """Heights of the body over C."""
    standing: float
    """Height of C over the plate when it stands level."""


def make_shape(design: Design, mass: MassProperties, walker: InSpace) -> Shape:
    """Return the shape of a design's body. Raises InputError for a body that is too thin to have corners."""
    contours = [contour * (1.0, -1.0) + walker.centre[[0, 2]] for contour in outline_of(design, mass)]
    corners, edges, radius = _make_core(design, contours)
    reach = float(np.hypot(*corners.T).max()) + radius
    feet = walker.root[:, 1] + walker.reach[:, 1]
    return Shape(
        corners,
        edges,
        radius,
        reach,
        sum(Polygon(contour).area for contour in contours),
        float(walker.corners[:, 1].min()),
        float(walker.corners[:, 1].max()),
        -float(feet.min()),
    )


def _make_core(design: Design, contours: list[Array]) -> tuple[Array, Whole, float]:
    """Return corners (v, 2) and edges (e, 2) of the core of contours, and the radius (mm) that was taken off them."""
    middle = contours[0].mean(axis=0)
    distances = np.hypot(*(contours[0] - middle).T)
    if len(contours) == 1 and len(distances) > 12 and float(np.ptp(distances)) < CIRCLE_TOLERANCE_MM:
        return middle[None, :], np.zeros((1, 2), np.int64), float(distances.mean())  # a disc: its core is a point
    radius = CORNER_MM
    while True:
        inner = [Polygon(contour).buffer(-radius, join_style="mitre") for contour in contours]
        if all(not part.is_empty and not isinstance(part, MultiPolygon) for part in inner):
            break
        radius *= 0.5
        if radius < 1e-3:
            raise InputError(
                f"{design.name}: its outline is thinner than {2e3 * radius:.2g} micrometres and cannot touch other "
                "bodies. Make it thicker."
            )
    rings = [np.asarray(part.exterior.coords)[:-1] for part in inner]
    edges, first = [], 0
    for ring in rings:
        numbers = first + np.arange(len(ring))
        edges.append(np.column_stack([numbers, np.roll(numbers, -1)]))
        first += len(ring)
    return np.vstack(rings), np.vstack(edges), radius


def common_heights(shapes: tuple[Shape, ...]) -> Array:
    """Return the lowest and highest height over C (mm) where kinds meet, (kinds, kinds, 2); NaN if they do not."""
    heights = np.full((len(shapes), len(shapes), 2), math.nan)
    for i, own in enumerate(shapes):
        for j, other in enumerate(shapes):
            low = max(own.standing + own.bottom, other.standing + other.bottom)
            high = min(own.standing + own.top, other.standing + other.top)
            if low < high:
                heights[i, j] = low - own.standing, high - own.standing
    return heights
