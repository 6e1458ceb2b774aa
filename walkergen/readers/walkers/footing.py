"""Where a leg of rectangular section meets a body of any shape: its anchor, and how far up its section is covered.

A leg is followed from its foot upward along its centre line, in the frame of walkergen (y up).
"""

import math
from typing import NamedTuple

import numpy as np

from walkergen.core.errors import GeometryError
from walkergen.core.numerics import Array, Mask
from walkergen.core.shapes import joining, modeller
from walkergen.core.shapes.mesh import Mesh


class Footing(NamedTuple):
    """Where a leg, followed from its foot, meets the body."""

    anchor: Array
    """Point where the centre line first meets the body, shape (3,), mm."""
    reach: float
    """Distance along the centre line from the foot to where the leg's whole section is covered,
    mm: the highest point of the body's lower surface over the section. A leg that ends deeper than
    this leaves no gap."""
    above: float
    """Distance to where, beyond that, a part of the section comes out of the body again, mm."""


def find_footing(
    body: joining.Body, foot: Array, direction: Array, thickness: float, width: float, key: str = "legs"
) -> Footing:
    """Find where a leg of rectangular section meets the body.

    The foot, shape (3,), mm, is the middle of the leg's lower end. The unit direction, shape (3,),
    leads from the foot up, in the x-y plane. Thickness is measured across the leg in that plane
    and width along z, mm. Raises GeometryError, beginning with `key`, when the leg misses the
    body, lies partly outside it or under a hole, or has its foot within the body.
    """
    subject = f"{key}: the leg with its foot at x = {foot[0]:.4g}, z = {foot[2]:.4g} mm"
    axes = np.array([[0.0, 0.0, 1.0], [direction[1], -direction[0], 0.0], direction])
    half = 0.5 * np.array([width, thickness])
    near_triangles = body.mesh.triangles[_is_near_line(body.mesh, foot, axes[:2], half)]
    distance = first_hit(body.mesh.vertices[near_triangles], foot, direction)
    if distance is None:
        raise GeometryError(f"{subject} misses the body. Move it under the body")
    anchor = foot + distance * direction
    bounds = _height_bounds((body.mesh.vertices[near_triangles] - foot) @ axes.T, half)
    if bounds is not None:
        return Footing(anchor, *bounds)
    corners = np.array(body.solid.bounding_box()).reshape(2, 3)
    leg_length = float(np.linalg.norm(np.abs(corners - foot).max(axis=0))) + thickness + width
    leg = joining.leg_prism(foot, direction, thickness, width, leg_length)
    outside = [
        modeller.to_mesh(piece).vertices
        for piece in modeller.check_solid(modeller.to_solid(leg) - body.solid).decompose()
    ]
    heights = [(points - foot) @ direction for points in outside]
    lower = [height for height in heights if height.min() < joining.ROUNDING_SHARE * leg_length]
    if len(lower) != 1:
        raise GeometryError(f"{subject} begins within the body. Make the leg longer")
    reach = float(lower[0].max())
    above = min(
        (float(height.min()) for height in heights if height.min() >= joining.ROUNDING_SHARE * leg_length),
        default=math.inf,
    )
    if reach > leg_length * (1.0 - joining.ROUNDING_SHARE):
        raise GeometryError(
            f"{subject}, {thickness:g} mm thick and {width:g} mm wide, is not wholly under the body: "
            "it lies under a hole or beyond an edge. Move it or make it smaller"
        )
    return Footing(anchor, reach, above)


