"""Exact tests whether outlines of walkers overlap in a dish, and kernels that add or move walkers without overlap.

An outline is the edges of its contours about the middle of the circle around it. Each walker may be smaller than its
outline by its own scale. Two outlines overlap when edges cross, or when one lies in the other. Random numbers come from
outside, so that kernels are functions of their arguments: `Outlines`, `Bounds` and `Cells`, the walkers' poses `places`
(x, y of the middle in mm, heading in rad, shape (N, 3)), and their `scales`, shape (N,). Kernels that add or move
walkers change `cells`, `places` and `scales` in place.
"""

import math
from typing import NamedTuple

import numpy as np

from walkergen.core import Array, Whole
from walkergen.core.numerics.kernels import kernel, lean

DISC, RING, RECTANGLE, PERIODIC = range(4)

NO_WALKER = -1
"""End of a list of the walkers in a cell; number of no walker."""


class Outlines(NamedTuple):
    """Outlines of all kinds of walkers, one kind after the other; lengths in mm."""

    kind: Whole
    """Kind of each walker, shape (N,)."""
    first: Whole
    """First edge of each kind, shape (kinds + 1,)."""
    edges: Array
    """Both ends of each edge, from the middle: x, y, x, y, shape (e, 4)."""
    first_start: Whole
    """First of `starts` of each kind, shape (kinds + 1,)."""
    starts: Array
    """A point of each contour, shape (c, 2)."""
    outer: Array
    """Radius of the circle around each kind, shape (kinds,)."""
    inner: Array
    """Radius of a circle about the middle that lies within, shape (kinds,)."""


class Bounds(NamedTuple):
    """Ground between walls, mm."""

    kind: int
    outer: float
    """Radius of a disc or ring, half the length of a rectangle, half the side of a square."""
    inner: float
    """Inner radius of a ring, half the width of a rectangle."""
    period: float
    """Side of a periodic square; 0 between walls."""


class Cells(NamedTuple):
    """Walkers sorted into the squares of a grid by their middles."""

    side: float
    across: int
    """Squares along either axis."""
    head: Whole
    """First walker of each square, shape (across^2,)."""
    following: Whole
    """Next walker of the same square, shape (N,)."""


def empty_cells(outlines: Outlines, bounds: Bounds) -> Cells:
    """Return an empty grid whose squares are at least as wide as two walkers."""
    half = max(bounds.outer, bounds.inner)
    across = max(int(2.0 * half / (2.0 * float(outlines.outer.max()))), 1)
    across = min(across, 2000)
    head = np.full(across * across, NO_WALKER, np.int64)
    return Cells(2.0 * half / across, across, head, np.full(len(outlines.kind), NO_WALKER, np.int64))


@lean
def _cell_index(cells, bounds, x, y):
    """Return the column and row of the grid's square that contains (x, y)."""
    half = max(bounds.outer, bounds.inner)
    last = cells.across - 1
    column = min(max(int((x + half) / cells.side), 0), last)
    return column, min(max(int((y + half) / cells.side), 0), last)


@lean
def _insert_walker(cells, bounds, i, x, y):
    """Add walker i to the list of the square that contains (x, y)."""
    column, row = _cell_index(cells, bounds, x, y)
    at = row * cells.across + column
    cells.following[i] = cells.head[at]
    cells.head[at] = i


@lean
def _remove_walker(cells, bounds, i, x, y):
    """Remove walker i from the list of the square that contains (x, y)."""
    column, row = _cell_index(cells, bounds, x, y)
    at = row * cells.across + column
    if cells.head[at] == i:
        cells.head[at] = cells.following[i]
        return
    other = cells.head[at]
    while cells.following[other] != i:
        other = cells.following[other]
    cells.following[other] = cells.following[i]


@lean
def _is_inside(outlines, kind, x, y):
    """Return whether the point (x, y), mm, lies inside the outline of a `kind` of walker."""
    odd = False
    for e in range(outlines.first[kind], outlines.first[kind + 1]):
        a_x, a_y = outlines.edges[e, 0], outlines.edges[e, 1]
        b_x, b_y = outlines.edges[e, 2], outlines.edges[e, 3]
        if (a_y > y) != (b_y > y) and x < (b_x - a_x) * (y - a_y) / (b_y - a_y) + a_x:
            odd = not odd
    return odd


