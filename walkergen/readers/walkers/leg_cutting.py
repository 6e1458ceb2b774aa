"""A finished walker from elsewhere: cut at a height into its body and its legs.

Everything below the cut is legs, a closed piece each. The section at the cut gives a leg's anchor,
thickness and width; its lowest points give the foot. A leg with several struts at the cut, such as
a leg and its brace, is measured at the largest of them.
"""

import math
from typing import NamedTuple

import manifold3d
import numpy as np

from walkergen.core.errors import GeometryError
from walkergen.core.numerics import Array
from walkergen.core.shapes import modeller
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker.limbs import Kind, Legs, Limb

FOOT_TOLERANCE_MM = 1e-3
"""Maximum height of points that touch the plate above a leg's lowest point, mm: a micrometre."""

MAX_LEGS = 100

DECIMALS = 5
"""Decimals of measured lengths, mm: files keep 32-bit floats."""

MIN_STRUT_SHARE = 1e-6
"""Area of a strut's section over the largest of a leg, below which it is rounding."""


class CutLeg(NamedTuple):
    """Leg of a finished walker, measured; places in the mesh's frame, mm."""

    mesh: Mesh
    """Part below the cut, closed."""
    anchor: Array
    """Middle (centroid) of the section at the cut, shape (3,)."""
    foot: Array
    """Middle in x and z of the lowest points, within FOOT_TOLERANCE_MM, shape (3,)."""
    tilt: float
    """Angle of the line from anchor to foot from the vertical in the x-y plane, rad; positive when
    the foot lies behind the anchor."""
    length: float
    """Distance from anchor to foot in the x-y plane, mm."""
    thickness: float
    """Extent of the section along x times the tilt's cosine: across the leg, mm."""
    width: float
    """Extent of the section along z, mm."""
    z: float
    """Middle of the section along z, mm."""
    struts: int
    """Number of separate sections at the cut: 2 for a leg and its brace with air between."""


class CutWalker(NamedTuple):
    """Finished walker, cut."""

    body: Mesh
    legs: tuple[CutLeg, ...]
    """Legs from back to front. Legs side by side are in the order of their z."""
    mesh: Mesh
    """Walker before the cut."""

    def limbs(self, kind: Kind, depth: float) -> tuple[Limb, ...]:
        """Return the legs as limbs of a design, all of this kind. `depth`: of the body, mm. Raises GeometryError."""
        return tuple(_to_limb(leg, kind, number, depth) for number, leg in enumerate(self.legs, start=1))


def cut_legs(mesh: Mesh, below_mm: float, key: str = "walker.legs_below_mm") -> CutWalker:
    """Cut a sound walker (y up) at a height above its lowest point into body and legs.

    Raises GeometryError, beginning with `key`, when the height is outside of the walker, the body
    would fall apart, or there are more than MAX_LEGS pieces below.
    """
    bottom, top = float(mesh.vertices[:, 1].min()), float(mesh.vertices[:, 1].max())
    if not 0.0 < below_mm < top - bottom:
        raise GeometryError(f"{key} = {below_mm:g}: must lie in 0..{top - bottom:.4g} mm, the walker's height")
    height = bottom + below_mm
    upper, lower = modeller.to_solid(mesh).split_by_plane((0.0, 1.0, 0.0), height)
    tops, pieces = (modeller.split_bodies(modeller.check_solid(half)) for half in (upper, lower))
    if len(tops) != 1:
        raise GeometryError(
            f"{key} = {below_mm:g}: above it are {len(tops)} pieces, must be one body; cut lower or higher"
        )
    if not 0 < len(pieces) <= MAX_LEGS:
        raise GeometryError(
            f"{key} = {below_mm:g}: below it are {len(pieces)} pieces, must be 1..{MAX_LEGS} legs; cut elsewhere"
        )
    legs = [_measure_leg(piece, height, f"{key} = {below_mm:g}") for piece in pieces]
    ordered = sorted(legs, key=lambda leg: (round(float(leg.anchor[0]), 6), leg.z))
    return CutWalker(modeller.to_mesh(tops[0]), tuple(ordered), mesh)


