"""Solids of the library manifold3d: conversion from and to meshes, extrusion of profiles, failures as exceptions.

Booleans of solids keep double precision: their tolerance is 1e-12 of the largest coordinate (measured at sizes from
1e-3 to 1e3 mm). Profiles have to be scaled, see `extrude`.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import manifold3d
import numpy as np

from walkergen.core.errors import SolidError
from walkergen.core.numerics import Array
from walkergen.core.shapes.mesh import Mesh

MIN_WINDOW_RATIO = 1e-9
"""Width of a window between leg and brace, over the leg's length, below which it does not count:
such slivers (a hundred picometres) are lost, all or in part, to the rounding of coordinates."""

Polygon = Array


class Engraving(NamedTuple):
    """Pockets cut into the upper flat side, z = the body's depth."""

    profiles: Sequence[Polygon]
    """Outlines of the pockets, shape (n, 2) each, mm."""
    depth: float
    """Depth of the pockets, mm."""


NO_ENGRAVING = Engraving([], 0.0)


def to_solid(mesh: Mesh) -> manifold3d.Manifold:
    """Convert a closed mesh to a solid. Raises SolidError when manifold3d refuses it."""
    # The modeller takes no read-only arrays, which its own results are
    vertices = np.require(mesh.vertices, np.float64, ["C", "W"])
    triangles = np.require(mesh.triangles, np.uint64, ["C", "W"])
    return check_solid(manifold3d.Manifold(manifold3d.Mesh64(vertices, triangles)))


def check_solid(manifold: manifold3d.Manifold) -> manifold3d.Manifold:
    """Evaluate the pending operations of a solid and return it. Raises SolidError if one of them failed."""
    if manifold.status() != manifold3d.Error.NoError:
        raise SolidError(f"the solid modeller gave no body: {manifold.status().name}")
    return manifold


def to_mesh(manifold: manifold3d.Manifold) -> Mesh:
    """Return the closed mesh of a solid."""
    raw = manifold.to_mesh64()
    vertices = np.array(raw.vert_properties, dtype=np.float64)[:, :3]
    return Mesh(vertices, np.asarray(raw.tri_verts, dtype=np.int64))


def split_bodies(manifold: manifold3d.Manifold) -> list[manifold3d.Manifold]:
    """Split a solid into its bodies, largest first. Closed cavities do not count as bodies."""
    outward = [piece for piece in manifold.decompose() if piece.volume() > 0.0]
    return sorted(outward, key=lambda piece: -piece.volume())


def count_bodies(mesh: Mesh) -> int:
    """Count the closed bodies of a mesh with coordinates as 32-bit floats, as in a file. Cavities are no bodies.

    Return 0 if the mesh is not closed and oriented, or encloses nothing. Vertices that coincide are merged.
    """
    rounded = mesh.vertices.astype(np.float32)
    vertices, index = np.unique(rounded, axis=0, return_inverse=True)
    triangles = index.reshape(-1)[mesh.triangles].astype(np.uint32)
    solid = manifold3d.Manifold(manifold3d.Mesh(vertices, triangles))
    if solid.status() != manifold3d.Error.NoError or solid.volume() <= 0.0:
        return 0
    return len(split_bodies(solid))


def extrude(
    profiles: Sequence[Polygon],
    depth: float,
    windows: int | None = None,
    engraving: Engraving = NO_ENGRAVING,
    pieces: bool = False,
) -> Mesh:
    """Extrude the union of profiles, shape (n, 2) each, to z = 0..depth, and cut an engraving into its upper side.

    `windows` is the number of holes that the result must have, if known. With `pieces`, it may be several bodies, as
    letters are. Otherwise it must be one.

    manifold3d's 2D booleans snap to a grid of 1e-8 units. A power of two brings the profile to a
    size of about 2^30 units first and back afterwards, both exact, which leaves 17 digits. Raises
    SolidError when the result is not as required.
    """
    largest_coordinate = max(float(np.abs(profile).max()) for profile in profiles)
    scale = 2.0 ** (30 - math.frexp(max(largest_coordinate, depth))[1])
    section = manifold3d.CrossSection([scale * profile for profile in profiles], manifold3d.FillRule.Positive)
    if windows == 0:
        section = _fill_slivers(section)
    solid = manifold3d.Manifold.extrude(section, scale * depth)
    if solid.status() != manifold3d.Error.NoError or solid.is_empty():
        raise SolidError(f"the solid modeller gave no body: {solid.status().name}")
    # k bodies with h holes have k + h contours and genus 1 - k + h: equal holes mean one body.
    genus, holes = solid.genus(), section.num_contour() - 1
    if (not pieces and genus != holes) or (windows is not None and genus != windows):
        raise SolidError(f"the solid is not one body with {windows} windows: genus {genus}, {holes} holes")
    if engraving.profiles:
        solid = _engrave(solid, engraving, depth, scale)
    mesh = to_mesh(solid)
    return mesh._replace(vertices=mesh.vertices / scale)


def _fill_slivers(section: manifold3d.CrossSection) -> manifold3d.CrossSection:
    """Return a profile with its holes filled. Raises SolidError if they exceed MIN_WINDOW_RATIO of its area."""
    min_area = MIN_WINDOW_RATIO * section.area()
    outlines = [polygon for polygon in section.to_polygons() if _signed_area(polygon) > min_area]
    filled = manifold3d.CrossSection(outlines)
    if filled.area() - section.area() > min_area:
        raise SolidError("the solid has a window that the design has not")
    return filled


def _signed_area(polygon: Polygon) -> float:
    """Return the area enclosed by a polygon, shape (n, 2), in its unit squared; negative for a hole."""
    following = np.roll(polygon, -1, axis=0)
    return 0.5 * float((polygon[:, 0] * following[:, 1] - polygon[:, 1] * following[:, 0]).sum())


def _engrave(solid: manifold3d.Manifold, engraving: Engraving, depth: float, scale: float) -> manifold3d.Manifold:
    """Return a solid with an engraving cut into its upper side.

    The solid is `scale` times as large as drawn. `depth` is the height of its upper side as drawn, mm.
    """
    section = manifold3d.CrossSection([scale * profile for profile in engraving.profiles], manifold3d.FillRule.Positive)
    cutter = manifold3d.Manifold.extrude(section, scale * 2.0 * engraving.depth)  # overshoots, so that no sides touch
    cut = solid - cutter.translate((0.0, 0.0, scale * (depth - engraving.depth)))
    # A pocket, with or without islands, leaves one body and opens no window.
    if cut.status() != manifold3d.Error.NoError or cut.genus() != solid.genus():
        raise SolidError(
            f"the digits do not stay pockets: {cut.status().name}, genus {cut.genus()} after {solid.genus()}"
        )
    return cut
