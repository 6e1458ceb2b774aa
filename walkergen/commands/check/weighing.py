"""Mass properties of each object in a mesh file, and of all objects together, in the axes of the file."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from walkergen.core.numerics import Array
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import mass
from walkergen.core.walker.mass import SolidMass
from walkergen.readers.drawings import size_check
from walkergen.readers.meshes import faults, meshes


class ObjectMass(NamedTuple):
    """Mass properties of one object, or of all objects together, in the axes of the file."""

    name: str
    triangles: int
    volume_mm3: float
    mass_g: float
    centre_mm: Array
    """Centre of mass, shape (3,)."""
    tensor_g_mm2: Array
    """Inertia tensor about the centre of mass, shape (3, 3)."""
    moments_g_mm2: Array
    """Principal moments of inertia, ascending, shape (3,)."""
    axes: Array
    """Principal axes, a unit vector a row, right-handed, shape (3, 3)."""


class Weighing(NamedTuple):
    """Mass properties of the objects of a mesh file."""

    parts: tuple[ObjectMass, ...]
    total: ObjectMass
    sha256: str
    """Hash of the file's bytes."""
    notes: tuple[str, ...]
    """Notes on parts of the file that were left out or repaired."""


def weigh(path: Path, density_g_cm3: float, scale_mm: float) -> Weighing:
    """Compute the mass properties of every object of a mesh file, and of all objects together.

    `scale_mm`: length of the file's unit, mm. A 3MF file states its unit, which is multiplied by `scale_mm`. A 3MF
    file may contain several objects, any other file is one object. An object may have several bodies. Raises
    InputError for unreadable files and open surfaces.
    """
    source = str(path)[-80:]
    loaded = meshes.read_mesh(path, source)
    several = path.suffix.lower() == ".3mf" and len(loaded.parts) > 1
    surfaces = loaded.parts if several else (meshes.join_parts(loaded.parts),)
    solids, bodies, notes = [], 0, [*loaded.notes]
    for surface in surfaces:
        mesh = Mesh(surface.vertices * scale_mm, surface.triangles)
        number, crossing = faults.check_closed(mesh, f"{source}: {surface.name}" if several else source)
        bodies += number
        notes += [f"{surface.name} {crossing}. What overlaps counts twice."] if crossing else []
        solids.append(mass.weigh(mesh, 1e-3 * density_g_cm3))
    counts = [len(surface.triangles) for surface in surfaces]
    parts = tuple(
        _mass_properties(surface.name, count, solid)
        for surface, count, solid in zip(surfaces, counts, solids, strict=True)
    )
    side = max(float(np.ptp(surface.vertices, axis=0).max()) for surface in surfaces) * scale_mm
    notes += ([f"{bodies} bodies"] if bodies > 1 else []) + _check_size(side, scale_mm)
    total = _mass_properties("total", sum(counts), mass.combine_solids(solids))
    return Weighing(parts, total, loaded.sha256, tuple(notes))


def _check_size(side_mm: float, scale_mm: float) -> list[str]:
    """Return a note with the units that a file may be in if the longest side (mm) is one that no walker has."""
    if size_check.MAX_INCH_SIZE_MM <= side_mm <= size_check.MAX_LENGTH_MM:
        return []
    units = [
        f"{size:.4g} mm in {name} (‹scale=›{unit:g})" for name, size, unit in size_check.readings(side_mm, scale_mm)
    ]
    return [f"The longest side is {side_mm:.4g} mm. It would be {', or '.join(units) or 'a walker in no common unit'}."]


def principal_axes(tensor: Array) -> tuple[Array, Array]:
    """Return the principal moments, ascending, shape (3,), and the principal axes, one in each row, shape (3, 3).

    The axes are right-handed. The largest components of the first two are positive. Axes of equal moments are any of
    their plane.
    """
    moments, columns = np.linalg.eigh(tensor)
    axes = columns.T
    for axis in axes[:2]:
        axis *= np.sign(axis[np.argmax(np.abs(axis))])
    axes[2] = np.cross(axes[0], axes[1])
    return moments, axes + 0.0


def _mass_properties(name: str, triangles: int, solid: SolidMass) -> ObjectMass:
    """Return the mass properties of a solid, with its principal axes. `triangles`: their number in its mesh."""
    tensor = 0.5 * (solid.tensor + solid.tensor.T)  # rounding alone makes it unequal
    volume, mass_g = float(solid.volume), float(solid.mass)
    return ObjectMass(name, triangles, volume, mass_g, solid.centre, tensor, *principal_axes(tensor))
