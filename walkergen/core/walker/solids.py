"""Solids of walkers: closed meshes of a design, built by extruding 2D profiles in manifold3d.

The profile lies in the x-y plane and is extruded along z by the body's depth, which is also how
the part is printed: lying on its side. Notches belong to the profile; digits are engraved into the
side that prints last, by a second, shallow extrusion taken from the first.
"""

import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from walkergen.core.errors import GeometryError
from walkergen.core.numerics import Array
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.shapes.modeller import MIN_WINDOW_RATIO, Engraving, extrude
from walkergen.core.walker import mass
from walkergen.core.walker.body import FinishedWalker
from walkergen.core.walker.design import Design
from walkergen.core.walker.limbs import Limb, Polygon
from walkergen.core.walker.mass import LegMass, MassProperties, SolidMass, Spatial
from walkergen.core.walker.resolve import load_readers
from walkergen.core.walker.sections import section_of, window_width

if TYPE_CHECKING:
    from walkergen.core.shapes import joining

FOOT_SEGMENTS = 64
"""Edges of a round foot's half circle: the polygon's foot is 2 % of a micrometre too small."""

ROUNDING_MM = 1e-9
"""Largest error, mm, of the modeller's heights."""


class Solids(NamedTuple):
    """Meshes of one walker."""

    walker: Mesh
    """Printable union of body and legs, in the design's frame: one closed body."""
    body: Mesh
    """Body alone, in the design's frame."""
    legs: tuple[Mesh, ...]
    """Each leg outside the body, with its brace if it has one, in the order of `Design.limbs`; its
    anchor at the origin of x and y, z from 0 to its width."""
    cap: Mesh | None = None
    """Cap on the body, in the design's frame, which prints apart; None without."""
    weighed: SolidMass | None = None
    """Mass of the body at 1 g/mm^3, if it is already known."""

    @property
    def walker_with_cap(self) -> Mesh:
        """Mesh of the walker with its cap, which is not one closed body."""
        return self.walker if self.cap is None else _concatenate_meshes([self.walker, self.cap])


class SideView(NamedTuple):
    """Polygons of a walker seen from the side, counter-clockwise, shape (n, 2), mm."""

    body: Polygon
    """Profile of the body, in the design's frame."""
    limbs: tuple[tuple[Polygon, ...], ...]
    """Each leg, and its brace if it has one, reaching into the body; its anchor at the origin."""


def _concatenate_meshes(meshes: Sequence[Mesh]) -> Mesh:
    """Return one mesh with all vertices and triangles of several meshes, which may overlap."""
    starts = itertools.accumulate([0, *(len(mesh.vertices) for mesh in meshes)])
    triangles = [mesh.triangles + start for mesh, start in zip(meshes, starts, strict=False)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(triangles))


def build(design: Design, foot_segments: int = FOOT_SEGMENTS, united: bool = True) -> Solids:
    """Build the solids of a walker: its printable union, its body, its legs and its cap.

    Parameters
    ----------
    design : Design
        Design of the walker.
    foot_segments : int, default: 64
        Edges of a round foot's half circle.
    united : bool, default: True
        Whether body and legs are united. Otherwise a body of any shape may stay separate from its legs, for display.

    Returns
    -------
    Solids
        Meshes in mm: those of legs with their anchor at the origin, the others in the design's frame.

    Raises
    ------
    SolidError
        If the result of the modeller is not sound.
    GeometryError
        If a leg does not meet the body, or pockets or a cap do not fit it.

    Examples
    --------
    >>> from walkergen.core import Design, build
    >>> solids = build(Design())
    >>> len(solids.legs), solids.walker.vertices.shape[1]
    (2, 3)
    """
    solid = _build_plain_solids(design, foot_segments, united or bool(design.parts))
    solid = _add_pockets(design, solid, foot_segments) if design.parts else solid
    return solid._replace(cap=_build_cap(design, solid.body))


def _build_cap(design: Design, body: Mesh) -> Mesh | None:
    """Build the cap of a body, or return None without a cap. Raises GeometryError."""
    if design.cap is None:
        return None
    return load_readers().place_on_body(design.cap, body, design.size.depth)


def _add_pockets(design: Design, solid: Solids, foot_segments: int) -> Solids:
    """Return a walker's solids with the pockets for its motor and battery cut into them. The marks must stay whole.

    `foot_segments`: edges of a round foot's half circle. Raises GeometryError.
    """
    from walkergen.core.walker import pockets

    if design.is_complete_mesh:
        roots = [
            leg.shift(_anchor_corner(limb, design.size.depth))
            for limb, leg in zip(design.limbs, solid.legs, strict=True)
        ]
    else:
        roots = _build_bars(design.limbs, _leg_profiles(design.limbs, foot_segments), design.size.depth)
    walker, body = pockets.cut_pockets(design, solid.walker, solid.body, roots)
    if not design.marks.blank:
        pockets.check_marks_intact(
            design, solid.body, _build_plain_solids(design.unmarked, foot_segments, united=False).body
        )
    return solid._replace(walker=walker, body=body, weighed=None)


