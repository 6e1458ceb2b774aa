"""Solids: from a design to closed meshes, by 2D profiles and one extrusion in manifold3d.

The profile lies in the x-y plane and is extruded along z by the body's depth, which is also how
the part is printed: lying on its side. Notches belong to the profile; digits are engraved into the
side that prints last, by a second, shallow extrusion taken from the first.
"""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import manifold3d
import numpy as np
import numpy.typing as npt

from walkergen.errors import SolidError
from walkergen.walker import marks
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties, Mesh, assemble

if TYPE_CHECKING:
    import trimesh

FOOT_SEGMENTS = 64
"""Edges of a round foot's half circle: the polygon's foot is 2 % of a micrometre too small."""

NARROWEST_WINDOW = 1e-9
"""Width of a window between leg and brace, over the leg's length, below which it does not count:
such slivers (a hundred picometres) are lost, all or in part, to the rounding of coordinates."""

Polygon = npt.NDArray[np.float64]


class Solids(NamedTuple):
    """Meshes of one walker."""

    walker: Mesh
    """Printable union of body and legs, in the design's frame: one closed body."""
    body: Mesh
    """Body alone, in the design's frame."""
    leg: Mesh
    """One leg outside the body, with its brace if it has one; its anchor at the origin."""


class Engraving(NamedTuple):
    """Pockets cut into the upper flat side, z = the body's depth."""

    profiles: Sequence[Polygon]
    depth: float
    """Depth of the pockets, mm."""


class Outline(NamedTuple):
    """Polygons of a walker's profile, counter-clockwise, shape (n, 2), mm."""

    body: Polygon
    """Profile of the body, in the design's frame."""
    limb: tuple[Polygon, ...]
    """Leg, and its brace if it has one, reaching into the body; its anchor at the origin."""


def build(design: Design, foot_segments: int = FOOT_SEGMENTS) -> Solids:
    """Build a walker's solids. Raises SolidError when the modeller's result is not sound."""
    body, raised = outline(design, foot_segments)
    legs = [part + np.array(anchor) for anchor in design.anchors for part in raised]
    windows = 2 * has_window(design)
    depth = design.body.depth_mm
    digits = Engraving(_digit_profiles(design), design.marks.depth_mm)
    return Solids(
        _extrude([body, *legs], depth, windows, digits),
        _extrude([body], depth, 0, digits),
        _extrude(_limb(design, foot_segments), depth, None, Engraving([], 0.0)),
    )


def outline(design: Design, foot_segments: int = FOOT_SEGMENTS) -> Outline:
    """Polygons whose union, with a limb at each anchor, is the profile to extrude."""
    # Legs reach into the body, so that the parts of the union overlap rather than touch.
    embedding = 0.25 * design.body.thickness_mm
    limb = tuple(_raised(part, embedding) for part in _limb(design, foot_segments))
    return Outline(_body_profile(design), limb)


def weigh(design: Design, solids: Solids) -> MassProperties:
    """Mass properties of a walker from its solids."""
    return assemble(design, solids.body, solids.leg)


def mass_of(design: Design) -> MassProperties:
    """Mass properties of a design's own solids. Raises SolidError."""
    return weigh(design, build(design))


def has_window(design: Design) -> bool:
    """True when there is air between a braced leg and its brace, as at all but small tilts."""
    return window_width(design) > NARROWEST_WINDOW * design.legs.length_mm


def window_width(design: Design) -> float:
    """Width of the air between a braced leg and its brace along the body's bottom face, mm.

    There it is widest; it is negative where leg and brace overlap, and 0 for flexible legs.
    """
    if not design.braced:
        return 0.0
    half_width = 0.5 * design.leg_thickness / math.cos(design.tilt)
    return abs(design.brace_offset) - (half_width + 0.5 * design.legs.brace_thickness_mm)


