"""Meshes to manifold3d and back, with its status turned into an exception.

Booleans of solids keep double precision: their tolerance is 1e-12 of the largest coordinate
(measured at sizes from 1e-3 to 1e3 mm), so that nothing has to be scaled, as profiles have.
"""

import manifold3d
import numpy as np

from walkergen.core.errors import SolidError
from walkergen.core.shapes.mesh import Mesh


def to_solid(mesh: Mesh) -> manifold3d.Manifold:
    """Convert a closed mesh to a solid. Raises SolidError when manifold3d refuses it."""
    # The modeller takes no read-only arrays, which its own results are
    vertices = np.require(mesh.vertices, np.float64, ["C", "W"])
    triangles = np.require(mesh.triangles, np.uint64, ["C", "W"])
    return check_solid(manifold3d.Manifold(manifold3d.Mesh64(vertices, triangles)))


def check_solid(manifold: manifold3d.Manifold) -> manifold3d.Manifold:
    """Carry out the operations of a solid and return it. Raises SolidError if one of them failed."""
    if manifold.status() != manifold3d.Error.NoError:
        raise SolidError(f"the solid modeller gave no body: {manifold.status().name}")
    return manifold


def to_mesh(manifold: manifold3d.Manifold) -> Mesh:
    """Return the closed mesh of a solid, vertices as float64."""
    raw = manifold.to_mesh64()
    vertices = np.asarray(raw.vert_properties, dtype=np.float64)[:, :3]
    return Mesh(vertices, np.asarray(raw.tri_verts, dtype=np.int64))


def split_bodies(manifold: manifold3d.Manifold) -> list[manifold3d.Manifold]:
    """Split a solid into its bodies, largest first; closed cavities do not count as bodies."""
    outward = [piece for piece in manifold.decompose() if piece.volume() > 0.0]
    return sorted(outward, key=lambda piece: -piece.volume())


def count_bodies(mesh: Mesh) -> int:
    """Count the closed bodies of a mesh with coordinates as 32-bit floats, as in a file; cavities are none.

    Zero if it is not closed and oriented, or encloses nothing. Vertices that coincide are merged.
    """
    rounded = mesh.vertices.astype(np.float32)
    vertices, index = np.unique(rounded, axis=0, return_inverse=True)
    triangles = index.reshape(-1)[mesh.triangles].astype(np.uint32)
    solid = manifold3d.Manifold(manifold3d.Mesh(vertices, triangles))
    if solid.status() != manifold3d.Error.NoError or solid.volume() <= 0.0:
        return 0
    return len(split_bodies(solid))
