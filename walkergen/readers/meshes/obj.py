"""Faces of OBJ files with more than three corners, cut into triangles as they lie in their plane."""

import re
from collections.abc import Sequence

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.numerics import Array

UNSUPPORTED_PATTERN = re.compile(rb"^[^#\n]+#|\t|^ |\\\r?\n", re.MULTILINE)
"""Lines that trimesh drops without a warning: with a comment behind, a tab, a blank before, or continued on
the next line."""


def triangulate_faces(data: bytes, source: str) -> bytes:
    """Return an OBJ file with vertices and triangles alone. Faces of more corners are cut by manifold3d.

    Raises InputError, which begins with `source`, for a face whose corners are not in the file.
    """
    text = data.decode("utf-8", "replace").replace("\\\r\n", " ").replace("\\\n", " ")
    lines = [line.partition("#")[0].split() for line in text.splitlines()]
    if not UNSUPPORTED_PATTERN.search(data) and not any(words[:1] == ["f"] and len(words) > 4 for words in lines):
        return data
    corners: list[list[float]] = []
    new_lines: list[str] = []
    for words in lines:
        if words[:1] == ["v"]:
            corners.append([_parse_number(word) for word in words[1:4]])
            new_lines.append(" ".join(words[:4]))
        elif words[:1] != ["f"]:
            new_lines.append("" if words[:1] in (["vt"], ["vn"], ["vp"]) else " ".join(words))
        else:
            # a number from the end counts from the corners so far, as from the start it counts from all
            indices = [int(word.partition("/")[0]) for word in words[1:]]
            indices = [index - 1 if index > 0 else len(corners) + index for index in indices]
            if not all(0 <= index < len(corners) for index in indices):
                raise InputError(f"{source}: a face has a corner that does not exist. Export the file again.")
            triangles = (
                [(0, 1, 2)] if len(indices) == 3 else _triangulate_polygon(np.array([corners[i] for i in indices]))
            )
            new_lines += ["f " + " ".join(str(indices[corner] + 1) for corner in triangle) for triangle in triangles]
    return "\n".join(new_lines).encode()


def _parse_number(word: str) -> float:
    """Return the number in a word, or NaN if it is none."""
    try:
        return float(word)
    except ValueError:
        return np.nan


def _triangulate_polygon(corners: Array) -> Sequence[Sequence[int]]:
    """Return corner indices of triangles that fill a plane polygon, shape (n, 3), in its sense of rotation."""
    following = np.roll(corners, -1, axis=0)
    normal = np.cross(corners, following).sum(axis=0)  # Newell's, twice the area
    turns = np.cross(following - corners, np.roll(corners, -2, axis=0) - following) @ normal
    count = len(corners)
    if not np.isfinite(turns).all() or (turns >= 0.0).all():
        return [(0, corner, corner + 1) for corner in range(1, count - 1)]
    import manifold3d

    _, _, axes = np.linalg.svd(corners - corners.mean(axis=0))
    plane = corners @ axes[:2].T
    if np.linalg.det(np.array([axes[0], axes[1], normal])) < 0.0:
        plane = plane * np.array([1.0, -1.0])
    cut: Sequence[Sequence[int]] = manifold3d.triangulate([plane]).tolist()
    return cut
