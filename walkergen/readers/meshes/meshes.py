"""Reading of mesh files of any kind: STL, OBJ, PLY, OFF, 3MF, GLB; bodies as placed in the file.

Binary STL and 3MF are read by `core.shapes`, GLB by trimesh, polygons of other files by `formats`, from the bytes
alone: no other file and no address that a file may name is opened. Vertices that coincide become one, to the last bit
or, on open edges, within WELD_TOLERANCE. Negative volumes of a slicer's file are cut away, and parts that do not print
are left out. Notes list all of these changes.
"""

import codecs
import hashlib
import io
import zipfile
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.files import file_reading
from walkergen.core.files import formatting as words
from walkergen.core.numerics import Array, Whole
from walkergen.core.shapes import modeller, stl, threemf
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.shapes.threemf import Part
from walkergen.readers.meshes import faults, formats, glb, polygons, repairs

READERS = {"stl": formats.read_stl, "obj": formats.read_obj, "ply": formats.read_ply, "off": formats.read_off}
"""Functions that read polygons, by the file's extension. STL is the text format here."""

FORMATS = (*READERS, "3mf", "glb")

GLB_UNIT_MM = 1000.0
"""Length of a GLB file's unit, mm: metres, by its standard."""

MAX_BYTES = 2**30
"""Largest file, and largest content of a compressed one."""

TEXT_BYTES = 2000
"""Length of the beginning of an STL file that shows whether it is text: more than its name and a comment."""

MAX_COORDINATE = 1e12
"""Largest coordinate, in the file's unit."""

WELD_TOLERANCE = 1e-6
"""Maximum distance between corners on open edges that are one, over the size of a part: some last bits of
the 32-bit floats of STL and 3MF."""


MIN_AREA_SHARE = 1e-12
"""Area of a triangle, over the square of a part's size, below which it has none."""


class MeshFile(NamedTuple):
    """Contents of a mesh file."""

    parts: tuple[Part, ...]
    """Objects at their positions in the file. A file without objects, such as STL, counts as one object."""
    sha256: str
    """Hash of the file's bytes."""
    notes: tuple[str, ...]
    """Notes on what was left out, cut away or merged, a few words each."""


def read_mesh(path: Path, source: str) -> MeshFile:
    """Read the printable parts of a mesh file. Raises InputError, beginning with `source`, for any other file."""
    kind = path.suffix.lower().removeprefix(".")
    if kind not in FORMATS:
        raise InputError(f"{source}: ends in {path.suffix[:20]!r}. Give a mesh: {', '.join(FORMATS)}")
    data = file_reading.read_bytes(path, MAX_BYTES)
    with file_reading.translate_library_errors(source, kind.upper()):
        raw, notes = _read_parts(data, kind, source)
        welded = [_weld_edges(_clean_part(source, part)) for part in raw]
    whole = [_drop_flat_triangles(part) for part, _ in welded]
    parts = _printable_parts(whole, source)
    notes += _omission_notes(whole)
    if flat := sum(len(part.triangles) for part, _ in welded) - sum(len(part.triangles) for part in whole):
        notes.append(f"left out {words.format_count(flat, 'triangle', 'triangles')} without area")
    if merged_corners := sum(count for _, count in welded):
        notes.append(
            f"merged {words.format_count(merged_corners, 'corner that differs', 'corners that differ')} by "
            "rounding alone"
        )
    count = sum(len(part.triangles) for part in parts)
    if count == 0:
        raise InputError(f"{source}: it contains no triangles. Export the body as a mesh.")
    polygons.check_count(count, source)
    return MeshFile(tuple(parts), hashlib.sha256(data).hexdigest(), tuple(notes))


