"""Mass properties of walkers: masses, moments of inertia and vectors (M, J, m, j ...) from closed triangle meshes.

A mesh is weighed by the divergence theorem about a local origin (the middle of its bounding box),
so that a part far from the coordinates' origin loses no digits to it. Frame: x along the run,
y up, z along the extrusion; O is the centre of mass of the body.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core.errors import GeometryError
from walkergen.core.numerics import Array
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker.limbs import Limb

Values = float | Array

SUPPORT_TOLERANCE_RAD = 1e-6
"""Largest error, rad, of the directions to a walker's feet."""


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

    def scale_density(self, factor: float) -> "SolidMass":
        """Return the mass properties of the same solid with its density multiplied by `factor`."""
        return self._replace(mass=factor * self.mass, tensor=factor * self.tensor)


class Spatial(NamedTuple):
    """Further mass properties of a walker's body, which only 3D simulations need."""

    z: float
    """Position of O across the run, from the middle of the walker's depth, mm."""
    body: Array
    """Inertia tensor of the body, with legs fixed to it, about O, shape (3, 3), g mm^2."""


class LegMass(NamedTuple):
    """Mass of a leg, and its vectors in the x-y plane, shape (2,), mm (paper, figure 1).

    The foot lies at O + anchor + c_A + c_T. Every field but the last may carry batch axes.
    """

    m: Values
    """Mass, g; 0 when braced, as part of M."""
    j: Values
    """Moment of inertia about its own centre of mass, g mm^2; 0 when braced."""
    anchor: Array
    """Vector from O to the anchor (paper: a of the back leg, b of the front leg)."""
    c_A: Array
    """Vector from the anchor to the leg's centre of mass."""
    c_T: Array
    """Vector from the leg's centre of mass to its foot (the point that touches the plate)."""
    across: float = 0.0
    """Position of its centre of mass across the run, from the middle of the walker's depth, mm."""
    tensor: Array | None = None
    """Inertia tensor about its own centre of mass, shape (3, 3), g mm^2, zero when braced. None if unknown; only
    3D simulations need it."""

    @property
    def foot(self) -> Array:
        """Vector from O to the foot."""
        return self.anchor + self.c_A + self.c_T

    @property
    def inertia(self) -> Values:
        """Moment of inertia about the anchor, g mm^2. Without batch axes only."""
        return self.j + self.m * self.c_A @ self.c_A


class MassProperties(NamedTuple):
    """Mass and moment of inertia of a walker's body, and its legs.

    Flexible legs: M, J, O belong to the body alone. Braced: they belong to body and legs. Of mixed
    legs the braced ones belong to the body. Every field may carry leading batch axes.
    """

    M: Values
    """Mass of the body, g."""
    J: Values
    """Moment of inertia of the body about O, g mm^2."""
    legs: tuple[LegMass, ...]
    """Legs in the order of `Design.limbs`."""
    rigid: bool
    """True when all legs are braced."""
    spatial: Spatial | None = None
    """Mass properties across the run. None if unknown; only 3D simulations need them."""

    @property
    def total(self) -> Values:
        """Mass of the whole walker, g."""
        return self.M + sum(leg.m for leg in self.legs)

    @property
    def centre(self) -> Array:
        """Centre of mass of the whole walker from O, shape (..., 2), mm."""
        moment = sum(np.asarray(leg.m)[..., None] * (leg.anchor + leg.c_A) for leg in self.legs)
        return np.asarray(moment / np.asarray(self.total)[..., None])


