"""Hard cases of meshes: a million slivers, walls of a millionth of a micrometre, faces that coincide."""

import math
from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from walkergen.commands.selftest.case import GEOMETRY, Case, Check, check_fact
from walkergen.core.shapes import joining, modeller
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import mass
from walkergen.readers.meshes import faults

CYLINDER_SIDES = 250_000
"""Sides of the cylinder: four triangles each, a million."""

UP = np.array([0.0, 1.0, 0.0])


def _cylinder(side_count: int, radius: float, height: float) -> Mesh:
    """Return a cylinder along z with flat sides (lengths in mm). Its lids are fans of slivers."""
    angles = 2.0 * math.pi * np.arange(side_count) / side_count
    rim = radius * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(side_count)])
    up = np.array([0.0, 0.0, height])
    i = np.arange(side_count)
    j = (i + 1) % side_count
    below, above = np.full(side_count, 2 * side_count), np.full(side_count, 2 * side_count + 1)
    a, b = side_count + i, side_count + j
    sides = [(j, i, below), (a, b, above), (i, j, b), (i, b, a)]
    return Mesh(np.vstack([rim, rim + up, np.zeros(3), up]), np.concatenate([np.column_stack(side) for side in sides]))


def _check_slivers() -> Iterator[Check]:
    """Check the mass properties of a cylinder of a million slivers."""
    radius, height = 11.0, 2.0
    turn = 2.0 * math.pi / CYLINDER_SIDES
    area = 0.5 * CYLINDER_SIDES * radius**2 * math.sin(turn)
    second = area * radius**2 * (2.0 + math.cos(turn)) / 6.0
    weighed = mass.weigh(_cylinder(CYLINDER_SIDES, radius, height), 1.0)
    reason = "rounding of a sum over a million slivers"
    yield Check("volume, relative", abs(weighed.volume / (area * height) - 1.0), 1e-12, reason)
    along = abs(float(weighed.tensor[2, 2]) / (second * height) - 1.0)
    yield Check("inertia about its axis, relative", along, 1e-12, reason)
    across = 0.5 * second * height + area * height**3 / 12.0
    yield Check("inertia across it, relative", abs(float(weighed.tensor[0, 0]) / across - 1.0), 1e-12, reason)
    deviation = float(np.abs(weighed.centre - (0.0, 0.0, 0.5 * height)).max())
    yield Check("centre, mm", deviation, 1e-12 * radius, reason)


def _box(size: tuple[float, float, float], middle: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Mesh:
    """Return a box of a length, height and depth (mm) with its middle at a position."""
    length, height, depth = size
    return joining.leg_prism(np.array(middle) - 0.5 * height * UP, UP, length, depth, height)


def _extents(mesh: Mesh) -> list[Fraction]:
    """Return the lengths of a box along its axes, without rounding."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    return [Fraction(float(b)) - Fraction(float(a)) for a, b in zip(low, high, strict=True)]


def _check_thin_walls() -> Iterator[Check]:
    """Check a box with a cavity that leaves walls down to 1e-9 mm against the difference of two boxes."""
    for wall in (1e-3, 1e-6, 1e-9):
        outer = _box((20.0, 6.0, 8.0))
        inner = _box((20.0 - 2.0 * wall, 6.0 - 2.0 * wall, 8.0 - 2.0 * wall))
        hollow = Mesh(
            np.concatenate([outer.vertices, inner.vertices]),
            np.concatenate([outer.triangles, inner.triangles[:, ::-1] + len(outer.vertices)]),
        )
        weighed = mass.weigh(hollow, 1.0)
        (a, b, c), (d, e, f) = _extents(outer), _extents(inner)
        volume = float(a * b * c - d * e * f)
        about_z = float((a * b * c * (a * a + b * b) - d * e * f * (d * d + e * e)) / 12)
        limit, reason = 1e-14 * 6.0 / wall, "rounding of the two boxes, over what is left of them"
        yield Check(f"walls of {wall:g} mm: volume, relative", abs(weighed.volume / volume - 1.0), limit, reason)
        turned = abs(float(weighed.tensor[2, 2]) / about_z - 1.0)
        yield Check(f"walls of {wall:g} mm: inertia, relative", turned, limit, reason)


def _check_coincident_faces() -> Iterator[Check]:
    """Check unions whose faces lie in one plane: whole, in part, one inside the other, and but for an ulp."""
    size = (20.0, 6.0, 8.0)
    for name, position, volume in (
        ("face on face", (20.0, 0.0, 0.0), 2.0),
        ("a part of a face", (20.0, 3.0, 4.0), 2.0),
        ("sides in one plane", (10.0, 0.0, 0.0), 1.5),
        ("the same box twice", (0.0, 0.0, 0.0), 1.0),
        ("an ulp inside", (math.nextafter(20.0, 0.0), 0.0, 0.0), 2.0),
    ):
        both = modeller.to_solid(_box(size)) + modeller.to_solid(_box(size, position))
        union = modeller.to_mesh(modeller.check_solid(both))
        yield check_fact(f"{name}: one body", len(modeller.split_bodies(both)) == 1)
        edges = np.concatenate([union.triangles[:, [i, j]] for i, j in ((0, 1), (1, 2), (2, 0))])
        pairs = {(int(i), int(j)) for i, j in edges}
        yield check_fact(f"{name}: closed", len(pairs) == len(edges) and all((j, i) in pairs for i, j in pairs))
        faults.check_solid(union, name)  # crossings too
        weighed = mass.weigh(union, 1.0)
        deviation = abs(weighed.volume / (volume * math.prod(size)) - 1.0)
        yield Check(f"{name}: volume, relative", deviation, 1e-12, "rounding of the boxes' corners")


CASES = [
    Case("a million slivers", "geometry", "regular polygon: area, second moment", GEOMETRY, _check_slivers),
    Case("walls of 1e-9 mm", "geometry", "two boxes, in exact rational arithmetic", GEOMETRY, _check_thin_walls),
    Case(
        "coincident faces in a union",
        "geometry",
        "volumes of boxes; every edge twice",
        GEOMETRY,
        _check_coincident_faces,
    ),
]
"""Hard cases of meshes and of unions."""
