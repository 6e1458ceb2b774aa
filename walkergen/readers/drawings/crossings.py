"""Triangles of a mesh that cross each other, found exactly but for a tolerance, in n log n time.

Triangles are ordered along a Morton curve. A tree of bounding boxes over that order, a binary heap,
finds the pairs that come near each other. Slivers that meet in one corner, as in the lid of a cylinder,
are all near each other. They are neighbours in the order, and the tree stores the directions from that
corner to them. Only slivers in overlapping directions can meet. Two triangles cross when
an edge of one passes through the other, and each has corners farther than the tolerance on both sides
of the other's plane; or when they lie in one plane, face the same way and overlap by more than the
tolerance. Neighbours along an edge are not compared: where neighbours are turned alike, one can at most
lie folded upon the other. In the kernels, `shapes` is an `OrderedTriangles`, and a triangle is an index into it.
"""

from typing import NamedTuple

import numpy as np

from walkergen.core.numerics import Array, Whole
from walkergen.core.numerics.kernels import kernel, lean

LEAF_SIZE = 4
"""Triangles of a leaf of the tree."""

MAX_CORNER_TRIANGLES = 32
"""Maximum number of triangles at a corner that is not crowded. Those at a crowded one are neighbours in the order."""

MORTON_BITS = 16
MORTON_MASKS = ((16, 0x0000FF0000FF), (8, 0x00F00F00F00F), (4, 0x0C30C30C30C3), (2, 0x249249249249))
"""Shifts and masks that put two zeros between the bits of a number of MORTON_BITS."""

STACK_SIZE = 128
"""Size of the stack of a walk down the tree: more than twice the depth for 2^60 triangles."""


class Crossings(NamedTuple):
    """Pairs of triangles that cross each other."""

    number: int
    pair: tuple[int, int]
    """Indices of the triangles of one such pair; (-1, -1) without any."""


class OrderedTriangles(NamedTuple):
    """Triangles in the order of the tree, as its kernels read them."""

    triangles: Whole
    """Indices of the vertices, shape (k, 3)."""
    corners: Array
    """Positions of the vertices, shape (k, 3, 3)."""
    normals: Array
    """Unit normals, shape (k, 3); zero for a triangle without area."""
    low: Array
    """Least coordinates of each triangle, shape (k, 3), half a tolerance inside."""
    high: Array
    """Greatest coordinates of each triangle, shape (k, 3), half a tolerance inside."""
    apexes: Whole
    """Crowded corner of each triangle, shape (k,); -1 without any."""
    vertices: Array
    """Positions of the vertices, shape (n, 3)."""


class Tree(NamedTuple):
    """Binary heap of bounding boxes: node 1 is the root, and the leaves begin at node `leaves`."""

    leaves: int
    low: Array
    high: Array
    """Bounds of what is below a node, shape (2 leaves, 6): of positions, and of directions from its apex."""
    apexes: Whole
    """Crowded corner that all triangles below a node share, shape (2 leaves,); -1 without any."""


class Scratch(NamedTuple):
    """Arrays that the kernels of a search overwrite."""

    stack: Whole
    seen: Array
    """Directions of a triangle's corners, shape (3, 3)."""
    low: Array
    high: Array
    """Bounds of the directions of a triangle, or of a leaf's, shape (3,)."""


def find(vertices: Array, triangles: Whole, tolerance: float) -> Crossings:
    """Find the pairs of triangles that cross by more than a tolerance, in the vertices' unit.

    Vertices of shape (n, 3), finite. Triangles of shape (k, 3), neighbours sharing their vertices.
    Touching within the tolerance is no crossing.
    """
    if len(triangles) == 0:
        return Crossings(0, (-1, -1))
    apexes = _crowded_corners(triangles)
    order = np.lexsort((_morton_codes(vertices, triangles), apexes))
    ordered = triangles[order]
    leaves = 1
    while leaves * LEAF_SIZE < len(ordered):
        leaves *= 2
    corners = vertices[ordered]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)
    first, second, third = corners.transpose(1, 0, 2)
    low = np.minimum(np.minimum(first, second), third)
    high = np.maximum(np.maximum(first, second), third)
    margin = 0.5 * tolerance * (high - low > 2.0 * tolerance)
    shapes = OrderedTriangles(ordered, corners, normals, low + margin, high - margin, apexes[order], vertices)
    scratch = Scratch(np.empty(STACK_SIZE, np.int64), np.empty((3, 3)), np.empty(3), np.empty(3))
    count, one, other = _count_crossings(
        shapes, Tree(leaves, *_build_tree(shapes, leaves, scratch)), scratch, tolerance
    )
    pair = (-1, -1) if count == 0 else (int(order[one]), int(order[other]))
    return Crossings(int(count), pair)


def _crowded_corners(triangles: Whole) -> Whole:
    """Return the vertex of each triangle that the most triangles share, or -1 if it is not crowded, shape (k,)."""
    valences = np.bincount(triangles.ravel())[triangles]
    most = valences.argmax(axis=1)
    rows = np.arange(len(triangles))
    return np.where(valences[rows, most] > MAX_CORNER_TRIANGLES, triangles[rows, most], -1)


