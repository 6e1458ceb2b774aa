"""Reading of mesh files of any kind: STL, OBJ, PLY, OFF, 3MF, GLB; bodies as they stand there.

Binary STL is read here, 3MF by lib3mf, everything else by trimesh, from the bytes alone: no other
file and no address that a file may name is opened. Vertices that coincide to the last bit become
one, because STL has no other way to say what is joined; nothing else is changed.
"""

import hashlib
import io
import zipfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.errors import InputError
from walkergen.files import reading
from walkergen.shapes import stl, threemf
from walkergen.shapes.threemf import Part

FORMATS = ("stl", "obj", "ply", "off", "3mf", "glb")

MOST_BYTES = 2**30
"""Largest file, and largest content of a compressed one."""

FARTHEST = 1e12
"""Largest coordinate, in the file's unit."""

MOST_TRIANGLES = 2_000_000
"""Largest number of triangles of a file: a million took 10 s and 0.7 GB to read and check, on two
busy cores (benchmarks/own_mesh.py)."""

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


class Loaded(NamedTuple):
    """Contents of a mesh file."""

    parts: tuple[Part, ...]
    """Objects as they are placed; a file without objects, such as STL, is one."""
    sha256: str
    """Hash of the file's bytes."""


def load(path: Path, source: str) -> Loaded:
    """Read a mesh file. Raises InputError, beginning with `source`, for what is not one."""
    kind = path.suffix.lower().removeprefix(".")
    if kind not in FORMATS:
        raise InputError(f"{source}: ends in {path.suffix[:20]!r}; give a mesh: {', '.join(FORMATS)}")
    data = reading.content(path, MOST_BYTES)
    with reading.by_library(source, kind.upper()):
        parts = [_part(source, *raw) for raw in _raw(data, kind, source)]
    count = sum(len(part.triangles) for part in parts)
    if count == 0:
        raise InputError(f"{source}: holds no triangles; export the body as a mesh")
    if count > MOST_TRIANGLES:
        raise InputError(
            f"{source}: {count} triangles, at most {MOST_TRIANGLES}; simplify the mesh: 100000 are enough for any print"
        )
    return Loaded(tuple(parts), hashlib.sha256(data).hexdigest())


def _raw(data: bytes, kind: str, source: str) -> list[Part]:
    """Parts of a file as they stand there; the libraries that read it raise whatever they like."""
    if kind == "3mf":
        _refuse_bombs(data, source)
        return threemf.read(data, source)
    if _is_binary_stl(kind, data):
        return [Part("mesh", *_binary_stl(data, source))]
    return _by_trimesh(data, kind, source)


def joined(parts: tuple[Part, ...]) -> Part:
    """All parts as one surface; vertices that coincide to the last bit become one."""
    if len(parts) == 1:
        return parts[0]
    starts = np.cumsum([0] + [len(part.vertices) for part in parts])
    shifted = [part.triangles + start for part, start in zip(parts, starts, strict=False)]
    vertices = np.concatenate([part.vertices for part in parts])
    return Part(parts[0].name, *merged(vertices, np.concatenate(shifted)))


def merged(vertices: Array, triangles: Indices) -> tuple[Array, Indices]:
    """Vertices that differ, in the order of their coordinates, and the triangles between them."""
    vertices = vertices + 0.0  # minus zero is zero
    order = np.lexsort(vertices.T)
    ordered = vertices[order]
    fresh = np.ones(len(ordered), bool)
    fresh[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    index = np.empty(len(ordered), np.int64)
    index[order] = np.cumsum(fresh) - 1
    return ordered[fresh], index[triangles]


def _is_binary_stl(kind: str, data: bytes) -> bool:
    """True for STL of the length that its count of triangles makes, or not led by "solid"."""
    if kind != "stl":
        return False
    start = stl.HEADER_BYTES + stl.COUNT_BYTES
    count = int.from_bytes(data[stl.HEADER_BYTES : start], "little")
    whole = len(data) == start + count * stl.TRIANGLE.itemsize
    return whole or not data.lstrip().lower().startswith(b"solid")


def _binary_stl(data: bytes, source: str) -> tuple[Array, Indices]:
    corners = stl.unpack(data, source).astype(np.float64).reshape(-1, 3)
    return corners, np.arange(len(corners)).reshape(-1, 3)


def _part(source: str, name: str, vertices: Array, triangles: Indices) -> Part:
    """Part with coinciding vertices merged. Raises InputError for indices and numbers of no use."""
    if len(triangles) and not 0 <= triangles.min() <= triangles.max() < len(vertices):
        raise InputError(f"{source}: a triangle has a corner that does not exist; export it anew")
    bad = int((~np.isfinite(vertices).all(axis=1)).sum())
    if bad:
        raise InputError(f"{source}: {bad} of {len(vertices)} vertices are not finite numbers; export it anew")
    if len(vertices) and (far := float(np.abs(vertices).max())) > FARTHEST:
        raise InputError(f"{source}: a coordinate of {far:.3g}, at most {FARTHEST:g}: export in mm")
    return Part(name, *merged(vertices, triangles))


def _by_trimesh(data: bytes, kind: str, source: str) -> list[Part]:
    """Names, vertices and triangles of all that a file holds, placed as it says."""
    import trimesh

    try:
        with np.errstate(all="ignore"):
            scene: Any = trimesh.load_scene(io.BytesIO(data), file_type=kind, process=False)
            placed = [(name, *scene.graph[name]) for name in scene.graph.nodes_geometry]
    except Exception as error:  # trimesh raises anything: every kind means that it cannot be read
        reason = str(error).splitlines()[:1] or [type(error).__name__]
        raise InputError(f"{source}: not a readable {kind} mesh: {reason[0][:120]}") from None
    parts = []
    for name, matrix, geometry in placed:
        mesh = scene.geometry[geometry]
        if not isinstance(mesh, trimesh.Trimesh):
            raise InputError(f"{source}: {name[:40]!r} holds points or lines; give a closed mesh")
        turn, shift = np.asarray(matrix)[:3, :3], np.asarray(matrix)[:3, 3]
        triangles = np.asarray(mesh.faces, np.int64).reshape(-1, 3)
        if np.linalg.det(turn) < 0.0:  # a mirror image is turned inside out
            triangles = triangles[:, ::-1]
        with np.errstate(invalid="ignore"):  # what is not finite is refused by _part
            vertices = np.asarray(mesh.vertices, np.float64) @ turn.T + shift
        parts.append(Part(str(name), vertices, triangles))
    return parts


def _refuse_bombs(data: bytes, source: str) -> None:
    """Raise InputError for what is no archive, or unpacks to more than MOST_BYTES."""
    try:
        size = sum(entry.file_size for entry in zipfile.ZipFile(io.BytesIO(data)).infolist())
    except (zipfile.BadZipFile, ValueError) as error:
        raise InputError(f"{source}: not a readable 3mf mesh: {error}") from None
    if size > MOST_BYTES:
        raise InputError(f"{source}: unpacks to {size} bytes, more than {MOST_BYTES}")
