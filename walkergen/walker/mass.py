"""Mass properties: from closed triangle meshes to M, J, m, j and the walker's vectors.

A mesh is weighed by the divergence theorem about a local origin (the middle of its bounding box),
so that a part far from the coordinates' origin loses no digits to it. Frame: x along the run,
y up, z along the extrusion; O is the centre of mass of the body.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.shapes.mesh import Mesh

if TYPE_CHECKING:
    from walkergen.walker.design import Design
    from walkergen.walker.fittings import Cylinder

Array = npt.NDArray[np.float64]
Values = float | Array


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

    def times(self, factor: float) -> "SolidMass":
        """The same shape, so many times as dense."""
        return self._replace(mass=factor * self.mass, tensor=factor * self.tensor)


class Spatial(NamedTuple):
    """What the mass properties of a plane leave out: the third dimension, for motion in space."""

    z: float
    """Place of O across the run, from the middle of the walker's depth, mm."""
    body: Array
    """Inertia tensor about O of what M counts, shape (3, 3), g mm^2."""


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
    """Place of its centre of mass across the run, from the middle of the walker's depth, mm."""
    tensor: Array | None = None
    """Inertia tensor about its own centre of mass, shape (3, 3), g mm^2, zero when braced; None
    when unknown, which only motion in space minds."""

    @property
    def foot(self) -> Array:
        """Vector from O to the foot."""
        return self.anchor + self.c_A + self.c_T

    @property
    def inertia(self) -> Values:
        """Moment of inertia about the anchor, g mm^2; without batch axes only."""
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
    """Mass properties across the run; None when unknown, which only motion in space minds."""

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
    """Weigh a closed mesh: mass (g), centre (mm), inertia tensor (g mm^2); density in g/mm^3.

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


def assemble(design: "Design", body: SolidMass, legs: Sequence[Mesh], cap: Mesh | None = None) -> MassProperties:
    """Mass properties of a walker from its body, weighed at 1 g/mm^3, and the meshes of its legs outside the body.

    The body lies in the design's frame, a leg's mesh has its anchor at the origin; a braced
    leg's mesh includes its brace. A cap belongs to the body. Weighed masses in the design override
    the meshes', the body's with its cap, and rescale the inertias with them: the shape is trusted,
    the density is not.
    """
    density, limbs = 1e-3 * design.material.density_g_cm3, design.limbs
    whole = body.times(density)
    if cap is not None and design.cap is not None:
        of_cap = weigh(cap, 1e-3 * design.cap.density(design.material.density_g_cm3))
        whole = together([whole, of_cap])
    top = _rescaled(whole, design.weighed.body_mass_g)
    if design.parts:
        top = together([top, *carried(design)])
    O = top.centre[:2]  # noqa: E741  (the paper's name)
    distinct = {id(mesh): mesh for mesh in legs}  # equal legs share theirs
    weighed_once = {key: weigh(mesh, density) for key, mesh in distinct.items()}
    placed, meshed = [], [weighed_once[id(mesh)] for mesh in legs]
    mean = sum(part.mass for part in meshed) / len(meshed)
    prisms = design.body.plain or design.body.flat
    for limb, part in zip(limbs, meshed, strict=True):
        weighed = design.weighed.leg_mass_g
        own = _rescaled(part, None if weighed is None else weighed * (part.mass / mean))
        c_A = own.centre[:2]
        # A prism's centre lies at its middle; that of a leg cut flush with a slope across need not
        aside = 0.0 if prisms else float(own.centre[2]) - 0.5 * limb.width
        placed.append(
            LegMass(
                own.mass,
                own.inertia,
                np.array(limb.anchor) - O,
                c_A,
                np.array(limb.anchor_to_foot) - c_A,
                limb.across + aside,
                own.tensor,
            )
        )
    across = float(top.centre[2]) - 0.5 * design.size.depth
    loose = MassProperties(top.mass, top.inertia, tuple(placed), False, Spatial(across, top.tensor))
    return frozen(loose, [limb.rigid for limb in limbs])


def carried(design: "Design") -> list[SolidMass]:
    """Mass properties of what a body carries: its parts, each with its share of the glue, and the
    wires, a thin rod from the middle of the one to that of the other.

    With one part alone the wires are within it. The centres are in the design's frame.
    """
    cylinders, depth = [part.cylinder for part in design.parts.values()], design.size.depth
    extra = design.fit.glue_g / len(cylinders)
    if len(cylinders) == 1:
        extra += design.fit.wires_g
    parts = [_of_cylinder(own, own.mass + extra, depth) for own in cylinders]
    if len(parts) > 1 and design.fit.wires_g > 0.0:
        first, second = (part.centre for part in parts)
        way, wires = second - first, design.fit.wires_g
        tensor = wires / 12.0 * (way @ way * np.eye(3) - np.outer(way, way))
        parts.append(SolidMass(wires, 0.5 * (first + second), tensor, 0.0))
    return parts


def _of_cylinder(cylinder: "Cylinder", mass: float, depth: float) -> SolidMass:
    """Mass properties of a solid cylinder of that mass, g, in a body of that depth, mm."""
    aside = mass * (3.0 * cylinder.radius**2 + cylinder.height**2) / 12.0
    tensor = aside * np.eye(3)
    tensor[cylinder.axis, cylinder.axis] = 0.5 * mass * cylinder.radius**2
    volume = np.pi * cylinder.radius**2 * cylinder.height
    return SolidMass(mass, np.array(cylinder.middle(depth)), tensor, volume)


def together(solids: Sequence[SolidMass]) -> SolidMass:
    """Mass properties of several solids as one rigid body, by Steiner's theorem."""
    masses = np.array([solid.mass for solid in solids])
    centres = np.array([solid.centre for solid in solids])
    centre = masses @ centres / masses.sum()
    tensor = np.zeros((3, 3))
    for solid, arm in zip(solids, centres - centre, strict=True):
        tensor += solid.tensor + solid.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    volume = sum(solid.volume for solid in solids)
    return SolidMass(float(masses.sum()), centre, tensor, float(volume))


