"""Points of a walker in the 3D simulation: corners of its feet, points that touch walls or a lid, the hull of its body.

A body is as good as the convex hull of its corners: 8 of a rectangle, at most `MAX_HULL_POINTS` of others. A
round body touches walls and lids at `DIRECTION_COUNT` points of its outline, between which it reaches up to 2 % of its
radius farther.
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from walkergen.core.simulation.effects import walls
from walkergen.core.simulation.effects.effect import Case
from walkergen.core.simulation.space.state import Array, Walker
from walkergen.core.walker import resolve
from walkergen.core.walker.body import Body
from walkergen.core.walker.design import Design
from walkergen.core.walker.limbs import Limb
from walkergen.core.walker.mass import MassProperties, to_centre_frame

MAX_HULL_POINTS = 128
"""Largest number of points that represent the hull of a body."""

DIRECTION_COUNT = 16
"""Number of horizontal directions whose outermost points of an outline may touch walls or a lid."""

LID_SLOPES = (0.4, 1.0, 4.0)
"""Slopes of the directions whose outermost points of a body may touch a lid."""

EQUAL_REACH_MM = 1e-9
"""Difference (mm) in reach below which points reach equally far."""

NO_REACH = np.zeros(2)


def leg_axis(limb: Limb) -> Array:
    """Return the unit vector anchor -> foot along a relaxed leg's centre line, shape (3,)."""
    return np.array([-math.sin(limb.tilt), -math.cos(limb.tilt), 0.0])


def contact_points(case: Case, free: Sequence[int], centre: Array, walled: bool, lidded: bool) -> dict[str, Any]:
    """Return arrays of contact points, by the names of the fields of `Walker`, and a further array, `foot`.

    Points are both corners of every foot, then those of the body if there are walls (`walled`) or a lid (`lidded`),
    each from back to front. `foot` is the number of the leg whose foot a point is, -1 for the body. `centre`: the
    walker's centre of mass from the body's, mm. `free`: numbers of the legs that swing.
    """
    design, mass = case.design, case.mass
    rows: list[Any] = []  # of leg, root, reach, side, axis, wall distance (see `Walker`) and foot
    for number, (limb, leg) in enumerate(zip(design.limbs, mass.legs, strict=True)):
        foot, axis, half = leg.c_A + leg.c_T, leg_axis(limb)[:2], 0.5 * limb.width
        for side in (-half, half):
            root = np.array([*leg.anchor, limb.across]) - centre
            # A braced foot is a point of the body
            rows.append(
                (free.index(number), root, foot, side, axis, 0.0, number)
                if number in free
                else (-1, root + np.array([*foot, side]), NO_REACH, 0.0, NO_REACH, 0.0, number)
            )
    if walled:
        place = 0.5 * walls.gap(case)
        for edge in _wall_points(design):
            root = np.array([*to_centre_frame(design.limbs, mass, edge[:2]), edge[2]]) - centre
            rows.append((-1, root, NO_REACH, 0.0, NO_REACH, place, -1))
    if lidded:
        assert case.scene.arena.lid_mm is not None
        for top in _lid_points(design):
            root = np.array([*to_centre_frame(design.limbs, mass, top[:2]), top[2]]) - centre
            rows.append((-1, root, NO_REACH, 0.0, NO_REACH, -case.scene.arena.lid_mm, -1))
    keys = ("leg", "root", "reach", "side", "axis", "wall_distance", "foot")
    return {key: np.array(values) for key, values in zip(keys, zip(*rows, strict=True), strict=True)}


def mirror_order(walker: Walker) -> Any:
    """Return the numbers of a walker's contact points in the order of its mirror image's points, shape (k,).

    Corners of feet (`wall_distance` 0) come first, then points that touch walls (> 0) or a lid (< 0).
    """
    feet = np.flatnonzero(walker.wall_distance == 0.0).reshape(-1, 2)[::-1].ravel()
    others = [np.flatnonzero(kind) for kind in (walker.wall_distance > 0.0, walker.wall_distance < 0.0)]
    return np.concatenate([feet, *(kind[_order_from_back(walker.root[kind] * (-1.0, 1.0, 1.0))] for kind in others)])


