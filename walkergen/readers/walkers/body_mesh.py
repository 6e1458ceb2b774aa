"""Bodies from users' mesh files: read, checked, repaired on request, and moved into walkergen's frame.

In the file one axis is up and one runs forward; here x is forward, y up and z across, right-handed.
The middle of the bounding box is the origin in x and y, and z begins at 0, as in any walker.
"""

from pathlib import Path
from typing import NamedTuple, get_args

import numpy as np

from walkergen.core.errors import InputError, Remedy
from walkergen.core.files import formatting
from walkergen.core.numerics import Array
from walkergen.core.shapes import modeller
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker.body import Axis
from walkergen.readers.drawings import size_check
from walkergen.readers.meshes import faults, meshes, repairs
from walkergen.readers.walkers import base


class ReadOptions(NamedTuple):
    """Options for reading a mesh file."""

    scale_mm: float | None = None
    """Length of the file's unit, mm (3MF names its unit; there it multiplies). None: 1."""
    length_mm: float | None = None
    """Length along the run after scaling, mm. None: not scaled."""
    up: Axis = "z"
    forward: Axis = "x"
    """Axes of the file that become y and x."""
    repair: bool = False
    """True to mend an unsound mesh."""
    base: bool | None = False
    """True for a plate under the body. None: a plate only if there are several bodies."""
    mirror: bool = False
    """True to turn what points forward backward."""


DEFAULT_OPTIONS = ReadOptions()
"""Options of a file that is not changed."""


REPAIR_REMEDY = Remedy("mend it", {"body.repair": True})


class OwnMesh(NamedTuple):
    """Body, or a whole walker, from a file."""

    mesh: Mesh
    """Sound closed mesh in walkergen's frame, mm."""
    sha256: str
    """Hash of the file's bytes."""
    changes: tuple[str, ...]
    """Notes on what was left out of the file or mended; empty if nothing was changed."""


def read_body(path: Path, options: ReadOptions = DEFAULT_OPTIONS, key: str = "body.mesh") -> OwnMesh:
    """Read a mesh (STL, OBJ, PLY, OFF, 3MF, GLB) as one closed body.

    Raises InputError, one line that begins with `key`, when the file is no mesh, the mesh cannot be made sound,
    or its size is not that of a walker.
    """
    source = f"{key} = {str(path)[-80:]!r}"
    turn = rotation(options.up, options.forward, key)
    loaded = meshes.read_mesh(path, source)
    part = meshes.join_parts(loaded.parts)
    vertices, triangles = part.vertices @ turn.T, part.triangles
    scale = options.scale_mm or 1.0
    if options.length_mm is not None:
        scale = options.length_mm / max(float(np.ptp(vertices[:, 0])), 1e-12)
    mesh = Mesh(vertices * scale, triangles)
    if options.mirror:
        mesh = Mesh(mesh.vertices * (-1.0, 1.0, 1.0), triangles[:, ::-1])
    if options.length_mm is None:
        size_check.check_size(float(np.ptp(mesh.vertices, axis=0).max()), source, scale)
    mesh, changes = _make_sound(mesh, options, source, loaded.notes)
    return OwnMesh(Mesh(_centre_vertices(mesh.vertices), mesh.triangles), loaded.sha256, changes)


def _make_sound(mesh: Mesh, options: ReadOptions, source: str, notes: tuple[str, ...]) -> tuple[Mesh, tuple[str, ...]]:
    """Return one sound body as a mesh, and notes on what was left out or mended. Raises InputError."""
    if not options.repair and not options.base:
        faults.check_solid(mesh, f"{source} ({'; '.join(notes)})" if notes else source, [REPAIR_REMEDY])
        return mesh, notes
    try:
        faults.check_solid(mesh, source)
    except InputError:
        mesh, changes = repairs.repair(mesh) if options.repair else (mesh, ())
        notes += changes
        if len(mesh.triangles) == 0:
            raise InputError(f"{source}: repair leaves nothing: {'; '.join(notes)}") from None
        mesh, joined = _make_single_body(mesh, options.base)
        notes += joined
        faults.check_solid(mesh, f"{source} ({'; '.join(notes)})" if notes else source)
        return mesh, notes
    return (base.add_to_mesh(mesh) if options.base else mesh), notes


def _make_single_body(mesh: Mesh, plate: bool | None) -> tuple[Mesh, tuple[str, ...]]:
    """Join bodies of a closed mesh by a `plate` (None: only if several), or keep the largest. Return mesh and notes."""
    if any(map(len, faults.faulty_edges(mesh.triangles))):
        return mesh, ()
    bodies = modeller.split_bodies(modeller.to_solid(mesh))
    if plate or (plate is None and len(bodies) > 1):
        return base.add_to_mesh(mesh), (f"joined {len(bodies)} bodies by a base plate",) if len(bodies) > 1 else ()
    if len(bodies) < 2:
        return mesh, ()
    return modeller.to_mesh(bodies[0]), (
        f"left out {formatting.format_count(len(bodies) - 1, 'body', 'bodies')} other than the largest",
    )


def rotation(up: Axis, forward: Axis, key: str) -> Array:
    """Return the rotation from a file's axes to walkergen's, shape (3, 3). Raises InputError unless the axes differ."""
    for name, axis in (("up", up), ("forward", forward)):
        if axis not in get_args(Axis):
            raise InputError(f"{key}: {name} = {axis!r}: must be one of {', '.join(get_args(Axis))}")
    if up[-1] == forward[-1]:
        raise InputError(f"{key}: up = {up!r} and forward = {forward!r} are one axis; change one")
    x, y = _unit_vector(forward), _unit_vector(up)
    return np.array([x, y, np.cross(x, y)])


def _unit_vector(axis: str) -> Array:
    """Return the unit vector of an axis, such as "-x", shape (3,)."""
    unit = np.zeros(3)
    unit["xyz".index(axis[-1])] = -1.0 if axis.startswith("-") else 1.0
    return unit


def _centre_vertices(vertices: Array) -> Array:
    """Return the vertices moved so that the middle of their box is at x = y = 0, and z begins at 0."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    middle: Array = 0.5 * (low + high)
    middle[2] = low[2]
    placed: Array = vertices - middle
    return placed