def _morton_codes(vertices: Array, triangles: Whole) -> Whole:
    """Return the positions of triangles' middles along the Morton curve, shape (k,)."""
    first, second, third = vertices.T[:, triangles.T].transpose(1, 0, 2)
    middles = first + second + third  # an axis a row
    low = middles.min(axis=1, keepdims=True)
    side = max(float((middles.max(axis=1, keepdims=True) - low).max()), 1e-300)
    cells = ((middles - low) * ((2**MORTON_BITS - 1) / side)).astype(np.int64)
    for shift, mask in MORTON_MASKS:
        cells = (cells | cells << shift) & mask
    codes: Whole = cells[0] | cells[1] << 1 | cells[2] << 2
    return codes


@kernel
def _build_tree(shapes, leaves, scratch):
    """Return the bounds (lows, highs) and apexes of the nodes of a `Tree` with this number of leaves."""
    lows = np.full((2 * leaves, 6), np.inf)
    highs = np.full((2 * leaves, 6), -np.inf)
    apexes = np.full(2 * leaves, -2)  # -2: empty
    for number in range(len(shapes.low)):
        node, apex = leaves + number // LEAF_SIZE, shapes.apexes[number]
        apexes[node] = apex if apexes[node] == -2 or apexes[node] == apex else -1
        if apex >= 0:
            _bound_directions(shapes, number, apex, scratch, True)  # reset the bounds
        for axis in range(3):
            lows[node, axis] = min(lows[node, axis], shapes.low[number, axis])
            highs[node, axis] = max(highs[node, axis], shapes.high[number, axis])
            if apex >= 0:
                lows[node, 3 + axis] = min(lows[node, 3 + axis], scratch.low[axis])
                highs[node, 3 + axis] = max(highs[node, 3 + axis], scratch.high[axis])
    for node in range(leaves - 1, 0, -1):
        left, right = apexes[2 * node], apexes[2 * node + 1]
        apexes[node] = left if right == -2 or right == left else -1
        for axis in range(6):
            lows[node, axis] = min(lows[2 * node, axis], lows[2 * node + 1, axis])
            highs[node, axis] = max(highs[2 * node, axis], highs[2 * node + 1, axis])
    return lows, highs, apexes