def _order_from_back(points: Array) -> Any:
    """Return the indices that sort points, shape (n, 3), from back to front, then across."""
    return np.lexsort((points[:, 2], points[:, 0].round(6)))


def body_hull(design: Design, mass: MassProperties, centre: Array) -> Array:
    """Return points of the body's hull, (n, 3), mm, from the walker's centre of mass, at `centre` from the body's."""
    corners = _box_corners(design) if design.body.plain else _hull_points(design.body.cache_key).copy()
    corners[:, :2] = to_centre_frame(design.limbs, mass, corners[:, :2])
    return np.asarray(corners - centre)


def _box_corners(design: Design) -> Array:
    """Return the corners of a rectangular body, shape (8, 3), from its middle, mm."""
    size = design.size
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return signs * (0.5 * np.array([size.length, size.thickness, size.depth]))


@lru_cache(maxsize=64)  # every run of every print asks for it, and hulls of large meshes take a second
def _hull_points(cache_key: str) -> Array:
    """Return points of a body's convex hull, shape (n, 3) with n <= MAX_HULL_POINTS, mm from its middle.

    `cache_key`: that of the body, which contains its keys.
    If the hull has more corners, the outermost points in `MAX_HULL_POINTS` evenly spread directions represent it.
    """
    from scipy.spatial import ConvexHull

    vertices = _solid_vertices(cache_key)
    hull = vertices[np.unique(ConvexHull(vertices).vertices)]
    if len(hull) <= MAX_HULL_POINTS:
        return np.array(hull)
    number = np.arange(MAX_HULL_POINTS) + 0.5
    up, turn = 1.0 - 2.0 * number / MAX_HULL_POINTS, math.pi * (1.0 + math.sqrt(5.0)) * number
    flat = np.sqrt(1.0 - up * up)
    directions = np.column_stack([flat * np.cos(turn), up, flat * np.sin(turn)])
    return np.array(hull[np.unique(np.argmax(directions @ hull.T, axis=1))])


@lru_cache(maxsize=64)
def _solid_vertices(cache_key: str) -> Array:
    """Return the vertices of the body with this `cache_key`, shape (n, 3), from its middle, mm."""
    shape = resolve.shape_of(Body.model_validate_json(cache_key))
    return np.asarray(shape.solid().vertices - (0.0, 0.0, 0.5 * shape.size.depth))


def _wall_points(design: Design) -> Array:
    """Return the points of the body that touch walls, shape (n, 3), mm from its middle, listed from back to front.

    A body drawn in side view has its upright edges, at half height. Other bodies have the outermost points of the
    outline.
    """
    size, shape = design.size, design.shape
    if shape.side is not None:
        half = 0.5 * size.length, 0.5 * size.depth
        return np.array([(x, 0.0, z) for x in (-half[0], half[0]) for z in (-half[1], half[1])])
    hull = _solid_vertices(design.body.cache_key)
    if shape.mesh is None:
        hull = hull * (1.0, 0.0, 1.0)
    corners = np.unique(hull[np.argmax(_directions(0.0) @ hull.T, axis=1)].round(9), axis=0)
    return np.asarray(corners[_order_from_back(corners)])


def _lid_points(design: Design) -> Array:
    """Return corners that may touch a lid as the body tilts, shape (n, 3), mm from its middle, from back to front."""
    body = design.body
    hull = _box_corners(design) if body.plain else _solid_vertices(body.cache_key)
    reach = _directions(*LID_SLOPES) @ hull.T
    # all points that reach equally far, so that mirror images have the same ones
    outermost = (reach > reach.max(axis=1, keepdims=True) - EQUAL_REACH_MM).any(axis=0)
    corners = np.unique(hull[outermost].round(9), axis=0)
    return np.asarray(corners[_order_from_back(corners)])


def _directions(*slopes: float) -> Array:
    """Return vectors that rise by each of the `slopes` in DIRECTION_COUNT horizontal directions, shape (n, 3)."""
    turn = (np.arange(DIRECTION_COUNT) + 0.5) * 2.0 * math.pi / DIRECTION_COUNT
    flat = np.column_stack([np.cos(turn), 0.0 * turn, np.sin(turn)])
    return np.concatenate([np.array([0.0, slope, 0.0]) + flat for slope in slopes])
