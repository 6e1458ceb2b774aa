"""Outline of a walker as discs of one rigid body: LAMMPS computes contacts of discs.

Every disc lies inside the outline and touches it. Straight sides become a row of wide discs, whose
bumps stay below a tolerance; a corner ends in ever smaller ones.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from shapely import Polygon, union_all
from shapely.geometry.base import BaseGeometry

from walkergen.core import Array, InputError
from walkergen.guests.crowd.cards.card import Card

OUTLINE_POINTS = 900
"""Approximate number of points along an outline from which its discs are chosen."""

ARC_SEGMENTS = 16
"""Straight pieces of a quarter of a rounded corner."""


class Discs(NamedTuple):
    """Discs that represent a body, relative to its centre of mass C, mm."""

    places: Array
    """Centres, shape (D, 2)."""
    radii: Array
    """Radii, shape (D,)."""

    @property
    def reach(self) -> float:
        """Distance from C to the farthest point, mm."""
        return float(np.max(np.hypot(*self.places.T) + self.radii))


class Rim(NamedTuple):
    """Points along an outline, with the directions inwards; mm."""

    points: Array
    """Positions, shape (S, 2)."""
    inwards: Array
    """Unit vectors, shape (S, 2)."""


def covered_region(card: Card) -> BaseGeometry:
    """Return the region in a card's outline (mm), corners rounded. Raises InputError if none is left."""
    ground = union_all([Polygon(contour).buffer(0.0) for contour in card.outline_mm])
    radius = card.corner_radius_mm
    rounded = ground.buffer(-radius).buffer(radius, quad_segs=ARC_SEGMENTS) if radius else ground
    if rounded.is_empty or rounded.area <= 0.0:
        raise InputError(
            f"card {card.name!r}: outline_mm: no area is left of {ground.area:g} mm2 after "
            f"corners are rounded by corner_radius_mm = {radius:g}. Reduce this radius."
        )
    return rounded


def outline_rim(card: Card) -> Rim:
    """Return points along the outline, equally spaced on each straight piece, none at a corner."""
    ground = covered_region(card)
    pieces = [ground] if isinstance(ground, Polygon) else list(ground.geoms)
    contours = [np.asarray(piece.exterior.normalize().coords)[:, :2] for piece in pieces]
    spacing = sum(piece.exterior.length for piece in pieces) / OUTLINE_POINTS
    points, inwards = [], []
    for contour in contours:
        if np.sum(contour[:-1, 0] * contour[1:, 1] - contour[1:, 0] * contour[:-1, 1]) < 0.0:
            contour = contour[::-1]  # counter-clockwise: inwards is to the left
        for start, end in pairwise(contour):
            length = float(np.hypot(*(end - start)))
            if length < 1e-9:
                continue
            count = max(1, round(length / spacing))
            shares = (np.arange(count) + 0.5) / count
            points.append(start + shares[:, None] * (end - start))
            left = np.array([start[1] - end[1], end[0] - start[0]]) / length
            inwards.append(np.tile(left, (count, 1)))
    return Rim(np.concatenate(points), np.concatenate(inwards))


def inscribed_radius(card: Card) -> float:
    """Return the radius of the widest disc inside the outline, mm."""
    return float(_inscribed_radii(outline_rim(card)).max())


def cover_outline(card: Card, tolerance: float) -> Discs:
    """Return discs inside a card's outline such that no point of it is farther than `tolerance` (mm) from them.

    Each disc is the one that covers the most uncovered points. Tips that need radii below half the tolerance stay
    uncovered. Raises InputError if all discs would be smaller.
    """
    edge = outline_rim(card)
    radii = _inscribed_radii(edge)
    centres = edge.points + radii[:, None] * edge.inwards
    usable = np.flatnonzero(radii >= 0.5 * tolerance)
    if not usable.size:
        raise InputError(
            f"card {card.name!r}: outline_mm: narrower than {tolerance:g} mm, the resolution "
            "of the discs. Use a wider outline."
        )
    centres, radii = centres[usable], radii[usable]
    away = np.hypot(*(edge.points[:, None, :] - centres[None, :, :]).transpose(2, 0, 1))
    covers = away - radii[None, :] <= tolerance
    uncovered = np.ones(len(edge.points), dtype=bool)
    chosen: list[int] = []
    while uncovered.any():
        gains = covers[uncovered].sum(axis=0)
        best = int(np.argmax(gains))
        if gains[best] == 0:
            break
        chosen.append(best)
        uncovered &= ~covers[:, best]
    chosen.sort()
    return Discs(centres[chosen], radii[chosen])


def _inscribed_radii(edge: Rim) -> Array:
    """Return, for each point of an outline, the radius (mm) of the widest inner disc that touches it, shape (S,)."""
    between = edge.points[None, :, :] - edge.points[:, None, :]
    ahead = np.einsum("ijk,ik->ij", between, edge.inwards)
    squares = np.einsum("ijk,ijk->ij", between, between)
    with np.errstate(divide="ignore", invalid="ignore"):
        radii = np.where(ahead > 1e-9, 0.5 * squares / ahead, np.inf)
    return np.asarray(radii.min(axis=1))