def _height_bounds(corners: Array, half: Array) -> tuple[float, float] | None:
    """Return the highest point of the lower side of a body over a section, and the lowest of its upper side, mm.

    Corners of triangles, shape (k, 3, 3), are in the section's frame, third axis up. `half` is half its size along the
    first two. Returns None unless exactly these two sides cover the section. Only the modeller resolves other cases.
    """
    if corners[:, :, 2].min() <= 0.0:
        return None
    for axis, limit in enumerate(half.tolist()):
        corners = _clip_polygons(_clip_polygons(corners, axis, limit), axis, limit, -1.0)
    x, y, heights = corners.transpose(2, 0, 1)
    areas = 0.5 * (x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y).sum(axis=1)
    lower, upper, total = areas < 0.0, areas > 0.0, 4.0 * half.prod()
    if any(abs(np.abs(areas[side]).sum() - total) > joining.ROUNDING_SHARE * total for side in (lower, upper)):
        return None
    reach, above = float(heights[lower].max()), float(heights[upper].min())
    return (reach, above) if reach < above else None


def _clip_polygons(polygons: Array, axis: int, limit: float, side: float = 1.0) -> Array:
    """Cut off the parts of convex polygons, shape (k, n, 3), where `side` times coordinate `axis` exceeds `limit`.

    `side` is 1 or -1. Polygons that vanish are dropped, and others may get more points. The first point is repeated to
    fill the rows of the result. Source: Sutherland and Hodgman (1974).
    """
    distance = limit - side * polygons[:, :, axis]
    inside, following_distance = distance >= 0.0, np.roll(distance, -1, axis=1)
    crossing = inside != np.roll(inside, -1, axis=1)
    share = np.divide(distance, distance - following_distance, out=np.zeros_like(distance), where=crossing)[:, :, None]
    intersections = polygons + share * (np.roll(polygons, -1, axis=1) - polygons)
    points = np.stack([polygons, intersections], axis=2).reshape(len(polygons), -1, 3)
    kept = np.stack([inside, crossing], axis=2).reshape(len(polygons), -1)
    points, kept = points[kept.any(axis=1)], kept[kept.any(axis=1)]
    order = np.argsort(~kept, axis=1, kind="stable")[:, : kept.sum(axis=1).max(initial=0)]
    points, kept = np.take_along_axis(points, order[:, :, None], 1), np.take_along_axis(kept, order, 1)
    return np.where(kept[:, :, None], points, points[:, :1])


def first_hit(corners: Array, start: Array, direction: Array) -> float | None:
    """Return the distance from a point along a unit direction to the first of some triangles, mm, or None.

    `corners`: shape (k, 3, 3). A ray through an edge or a vertex hits. Source: Moeller and Trumbore (1997).
    """
    a, b, c = corners.transpose(1, 0, 2)
    first, second = b - a, c - a
    normal = np.cross(direction, second)
    determinant = np.einsum("ki,ki->k", first, normal)
    scale = np.linalg.norm(first, axis=1) * np.linalg.norm(second, axis=1)
    steep = np.abs(determinant) > 1e-12 * scale
    with np.errstate(divide="ignore", invalid="ignore"):
        from_a = start - a
        u = np.einsum("ki,ki->k", from_a, normal) / determinant
        cross_product = np.cross(from_a, first)
        v = cross_product @ direction / determinant
        distance = np.einsum("ki,ki->k", second, cross_product) / determinant
        # Of a triangle's side, so that a ray cannot slip through between two neighbours
        slack = 1e-9
        hit = steep & (u >= -slack) & (v >= -slack) & (u + v <= 1.0 + slack) & (distance >= 0.0)
    return float(distance[hit].min()) if hit.any() else None


def _is_near_line(mesh: Mesh, start: Array, directions: Array, distances: Array) -> Mask:
    """Return a mask of triangles: along each unit direction, their distance from `start` is within `distances`, mm."""
    slack = 1e-6 * float(np.ptp(mesh.vertices, axis=0).max())
    is_near = np.ones(len(mesh.triangles), bool)
    for side, limit in zip(directions, distances + slack, strict=True):
        first, second, third = ((mesh.vertices - start) @ side)[mesh.triangles.T]
        is_near &= np.minimum(np.minimum(first, second), third) <= limit
        is_near &= np.maximum(np.maximum(first, second), third) >= -limit
    return is_near
