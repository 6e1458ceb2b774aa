"""Solids: from a design to closed meshes, by 2D profiles and one extrusion in manifold3d.

The profile lies in the x-y plane and is extruded along z by the body's depth, which is also how
the part is printed: lying on its side. Notches belong to the profile; digits are engraved into the
side that prints last, by a second, shallow extrusion taken from the first.
"""

import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import manifold3d
import numpy as np

from walkergen.errors import SolidError
from walkergen.walker import marks, profiles
from walkergen.walker.design import Design
from walkergen.walker.limbs import Limb
from walkergen.walker.mass import MassProperties, Mesh, assemble

if TYPE_CHECKING:
    import trimesh

FOOT_SEGMENTS = 64
"""Edges of a round foot's half circle: the polygon's foot is 2 % of a micrometre too small."""

NARROWEST_WINDOW = 1e-9
"""Width of a window between leg and brace, over the leg's length, below which it does not count:
such slivers (a hundred picometres) are lost, all or in part, to the rounding of coordinates."""

Polygon = profiles.Polygon


class Solids(NamedTuple):
    """Meshes of one walker."""

    walker: Mesh
    """Printable union of body and legs, in the design's frame: one closed body."""
    body: Mesh
    """Body alone, in the design's frame."""
    legs: tuple[Mesh, ...]
    """Each leg outside the body, with its brace if it has one, in the order of `Design.limbs`; its
    anchor at the origin of x and y, z from 0 to its width."""


class Engraving(NamedTuple):
    """Pockets cut into the upper flat side, z = the body's depth."""

    profiles: Sequence[Polygon]
    depth: float
    """Depth of the pockets, mm."""


NO_ENGRAVING = Engraving([], 0.0)


class Outline(NamedTuple):
    """Polygons of a walker seen from the side, counter-clockwise, shape (n, 2), mm."""

    body: Polygon
    """Profile of the body, in the design's frame."""
    limbs: tuple[tuple[Polygon, ...], ...]
    """Each leg, and its brace if it has one, reaching into the body; its anchor at the origin."""


def build(design: Design, foot_segments: int = FOOT_SEGMENTS) -> Solids:
    """Build a walker's solids. Raises SolidError when the modeller's result is not sound."""
    body, raised = outline(design, foot_segments)
    depth, limbs = design.size.depth, design.limbs
    digits = Engraving(_digit_profiles(design), design.marks.depth_mm)
    top = _extrude([body], depth, 0, digits)
    legs = _legs(limbs, foot_segments)
    placed = [
        [part + np.array(limb.anchor) for part in parts]
        for limb, parts in zip(limbs, raised, strict=True)
    ]
    if all(limb.width == depth and limb.across == 0.0 for limb in limbs):
        windows = sum(has_window(limb) for limb in limbs)
        profile = [body, *(part for parts in placed for part in parts)]
        return Solids(_extrude(profile, depth, windows, digits), top, legs)
    bars = [
        _shifted(_extrude(parts, limb.width, None, NO_ENGRAVING), _left_side(limb, depth))
        for limb, parts in zip(limbs, placed, strict=True)
    ]
    return Solids(united([top, *bars]), top, legs)


def _legs(limbs: Sequence[Limb], foot_segments: int) -> tuple[Mesh, ...]:
    """Meshes of the legs outside the body, anchors at the origin; equal legs share theirs."""
    made: dict[tuple[object, ...], Mesh] = {}
    for limb in limbs:
        if _shape(limb) not in made:
            profile = profiles.limb(limb, foot_segments)
            made[_shape(limb)] = _extrude(profile, limb.width, None, NO_ENGRAVING)
    return tuple(made[_shape(limb)] for limb in limbs)


def _shape(limb: Limb) -> tuple[object, ...]:
    """What the shape of a leg depends on, but not its place."""
    return limb._replace(along=0.0, across=0.0, bottom=0.0, friction=None, restitution=None)


def _left_side(limb: Limb, depth: float) -> float:
    """Place z of a leg's flat side, in the frame in which the body begins at z = 0, mm."""
    return 0.5 * depth + limb.across - 0.5 * limb.width


def _shifted(mesh: Mesh, z: float) -> Mesh:
    return mesh._replace(vertices=mesh.vertices + np.array([0.0, 0.0, z]))


