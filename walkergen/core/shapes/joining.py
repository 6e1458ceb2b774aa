"""Joining of legs to a body of any shape: the part of a leg outside it, and the union of body and legs; y up."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import manifold3d
import numpy as np

from walkergen.core.errors import GeometryError, SolidError
from walkergen.core.numerics import Array
from walkergen.core.shapes import modeller
from walkergen.core.shapes.mesh import Mesh

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

ROUNDING_SHARE = 1e-9
"""Volume of a piece, over that of the leg, below which it is the modeller's rounding."""


class Body(NamedTuple):
    """Body to which legs are joined, as a mesh and as the same solid. The conversion takes as long as a union."""

    mesh: Mesh
    solid: manifold3d.Manifold


def prepare_body(mesh: Mesh) -> Body:
    """Convert a closed mesh to a body for `cut_flush` and `unite_with_legs`. Raises SolidError if it is not sound."""
    return Body(mesh, modeller.to_solid(mesh))


def plan_projection(solid: manifold3d.Manifold) -> "BaseGeometry":
    """Return the region that a solid covers seen from above, as a polygon with the coordinates x and z, mm."""
    import shapely

    covered: BaseGeometry = shapely.Polygon()
    for ring in solid.rotate((-90.0, 0.0, 0.0)).project().to_polygons():  # z to y
        covered = covered.symmetric_difference(shapely.Polygon(ring).buffer(0.0))
    return covered


def leg_prism(foot: Array, direction: Array, thickness: float, width: float, length: float) -> Mesh:
    """Build a straight leg of rectangular section, square at both ends, from the middle of its foot upward.

    The unit vector `direction`, shape (3,), leads from the middle of the foot, `foot`, shape (3,), along the leg in an
    x-y plane. `width` is along z. Lengths in mm.
    """
    side = 0.5 * thickness * np.array([direction[1], -direction[0], 0.0])
    across, along = np.array([0.0, 0.0, 0.5 * width]), length * direction
    ring = np.array([-side - across, side - across, side + across, -side + across])
    vertices = foot + np.concatenate([ring, ring + along])
    # Corners 0 1 2 3 at the foot, 4 5 6 7 at the top; triangles counter-clockwise from outside
    quads = np.array([(0, 1, 2, 3), (7, 6, 5, 4), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)])
    return Mesh(vertices, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


def cut_flush(leg: Mesh, body: Body, key: str = "legs") -> Mesh:
    """Return the part of a leg outside the body, cut flush: from its foot to the body's surface.

    Raises GeometryError, whose message begins with `key`, when the leg lies within the body, or comes out of it again.
    """
    leg_solid = modeller.to_solid(leg)
    remainder = modeller.check_solid(leg_solid - body.solid).decompose()
    pieces = [piece for piece in remainder if piece.volume() > ROUNDING_SHARE * leg_solid.volume()]
    if not pieces:
        raise GeometryError(f"{key}: a leg lies wholly within the body. Make it longer")
    # (x, y, z) of the low corner come first in a bounding box
    lowest = min(pieces, key=lambda piece: piece.bounding_box()[1])
    if len(pieces) > 1:
        excess = sum(piece.volume() for piece in pieces) - lowest.volume()
        raise GeometryError(f"{key}: a leg comes out of the body again by {excess:.3g} mm^3: end it within the body")
    return modeller.to_mesh(lowest)


def unite_with_legs(body: Body, legs: Sequence[Mesh], key: str = "legs") -> Mesh:
    """Unite a body and the legs that reach into it to one closed mesh.

    Raises GeometryError, whose message begins with `key`, when a leg does not reach into the body, and SolidError when
    the volume of the union is impossible.
    """
    parts = [body.solid, *(modeller.to_solid(leg) for leg in legs)]
    union = modeller.check_solid(manifold3d.Manifold.batch_boolean(parts, manifold3d.OpType.Add))
    pieces = modeller.split_bodies(union)
    if len(pieces) != 1:
        raise GeometryError(
            f"{key}: body and {len(legs)} legs are {len(pieces)} pieces, must be one; let every leg reach into the body"
        )
    volumes = [part.volume() for part in parts]
    if not max(volumes) * (1.0 - ROUNDING_SHARE) <= union.volume() <= sum(volumes) * (1.0 + ROUNDING_SHARE):
        raise SolidError(f"the union of {max(volumes):.6g} mm^3 and its legs has {union.volume():.6g} mm^3")
    return modeller.to_mesh(union)
