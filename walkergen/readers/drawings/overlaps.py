"""Union of drawn paths that cross or touch to contours that do neither, and the separate pieces of an outline."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import manifold3d
import numpy as np

from walkergen.core.numerics import Array
from walkergen.readers.drawings.contours import Shape

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

JOINT_RADIUS = 0.02
"""Radius, over the drawing's longer side, of the disc that joins parts that meet in a point."""

GRID_SIZE = 1e-7
"""Grid, over the drawing's longer side, on which contours meet."""

MIN_AREA_SHARE = 1e-6
"""Area over the largest below which a piece or a hole is rounding."""

MANIFOLD_SIZE = 2.0**20
"""Size of drawings after scaling for manifold3d, which rounds to 1e-8 units."""


def unite_shapes(shapes: Sequence[Shape]) -> Shape:
    """Unite shapes that may overlap into one whose contours neither cross nor touch.

    Each is filled by its own rule. A shape that lies within a larger one is a hole in it, as in `outlines.from_shapes`;
    one that crosses it is united with it. Parts that meet only in a point are joined.
    """
    import shapely

    regions = sorted(filter(None, map(_filled_region, shapes)), key=lambda region: -_fill_holes(region).area)
    union: BaseGeometry = shapely.Polygon()
    for region in regions:
        within = union.contains(region)
        union = union.difference(region) if within else union.union(region)
    if union.is_empty:
        return Shape([], nonzero=False)
    left, low, right, high = union.bounds
    size = max(right - left, high - low)
    union = shapely.set_precision(union, GRID_SIZE * size)
    union = shapely.union_all(
        [union, *(point.buffer(JOINT_RADIUS * size) for point in _touching_points(union, GRID_SIZE * size))]
    )
    polygons = [polygon for polygon in shapely.get_parts(union) if polygon.area > 0.0]
    min_area = MIN_AREA_SHARE * max((polygon.area for polygon in polygons), default=0.0)
    rings = [
        np.asarray(ring.coords)[:-1]
        for polygon in polygons
        if polygon.area > min_area
        for ring in (polygon.exterior, *polygon.interiors)
        if shapely.Polygon(ring).area > min_area
    ]
    return Shape(rings, nonzero=False)


def _filled_region(shape: Shape) -> "BaseGeometry":
    """Return the region that a shape fills by its fill rule."""
    import shapely

    contours = [contour for contour in shape.contours if len(contour) > 2]
    if not contours:
        return shapely.Polygon()
    points = np.vstack(contours)
    middle, size = points.mean(axis=0), float(np.ptp(points, axis=0).max()) or 1.0
    rule = manifold3d.FillRule.NonZero if shape.nonzero else manifold3d.FillRule.EvenOdd
    section = manifold3d.CrossSection([(MANIFOLD_SIZE / size) * (contour - middle) for contour in contours], rule)
    union: BaseGeometry = shapely.Polygon()
    for ring in section.to_polygons():
        union = union.symmetric_difference(
            shapely.Polygon(np.asarray(ring) * (size / MANIFOLD_SIZE) + middle).buffer(0.0)
        )
    return union


def _fill_holes(region: "BaseGeometry") -> "BaseGeometry":
    """Fill the holes of a region."""
    import shapely

    return shapely.union_all([shapely.Polygon(part.exterior) for part in shapely.get_parts(region)])


def _touching_points(region: "BaseGeometry", gap: float) -> "list[BaseGeometry]":
    """Return the points where contours of a region come within a gap of each other."""
    import shapely

    rings = [ring for part in shapely.get_parts(region) for ring in (part.exterior, *part.interiors)]
    pairs = shapely.STRtree(rings).query(rings, predicate="dwithin", distance=gap).T
    meetings = [rings[i].intersection(rings[j].buffer(gap)) for i, j in pairs if i < j]
    return [part.centroid for meeting in meetings for part in shapely.get_parts(meeting)]


def pieces(plan: Sequence[Array]) -> "list[BaseGeometry]":
    """Return the separate pieces of an outline, each with its holes, the largest first. `plan`: its contours."""
    import shapely

    region: BaseGeometry = shapely.Polygon()
    for contour in plan:
        region = region.symmetric_difference(shapely.Polygon(contour))
    return sorted(shapely.get_parts(region), key=lambda piece: -piece.area)


def contours(region: "BaseGeometry") -> list[Array]:
    """Return the contours of a polygon, or of several: the outer ones counter-clockwise, then holes clockwise."""
    import shapely

    parts = shapely.get_parts(region.normalize()).tolist()
    outer = [np.asarray(shapely.geometry.polygon.orient(part).exterior.coords)[:-1] for part in parts]
    holes = [np.asarray(ring.coords)[:-1] for part in parts for ring in shapely.geometry.polygon.orient(part).interiors]
    return [np.ascontiguousarray(ring) for ring in (*outer, *holes)]
