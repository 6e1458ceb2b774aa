"""Binary STL files: a header, the number of triangles, and a record for each, in 32-bit floats."""

import numpy as np
import numpy.typing as npt

from walkergen.core.errors import InputError
from walkergen.core.numerics import Array

Corners = npt.NDArray[np.float32]

HEADER_BYTES = 80
COUNT_BYTES = 4
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def pack(corners: Array, header: str) -> bytes:
    """Pack corners (triangles, 3, 3) in mm as binary STL. A triangle without area has a zero normal.

    The header begins with "binary STL", because readers take "solid" for the text format. Its
    characters beyond ASCII or beyond its 80 bytes are lost.
    """
    records = np.zeros(len(corners), TRIANGLE)
    records["corners"] = corners
    records["normal"] = _unit_normals(corners)
    start = f"binary STL, mm: {header}".encode("ascii", "replace")[:HEADER_BYTES]
    count = len(records).to_bytes(COUNT_BYTES, "little")
    return start.ljust(HEADER_BYTES) + count + records.tobytes()


def unpack(data: bytes, source: str) -> tuple[Corners, str]:
    """Return the unchanged corners (triangles, 3, 3) of a binary STL, in its unit, and a note on faults, or "".

    Programs that write while they compute leave the count at 0 or at its largest. The length then gives the number of
    triangles. Data after the counted triangles are left out. Raises InputError, which begins with `source`, when the
    length is not that of a binary STL with triangles, or when a corner is not finite.
    """
    start = HEADER_BYTES + COUNT_BYTES
    count = int.from_bytes(data[HEADER_BYTES:start], "little")
    count_by_length, rest = divmod(max(len(data) - start, 0), TRIANGLE.itemsize)
    note = ""
    if count_by_length and not rest and count in (0, 2**32 - 1):
        count, note = count_by_length, f"its count of triangles is not filled in: {count_by_length} by its length"
    elif 0 < count <= count_by_length and len(data) > start + count * TRIANGLE.itemsize:
        note = f"left out {len(data) - start - count * TRIANGLE.itemsize} bytes after its triangles"
    if count > count_by_length or count == 0:
        raise InputError(f"{source}: {len(data)} bytes is no binary STL file of {count} triangles. Save it again")
    corners: Corners = np.frombuffer(data, TRIANGLE, offset=start, count=count)["corners"]
    if not np.isfinite(corners).all():
        raise InputError(f"{source}: a corner is not finite. Write the file again")
    return corners, note


def _unit_normals(corners: Array) -> Array:
    """Compute normals of length 1, shape (triangles, 3), or zero for a triangle without area."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    units: Array = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)
    return units
