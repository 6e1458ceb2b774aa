"""Gaps between bodies seen from above, and between bodies and walls.

`bodies`, `ground` and `planar` are those of `bodies.Crowd`, `i` and `j` numbers of walkers. x, z: coordinates in the
plane, mm. A body's core is its outline moved inward by a radius. `layer`: 0 for the bottom, 1 for the top of bodies.
"""

import math

from walkergen.core.numerics.kernels import lean
from walkergen.guests.crowd.space.bodies import COS, ENDLESS, LEAN_X, LEAN_Z, PERIODIC, RECTANGLE, RING, SIN, X, Z

FAR = 1e9
"""Gap of bodies that never meet, mm."""


@lean
def minimum_image(ground, d):
    """Return the difference d of two coordinates (mm) to the nearest periodic image; d itself without a period."""
    if ground.period > 0.0:
        return d - ground.period * math.floor(d / ground.period + 0.5)
    return d


@lean
def closest_point(bodies, kind, x, z):
    """Find the point closest to (x, z) on the core of a kind of body (its outline moved inward), in body axes, mm.

    Returns distance, point, whether it is a corner, and the number of that corner, or of the closer end of the edge.
    """
    least, c_x, c_z, is_corner, end = FAR * FAR, 0.0, 0.0, False, 0
    for e in range(bodies.first_edge[kind], bodies.first_edge[kind + 1]):
        a, b = bodies.edges[e, 0], bodies.edges[e, 1]
        a_x, a_z = bodies.corners[a, 0], bodies.corners[a, 1]
        d_x, d_z = bodies.corners[b, 0] - a_x, bodies.corners[b, 1] - a_z
        size = d_x * d_x + d_z * d_z
        t = 0.0
        if size > 0.0:
            t = min(max(((x - a_x) * d_x + (z - a_z) * d_z) / size, 0.0), 1.0)
        p_x, p_z = a_x + t * d_x, a_z + t * d_z
        distance = (x - p_x) ** 2 + (z - p_z) ** 2
        if distance < least:
            least, c_x, c_z, is_corner = distance, p_x, p_z, t == 0.0 or t == 1.0
            end = a if t < 0.5 else b
    return math.sqrt(least), c_x, c_z, is_corner, end


@lean
def box_distance(bodies, kind, x, z):
    """Return the distance of (x, z) from the bounding box of the core of a kind of body, in body axes, mm."""
    box = bodies.box
    d_x = max(abs(x - box[kind, 0]) - box[kind, 2], 0.0)
    d_z = max(abs(z - box[kind, 1]) - box[kind, 3], 0.0)
    return math.sqrt(d_x * d_x + d_z * d_z)


@lean
def to_plane(planar, i, height, b_x, b_z):
    """Return the plane coordinates (mm) of the point (b_x, b_z) of body i, in body axes at a height (mm) over C."""
    c, s = planar[i, COS], planar[i, SIN]
    x = planar[i, X] + height * planar[i, LEAN_X] + c * b_x - s * b_z
    return x, planar[i, Z] + height * planar[i, LEAN_Z] + s * b_x + c * b_z


@lean
def to_body_frame(planar, i, height, x, z):
    """Return the coordinates (mm) of a point (x, z) of the plane in the axes of body i at a height (mm) over its C."""
    c, s = planar[i, COS], planar[i, SIN]
    d_x = x - planar[i, X] - height * planar[i, LEAN_X]
    d_z = z - planar[i, Z] - height * planar[i, LEAN_Z]
    return c * d_x + s * d_z, c * d_z - s * d_x


@lean
def gap_lower_bound(bodies, ground, planar, i, j):
    """Compute a lower bound of the gap of bodies i and j from their outer radii, mm."""
    d_x = minimum_image(ground, planar[i, X] - planar[j, X])
    d_z = minimum_image(ground, planar[i, Z] - planar[j, Z])
    reach = bodies.reach[bodies.kind[i]] + bodies.reach[bodies.kind[j]]
    return math.sqrt(d_x * d_x + d_z * d_z) - reach - 2.0 * lean_displacement(bodies, planar, i, j)


@lean
def lean_displacement(bodies, planar, i, j):
    """Return the larger of the distances by which the lean of bodies i and j moves their upright edges' ends, mm."""
    largest = 0.0
    for body in (i, j):
        kind = bodies.kind[body]
        height = max(abs(bodies.ends[kind, 0]), abs(bodies.ends[kind, 1]))
        lean = abs(planar[body, LEAN_X]) + abs(planar[body, LEAN_Z])
        largest = max(largest, height * lean)
    return largest


@lean
def corner_gap(bodies, ground, planar, i, j, layer, least, cutoff):
    """Return the smaller of `least`, the gap found so far, and the gaps of body i's corners from body j, mm.

    For gaps above `cutoff` (mm) it uses lower bounds. `layer`: 0 at the bottom of both bodies, 1 at the top.
    """
    kind_i, kind_j = bodies.kind[i], bodies.kind[j]
    height, height_j = bodies.heights[kind_i, kind_j, layer], bodies.heights[kind_j, kind_i, layer]
    radii = bodies.radius[kind_i] + bodies.radius[kind_j]
    for v in range(bodies.first[kind_i], bodies.first[kind_i + 1]):
        x, z = to_plane(planar, i, height, bodies.corners[v, 0], bodies.corners[v, 1])
        x = planar[j, X] + minimum_image(ground, x - planar[j, X])
        z = planar[j, Z] + minimum_image(ground, z - planar[j, Z])
        b_x, b_z = to_body_frame(planar, j, height_j, x, z)
        gap = box_distance(bodies, kind_j, b_x, b_z) - radii
        if gap < least:
            if gap < cutoff:
                distance, _, _, _, _ = closest_point(bodies, kind_j, b_x, b_z)
                gap = distance - radii
            least = min(least, gap)
    return least


@lean
def body_gap(bodies, ground, planar, i, j, cutoff):
    """Return the smallest gap of bodies i and j at bottom and top, mm; above `cutoff` (mm) a lower bound of the gap."""
    least = FAR
    if math.isnan(bodies.heights[bodies.kind[i], bodies.kind[j], 0]):
        return least
    for layer in range(2):
        least = corner_gap(bodies, ground, planar, i, j, layer, least, cutoff)
        least = corner_gap(bodies, ground, planar, j, i, layer, least, cutoff)
    return least


@lean
def wall_gap(bodies, ground, planar, i):
    """Return the gap of body i from the nearest wall, mm; FAR without walls."""
    if ground.kind == PERIODIC or ground.kind == ENDLESS:
        return FAR
    kind, least = bodies.kind[i], FAR
    for layer in range(2):
        height = bodies.ends[kind, layer]
        for v in range(bodies.first[kind], bodies.first[kind + 1]):
            x, z = to_plane(planar, i, height, bodies.corners[v, 0], bodies.corners[v, 1])
            if ground.kind == RECTANGLE:
                gap = min(ground.outer - abs(x), ground.inner - abs(z))
            else:
                gap = ground.outer - math.sqrt(x * x + z * z)
            least = min(least, gap - bodies.radius[kind])
        if ground.kind == RING:
            b_x, b_z = to_body_frame(planar, i, height, 0.0, 0.0)
            distance, _, _, _, _ = closest_point(bodies, kind, b_x, b_z)
            least = min(least, distance - bodies.radius[kind] - ground.inner)
    return least