@lean
def _has_intersection(edge, p_x, p_y, q_x, q_y):
    """Return whether an edge (x, y, x, y) and the segment from p to q have a point in common."""
    a_x, a_y, b_x, b_y = edge[0], edge[1], edge[2], edge[3]
    if max(a_x, b_x) < min(p_x, q_x) or max(p_x, q_x) < min(a_x, b_x):
        return False
    if max(a_y, b_y) < min(p_y, q_y) or max(p_y, q_y) < min(a_y, b_y):
        return False
    u_x, u_y, v_x, v_y = b_x - a_x, b_y - a_y, q_x - p_x, q_y - p_y
    left = u_x * (p_y - a_y) - u_y * (p_x - a_x)
    right = u_x * (q_y - a_y) - u_y * (q_x - a_x)
    if left * right > 0.0:
        return False
    left = v_x * (a_y - p_y) - v_y * (a_x - p_x)
    right = v_x * (b_y - p_y) - v_y * (b_x - p_x)
    return left * right <= 0.0


@lean
def _has_overlap(outlines, own, other, d_x, d_y, turn, ratio):
    """Return whether the outlines of two kinds overlap, in the frame of kind `own`.

    Kind `other` is scaled by `ratio`. Its middle is at (d_x, d_y), mm, and it is turned by `turn`, rad.
    """
    c, s, reach = ratio * math.cos(turn), ratio * math.sin(turn), outlines.outer[own]
    for e in range(outlines.first[other], outlines.first[other + 1]):
        edge = outlines.edges[e]
        p_x, p_y = d_x + c * edge[0] - s * edge[1], d_y + s * edge[0] + c * edge[1]
        q_x, q_y = d_x + c * edge[2] - s * edge[3], d_y + s * edge[2] + c * edge[3]
        if max(p_x, q_x) < -reach or min(p_x, q_x) > reach or max(p_y, q_y) < -reach or min(p_y, q_y) > reach:
            continue
        for f in range(outlines.first[own], outlines.first[own + 1]):
            if _has_intersection(outlines.edges[f], p_x, p_y, q_x, q_y):
                return True
    for k in range(outlines.first_start[other], outlines.first_start[other + 1]):
        b_x, b_y = outlines.starts[k, 0], outlines.starts[k, 1]
        if _is_inside(outlines, own, d_x + c * b_x - s * b_y, d_y + s * b_x + c * b_y):
            return True
    ratio_squared = ratio * ratio
    for k in range(outlines.first_start[own], outlines.first_start[own + 1]):
        b_x, b_y = outlines.starts[k, 0] - d_x, outlines.starts[k, 1] - d_y
        if _is_inside(outlines, other, (c * b_x + s * b_y) / ratio_squared, (c * b_y - s * b_x) / ratio_squared):
            return True
    return False


@lean
def _has_pair_overlap(outlines, bounds, places, scales, i, j, x, y, heading, scale):
    """Return whether walker i, at this pose (mm, rad) and `scale`, overlaps walker j or an image of walker j."""
    own, other = outlines.kind[i], outlines.kind[j]
    far = scale * outlines.outer[own] + scales[j] * outlines.outer[other]
    near = scale * outlines.inner[own] + scales[j] * outlines.inner[other]
    images = 1 if bounds.period > 0.0 else 0
    for across in range(-images, images + 1):
        for up in range(-images, images + 1):
            d_x = places[j, 0] - x + across * bounds.period
            d_y = places[j, 1] - y + up * bounds.period
            distance_squared = d_x * d_x + d_y * d_y
            if distance_squared >= far * far or (i == j and across == 0 and up == 0):
                continue
            if distance_squared < near * near:
                return True
            c, s = math.cos(heading) / scale, math.sin(heading) / scale
            b_x, b_y = c * d_x + s * d_y, c * d_y - s * d_x
            turn = places[j, 2] - heading
            if _has_overlap(outlines, own, other, b_x, b_y, turn, scales[j] / scale):
                return True
    return False


@lean
def _has_wall_overlap(outlines, bounds, kind, x, y, heading, scale):
    """Return whether the outline of a `kind`, at this pose (mm, rad) and `scale`, reaches into a wall."""
    if bounds.kind == PERIODIC:
        return False
    c, s = scale * math.cos(heading), scale * math.sin(heading)
    for e in range(outlines.first[kind], outlines.first[kind + 1]):
        a_x, a_y = outlines.edges[e, 0], outlines.edges[e, 1]
        p_x, p_y = x + c * a_x - s * a_y, y + s * a_x + c * a_y
        if bounds.kind == RECTANGLE:
            if abs(p_x) > bounds.outer or abs(p_y) > bounds.inner:
                return True
        elif p_x * p_x + p_y * p_y > bounds.outer * bounds.outer:
            return True
        if bounds.kind == RING:
            a_x, a_y = outlines.edges[e, 2], outlines.edges[e, 3]
            v_x, v_y = x + c * a_x - s * a_y - p_x, y + s * a_x + c * a_y - p_y
            t = -(p_x * v_x + p_y * v_y) / (v_x * v_x + v_y * v_y)
            t = min(max(t, 0.0), 1.0)
            p_x, p_y = p_x + t * v_x, p_y + t * v_y
            if p_x * p_x + p_y * p_y < bounds.inner * bounds.inner:
                return True
    if bounds.kind == RING:
        scale_squared = scale * scale
        return _is_inside(outlines, kind, -(c * x + s * y) / scale_squared, (s * x - c * y) / scale_squared)
    return False


