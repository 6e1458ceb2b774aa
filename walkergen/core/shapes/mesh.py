"""Closed meshes of triangles."""

from typing import NamedTuple

from walkergen.core.numerics import Array, Whole


class Mesh(NamedTuple):
    """Closed triangle mesh, with triangles counter-clockwise seen from outside."""

    vertices: Array
    """Coordinates of the corners, shape (n, 3), mm."""
    triangles: Whole
    """Corners of the triangles as indices into the vertices, shape (k, 3)."""

    def shift(self, shift: Array) -> "Mesh":
        """Return the mesh moved by a shift of shape (3,), mm."""
        return self._replace(vertices=self.vertices + shift)
