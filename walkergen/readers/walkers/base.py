"""Base plates: a flat plate under a body of any shape, which joins its pieces and gives its legs room."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import manifold3d
import numpy as np

from walkergen.core.errors import GeometryError
from walkergen.core.numerics import Array
from walkergen.core.shapes import joining, modeller
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.shapes.modeller import extrude
from walkergen.readers.drawings import overlaps

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

MAX_THICKNESS_MM = 1.6
"""Thickness of a plate at most, mm: eight layers. Of a body in plan view it is at most half of the body's."""

RIM_MM = 1.0
"""Width of a plate beyond the hull of the parts on it, mm."""

MIN_LENGTH_MM, MIN_WIDTH_MM, GROWTH_PER_HEIGHT = 13.0, 7.0, 0.35
"""Least length and width of a plate, mm, and their growth over the height of the parts on it: room
for legs whose feet are as far apart as `leg_rows` requires."""


def add_to_outline(outline: Sequence[Array], thickness: float) -> tuple[list[Array], Mesh]:
    """Return the contour of a base plate under an outline, in a list, and a mesh of plate and extruded outline.

    The mesh reaches from z = 0 to `thickness`, mm. The middle of the contour's box is the origin of both.
    """
    import shapely

    (contour,) = overlaps.contours(_plate_region(shapely.union_all(overlaps.pieces(outline)), thickness))
    middle = 0.5 * (contour.min(axis=0) + contour.max(axis=0))
    raised = extrude([ring - middle for ring in outline], thickness, pieces=True)
    plate = extrude([contour - middle], min(MAX_THICKNESS_MM, 0.5 * thickness))
    return [contour - middle], _unite_parts([raised, plate])


def add_to_mesh(mesh: Mesh) -> Mesh:
    """Return a mesh (y up) with a base plate at its lowest level. Raises GeometryError for parts that float."""
    import shapely

    low, high = mesh.vertices[:, 1].min(), mesh.vertices[:, 1].max()
    plate = _plate_region(joining.plan_projection(modeller.to_solid(mesh)), float(high - low))
    turned = shapely.affinity.scale(plate, 1.0, -1.0, origin=(0.0, 0.0))  # z to -y
    x, v, w = (flat := extrude(overlaps.contours(turned), MAX_THICKNESS_MM)).vertices.T
    return _unite_parts([mesh, Mesh(np.column_stack([x, low + w, -v]), flat.triangles)])


def _plate_region(shadow: "BaseGeometry", height: float) -> "BaseGeometry":
    """Return the area of a plate for parts of this height (mm) and this `shadow` from above: its hull with a rim.

    About the shadow's centroid it has at least the size that legs need.
    """
    import shapely

    x, y = shadow.centroid.x, shadow.centroid.y
    half = 0.5 * (MIN_LENGTH_MM + GROWTH_PER_HEIGHT * height), 0.5 * (MIN_WIDTH_MM + GROWTH_PER_HEIGHT * height)
    rim = shadow.convex_hull.buffer(RIM_MM)
    return rim.union(shapely.box(x - half[0], y - half[1], x + half[0], y + half[1])).convex_hull


def _unite_parts(parts: Sequence[Mesh]) -> Mesh:
    """Unite a plate and the parts on it to one closed mesh. Raises GeometryError."""
    solids = [modeller.to_solid(part) for part in parts]
    union = modeller.check_solid(manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add))
    if apart := len(modeller.split_bodies(union)) - 1:
        raise GeometryError(f"body.base = true: {apart} pieces float above the plate. Lower them onto the others.")
    return modeller.to_mesh(union)