def weigh(mesh: Mesh, density: float) -> SolidMass:
    """Compute the mass properties of a closed mesh of uniform density, g/mm^3.

    Exact for polyhedra up to rounding. Source: the divergence theorem summed over the tetrahedra
    between the local origin and each triangle.
    """
    origin = 0.5 * (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0))
    corners = (mesh.vertices - origin)[mesh.triangles]
    x, y, z = corners.transpose(2, 1, 0)
    six_volumes = (
        x[0] * (y[1] * z[2] - z[1] * y[2]) + y[0] * (z[1] * x[2] - x[1] * z[2]) + z[0] * (x[1] * y[2] - y[1] * x[2])
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


def combine_solids(solids: Sequence[SolidMass]) -> SolidMass:
    """Return the mass properties of several solids joined to one rigid body, by Steiner's theorem."""
    masses = np.array([solid.mass for solid in solids])
    centres = np.array([solid.centre for solid in solids])
    centre = masses @ centres / masses.sum()
    tensor = np.zeros((3, 3))
    for solid, arm in zip(solids, centres - centre, strict=True):
        tensor += solid.tensor + solid.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    volume = sum(solid.volume for solid in solids)
    return SolidMass(float(masses.sum()), centre, tensor, float(volume))


def to_rigid(mass: MassProperties) -> MassProperties:
    """Return the mass properties with the joints frozen: body and all legs as one rigid solid."""
    return mass if mass.rigid else freeze_joints(mass, [True] * len(mass.legs))


def freeze_joints(mass: MassProperties, rigid: Sequence[bool]) -> MassProperties:
    """Return mass properties in which the legs marked True in `rigid` are fixed to the body and belong to it."""
    frozen = [leg for leg, is_rigid in zip(mass.legs, rigid, strict=True) if is_rigid]
    if not frozen:
        return mass
    masses = np.array([mass.M, *(leg.m for leg in frozen)])
    centres = np.array([(0.0, 0.0), *(leg.anchor + leg.c_A for leg in frozen)])
    M = float(masses.sum())
    O = masses @ centres / M  # noqa: E741  (the paper's name)
    J = mass.J + sum(leg.j for leg in frozen)
    J = J + float(masses @ np.sum((centres - O) ** 2, axis=1))
    spatial = None
    if mass.spatial is not None:
        middle, tensor = centre_and_inertia(mass.spatial, frozen, masses, centres)
        spatial = Spatial(float(middle[2]), tensor)
    legs = [
        leg._replace(
            m=0.0 if is_rigid else leg.m,
            j=0.0 if is_rigid else leg.j,
            anchor=leg.anchor - O,
            tensor=np.zeros((3, 3)) if is_rigid and leg.tensor is not None else leg.tensor,
        )
        for leg, is_rigid in zip(mass.legs, rigid, strict=True)
    ]
    return MassProperties(M, J, tuple(legs), all(rigid), spatial)


def scale_masses(mass: MassProperties, body_ratio: Values, leg_ratio: Values) -> MassProperties:
    """Return mass properties with masses and inertias multiplied by ratios, one for the body and one for all legs.

    For arrays of ratios, their axes become the leading batch axes of the result.
    """
    spatial, matrix_axes = mass.spatial, (..., None, None)  # a ratio for each whole tensor, shape (3, 3)
    body_ratio, leg_ratio = np.asarray(body_ratio), np.asarray(leg_ratio)
    if spatial is not None:
        spatial = spatial._replace(body=spatial.body * body_ratio[matrix_axes])
    legs = tuple(
        leg._replace(
            m=leg.m * leg_ratio,
            j=leg.j * leg_ratio,
            tensor=None if leg.tensor is None else leg.tensor * leg_ratio[matrix_axes],
        )
        for leg in mass.legs
    )
    return mass._replace(M=mass.M * body_ratio, J=mass.J * body_ratio, legs=legs, spatial=spatial)


def centre_and_inertia(body: Spatial, legs: Sequence[LegMass], masses: Array, centres: Array) -> tuple[Array, Array]:
    """Return the centre of mass, shape (3,), and the inertia tensor about it, shape (3, 3), of a body with legs.

    The centre is relative to O at half depth, mm. The tensor is in g mm^2. `masses` are those of the body and of each
    leg, shape (1 + legs,), g. `centres` are their centres of mass from O in the x-y plane, shape (1 + legs, 2), mm.
    """
    positions = np.column_stack([centres, (body.z, *(leg.across for leg in legs))])
    middle = masses @ positions / masses.sum()
    tensor = body.body + sum(leg.tensor for leg in legs if leg.tensor is not None)
    for mass, position in zip(masses, positions - middle, strict=True):
        tensor = tensor + mass * (position @ position * np.eye(3) - np.outer(position, position))
    return middle, tensor


def to_centre_frame(limbs: Sequence[Limb], mass: MassProperties, points: Array) -> Array:
    """Return points (n, 2) of the design's frame relative to O, the body's centre of mass, mm. `limbs`: its legs."""
    O = np.array(limbs[0].anchor) - mass.legs[0].anchor  # noqa: E741  (the paper's name)
    return np.asarray(points) - O


def scale_to_weighed_mass(part: SolidMass, weighed_mass: float | None) -> SolidMass:
    """Return a solid's mass properties scaled to its weighed mass, g. Without a weighed mass they are unchanged."""
    if weighed_mass is None:
        return part
    return part._replace(mass=weighed_mass, tensor=part.tensor * weighed_mass / part.mass)


def check_support(limbs: Sequence[Limb], mass: MassProperties) -> None:
    """Raise GeometryError unless the walker's centre of mass lies above the area between its feet."""
    centre = _centre_in_plan(mass)
    corners = np.array(  # both ends of each foot, (x, z) from O and half the depth
        [
            (leg.foot[0], limb.across + side * 0.5 * limb.width)
            for limb, leg in zip(limbs, mass.legs, strict=True)
            for side in (-1.0, 1.0)
        ]
    )
    directions = np.sort(np.arctan2(*(corners - centre).T[::-1]))
    gaps = np.diff(np.append(directions, directions[0] + 2.0 * math.pi))
    if gaps.max() < math.pi - SUPPORT_TOLERANCE_RAD:
        return
    x, z = centre - (mass.legs[0].foot[0] - limbs[0].along, 0.0)
    positions = ", ".join(f"{limb.along:g}" for limb in limbs[:6])
    raise GeometryError(
        f"legs[1].along_mm = {limbs[0].along:g}: the walker falls over. Its centre of mass is at "
        f"{x:.3f} mm along and {z:.3f} mm across the body, not above its feet (at {positions} mm "
        "along). Move legs to either side of it.",
        "legs[1].along_mm",
    )


def _centre_in_plan(mass: MassProperties) -> Array:
    """Return the walker's centre of mass along and across the run, shape (2,), mm, from O and half the depth."""
    z = mass.spatial.z if mass.spatial is not None else 0.0
    across = mass.M * z + sum(leg.m * leg.across for leg in mass.legs)
    return np.array([mass.centre[0], across / mass.total])
