"""Walkers seen from above: the outline of the body, x forward and y to the left.

A body's z axis points to the right of the run, so that y = -z. Legs, and a cap that hangs over, are
not part of it: walkers of one height meet with their bodies.
"""

from collections.abc import Sequence

import numpy as np

from walkergen.core.numerics import Array
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties, to_centre_frame
from walkergen.readers.drawings.outlines import area
from walkergen.readers.walkers import leg_attachment

MAX_DEVIATION_MM = 0.01
"""Distance between an outline and its simplification at most, mm: below what a printer resolves."""


def body_contours(design: Design) -> tuple[Array, ...]:
    """Return contours of the body from above, relative to the middle of its box, shape (n, 2) each, mm.

    Outer contours are counter-clockwise, then holes clockwise. A body in side view has its rectangle, a mesh its
    projection.
    """
    shape, half = design.shape, 0.5 * np.array([design.size.length, design.size.depth])
    if shape.side is not None:
        return (half * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]),)
    if shape.mesh is None:
        return shape.plan
    turned_up = leg_attachment.prepare_body(design.body.cache_key).solid.rotate((90.0, 0.0, 0.0))  # z to -y
    rings = [np.add(ring, (0.0, half[1])) for ring in turned_up.project().to_polygons()]
    return tuple(sorted(rings, key=lambda ring: area(ring) < 0.0))


def outline_of(design: Design, mass: MassProperties | None = None) -> list[Array]:
    """Return the outer contours of the body relative to its centre of mass O, counter-clockwise, mm.

    Shape (n, 2) each, the last point not repeated. No point moves farther than `MAX_DEVIATION_MM`. `mass` is computed
    unless it is given. Raises GeometryError for a body that cannot be made.
    """
    mass = solids.mass_of(design) if mass is None else mass
    shift = to_centre_frame(design.limbs, mass, np.zeros((1, 2)))[0, 0], 0.0
    is_round = design.body.outline in ("disc", "ellipse")
    simplify = _thin_evenly if is_round else _simplify_ring
    return [np.add(simplify(ring), shift) for ring in body_contours(design) if area(ring) > 0.0]


def area_of(outline: Sequence[Array]) -> float:
    """Return the area within the contours of an outline, mm^2. They do not overlap."""
    return float(sum(area(contour) for contour in outline))


def _simplify_ring(ring: Array) -> Array:
    """Drop points of a contour that change it by less than MAX_DEVIATION_MM."""
    import shapely

    exterior = shapely.polygons(ring).simplify(MAX_DEVIATION_MM, preserve_topology=True).exterior
    points = np.asarray(exterior.coords, dtype=np.float64)[:-1]
    return points if area(points) > 0.0 else points[::-1]


def _thin_evenly(ring: Array) -> Array:
    """Return every k-th point of a round contour, for the largest k allowed. It stays its own mirror image."""
    half = len(ring) // 2
    for step in range(half // 2, 1, -1):
        if half % step == 0 and _thinning_error(ring, step) <= MAX_DEVIATION_MM:
            return ring[::step]
    return ring


def _thinning_error(ring: Array, step: int) -> float:
    """Return the largest distance of a contour's points from the contour of every `step`-th point, mm."""
    import shapely

    kept = shapely.linearrings(ring[::step])
    return float(shapely.distance(shapely.points(ring), kept).max())
