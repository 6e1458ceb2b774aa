"""A body of a person's own: a mesh file read, checked, if asked repaired, and put into the frame.

In the file one axis is up and one runs forward; here x is forward, y up and z across, right-handed.
The middle of the bounding box is the origin in x and y, and z begins at 0, as in any walker.
"""

from pathlib import Path
from typing import NamedTuple, get_args

import numpy as np

from walkergen.errors import InputError
from walkergen.shapes import faults, meshes, repairs
from walkergen.shapes.mesh import Mesh
from walkergen.walker.body import Axis
from walkergen.walker.mass import Array

SMALLEST, LARGEST = 0.5, 500.0
"""Least and greatest length of the longest side of a body's bounding box, mm."""

UNITS = {"micrometres": 1e-3, "centimetres": 10.0, "inches": 25.4, "metres": 1000.0}
"""Millimetres of other units that a file may be drawn in."""


class OwnMesh(NamedTuple):
    """Body, or a whole walker, from a file."""

    mesh: Mesh
    """Sound closed mesh in walkergen's frame, mm."""
    sha256: str
    """Hash of the file's bytes."""
    changes: tuple[str, ...]
    """What was left out of the file or mended, in words; none when it was taken as it is."""


def read(
    path: Path, scale_mm: float = 1.0, up: Axis = "z", forward: Axis = "x", repair: bool = False, key: str = "body.mesh"
) -> OwnMesh:
    """Read a mesh (STL, OBJ, PLY, OFF, 3MF, GLB) as one closed body.

    `scale_mm` is the length of the file's unit in mm (3MF names its unit; there it multiplies);
    `up` and `forward` are the file's axes that become y and x. Raises InputError, one line that
    begins with `key`, when the file is no mesh, the mesh is unsound and, if `repair`, stays so,
    or its size is not a walker's.
    """
    source = f"{key} = {str(path)[-80:]!r}"
    turn = rotation(up, forward, key)
    loaded = meshes.load(path, source)
    part = meshes.joined(loaded.parts)
    mesh = Mesh(part.vertices * scale_mm, part.triangles)
    _refuse_size(mesh, source, scale_mm)
    changes = loaded.notes
    if repair:
        mesh, repaired = repairs.repair(mesh)
        changes += repaired
        if len(mesh.triangles) == 0:
            raise InputError(f"{source}: repair leaves nothing: {'; '.join(changes)}")
    faults.refuse(mesh, f"{source} ({'; '.join(changes)})" if changes else source)
    return OwnMesh(Mesh(_placed(mesh.vertices @ turn.T), mesh.triangles), loaded.sha256, changes)


def rotation(up: Axis, forward: Axis, key: str) -> Array:
    """Rotation from a file's axes to walkergen's, shape (3, 3). Raises InputError for one axis."""
    for name, axis in (("up", up), ("forward", forward)):
        if axis not in get_args(Axis):
            raise InputError(f"{key}: {name} = {axis!r}: must be one of {', '.join(get_args(Axis))}")
    if up[-1] == forward[-1]:
        raise InputError(f"{key}: up = {up!r} and forward = {forward!r} are one axis; change one")
    x, y = _unit(forward), _unit(up)
    return np.array([x, y, np.cross(x, y)])


def _unit(axis: str) -> Array:
    unit = np.zeros(3)
    unit["xyz".index(axis[-1])] = -1.0 if axis.startswith("-") else 1.0
    return unit


def _placed(vertices: Array) -> Array:
    """Vertices with the middle of their box at the origin in x and y, and z from 0."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    middle: Array = 0.5 * (low + high)
    middle[2] = low[2]
    placed: Array = vertices - middle
    return placed


def _refuse_size(mesh: Mesh, source: str, scale_mm: float) -> None:
    """Raise InputError, with units that would do, when a mesh is not of a walker's size."""
    size = float((mesh.vertices.max(axis=0) - mesh.vertices.min(axis=0)).max())
    if SMALLEST <= size <= LARGEST:
        return
    fitting = [
        f"{scale_mm * unit:g} ({name}, {size * unit:.4g} mm)"
        for name, unit in UNITS.items()
        if SMALLEST <= size * unit <= LARGEST
    ]
    ask = (
        f"is it drawn in another unit? scale_mm = {' or '.join(fitting)}"
        if fitting
        else ("set scale_mm, the millimetres of the file's unit")
    )
    raise InputError(
        f"{source}: the longest side is {size:.4g} mm at scale_mm = {scale_mm:g}, "
        f"must lie in {SMALLEST:g}..{LARGEST:g} mm; {ask}"
    )
