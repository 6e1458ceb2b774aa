"""Closed meshes of triangles."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class Mesh(NamedTuple):
    """Closed triangle mesh, with triangles counter-clockwise seen from outside."""

    vertices: Array
    """Coordinates of the corners, shape (n, 3), mm."""
    triangles: npt.NDArray[np.int64]
    """Corners of the triangles as indices into the vertices, shape (k, 3)."""
