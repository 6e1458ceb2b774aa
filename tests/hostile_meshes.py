"""Meshes for tests: sound ones, and one for each fault."""

import manifold3d
import numpy as np

from walkergen.core.shapes import joining, modeller, stl
from walkergen.core.shapes.mesh import Mesh

UP = np.array([0.0, 1.0, 0.0])


def box(length=20.0, height=6.0, depth=8.0, middle=(0.0, 0.0, 0.0)):
    """Box with its middle at a place: x along, y up, z across."""
    foot = np.array(middle, float) - 0.5 * height * UP
    return joining.leg_prism(foot, UP, length, depth, height)


def invert_mesh(mesh):
    return Mesh(mesh.vertices, mesh.triangles[:, ::-1])


def together(*meshes):
    """Several surfaces as one, vertices kept apart."""
    starts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes])
    triangles = [mesh.triangles + start for mesh, start in zip(meshes, starts, strict=False)]
    return Mesh(np.concatenate([m.vertices for m in meshes]), np.concatenate(triangles))


def duck(segments=32):
    """Duck 26 mm long: body, head, beak and tail of spheres, in a file's axes, z up, x forward."""
    sphere = manifold3d.Manifold.sphere(1.0, segments)
    parts = [
        sphere.scale((10.0, 6.0, 5.0)),
        sphere.scale((4.0, 4.0, 4.0)).translate((8.0, 0.0, 7.0)),
        sphere.scale((3.0, 2.0, 1.0)).translate((12.5, 0.0, 6.5)),
        sphere.scale((3.0, 2.0, 1.5)).translate((-9.5, 0.0, 2.0)),
    ]
    return modeller.to_mesh(manifold3d.Manifold.batch_boolean(parts, manifold3d.OpType.Add))


def tube(path, radius=0.6, sides=12):
    """Closed tube along a path of points, shape (n, 3); it crosses itself where the path does."""
    path = np.array(path, float)
    ahead = np.gradient(path, axis=0)
    across = np.cross(ahead, (0.1, 0.2, 1.0))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    up = np.cross(ahead, across)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    angles = 2.0 * np.pi * np.arange(sides) / sides
    rings = path[:, None] + radius * (np.cos(angles)[:, None] * across[:, None] + np.sin(angles)[:, None] * up[:, None])
    count = len(path)
    index = np.arange(count * sides).reshape(count, sides)
    a, b = index[:-1], np.roll(index, -1, axis=1)[:-1]
    c, d = index[1:], np.roll(index, -1, axis=1)[1:]
    first, last = count * sides, count * sides + 1
    sheets = [np.stack(one, axis=-1).reshape(-1, 3) for one in ((a, b, c), (b, d, c))]
    lids = [
        np.stack([np.full(sides, first), np.roll(index[0], -1), index[0]], axis=-1),
        np.stack([np.full(sides, last), index[-1], np.roll(index[-1], -1)], axis=-1),
    ]
    vertices = np.concatenate([rings.reshape(-1, 3), path[:1], path[-1:]])
    return Mesh(vertices, np.concatenate([*sheets, *lids]))


def slivers(sections, radius=11.0, height=2.0):
    """Cylinder along z of `sections` sides: lids are fans of slivers in one corner each."""
    angles = 2.0 * np.pi * np.arange(sections) / sections
    rim = np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.zeros(sections)])
    up = np.array([0.0, 0.0, height])
    vertices = np.vstack([rim, rim + up, np.zeros(3), up])
    i = np.arange(sections)
    j = (i + 1) % sections
    below, above = np.full(sections, 2 * sections), np.full(sections, 2 * sections + 1)
    a, b = sections + i, sections + j
    sides = [(j, i, below), (a, b, above), (i, j, b), (i, b, a)]
    return Mesh(vertices, np.concatenate([np.column_stack(side) for side in sides]))


def bow():
    """Tube that crosses itself once, as a bow does: one closed body."""
    path = [(-6, -6, 0), (6, 6, 0), (6, 9, 0), (0, 12, 0), (-6, 9, 0), (-6, 6, 0), (6, -6, 0.1)]
    return tube(path, 0.5)


def to_stl(path, mesh):
    """Write a mesh as binary STL."""
    path.write_bytes(stl.pack(mesh.vertices[mesh.triangles], path.stem))
    return path