def _read_parts(data: bytes, kind: str, source: str) -> tuple[list[Part], list[str]]:
    """Return a file's parts, at their positions in it, and notes. `kind`: its extension. May raise any exception."""
    if kind == "3mf":
        _check_unpacked_size(data, source)
        return threemf.read_parts(data, source), []
    if kind == "glb":
        glb.check(data, source)
        polygons.check_count(glb.triangle_count(data), source)
        return [part._replace(vertices=GLB_UNIT_MM * part.vertices) for part in _read_with_trimesh(data, source)], []
    if kind == "stl" and _is_binary_stl(data):
        polygons.check_count((len(data) - stl.HEADER_BYTES) // stl.TRIANGLE.itemsize, source)
        corners, note = stl.unpack(data, source)
        vertices = corners.astype(np.float64).reshape(-1, 3)
        return [Part("mesh", vertices, np.arange(len(vertices)).reshape(-1, 3))], [note] if note else []
    surface = READERS[kind](data if kind == "ply" else _unify_text(data), source)
    return [Part("mesh", surface.vertices, polygons.triangulate(surface, source))], []


def _unify_text(data: bytes) -> bytes:
    """Return a file's text with one byte per letter, without byte order mark, with line ends as on Unix."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        data = data.decode("utf-16", "replace").encode("latin-1", "replace")
    return data.removeprefix(codecs.BOM_UTF8).replace(b"\r\n", b"\n").replace(b"\r", b"\n")


def _printable_parts(parts: list[Part], source: str) -> list[Part]:
    """Return the printed parts, with the negative volumes of each item subtracted from its parts."""
    printed = [part for part in parts if part.role == "model"]
    for number in {part.item for part in parts if part.role == "negative"}:
        item_parts = [part for part in printed if part.item == number]
        negative_parts = [part for part in parts if part.role == "negative" and part.item == number]
        for part in item_parts:
            faults.check_solid(Mesh(part.vertices, part.triangles), f"{source}: {part.name}")
        if not item_parts:
            continue
        joined = join_parts(tuple(item_parts))
        solid = modeller.to_solid(Mesh(joined.vertices, joined.triangles))
        for part in negative_parts:
            solid = modeller.check_solid(solid - modeller.to_solid(Mesh(part.vertices, part.triangles)))
        mesh = modeller.to_mesh(solid)
        remaining = item_parts[0]._replace(vertices=mesh.vertices, triangles=mesh.triangles)
        printed = [part for part in printed if part.item != number] + [remaining]
    return sorted(printed, key=lambda part: part.item)


def _omission_notes(parts: list[Part]) -> list[str]:
    """Describe what was cut away and what was left out of a file."""
    roles = Counter(part.role for part in parts)
    notes = [f"cut {roles['negative']} negative volumes away"] if roles["negative"] else []
    if roles["other"]:
        notes.append(f"left out {words.format_count(roles['other'], 'part that does not', 'parts that do not')} print")
    return notes


def _weld_edges(part: Part) -> tuple[Part, int]:
    """Merge corners along open edges of a part within WELD_TOLERANCE. Return the part and the count of merged ones."""
    if not len(part.triangles) or not len(faults.faulty_edges(part.triangles).open):
        return part, 0
    mesh = Mesh(part.vertices, part.triangles)
    closer, count = repairs.merge_rim_vertices(mesh, WELD_TOLERANCE * float(np.ptp(part.vertices, axis=0).max()))
    return part._replace(triangles=closer.triangles), count


def _drop_flat_triangles(part: Part) -> Part:
    """Return a part without triangles of only two corners, and without flat ones if the rest is then closed."""
    triangles = part.triangles[(part.triangles != np.roll(part.triangles, 1, axis=1)).all(axis=1)]
    if len(triangles) and any(map(len, faults.faulty_edges(triangles))):
        first, second, third = part.vertices[triangles].transpose(1, 0, 2)
        areas = np.linalg.norm(np.cross(second - first, third - first), axis=1)
        rest = triangles[areas > MIN_AREA_SHARE * float(np.ptp(part.vertices, axis=0).max()) ** 2]
        triangles = rest if len(rest) and not any(map(len, faults.faulty_edges(rest))) else triangles
    return part._replace(triangles=triangles)


def join_parts(parts: tuple[Part, ...]) -> Part:
    """Join all parts to one surface. Vertices that coincide to the last bit become one."""
    if len(parts) == 1:
        return parts[0]
    starts = np.cumsum([0] + [len(part.vertices) for part in parts])
    shifted = [part.triangles + start for part, start in zip(parts, starts, strict=False)]
    vertices = np.concatenate([part.vertices for part in parts])
    return Part(parts[0].name, *merge_vertices(vertices, np.concatenate(shifted)))


def merge_vertices(vertices: Array, triangles: Whole) -> tuple[Array, Whole]:
    """Return the distinct vertices, sorted by coordinates, and the triangles with indices into these vertices."""
    vertices = vertices + 0.0  # minus zero is zero
    order = np.lexsort(vertices.T)
    ordered = vertices[order]
    is_first = np.ones(len(ordered), bool)
    is_first[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    index = np.empty(len(ordered), np.int64)
    index[order] = np.cumsum(is_first) - 1
    return ordered[is_first], index[triangles]


def _is_binary_stl(data: bytes) -> bool:
    """Return whether an STL file is binary: its length fits its triangle count, or it lacks the text format's words."""
    start = stl.HEADER_BYTES + stl.COUNT_BYTES
    count = int.from_bytes(data[stl.HEADER_BYTES : start], "little")
    fits = len(data) == start + count * stl.TRIANGLE.itemsize
    text = _unify_text(data[: 2 * TEXT_BYTES]).lower()[:TEXT_BYTES]
    return fits or b"\0" in text or not (b"facet" in text or text.lstrip().startswith(b"solid"))


def _clean_part(source: str, part: Part) -> Part:
    """Merge coinciding vertices of a part. Raises InputError for unusable indices and numbers."""
    vertices, triangles = part.vertices, part.triangles
    if len(triangles) and not 0 <= triangles.min() <= triangles.max() < len(vertices):
        raise InputError(f"{source}: a triangle has a corner that does not exist. Export the file again.")
    bad = int((~np.isfinite(vertices).all(axis=1)).sum())
    if bad:
        raise InputError(f"{source}: {bad} of {len(vertices)} vertices are not finite numbers. Export the file again.")
    if len(vertices) and (largest := float(np.abs(vertices).max())) > MAX_COORDINATE:
        raise InputError(f"{source}: a coordinate of {largest:.3g}, at most {MAX_COORDINATE:g}: export in mm")
    vertices, triangles = merge_vertices(vertices, triangles)
    return part._replace(vertices=vertices, triangles=triangles)


def _read_with_trimesh(data: bytes, source: str) -> list[Part]:
    """Return all objects of a GLB file as parts, with vertices at their positions in the scene, m."""
    import trimesh

    with np.errstate(all="ignore"):
        scene: Any = trimesh.load_scene(io.BytesIO(data), file_type="glb", process=False)
        placed = [(name, *scene.graph[name]) for name in scene.graph.nodes_geometry]
    parts = []
    for name, matrix, geometry in placed:
        mesh = scene.geometry[geometry]
        if not isinstance(mesh, trimesh.Trimesh):
            raise InputError(f"{source}: {name[:40]!r} contains points or lines. Use a closed mesh.")
        turn, shift = np.asarray(matrix)[:3, :3], np.asarray(matrix)[:3, 3]
        triangles = np.asarray(mesh.faces, np.int64).reshape(-1, 3)
        if np.linalg.det(turn) < 0.0:  # a mirror image is turned inside out
            triangles = triangles[:, ::-1]
        with np.errstate(invalid="ignore"):  # _clean_part refuses values that are not finite
            vertices = np.asarray(mesh.vertices, np.float64) @ turn.T + shift
        parts.append(Part(str(name), vertices, triangles))
    return parts


def _check_unpacked_size(data: bytes, source: str) -> None:
    """Raise InputError for a 3MF file that is no archive, or unpacks to more than MAX_BYTES."""
    try:
        size = sum(entry.file_size for entry in zipfile.ZipFile(io.BytesIO(data)).infolist())
    except (zipfile.BadZipFile, ValueError) as error:
        raise InputError(f"{source}: not a readable 3mf mesh: {error}") from None
    if size > MAX_BYTES:
        raise InputError(f"{source}: unpacks to {size} bytes, more than {MAX_BYTES}")