def united(meshes: Sequence[Mesh]) -> Mesh:
    """One closed body, the union of overlapping ones. Raises SolidError when it is not one."""
    reach = max(float(np.abs(mesh.vertices).max()) for mesh in meshes)
    scale = _scale(reach)
    solid = manifold3d.Manifold.batch_boolean(
        [_manifold(mesh, scale) for mesh in meshes], manifold3d.OpType.Add
    )
    if solid.status() != manifold3d.Error.NoError or len(solid.decompose()) != 1:
        raise SolidError(
            f"the union of body and legs is not one body: {solid.status().name}, "
            f"{len(solid.decompose())} bodies"
        )
    return _mesh(solid, scale)


def _manifold(mesh: Mesh, scale: float) -> manifold3d.Manifold:
    return manifold3d.Manifold(
        manifold3d.Mesh64(scale * mesh.vertices, mesh.triangles.astype(np.uint64))
    )


def _mesh(solid: manifold3d.Manifold, scale: float) -> Mesh:
    raw = solid.to_mesh64()
    vertices = np.asarray(raw.vert_properties, dtype=np.float64)[:, :3] / scale
    return Mesh(vertices, np.asarray(raw.tri_verts, dtype=np.int64))


def _scale(reach: float) -> float:
    """Power of two that brings lengths up to `reach` to about 2^30 units."""
    return 2.0 ** (30 - math.frexp(reach)[1])


def outline(design: Design, foot_segments: int = FOOT_SEGMENTS) -> Outline:
    """Polygons whose union, with each limb at its anchor, is the walker seen from the side."""
    # Legs reach into the body, so that the parts of the union overlap rather than touch.
    embedding = 0.25 * design.size.thickness
    limbs = tuple(
        tuple(profiles.raised(part, embedding) for part in profiles.limb(limb, foot_segments))
        for limb in design.limbs
    )
    return Outline(_body_profile(design), limbs)


def weigh(design: Design, solids: Solids) -> MassProperties:
    """Mass properties of a walker from its solids. Raises GeometryError when it cannot stand."""
    return assemble(design, solids.body, solids.legs)


def mass_of(design: Design) -> MassProperties:
    """Mass properties of a design's own solids. Raises SolidError."""
    return weigh(design, build(design))


def has_window(limb: Limb) -> bool:
    """True when there is air between a braced leg and its brace, as at all but small tilts."""
    return window_width(limb) > NARROWEST_WINDOW * limb.length


def window_width(limb: Limb) -> float:
    """Width of the air between a braced leg and its brace along the body's bottom face, mm.

    There it is widest; it is negative where leg and brace overlap, and 0 for flexible legs.
    """
    if not limb.braced:
        return 0.0
    return abs(limb.brace_offset) - (limb.half_width + 0.5 * limb.brace)


def clearance(limbs: Sequence[Limb]) -> float:
    """Least distance along the run between two legs (or their braces) that stand in line, mm."""
    apart = [math.inf]
    for one, other in itertools.combinations(limbs, 2):
        back, front = sorted((one, other), key=lambda limb: limb.along)
        if abs(one.across - other.across) >= 0.5 * (one.width + other.width):
            continue
        spacing = front.along - back.along
        if back.tilt == front.tilt:
            apart.append(spacing - (back.half_width + front.half_width))
        else:
            apart.append(min(spacing, front.anchor[0] - back.anchor[0])
                         - (back.half_width + front.half_width))  # fmt: skip
        for limb in (back, front):
            if limb.braced:
                crossing = abs(limb.brace_offset) + limb.half_width + 0.5 * limb.brace
                apart.append(spacing - crossing)
    return min(apart)


def bodies(mesh: Mesh) -> int:
    """Number of closed bodies of a mesh once its coordinates are 32-bit floats, as in a file.

    Zero when it is not closed and oriented, or encloses nothing. Vertices that coincide are merged.
    """
    rounded = mesh.vertices.astype(np.float32)
    vertices, index = np.unique(rounded, axis=0, return_inverse=True)
    triangles = index.reshape(-1)[mesh.triangles].astype(np.uint32)
    solid = manifold3d.Manifold(manifold3d.Mesh(vertices, triangles))
    if solid.status() != manifold3d.Error.NoError or solid.volume() <= 0.0:
        return 0
    return len(solid.decompose())