def centre_on_body(cut: CutWalker) -> CutWalker:
    """Return the walker moved into the design's frame: x and y from the middle of its body's box, z from 0 on."""
    low, high = cut.body.vertices.min(axis=0), cut.body.vertices.max(axis=0)
    shift = -0.5 * (low + high)
    shift[2] = -low[2]
    return CutWalker(
        cut.body.shift(shift),
        tuple(
            leg._replace(
                mesh=leg.mesh.shift(shift), anchor=leg.anchor + shift, foot=leg.foot + shift, z=leg.z + float(shift[2])
            )
            for leg in cut.legs
        ),
        cut.mesh.shift(shift),
    )


def _to_limb(leg: CutLeg, kind: Kind, number: int, depth: float) -> Limb:
    """Convert a leg of a finished walker, whose body is `depth` mm deep, to a Limb. Its foot counts as flat.

    Raises GeometryError for a leg with a brace that is declared flexible.
    """
    if leg.struts > 1 and kind == "flexible":
        raise GeometryError(
            f"walker.legs = 'flexible': leg {number} meets the cut in {leg.struts} places, as a "
            "leg with a brace does: say legs = 'braced', or cut it lower"
        )
    plain = Legs(kind=kind)
    return Limb(
        kind,
        leg.tilt,
        round(leg.length, DECIMALS),
        round(leg.thickness, DECIMALS),
        plain.thickness_sd_mm,
        plain.brace_thickness_mm,
        "flat",
        round(float(leg.foot[0]), DECIMALS),
        round(leg.z - 0.5 * depth, DECIMALS),
        round(leg.width, DECIMALS),
        bottom=float(leg.anchor[1]),
        embedding=0.0,
        friction=None,
        restitution=None,
    )


def _measure_leg(piece: manifold3d.Manifold, height: float, source: str) -> CutLeg:
    """Measure the leg that is a piece below the cut at `height`, mm. Raises GeometryError, beginning with `source`."""
    mesh = modeller.to_mesh(piece)
    struts = _find_struts(mesh, height)
    if not struts:
        raise GeometryError(f"{source}: a piece below it has no section there; cut elsewhere")
    points, anchor = struts[0]
    extent = points.max(axis=0) - points.min(axis=0)
    foot = _find_foot(mesh)
    dx, dy = anchor[0] - foot[0], anchor[1] - foot[1]
    tilt = math.atan2(dx, dy)
    return CutLeg(
        mesh,
        anchor,
        foot,
        tilt,
        math.hypot(dx, dy),
        float(extent[0]) * math.cos(tilt),
        float(extent[2]),
        float(0.5 * (points[:, 2].max() + points[:, 2].min())),
        len(struts),
    )


def _find_foot(mesh: Mesh) -> Array:
    """Return the foot of a leg, shape (3,), mm: the middle of its lowest points in x and z, and their least y."""
    lowest = float(mesh.vertices[:, 1].min())
    touching = mesh.vertices[mesh.vertices[:, 1] <= lowest + FOOT_TOLERANCE_MM]
    foot: Array = 0.5 * (touching.min(axis=0) + touching.max(axis=0))
    foot[1] = lowest
    return foot


def _find_struts(mesh: Mesh, height: float) -> list[tuple[Array, Array]]:
    """Return the corners, shape (n, 3), and centroid, shape (3,), of every section at a height, largest first.

    The sections are the flat faces that the cut has left at the top of a leg.
    """
    from scipy.sparse import coo_matrix, csgraph

    slack = 1e-9 * max(1.0, float(np.abs(mesh.vertices).max()))
    top = np.abs(mesh.vertices[:, 1] - height) <= slack
    lids = mesh.triangles[top[mesh.triangles].all(axis=1)]
    links = np.ones(2 * len(lids), np.int8), (lids[:, :2].reshape(-1), lids[:, 1:].reshape(-1))
    size = (len(mesh.vertices), len(mesh.vertices))
    _, label = csgraph.connected_components(coo_matrix(links, size), directed=False)
    corners = mesh.vertices[lids]
    areas = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 1]
    struts = []
    for strut in np.unique(label[lids[:, 0]]):
        is_strut = label[lids[:, 0]] == strut
        area = float(areas[is_strut].sum())
        if area > 0.0:
            centroid = areas[is_strut] @ corners[is_strut].mean(axis=1) / area
            struts.append((area, corners[is_strut].reshape(-1, 3), centroid))
    struts.sort(key=lambda strut: -strut[0])
    return [(points, middle) for area, points, middle in struts if area > MIN_STRUT_SHARE * struts[0][0]]