def as_rigid(mass: MassProperties) -> MassProperties:
    """Mass properties with the joints frozen: body and all legs as one rigid solid."""
    return mass if mass.rigid else frozen(mass, [True] * len(mass.legs))


def frozen(mass: MassProperties, rigid: Sequence[bool]) -> MassProperties:
    """Mass properties with those joints frozen whose legs are `rigid`: they belong to the body."""
    chosen = [leg for leg, is_rigid in zip(mass.legs, rigid, strict=True) if is_rigid]
    if not chosen:
        return mass
    masses = np.array([mass.M, *(leg.m for leg in chosen)])
    centres = np.array([(0.0, 0.0), *(leg.anchor + leg.c_A for leg in chosen)])
    M = float(masses.sum())
    O = masses @ centres / M  # noqa: E741  (the paper's name)
    J = mass.J + sum(leg.j for leg in chosen)
    J = J + float(masses @ np.sum((centres - O) ** 2, axis=1))
    whole = None
    if mass.spatial is not None:
        middle, tensor = joined(mass.spatial, chosen, masses, centres)
        whole = Spatial(float(middle[2]), tensor)
    legs = [
        leg._replace(
            m=0.0 if is_rigid else leg.m,
            j=0.0 if is_rigid else leg.j,
            anchor=leg.anchor - O,
            tensor=np.zeros((3, 3)) if is_rigid and leg.tensor is not None else leg.tensor,
        )
        for leg, is_rigid in zip(mass.legs, rigid, strict=True)
    ]
    return MassProperties(M, J, tuple(legs), all(rigid), whole)


def scaled(mass: MassProperties, body: Values, leg: Values) -> MassProperties:
    """Mass properties with the masses and inertias of body and legs times ratios, any shape."""
    whole, sides = mass.spatial, (..., None, None)
    body, leg = np.asarray(body), np.asarray(leg)
    if whole is not None:
        whole = whole._replace(body=whole.body * body[sides])
    legs = tuple(
        own._replace(m=own.m * leg, j=own.j * leg, tensor=None if own.tensor is None else own.tensor * leg[sides])
        for own in mass.legs
    )
    return mass._replace(M=mass.M * body, J=mass.J * body, legs=legs, spatial=whole)


def joined(body: Spatial, legs: Sequence[LegMass], masses: Array, centres: Array) -> tuple[Array, Array]:
    """Centre of mass (mm, from O at half depth) and inertia tensor about it (g mm^2) of the whole.

    Masses of the body and these legs, shape (1 + legs,), g; their centres from O, shape
    (1 + legs, 2), mm.
    """
    places = np.column_stack([centres, (body.z, *(leg.across for leg in legs))])
    middle = masses @ places / masses.sum()
    tensor = body.body + sum(leg.tensor for leg in legs if leg.tensor is not None)
    for mass, place in zip(masses, places - middle, strict=True):
        tensor = tensor + mass * (place @ place * np.eye(3) - np.outer(place, place))
    return middle, tensor


def from_centre(design: "Design", mass: MassProperties, points: Array) -> Array:
    """Points of the design's frame, shape (n, 2), seen from O, mm."""
    O = np.array(design.limbs[0].anchor) - mass.legs[0].anchor  # noqa: E741  (the paper's name)
    return np.asarray(points) - O


def _rescaled(part: SolidMass, weighed_mass: float | None) -> SolidMass:
    if weighed_mass is None:
        return part
    return part._replace(mass=weighed_mass, tensor=part.tensor * weighed_mass / part.mass)