def _build_plain_solids(design: Design, foot_segments: int, united: bool) -> Solids:
    """Build the solids of a walker without pockets and cap. `foot_segments`: edges of a round foot's half circle.

    `Solids.walker` is the union of body and legs if `united`. Otherwise they may be separate pieces of it.
    """
    if design.shape.finished is not None:
        return _finished_solids(design.shape.finished, design)
    if not design.body.plain:
        return _build_any_body(design, foot_segments, united)
    body, depth, limbs = _body_profile(design), design.size.depth, design.limbs
    sections = _leg_profiles(limbs, foot_segments)
    digits = Engraving(_engraving_profiles(design), design.marks.depth_mm)
    top, legs = extrude([body], depth, windows=0, engraving=digits), _build_legs(limbs, sections)
    if all(limb.width == depth and limb.across == 0.0 for limb in limbs):
        windows = sum(has_window(limb) for limb in limbs)
        leg_profiles = [
            part + np.array(limb.anchor)
            for limb, section in zip(limbs, sections, strict=True)
            for part in section.raised
        ]
        return Solids(extrude([body, *leg_profiles], depth, windows, digits), top, legs)
    from walkergen.core.shapes import joining

    bars = _build_bars(limbs, sections, depth)
    return Solids(joining.unite_with_legs(joining.prepare_body(top), bars), top, legs)


def _finished_solids(finished: FinishedWalker, design: Design) -> Solids:
    """Return the solids of a user's mesh of a whole walker, each leg shifted so that its anchor is the origin.

    A leg that the design makes thicker than in the mesh is widened about the line from its anchor to its foot.
    """
    depth, legs = design.size.depth, []
    measured = finished.limbs(design.kind, depth)
    for limb, in_mesh, leg in zip(design.limbs, measured, finished.legs, strict=True):
        x, y, z = leg.shift(-_anchor_corner(limb, depth)).vertices.T
        x = x + (limb.thickness / in_mesh.thickness - 1.0) * (x - y * math.tan(limb.tilt))
        legs.append(leg._replace(vertices=np.column_stack([x, y, z])))
    return Solids(finished.mesh, finished.body, tuple(legs))


def _build_any_body(design: Design, foot_segments: int, united: bool) -> Solids:
    """Build the solids of a walker with a body of any shape, without pockets and cap.

    `foot_segments` and `united` are those of `_build_plain_solids`.
    """
    from walkergen.core.shapes import joining

    readers = load_readers()
    joined_body, limbs, depth = readers.prepare_body(design.body.cache_key), design.limbs, design.size.depth
    weighed = None if design.letters else readers.body_mass(design.body.cache_key)
    if design.letters:
        joined_body = joining.prepare_body(readers.cut_letters(joined_body.mesh, design))
    sections = _leg_profiles(limbs, foot_segments)
    bars = _build_bars(limbs, sections, depth)
    legs = _build_legs(limbs, sections) if design.body.flat else _build_flush_legs(limbs, bars, joined_body, depth)
    if united:
        return Solids(joining.unite_with_legs(joined_body, bars), joined_body.mesh, legs, weighed=weighed)
    shifted_legs = [leg.shift(_anchor_corner(limb, depth)) for limb, leg in zip(limbs, legs, strict=True)]
    return Solids(_concatenate_meshes([joined_body.mesh, *shifted_legs]), joined_body.mesh, legs, weighed=weighed)


def _build_flush_legs(
    limbs: Sequence[Limb], bars: Sequence[Mesh], body: "joining.Body", depth: float
) -> tuple[Mesh, ...]:
    """Return the parts of legs outside a body whose underside is not flat, cut where they enter it.

    `bars` are meshes of the legs that reach into the body, which is `depth` mm deep. Each result has its anchor at the
    origin. Raises GeometryError.
    """
    from walkergen.core.shapes import joining

    legs = []
    for number, (limb, bar) in enumerate(zip(limbs, bars, strict=True), start=1):
        key = f"legs[{number}].along_mm = {limb.along:g}"
        outside = joining.cut_flush(bar, body, key)
        if outside.vertices[:, 1].max() > bar.vertices[:, 1].max() - ROUNDING_MM:
            raise GeometryError(f"{key}: a part of the leg is not under the body. Move it.", f"legs[{number}].along_mm")
        legs.append(outside.shift(-_anchor_corner(limb, depth)))
    return tuple(legs)


