"""Solids: from a design to closed meshes, by 2D profiles and one extrusion in manifold3d.

The profile lies in the x-y plane and is extruded along z by the body's depth, which is also how
the part is printed: lying on its side.
"""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import manifold3d
import numpy as np
import numpy.typing as npt

from walkergen.design import Design
from walkergen.errors import SolidError
from walkergen.mass import MassProperties, Mesh, assemble

if TYPE_CHECKING:
    import trimesh

FOOT_SEGMENTS = 64
"""Edges of a round foot's half circle: the polygon's foot is 2 % of a micrometre too small."""

Polygon = npt.NDArray[np.float64]


class Solids(NamedTuple):
    """The meshes of one walker."""

    walker: Mesh
    """The printable union, in the design's frame: one closed body."""
    body: Mesh
    """The body alone, in the same frame."""
    leg: Mesh
    """One leg outside the body, with its brace if it has one; its anchor at the origin."""


class Outline(NamedTuple):
    """The polygons of a walker's profile, counter-clockwise, shape (n, 2), mm."""

    body: Polygon
    """In the design's frame."""
    limb: tuple[Polygon, ...]
    """One leg, and its brace if it has one, reaching into the body; its anchor at the origin."""


def build(design: Design, foot_segments: int = FOOT_SEGMENTS) -> Solids:
    """Build a walker's solids. Raises SolidError when the modeller's result is not sound."""
    body, raised = outline(design, foot_segments)
    legs = [part + np.array(anchor) for anchor in design.anchors for part in raised]
    windows = 2 * has_window(design)
    depth = design.body.depth_mm
    return Solids(
        _extrude([body, *legs], depth, windows),
        _extrude([body], depth, 0),
        _extrude(_limb(design, foot_segments), depth, None),
    )


def outline(design: Design, foot_segments: int = FOOT_SEGMENTS) -> Outline:
    """The profile whose union, both limbs at their anchors, is extruded."""
    # In the union legs reach into the body, so that the parts overlap rather than touch.
    embedding = 0.25 * design.body.thickness_mm
    limb = tuple(_raised(part, embedding) for part in _limb(design, foot_segments))
    return Outline(_body_profile(design), limb)


def weigh(design: Design, solids: Solids) -> MassProperties:
    """Mass properties of a walker from its solids."""
    return assemble(design, solids.body, solids.leg)


def has_window(design: Design) -> bool:
    """True when there is air between a braced leg and its brace (not at small tilt)."""
    if not design.braced:
        return False
    half_width = 0.5 * design.leg_thickness / math.cos(design.tilt)
    return abs(design.brace_offset) > half_width + 0.5 * design.legs.brace_thickness_mm


def to_trimesh(mesh: Mesh) -> "trimesh.Trimesh":
    """The mesh as trimesh's object, vertices and order untouched."""
    import trimesh

    return trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)


def _body_profile(design: Design) -> Polygon:
    x, y = 0.5 * design.body.length_mm, 0.5 * design.body.thickness_mm
    return np.array([(-x, -y), (x, -y), (x, y), (-x, y)])


def _limb(design: Design, foot_segments: int) -> list[Polygon]:
    leg = _leg_profile(design, foot_segments)
    return [leg, _brace_profile(design)] if design.braced else [leg]


def _leg_profile(design: Design, foot_segments: int) -> Polygon:
    """One leg below the bottom face (y <= 0), its anchor at the origin; counter-clockwise."""
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
    """The vertical support from the foot up to the bottom face, in the leg's frame."""
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


def _extrude(profiles: Sequence[Polygon], depth: float, windows: int | None) -> Mesh:
    """Union of profiles, extruded to z = 0..depth; `windows` is the genus to be found, if known.

    manifold3d's 2D booleans snap to a grid of 1e-8 units. A power of two brings the profile to a
    size of about 2^30 units first and back afterwards, both exact, which leaves 17 digits.
    """
    reach = max(float(np.abs(profile).max()) for profile in profiles)
    scale = 2.0 ** (30 - math.frexp(max(reach, depth))[1])
    section = manifold3d.CrossSection(
        [scale * profile for profile in profiles], manifold3d.FillRule.Positive
    )
    solid = manifold3d.Manifold.extrude(section, scale * depth)
    if solid.status() != manifold3d.Error.NoError or solid.is_empty():
        raise SolidError(f"the solid modeller gave no body: {solid.status().name}")
    # k bodies with h holes have k + h contours and genus 1 - k + h: equal holes mean one body.
    genus, holes = solid.genus(), section.num_contour() - 1
    if genus != holes or (windows is not None and genus != windows):
        raise SolidError(
            f"the solid is not one body with {windows} windows: genus {genus}, {holes} holes"
        )
    raw = solid.to_mesh64()
    vertices = np.asarray(raw.vert_properties, dtype=np.float64)[:, :3] / scale
    return Mesh(vertices, np.asarray(raw.tri_verts, dtype=np.int64))