def to_trimesh(mesh: Mesh) -> "trimesh.Trimesh":
    """Convert a mesh to trimesh's object; vertices and their order stay as they are."""
    import trimesh

    return trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)


def _body_profile(design: Design) -> Polygon:
    """Profile of the body with the notches in its upper edge, counter-clockwise."""
    length, thickness = design.size.length, design.size.thickness
    x, y = 0.5 * length, 0.5 * thickness
    edge = [
        corner
        for notch in marks.notches(
            design.marks, design.family.tilt_deg, design.tilt_deg, length, thickness
        )
        for corner in (
            (notch.right, y), (notch.right, notch.bottom), (notch.left, notch.bottom),
            (notch.left, y),
        )
    ]  # fmt: skip
    return np.array([(-x, -y), (x, -y), (x, y), *edge, (-x, y)])


def _digit_profiles(design: Design) -> list[Polygon]:
    strokes = marks.strokes(design.marks, design.tilt_deg, design.size.thickness)
    return [
        np.array([(s.left, s.bottom), (s.right, s.bottom), (s.right, s.top), (s.left, s.top)])
        for s in strokes
    ]


def _extrude(
    profiles: Sequence[Polygon], depth: float, windows: int | None, engraving: Engraving
) -> Mesh:
    """Extrude the union of profiles to z = 0..depth; `windows` is the expected genus, if known.

    manifold3d's 2D booleans snap to a grid of 1e-8 units. A power of two brings the profile to a
    size of about 2^30 units first and back afterwards, both exact, which leaves 17 digits. Raises
    SolidError when the result is not one sound body with so many windows.
    """
    reach = max(float(np.abs(profile).max()) for profile in profiles)
    scale = _scale(max(reach, depth))
    section = manifold3d.CrossSection(
        [scale * profile for profile in profiles], manifold3d.FillRule.Positive
    )
    if windows == 0:
        section = _without_slivers(section)
    solid = manifold3d.Manifold.extrude(section, scale * depth)
    if solid.status() != manifold3d.Error.NoError or solid.is_empty():
        raise SolidError(f"the solid modeller gave no body: {solid.status().name}")
    # k bodies with h holes have k + h contours and genus 1 - k + h: equal holes mean one body.
    genus, holes = solid.genus(), section.num_contour() - 1
    if genus != holes or (windows is not None and genus != windows):
        raise SolidError(
            f"the solid is not one body with {windows} windows: genus {genus}, {holes} holes"
        )
    if engraving.profiles:
        solid = _engraved(solid, engraving, depth, scale)
    return _mesh(solid, scale)


def _without_slivers(section: manifold3d.CrossSection) -> manifold3d.CrossSection:
    """Fill the slivers of windows narrower than NARROWEST_WINDOW in a profile without windows.

    Raises SolidError when a hole is larger than that.
    """
    least = NARROWEST_WINDOW * section.area()
    outlines = [polygon for polygon in section.to_polygons() if _signed_area(polygon) > least]
    filled = manifold3d.CrossSection(outlines)
    if filled.area() - section.area() > least:
        raise SolidError("the solid has a window that the design has not")
    return filled


def _signed_area(polygon: Polygon) -> float:
    """Area enclosed by a polygon; negative for a hole."""
    following = np.roll(polygon, -1, axis=0)
    return 0.5 * float((polygon[:, 0] * following[:, 1] - polygon[:, 1] * following[:, 0]).sum())


def _engraved(
    solid: manifold3d.Manifold, engraving: Engraving, depth: float, scale: float
) -> manifold3d.Manifold:
    """Cut pockets into a scaled solid's upper side; they overshoot it, so that no sides touch."""
    section = manifold3d.CrossSection(
        [scale * profile for profile in engraving.profiles], manifold3d.FillRule.Positive
    )
    tool = manifold3d.Manifold.extrude(section, scale * 2.0 * engraving.depth)
    cut = solid - tool.translate((0.0, 0.0, scale * (depth - engraving.depth)))
    # A pocket, with or without islands, leaves one body and opens no window.
    if cut.status() != manifold3d.Error.NoError or cut.genus() != solid.genus():
        raise SolidError(
            f"the digits do not stay pockets: {cut.status().name}, genus {cut.genus()} "
            f"after {solid.genus()}"
        )
    return cut