class _LegProfiles(NamedTuple):
    """Side views of a leg, and of its brace if it has one, shape (n, 2), mm, with the anchor at the origin."""

    below: Sequence[Polygon]
    """Their parts below the underside of the body."""
    raised: tuple[Polygon, ...]
    """The same, extended upward into the body."""


def _leg_profiles(limbs: Sequence[Limb], foot_segments: int) -> list[_LegProfiles]:
    """Return the side views of legs; round feet have `foot_segments` edges. Legs of equal shape share one object."""
    by_shape: dict[Limb, _LegProfiles] = {}
    sections = []
    for limb in limbs:
        shape = limb._replace(along=0.0, across=0.0, bottom=0.0, friction=None, restitution=None)
        if shape not in by_shape:
            below = section_of(limb).profile(limb, foot_segments)
            raised = tuple(_extend_into_body(part, limb.embedding) for part in below)
            by_shape[shape] = _LegProfiles(below, raised)
        sections.append(by_shape[shape])
    return sections


def _extend_into_body(profile: Polygon, embedding: float) -> Polygon:
    """Extend a leg's profile, shape (n, 2), by `embedding` mm into the body. Its first and last points are on top."""
    left, right = profile[0], profile[-1]
    up = np.array([0.0, embedding])
    return np.concatenate([profile, [right + up, left + up]])


def _build_bars(limbs: Sequence[Limb], sections: Sequence[_LegProfiles], depth: float) -> list[Mesh]:
    """Build meshes of legs that reach into a body of this depth (mm), at their positions in the design's frame."""
    bars = []
    for limb, section in zip(limbs, sections, strict=True):
        mesh = extrude([part + np.array(limb.anchor) for part in section.raised], limb.width)
        bars.append(mesh.shift(np.array([0.0, 0.0, _left_side(limb, depth)])))
    return bars


def _build_legs(limbs: Sequence[Limb], sections: Sequence[_LegProfiles]) -> tuple[Mesh, ...]:
    """Build meshes of the legs outside the body, with their anchors at the origin. Equal legs share one mesh."""
    meshes: dict[int, Mesh] = {}
    for limb, section in zip(limbs, sections, strict=True):
        if id(section) not in meshes:
            meshes[id(section)] = extrude(section.below, limb.width)
    return tuple(meshes[id(section)] for section in sections)


def _anchor_corner(limb: Limb, depth: float) -> Array:
    """Return the position of a leg's anchor, at the leg's side of least z, shape (3,), mm."""
    return np.array([*limb.anchor, _left_side(limb, depth)])


def _left_side(limb: Limb, depth: float) -> float:
    """Return the least z of a leg, mm, on a body that extends from z = 0 to `depth` mm."""
    return 0.5 * depth + limb.across - 0.5 * limb.width


def is_printed_on_side(design: Design) -> bool:
    """Return whether a walker prints lying on its side: a prism in side view, all legs of which reach that side.

    All others print upside down with their legs up: legs narrower than the body would hang over the bed.
    """
    if not (design.body.plain or design.body.profile_mm is not None):
        return False
    depth = design.size.depth
    return all(_left_side(limb, depth) <= ROUNDING_MM for limb in design.limbs)


def orient_for_print(design: Design, mesh: Mesh) -> Mesh:
    """Return a walker's mesh turned as it prints, z up from 0: on its side, or upside down with its legs up.

    Upside down needs no supports while legs tilt by 45 deg at most and the body's upper side is flat.
    """
    if is_printed_on_side(design):
        return mesh
    x, y, z = mesh.vertices.T
    turned = np.column_stack([x, z, -y])
    turned[:, 2] -= turned[:, 2].min()
    return mesh._replace(vertices=turned)


def side_view(design: Design, foot_segments: int = FOOT_SEGMENTS) -> SideView:
    """Return the polygons of a walker's side view: its body, and each leg with its anchor at the origin.

    For a body that is no prism in side view its polygon is its box.
    """
    sections = _leg_profiles(design.limbs, foot_segments)
    return SideView(_body_profile(design), tuple(section.raised for section in sections))


def weigh(design: Design, solids: Solids) -> MassProperties:
    """Compute a walker's mass properties from its solids. Raises GeometryError when it cannot stand."""
    body = mass.weigh(solids.body, 1.0) if solids.weighed is None else solids.weighed
    return _assemble_and_check(design, body, solids.legs, solids.cap)