@lean
def _count_crossings(shapes, tree, scratch, tolerance):
    """Return the number of crossing pairs, and both indices of the first pair in the tree's order; -1 without one."""
    total, leaves, stack = len(shapes.triangles), tree.leaves, scratch.stack
    count, one, other = 0, -1, -1
    for leaf in range(leaves, leaves + (total + LEAF_SIZE - 1) // LEAF_SIZE):
        begin, end, apex = LEAF_SIZE * (leaf - leaves), min(LEAF_SIZE * (leaf - leaves) + LEAF_SIZE, total), -1
        stack[0] = 1
        height = 1
        while height > 0:
            height -= 1
            node = stack[height]
            if _is_disjoint(tree.low, tree.high, leaf, tree.low, tree.high, node):
                continue
            if tree.apexes[node] >= 0:
                if tree.apexes[node] != apex:
                    apex = tree.apexes[node]
                    for first in range(begin, end):
                        _bound_directions(shapes, first, apex, scratch, first == begin)
                if _has_disjoint_directions(scratch, tree, node):
                    continue
            if node < leaves:
                stack[height] = 2 * node
                stack[height + 1] = 2 * node + 1
                height += 2
            elif node >= leaf:  # each pair once
                start = LEAF_SIZE * (node - leaves)
                for first in range(begin, end):
                    for second in range(max(start, first + 1), min(start + LEAF_SIZE, total)):
                        if _is_disjoint(shapes.low, shapes.high, first, shapes.low, shapes.high, second):
                            continue
                        if _is_crossing(shapes, first, second, tolerance):
                            if count == 0:
                                one, other = first, second
                            count += 1
    return count, one, other


@lean
def _bound_directions(shapes, triangle, apex, scratch, reset):
    """Set the bounds in `scratch` of directions (unit vectors) from vertex `apex` to a triangle, or widen them.

    They are widened unless `reset`. A direction is w / |w| for a point w of the flat triangle between the corners'
    directions. It is no farther from w than 1 - |w|, and |w|^2 is at least the least scalar product of two corners'
    directions.
    """
    rays, count, touches_apex = scratch.seen, 0, False
    for corner in range(3):
        if shapes.triangles[triangle, corner] == apex:
            continue
        square = 0.0
        for axis in range(3):
            rays[count, axis] = shapes.corners[triangle, corner, axis] - shapes.vertices[apex, axis]
            square += rays[count, axis] * rays[count, axis]
        touches_apex = touches_apex or square == 0.0
        for axis in range(3):
            rays[count, axis] /= np.sqrt(square) if square > 0.0 else 1.0
        count += 1
    least_product = 1.0
    for i in range(count):
        for j in range(i):
            product = rays[i, 0] * rays[j, 0] + rays[i, 1] * rays[j, 1] + rays[i, 2] * rays[j, 2]
            least_product = min(least_product, product)
    margin = 2.0 if touches_apex or least_product <= 0.0 else 1.0 - np.sqrt(least_product) + 1e-14
    for axis in range(3):
        if reset:
            scratch.low[axis], scratch.high[axis] = np.inf, -np.inf
        for i in range(count):
            scratch.low[axis] = min(scratch.low[axis], rays[i, axis] - margin)
            scratch.high[axis] = max(scratch.high[axis], rays[i, axis] + margin)


@lean
def _has_disjoint_directions(scratch, tree, node):
    """Return whether the bounds of directions in `scratch` and those of a node do not overlap."""
    for axis in range(3):
        if scratch.low[axis] > tree.high[node, 3 + axis] or scratch.high[axis] < tree.low[node, 3 + axis]:
            return True
    return False


@lean
def _is_disjoint(low, high, one, lows, highs, other):
    """Return whether two boxes do not meet: row `one` of `low` and `high`, and row `other` of `lows` and `highs`."""
    return (
        low[one, 0] > highs[other, 0]
        or high[one, 0] < lows[other, 0]
        or low[one, 1] > highs[other, 1]
        or high[one, 1] < lows[other, 1]
        or low[one, 2] > highs[other, 2]
        or high[one, 2] < lows[other, 2]
    )


@lean
def _is_crossing(shapes, one, other, tolerance):
    """Return whether two triangles cross each other by more than a tolerance."""
    shared = 0
    for i in range(3):
        for j in range(3):
            shared += shapes.triangles[one, i] == shapes.triangles[other, j]
    if shared > 1:
        return False
    is_on_one_side, is_coplanar = False, False
    for first, second in ((one, other), (other, one)):
        least, most = np.inf, -np.inf
        for corner in range(3):
            height = _height_above_plane(shapes, first, second, corner)
            least, most = min(least, height), max(most, height)
        is_on_one_side = is_on_one_side or -least <= tolerance or most <= tolerance
        is_coplanar = is_coplanar or max(-least, most) <= tolerance
    if is_coplanar:
        return _is_overlapping(shapes, one, other, tolerance)
    if is_on_one_side:
        return False
    for number in range(6):
        first, second = (one, other) if number < 3 else (other, one)
        if _pierces(shapes, first, number % 3, second):
            return True
    return False


@lean
def _height_above_plane(shapes, triangle, other, corner):
    """Return the height of corner 0, 1 or 2 of the triangle `other` above the plane of `triangle`."""
    height = 0.0
    for axis in range(3):
        rise = shapes.corners[other, corner, axis] - shapes.corners[triangle, 0, axis]
        height += rise * shapes.normals[triangle, axis]
    return height


@lean
def _pierces(shapes, one, edge, other):
    """Return whether edge 0, 1 or 2 of triangle `one` passes through the triangle `other` without a common end.

    An edge that meets an edge of the other triangle passes: nothing slips between two neighbours.
    """
    following = (edge + 1) % 3
    for corner in range(3):
        end = shapes.triangles[other, corner]
        if end == shapes.triangles[one, edge] or end == shapes.triangles[one, following]:
            return False
    above, below = _height_above_plane(shapes, other, one, edge), _height_above_plane(shapes, other, one, following)
    if above * below >= 0.0:
        return False
    share = above / (above - below)
    for side in range(3):
        start = _signed_edge_distance(shapes, other, side, one, edge)
        end = _signed_edge_distance(shapes, other, side, one, following)
        if start + share * (end - start) < 0.0:
            return False
    return True


@lean
def _signed_edge_distance(shapes, triangle, edge, other, corner):
    """Return the distance of a corner of the triangle `other` from the line along an edge of `triangle`.

    It is positive inside, and measured in the plane of `triangle`. Edges and corners are 0, 1 or 2.
    """
    following = (edge + 1) % 3
    length, across = 0.0, 0.0
    for axis in range(3):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        along = shapes.corners[triangle, following, axis] - shapes.corners[triangle, edge, axis]
        length += along * along
        ui = shapes.corners[triangle, following, i] - shapes.corners[triangle, edge, i]
        uj = shapes.corners[triangle, following, j] - shapes.corners[triangle, edge, j]
        inward = shapes.normals[triangle, i] * uj - shapes.normals[triangle, j] * ui
        across += inward * (shapes.corners[other, corner, axis] - shapes.corners[triangle, edge, axis])
    return across / np.sqrt(length) if length > 0.0 else 0.0


@lean
def _is_overlapping(shapes, one, other, tolerance):
    """Return whether two triangles in one plane that face the same way overlap: no edge of one separates them."""
    facing = 0.0
    for axis in range(3):
        facing += shapes.normals[one, axis] * shapes.normals[other, axis]
    if facing <= 0.0:
        return False
    for number in range(6):
        first, second = (one, other) if number < 3 else (other, one)
        deepest = -np.inf
        for corner in range(3):
            deepest = max(deepest, _signed_edge_distance(shapes, first, number % 3, second, corner))
        if deepest <= tolerance:
            return False
    return True
