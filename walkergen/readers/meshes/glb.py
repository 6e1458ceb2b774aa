"""GLB files: the number of their triangles before they are read, and a check for features that are not supported."""

import json
from typing import Any

from walkergen.core.errors import InputError

TRIANGLE_STRIP_MODE = 5
"""Mode of faces with a triangle for every corner after the second."""

PACKING_EXTENSIONS = (
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "KHR_draco_mesh_compression",
    "KHR_mesh_quantization",
)
"""Extensions that pack the corners of meshes, or place meshes outside the nodes."""

PARSE_ERRORS = (LookupError, TypeError, ValueError, AttributeError, RecursionError)
"""Errors that reading raises for a file that is no GLB, or not as the standard requires."""


def check(data: bytes, source: str) -> None:
    """Raise InputError, which begins with `source`, for meshes that are packed, posed by a skeleton, or morphed."""
    try:
        tree = _parse_json(data)
        packed = [
            name
            for name in PACKING_EXTENSIONS
            if name in [*tree.get("extensionsUsed", ()), *tree.get("extensionsRequired", ())]
        ]
        has_skeleton = any("skin" in node for node in tree.get("nodes", ()))
        has_weights = any(any(part.get("weights", ())) for part in [*tree.get("nodes", ()), *tree.get("meshes", ())])
    except PARSE_ERRORS:
        return  # its reader reports the error
    for found, what in (
        (packed, f"is packed by {', '.join(packed)}"),
        (has_skeleton, "has a skeleton"),
        (has_weights, "is morphed by weights"),
    ):
        if found:
            raise InputError(f"{source}: {what}, which walkergen cannot read. Export the plain mesh.")


def triangle_count(data: bytes) -> int:
    """Count the triangles of a GLB before it is read, as its JSON states them, or return 0 if that is not readable.

    The result is at least a third of the largest array's length, even if no mesh uses that array. A few bytes can
    declare a huge array of zeros, which a reader would create.
    """

    def count_triangles(primitive: dict[str, Any]) -> int:
        """Return the number of triangles of a primitive from the length of its array of corners, in `counts`."""
        count: int = counts[primitive["indices"] if "indices" in primitive else primitive["attributes"]["POSITION"]]
        return count if primitive.get("mode") == TRIANGLE_STRIP_MODE else count // 3

    try:
        tree = _parse_json(data)
        counts = [int(accessor["count"]) for accessor in tree["accessors"]]
        meshes = [sum(map(count_triangles, mesh["primitives"])) for mesh in tree["meshes"]]
        placed = sum(meshes[node["mesh"]] for node in tree["nodes"] if "mesh" in node)
    except PARSE_ERRORS:
        return 0
    return max(int(placed), max(counts, default=0) // 3)


def _parse_json(data: bytes) -> Any:
    """Parse a file's JSON, which describes its contents."""
    return json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