def mass_of(design: Design) -> MassProperties:
    """Build the solids of a design and compute the mass properties of the walker.

    Parameters
    ----------
    design : Design
        Design of the walker.

    Returns
    -------
    MassProperties
        Masses, g, and moments of inertia, g mm^2, of body and legs.

    Raises
    ------
    SolidError
        If a solid cannot be built.
    GeometryError
        If the walker cannot stand.

    Notes
    -----
    Every solid has the uniform density of the material. Masses from a balance in the design replace those of the
    solids.

    Examples
    --------
    >>> from walkergen.core import Design, mass_of
    >>> round(float(mass_of(Design()).total), 2)  # g
    0.89
    """
    if design.parts or not design.body.plain:
        return weigh(design, build(design, united=False))
    digits = Engraving(_engraving_profiles(design), design.marks.depth_mm)
    top = extrude([_body_profile(design)], design.size.depth, windows=0, engraving=digits)
    legs = _build_legs(design.limbs, _leg_profiles(design.limbs, FOOT_SEGMENTS))
    return _assemble_and_check(design, mass.weigh(top, 1.0), legs, _build_cap(design, top))


def _assemble_and_check(design: Design, body: SolidMass, legs: Sequence[Mesh], cap: Mesh | None) -> MassProperties:
    """Return the mass properties of body, legs and cap together. Raises GeometryError if the walker falls over."""
    whole = assemble(design, body, legs, cap)
    if not design.has_legs_table:
        mass.check_support(design.limbs, whole)
    return whole


def assemble(design: Design, body: SolidMass, legs: Sequence[Mesh], cap: Mesh | None = None) -> MassProperties:
    """Combine the body, weighed at 1 g/mm^3, and the meshes of legs outside it to the mass properties of a walker.

    The body lies in the design's frame. A leg's mesh has its anchor at the origin, and includes its brace. A cap
    belongs to the body. Weighed masses in the design replace those of the meshes, and the inertias change in
    proportion: the shape is trusted, the density is not.
    """
    density, limbs = 1e-3 * design.material.density_g_cm3, design.limbs
    whole = body.scale_density(density)
    if cap is not None and design.cap is not None:
        cap_mass = mass.weigh(cap, 1e-3 * design.cap.density(design.material.density_g_cm3))
        whole = mass.combine_solids([whole, cap_mass])
    top = mass.scale_to_weighed_mass(whole, design.weighed.body_mass_g)
    if design.parts:
        from walkergen.core.walker import pockets

        top = mass.combine_solids([top, *pockets.weigh_contents(design)])
    O = top.centre[:2]  # noqa: E741  (the paper's name)
    distinct = {id(mesh): mesh for mesh in legs}  # equal legs share theirs
    weighed_once = {key: mass.weigh(mesh, density) for key, mesh in distinct.items()}
    placed, meshed = [], [weighed_once[id(mesh)] for mesh in legs]
    mean = sum(part.mass for part in meshed) / len(meshed)
    prisms = design.body.plain or design.body.flat
    for limb, part in zip(limbs, meshed, strict=True):
        weighed = design.weighed.leg_mass_g
        leg_mass = mass.scale_to_weighed_mass(part, None if weighed is None else weighed * (part.mass / mean))
        c_A = leg_mass.centre[:2]
        # A prism's centre lies at its middle; that of a leg cut flush with a slope across need not
        offset_across = 0.0 if prisms else float(leg_mass.centre[2]) - 0.5 * limb.width
        placed.append(
            LegMass(
                leg_mass.mass,
                leg_mass.inertia,
                np.array(limb.anchor) - O,
                c_A,
                np.array(limb.anchor_to_foot) - c_A,
                limb.across + offset_across,
                leg_mass.tensor,
            )
        )
    across = float(top.centre[2]) - 0.5 * design.size.depth
    jointed = MassProperties(top.mass, top.inertia, tuple(placed), False, Spatial(across, top.tensor))
    return mass.freeze_joints(jointed, [limb.rigid for limb in limbs])


def has_window(limb: Limb) -> bool:
    """Return whether there is a gap between a leg and its brace. At small tilts, or without a brace, there is none."""
    return window_width(limb) > MIN_WINDOW_RATIO * limb.length


def _body_profile(design: Design) -> Polygon:
    """Return the side view of the body with its notches, or of its box, counter-clockwise, shape (n, 2), mm."""
    if design.body.profile_mm is not None:
        side = design.shape.side
        assert side is not None
        return side
    x, y = 0.5 * design.size.length, 0.5 * design.size.thickness
    corners = np.array([(-x, -y), (x, -y), (x, y), (-x, y)])
    if design.marks.blank:
        return corners
    return load_readers().add_notches(design, corners)


def _engraving_profiles(design: Design) -> list[Polygon]:
    """Return the outlines of the digits or text to engrave, shape (n, 2) each, mm from the body's middle, or []."""
    if design.marks.blank:
        return []
    return load_readers().engraved_profiles(design)