def clearance(design: Design) -> float:
    """Least distance between the back leg and the front leg (or its brace), mm."""
    thickness = design.leg_thickness / math.cos(design.tilt)
    between_legs = design.legs.contact_spacing_mm - thickness
    if not design.braced:
        return between_legs
    half_brace = 0.5 * design.legs.brace_thickness_mm
    crossing = abs(design.brace_offset) + 0.5 * thickness + half_brace
    return min(between_legs, design.legs.contact_spacing_mm - crossing)


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
    length, thickness = design.body.length_mm, design.body.thickness_mm
    x, y = 0.5 * length, 0.5 * thickness
    edge = [
        corner
        for notch in marks.notches(
            design.marks, design.family.tilt_deg, design.legs.tilt_deg, length, thickness
        )
        for corner in (
            (notch.right, y), (notch.right, notch.bottom), (notch.left, notch.bottom),
            (notch.left, y),
        )
    ]  # fmt: skip
    return np.array([(-x, -y), (x, -y), (x, y), *edge, (-x, y)])


def _digit_profiles(design: Design) -> list[Polygon]:
    strokes = marks.strokes(design.marks, design.legs.tilt_deg, design.body.thickness_mm)
    return [
        np.array([(s.left, s.bottom), (s.right, s.bottom), (s.right, s.top), (s.left, s.top)])
        for s in strokes
    ]


def _limb(design: Design, foot_segments: int) -> list[Polygon]:
    leg = _leg_profile(design, foot_segments)
    return [leg, _brace_profile(design)] if design.braced else [leg]


def _leg_profile(design: Design, foot_segments: int) -> Polygon:
    """Profile of a leg below the bottom face (y <= 0), anchor at the origin, counter-clockwise."""
    sin, cos = math.sin(design.tilt), math.cos(design.tilt)
    half, length = 0.5 * design.leg_thickness, design.legs.length_mm
    along, across = np.array([-sin, -cos]), np.array([cos, -sin])
    top = np.array([half / cos, 0.0])
    if design.legs.foot == "round":
        centre = (length - half) * along
        foot = centre + half * _half_circle(design.tilt, foot_segments)
    elif design.legs.foot == "square":
        foot = np.array([length * along - half * across, length * along + half * across])
    else:
        foot = np.array([length * along - top, length * along + top])
    return np.vstack([-top, foot, top])


def _half_circle(tilt: float, segments: int) -> Polygon:
    """Unit half circle below a leg, counter-clockwise, a vertex exactly at its lowest point."""
    start, lowest, end = math.pi - tilt, 1.5 * math.pi, 2.0 * math.pi - tilt
    before = max(1, round(segments * (lowest - start) / math.pi))
    after = max(1, segments - before)
    angles = np.concatenate(
        [np.linspace(start, lowest, before + 1), np.linspace(lowest, end, after + 1)[1:]]
    )
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    circle[before] = (0.0, -1.0)
    return circle


def _brace_profile(design: Design) -> Polygon:
    """Profile of the vertical support from the foot to the bottom face, in the leg's frame."""
    legs = design.legs
    x, half = design.brace_offset, 0.5 * legs.brace_thickness_mm
    reach = legs.length_mm - (0.5 * design.leg_thickness if legs.foot == "round" else 0.0)
    y = -reach * math.cos(design.tilt)
    slope = math.tan(design.tilt) if legs.foot == "square" else 0.0
    left, right = (x - half, y + slope * half), (x + half, y - slope * half)
    return np.array([(x - half, 0.0), left, right, (x + half, 0.0)])


def _raised(profile: Polygon, embedding: float) -> Polygon:
    left, right = profile[0], profile[-1]
    up = np.array([0.0, embedding])
    return np.vstack([profile, right + up, left + up])


def _extrude(
    profiles: Sequence[Polygon], depth: float, windows: int | None, engraving: Engraving
) -> Mesh:
    """Extrude the union of profiles to z = 0..depth; `windows` is the expected genus, if known.

    manifold3d's 2D booleans snap to a grid of 1e-8 units. A power of two brings the profile to a
    size of about 2^30 units first and back afterwards, both exact, which leaves 17 digits. Raises
    SolidError when the result is not one sound body with so many windows.
    """
    reach = max(float(np.abs(profile).max()) for profile in profiles)
    scale = 2.0 ** (30 - math.frexp(max(reach, depth))[1])
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
    raw = solid.to_mesh64()
    vertices = np.asarray(raw.vert_properties, dtype=np.float64)[:, :3] / scale
    return Mesh(vertices, np.asarray(raw.tri_verts, dtype=np.int64))


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
