"""Regions of a drawing: contours that overlap become regions, and regions become contours that do not touch."""

from collections.abc import Iterable, Sequence
from functools import reduce
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import manifold3d
import numpy as np

from walkergen.core.numerics import Array
from walkergen.readers.drawings.contours import area

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

Region: TypeAlias = manifold3d.CrossSection

REGION_SIZE = 2.0**20
"""Size of a drawing after scaling for manifold3d, which rounds to 1e-8 units."""

ROUNDING = 1e-7 * REGION_SIZE
"""Width of the slits and fins that rounding leaves where two shapes share an edge."""

MAX_SLIT = 1e-3 * REGION_SIZE
"""Width of a slit below which it is closed: 0.03 mm on a body of 28 mm. Slicers close slits of 0.1 mm."""

MAX_CONTACT_GAP, CONTACT_RADIUS = 1e-6 * REGION_SIZE, 1e-3 * REGION_SIZE
"""Gap below which contours touch, and radius of what is cut away there: files of meshes have 7 digits, and two circles
that touch are apart by 1e-6 of their size at 1e-3 from there."""

MITER_LIMIT = 1e3
"""Corners keep their tips when a region grows and shrinks: curves have chords that turn by more than 1/500."""

MIN_AREA_SHARE, MIN_HOLE_SHARE = 1e-6, 1e-5
"""Area over that of the drawing's square below which a piece is rounding, and a hole closes in print: 0.09 x 0.09 mm on
a body of 28 mm."""


class Frame(NamedTuple):
    """Frame of coordinates in which manifold3d handles a drawing: centred, and scaled to REGION_SIZE."""

    middle: Array
    """Origin of the frame in the drawing's units, shape (2,)."""
    scale: float
    """Units of the frame per unit of the drawing."""

    def region(self, contours: Iterable[Array], nonzero: bool) -> Region:
        """Return the region that contours (in drawing's units) fill by the rule nonzero, or else even-odd."""
        rule = manifold3d.FillRule.NonZero if nonzero else manifold3d.FillRule.EvenOdd
        return Region([self.scale * (contour - self.middle) for contour in contours if len(contour) > 2], rule)

    def contours(self, region: Region) -> list[Array]:
        """Return the contours of a region in the drawing's units, without pieces and holes that are too small."""
        rings = [(ring, area(ring) / REGION_SIZE**2) for ring in region.to_polygons()]
        return [self.to_drawing(ring) for ring, share in rings if share > MIN_AREA_SHARE or share < -MIN_HOLE_SHARE]

    def to_drawing(self, points: Array) -> Array:
        """Convert points from this frame to the drawing's units, shape (n, 2)."""
        return np.asarray(points, dtype=np.float64) / self.scale + self.middle


def frame_of(points: Array) -> Frame:
    """Return the frame whose origin is the middle of a drawing's points, shape (n, 2)."""
    low, high = points.min(axis=0), points.max(axis=0)
    return Frame(0.5 * (low + high), REGION_SIZE / (float((high - low).max()) or 1.0))


def unite_contours(contours: Sequence[Array]) -> tuple[list[Array], list[Array]]:
    """Unite contours that cross or touch. Return the contours of the union, and the points in which these touch.

    A contour within the others is a hole, and so on alternately. A contour that crosses the others is united with them.
    """
    frame, union = frame_of(np.vstack(contours)), Region()
    regions = [frame.region([contour], nonzero=False) for contour in contours]
    for region in sorted(regions, key=lambda region: -region.area()):
        is_within = (region - union).area() <= MIN_AREA_SHARE * region.area()
        union = union - region if is_within else union + region
    return separate_contours(union, frame)


def separate_contours(region: Region, frame: Frame) -> tuple[list[Array], list[Array]]:
    """Return contours of a region, cut apart where they touch, and these points, both in the drawing's units.

    Slits are closed. A single point joins no parts: the region is cut open there by CONTACT_RADIUS.
    """
    region = _grow(_grow(_grow(region, -ROUNDING), 2.0 * ROUNDING), -ROUNDING).simplify(MAX_CONTACT_GAP)
    slits = _grow(_grow(region, 0.5 * MAX_SLIT), -0.5 * MAX_SLIT) - region
    cut = _discs_about(find_contacts(region))
    wide = [slit for slit in slits.decompose() if slit.area() > ROUNDING * MAX_SLIT and (slit ^ cut).is_empty()]
    region = unite([region, *(_grow(slit, ROUNDING) for slit in wide)]).simplify(MAX_CONTACT_GAP)
    contacts = find_contacts(region)
    return frame.contours(region - _discs_about(contacts)), [frame.to_drawing(point) for point in contacts]


def _discs_about(points: Sequence[Array]) -> Region:
    """Return the union of discs of CONTACT_RADIUS about points."""
    return unite([Region.circle(CONTACT_RADIUS, 16).translate(point) for point in points])


def unite(regions: Sequence[Region]) -> Region:
    """Return the union of regions."""
    return Region.batch_boolean(list(regions), manifold3d.OpType.Add) if regions else Region()


def _grow(region: Region, distance: float) -> Region:
    """Grow a region by a distance, or shrink it by a negative one. Corners stay corners."""
    return region.offset(distance, manifold3d.JoinType.Miter, MITER_LIMIT)


def find_contacts(region: Region) -> list[Array]:
    """Return the points in which contours of a region touch themselves or each other, shape (2,) each, in its frame."""
    import shapely

    rings = [np.asarray(ring, dtype=np.float64) for ring in region.to_polygons()]
    if not rings:
        return []
    points, ends = np.vstack(rings), np.vstack([np.roll(ring, -1, axis=0) for ring in rings])
    edges = shapely.linestrings(np.stack([points, ends], axis=1))
    following = np.concatenate([np.roll(np.arange(len(ring)), -1) for ring in rings])
    starts = np.cumsum([0, *map(len, rings[:-1])])
    following += np.repeat(starts, list(map(len, rings)))
    corner, edge = shapely.STRtree(edges).query(shapely.points(points), predicate="dwithin", distance=MAX_CONTACT_GAP)
    corner = corner[(corner != edge) & (corner != following[edge])]
    near = shapely.union_all(shapely.points(points[corner]).tolist()).buffer(0.5 * CONTACT_RADIUS)
    return [np.array(part.centroid.coords[0]) for part in shapely.get_parts(near) if not part.is_empty]


def pieces(plan: Sequence[Array]) -> "list[BaseGeometry]":
    """Return the separate pieces of an outline, each with its holes, the largest first. `plan`: its contours."""
    import shapely

    region: BaseGeometry = reduce(
        lambda union, contour: union.symmetric_difference(shapely.Polygon(contour)), plan, shapely.Polygon()
    )
    return sorted(shapely.get_parts(region), key=lambda piece: -piece.area)


def contours(region: "BaseGeometry") -> list[Array]:
    """Return the contours of a polygon, or of several: the outer ones counter-clockwise, then holes clockwise."""
    import shapely

    parts = [shapely.geometry.polygon.orient(part) for part in shapely.get_parts(region.normalize())]
    rings = [*(part.exterior for part in parts), *(ring for part in parts for ring in part.interiors)]
    return [np.ascontiguousarray(np.asarray(ring.coords)[:-1]) for ring in rings]
