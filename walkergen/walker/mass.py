"""Mass properties: from closed triangle meshes to M, J, m, j and the walker's vectors.

A mesh is weighed by the divergence theorem about a local origin (the middle of its bounding box),
so that a part far from the coordinates' origin loses no digits to it. Frame: x along the run,
y up, z along the extrusion; O is the centre of mass of the body.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.walker.design import Design

Array = npt.NDArray[np.float64]
Values = float | Array


class Mesh(NamedTuple):
    """Closed triangle mesh, with triangles counter-clockwise seen from outside."""

    vertices: Array
    """Coordinates of the corners, shape (n, 3), mm."""
    triangles: npt.NDArray[np.int64]
    """Corners of the triangles as indices into the vertices, shape (k, 3)."""


class SolidMass(NamedTuple):
    """Mass properties of one solid of uniform density."""

    mass: float
    """Mass, g."""
    centre: Array
    """Centre of mass, shape (3,), mm."""
    tensor: Array
    """Inertia tensor about the centre of mass, shape (3, 3), g mm^2."""
    volume: float
    """Volume, mm^3."""

    @property
    def inertia(self) -> float:
        """Moment of inertia about the z axis through the centre of mass, g mm^2."""
        return float(self.tensor[2, 2])


class Spatial(NamedTuple):
    """What the mass properties of a plane leave out: the third dimension, for motion in space."""

    z: float
    """Place of O across the run, from the middle of the walker's depth, mm."""
    body: Array
    """Inertia tensor about O of what M counts, shape (3, 3), g mm^2."""
    leg: Array
    """Inertia tensor of one leg about its own centre of mass, shape (3, 3); zero when braced."""


class MassProperties(NamedTuple):
    """Masses, moments of inertia and vectors of a walker (paper, figure 1); vectors (2,), mm, x-y.

    Flexible legs: M, J, O belong to the body alone and m, j to one leg. Braced: M, J, O belong to
    the whole solid and m = j = 0. The foot lies at O + a + c_A + c_T (back), O + b + c_A + c_T
    (front). Every field may carry leading batch axes.
    """

    M: Values
    """Mass of the body, g."""
    J: Values
    """Moment of inertia of the body about O, g mm^2."""
    m: Values
    """Mass of one leg, g; 0 when braced."""
    j: Values
    """Moment of inertia of a leg about its own centre of mass, g mm^2; 0 when braced."""
    a: Array
    """Vector from O to the anchor of the back leg."""
    b: Array
    """Vector from O to the anchor of the front leg."""
    c_A: Array
    """Vector from the anchor to the centre of mass of a leg."""
    c_T: Array
    """Vector from a leg's centre of mass to its foot (the point that touches the plate)."""
    rigid: bool
    """True when the legs are braced."""
    spatial: Spatial | None = None
    """Mass properties across the run; None when unknown, which only motion in space minds."""


def weigh(mesh: Mesh, density: float) -> SolidMass:
    """Weigh a closed mesh: mass (g), centre (mm), inertia tensor (g mm^2); density in g/mm^3.

    Exact for polyhedra up to rounding. Source: the divergence theorem summed over the tetrahedra
    between the local origin and each triangle.
    """
    origin = 0.5 * (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0))
    corners = (mesh.vertices - origin)[mesh.triangles]
    x, y, z = corners.transpose(2, 1, 0)
    six_volumes = (
        x[0] * (y[1] * z[2] - z[1] * y[2])
        + y[0] * (z[1] * x[2] - x[1] * z[2])
        + z[0] * (x[1] * y[2] - y[1] * x[2])
    )
    volume = six_volumes.sum() / 6.0
    total = corners.sum(axis=1)
    centre = (six_volumes[:, None] * total).sum(axis=0) / (24.0 * volume)
    # Integral of r r^T over a tetrahedron with one corner at the origin
    second = np.einsum("k,kai,kaj->ij", six_volumes, corners, corners)
    second += np.einsum("k,ki,kj->ij", six_volumes, total, total)
    second = second / 120.0 - volume * np.outer(centre, centre)
    tensor = density * (np.trace(second) * np.eye(3) - second)
    return SolidMass(density * volume, origin + centre, tensor, volume)


def assemble(design: Design, body: Mesh, leg: Mesh) -> MassProperties:
    """Mass properties of a walker from the meshes of its body and of one leg outside the body.

    The body's mesh lies in the design's frame, the leg's has its anchor at the origin; a braced
    leg's mesh includes its brace. Weighed masses in the design override the meshes' and rescale
    the inertias with them: the shape is trusted, the density is not.
    """
    density = 1e-3 * design.material.density_g_cm3
    top = _rescaled(weigh(body, density), design.weighed.body_mass_g)
    limb = _rescaled(weigh(leg, density), design.weighed.leg_mass_g)
    O, c_A = top.centre[:2], limb.centre[:2]  # noqa: E741  (the paper's name)
    anchors, foot = np.array(design.anchors), np.array(design.anchor_to_foot)
    a, b = anchors - O
    across = float(top.centre[2]) - 0.5 * design.body.depth_mm
    loose = MassProperties(
        top.mass, top.inertia, limb.mass, limb.inertia, a, b, c_A, foot - c_A, rigid=False,
        spatial=Spatial(across, top.tensor, limb.tensor),
    )  # fmt: skip
    return as_rigid(loose) if design.braced else loose


def as_rigid(mass: MassProperties) -> MassProperties:
    """Mass properties with the joints frozen: body and both legs as one rigid solid."""
    if mass.rigid:
        return mass
    masses = np.array([mass.M, mass.m, mass.m])
    centres = np.array([(0.0, 0.0), mass.a + mass.c_A, mass.b + mass.c_A])
    M = float(masses.sum())
    O = masses @ centres / M  # noqa: E741  (the paper's name)
    J = mass.J + 2 * mass.j + float(masses @ np.sum((centres - O) ** 2, axis=1))
    whole = None
    if mass.spatial is not None:
        middle, tensor = joined(mass.spatial, masses, centres)
        whole = Spatial(float(middle[2]), tensor, np.zeros((3, 3)))
    return mass._replace(
        M=M, J=J, m=0.0, j=0.0, a=mass.a - O, b=mass.b - O, rigid=True, spatial=whole
    )


def scaled(mass: MassProperties, body: Values, leg: Values) -> MassProperties:
    """Mass properties with the body's and a leg's masses and inertias times ratios, any shape."""
    whole, (body, leg) = mass.spatial, (np.asarray(body), np.asarray(leg))
    if whole is not None:
        sides = (..., None, None)
        whole = whole._replace(body=whole.body * body[sides], leg=whole.leg * leg[sides])
    return mass._replace(
        M=mass.M * body, J=mass.J * body, m=mass.m * leg, j=mass.j * leg, spatial=whole
    )


def joined(parts: Spatial, masses: Array, centres: Array) -> tuple[Array, Array]:
    """Centre of mass (mm, from O at half depth) and inertia tensor about it (g mm^2) of the whole.

    Masses of body and both legs, shape (3,), g; their centres from O, shape (3, 2), mm.
    """
    places = np.column_stack([centres, (parts.z, 0.0, 0.0)])
    middle = masses @ places / masses.sum()
    tensor = parts.body + 2.0 * parts.leg
    for mass, place in zip(masses, places - middle, strict=True):
        tensor = tensor + mass * (place @ place * np.eye(3) - np.outer(place, place))
    return middle, tensor


def _rescaled(part: SolidMass, weighed_mass: float | None) -> SolidMass:
    if weighed_mass is None:
        return part
    return part._replace(mass=weighed_mass, tensor=part.tensor * weighed_mass / part.mass)