@lean
def is_free(outlines, bounds, cells, places, scales, i, x, y, heading, scale):
    """Return whether walker i, at this pose (mm, rad) and `scale`, touches neither walls nor the walkers in `cells`.

    In a periodic square it stores this pose and scale in `places` and `scales`, to compare the walker with its images.
    """
    if _has_wall_overlap(outlines, bounds, outlines.kind[i], x, y, heading, scale):
        return False
    column, row = _cell_index(cells, bounds, x, y)
    around = 1 if cells.across > 2 else 0
    first, last = (-1, 1) if around else (0, cells.across - 1)
    for over in range(first, last + 1):
        for up in range(first, last + 1):
            at_x, at_y = (column + over, row + up) if around else (over, up)
            if bounds.period > 0.0:
                at_x, at_y = at_x % cells.across, at_y % cells.across
            elif at_x < 0 or at_y < 0 or at_x >= cells.across or at_y >= cells.across:
                continue
            j = cells.head[at_y * cells.across + at_x]
            while j != NO_WALKER:
                if j != i and _has_pair_overlap(outlines, bounds, places, scales, i, j, x, y, heading, scale):
                    return False
                j = cells.following[j]
    if bounds.period > 0.0:
        places[i, 0], places[i, 1], places[i, 2] = x, y, heading
        scales[i] = scale
        return not _has_pair_overlap(outlines, bounds, places, scales, i, i, x, y, heading, scale)
    return True


@kernel
def add_walkers(outlines, bounds, cells, places, scales, order, done, randoms):
    """Add walkers one by one, each at the first random pose that is free, until all are added or tries are used up.

    `order`: walkers' numbers; the first `done` of them have their poses already. `randoms`: shape (tries, 3), 0 to 1.
    Stores poses in `places`, and returns the number of walkers with poses.
    """
    half_x = bounds.outer
    half_y = bounds.inner if bounds.kind == RECTANGLE else bounds.outer
    for t in range(len(randoms)):
        if done == len(order):
            break
        i = order[done]
        x, y = half_x * (2.0 * randoms[t, 0] - 1.0), half_y * (2.0 * randoms[t, 1] - 1.0)
        heading = 2.0 * math.pi * randoms[t, 2]
        if is_free(outlines, bounds, cells, places, scales, i, x, y, heading, scales[i]):
            places[i, 0], places[i, 1], places[i, 2] = x, y, heading
            _insert_walker(cells, bounds, i, x, y)
            done += 1
    return done


@kernel
def move_and_grow(outlines, bounds, cells, places, scales, randoms, steps, growth, most):
    """Move every walker once at random and let it grow, up to a scale of `most`.

    `randoms`: shape (N, 4), 0 to 1. `steps`: largest shift (mm) and turn (rad), shape (2,). `growth`: largest relative
    growth. Moves that would overlap are not made. Changes `places` and `scales`. Returns the number of moves.
    """
    moved = 0
    half = 0.5 * bounds.period
    for i in range(len(places)):
        x, y, heading, scale = places[i, 0], places[i, 1], places[i, 2], scales[i]
        new_x = x + steps[0] * (2.0 * randoms[i, 0] - 1.0)
        new_y = y + steps[0] * (2.0 * randoms[i, 1] - 1.0)
        turned = heading + steps[1] * (2.0 * randoms[i, 2] - 1.0)
        if bounds.period > 0.0:
            new_x -= bounds.period * math.floor((new_x + half) / bounds.period)
            new_y -= bounds.period * math.floor((new_y + half) / bounds.period)
        _remove_walker(cells, bounds, i, x, y)
        if is_free(outlines, bounds, cells, places, scales, i, new_x, new_y, turned, scale):
            x, y, heading = new_x, new_y, turned
            moved += 1
        larger = min(most, scale * (1.0 + growth * randoms[i, 3]))
        if larger > scale and is_free(outlines, bounds, cells, places, scales, i, x, y, heading, larger):
            scale = larger
        places[i, 0], places[i, 1], places[i, 2] = x, y, heading
        scales[i] = scale
        _insert_walker(cells, bounds, i, x, y)
    return moved


@kernel
def find_overlap(outlines, bounds, cells, places, scales):
    """Return the first walker that overlaps a wall or another one, or NO_WALKER. Fills the empty `cells`."""
    for i in range(len(places)):
        x, y, heading = places[i, 0], places[i, 1], places[i, 2]
        if not is_free(outlines, bounds, cells, places, scales, i, x, y, heading, scales[i]):
            return i
        _insert_walker(cells, bounds, i, x, y)
    return NO_WALKER
