"""Faults that keep a surface from being one solid, such as open edges, described with number and position.

A sound mesh is closed, consistently turned, outward, of one body (which may hold closed cavities),
encloses something and does not cross itself. Edges are compared by their vertices' indices, so
that vertices with equal coordinates must be merged first. Bodies that touch in a vertex count as apart, as
in manifold3d; touching within RELATIVE_TOLERANCE is no crossing.
"""

from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from walkergen.core.errors import InputError, Remedy
from walkergen.core.numerics import Array, Whole
from walkergen.core.shapes.mesh import Mesh
from walkergen.readers.drawings import crossings

RELATIVE_TOLERANCE = 1e-6
"""Depth of a crossing, over the mesh's largest coordinate or side, below which the crossing is
ignored: fifteen times the rounding error of a coordinate in 32-bit floats, as in STL."""

MIN_VOLUME_RATIO = 1e-9
"""Volume over the cube of the largest side of the box, below which a mesh encloses nothing."""


class Edges(NamedTuple):
    """Edges of a surface, sorted by the kind of their fault: indices of their two vertices, shape (n, 2) each."""

    open: Whole
    """Edges of one triangle only."""
    crowded: Whole
    """Edges of three triangles or more."""
    disagreeing: Whole
    """Edges of two triangles that are turned differently: one is inside out."""


class Shells(NamedTuple):
    """Closed pieces of a surface."""

    number: int
    """Number of pieces."""
    label: Whole
    """Index of the piece that each triangle belongs to, shape (k,)."""
    volumes: Array
    """Volumes of the pieces, negative where turned inward, mm^3, shape (number,)."""


def check_solid(mesh: Mesh, source: str, repairs: Sequence[Remedy] = ()) -> None:
    """Raise InputError, one line that begins with `source`, when a mesh is not a sound solid.

    If a repair may mend the fault, the error suggests the remedies `repairs`.
    """
    fault = _triangle_fault(mesh) or _edge_fault(mesh) or _shell_fault(mesh, shells(mesh))
    if fault:
        raise InputError(f"{source}: {fault}", helps=partial(tuple, repairs))
    if fault := _crossing_fault(mesh):
        raise InputError(f"{source}: {fault}")


def check_closed(mesh: Mesh, source: str) -> tuple[int, str]:
    """Return the number of bodies of a closed mesh, and the fault of triangles that cross each other, or "".

    Bodies that touch along edges count as one. Raises InputError, which begins with `source`, for meshes that are not
    closed.
    """
    fault = _triangle_fault(mesh) or _edge_fault(mesh, several=True)
    pieces = shells(mesh)
    if fault := fault or _shell_fault(mesh, pieces, several=True):
        raise InputError(f"{source}: {fault}")
    return int((pieces.volumes > 0.0).sum()), _crossing_fault(mesh)


def crossing_tolerance(mesh: Mesh) -> float:
    """Return the depth up to which triangles of a mesh may cross each other without a fault, mm."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    size = max(float(np.abs(mesh.vertices).max()), float((high - low).max()))
    return RELATIVE_TOLERANCE * size


def faulty_edges(triangles: Whole, several: bool = False) -> Edges:
    """Find the faulty edges of triangles, shape (k, 3), and sort them by the kind of their fault.

    If `several` bodies are allowed, edges along which two of them touch are no fault.
    """
    starts, ends = triangles.reshape(-1), triangles[:, [1, 2, 0]].reshape(-1)
    size = np.int64(triangles.max()) + 1
    keys = _edge_keys(starts, ends, size)
    order = np.argsort(keys)
    keys, forward = keys[order], np.where(starts < ends, 1, -1)[order]
    first = np.flatnonzero(np.r_[True, keys[1:] != keys[:-1]])
    times, turns = np.diff(np.r_[first, len(keys)]), np.add.reduceat(forward, first)
    crowded = (times > 2) & ((turns != 0) | (not several))
    wrong = (keys[first[rows]] for rows in (times == 1, crowded, (times == 2) & (turns != 0)))
    return Edges(*(np.column_stack([pairs // size, pairs % size]) for pairs in wrong))


def _edge_keys(starts: Whole, ends: Whole, size: np.int64) -> Whole:
    """Return an integer for each edge, equal for both directions of the edge. `size` exceeds all vertex indices."""
    keys: Whole = np.minimum(starts, ends) * size + np.maximum(starts, ends)
    return keys


def shells(mesh: Mesh) -> Shells:
    """Divide a closed surface into pieces that share no edge, in the order of their first triangles."""
    from scipy.sparse import coo_matrix, csgraph

    count = len(mesh.triangles)
    starts, ends = mesh.triangles.reshape(-1), mesh.triangles[:, [1, 2, 0]].reshape(-1)
    keys = _edge_keys(starts, ends, np.int64(len(mesh.vertices)))
    order = np.argsort(keys)
    owner, keys = np.repeat(np.arange(count), 3)[order], keys[order]
    same = np.flatnonzero(keys[1:] == keys[:-1])
    links = np.ones(len(same), np.int8), (owner[same], owner[same + 1])
    number, label = csgraph.connected_components(coo_matrix(links, (count, count)), directed=False)
    corners = (mesh.vertices - mesh.vertices.mean(axis=0))[mesh.triangles]
    six = np.einsum("ki,ki->k", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    volumes: Array = np.bincount(label, weights=six / 6.0, minlength=number).astype(np.float64)
    return Shells(int(number), label.astype(np.int64), volumes)


def format_place(points: Array) -> str:
    """Format the mean of points, shape (..., 3), as coordinates for a message."""
    x, y, z = points.reshape(-1, 3).mean(axis=0) + 0.0
    return f"({x:.4g}, {y:.4g}, {z:.4g})"


def _triangle_fault(mesh: Mesh) -> str:
    """Describe missing or flat triangles, or vertices that are not finite. Return "" without such faults."""
    if len(mesh.triangles) == 0:
        return "holds no triangles"
    bad = int((~np.isfinite(mesh.vertices).all(axis=1)).sum())
    if bad:
        return f"{bad} of {len(mesh.vertices)} vertices are not finite numbers. Export the file again"
    flat = (mesh.triangles == np.roll(mesh.triangles, 1, axis=1)).any(axis=1)
    if flat.any():
        where = format_place(mesh.vertices[mesh.triangles[flat][0]])
        return f"{int(flat.sum())} triangles have no area, one at {where}"
    return ""


def _edge_fault(mesh: Mesh, several: bool = False) -> str:
    """Describe open, crowded or disagreeing edges, or return "". If `several` bodies are allowed, they may touch."""
    wrong = faulty_edges(mesh.triangles, several)
    for pairs, words in (
        (wrong.open, "is open: {} edges belong to one triangle only"),
        (wrong.crowded, "is not a solid's surface: {} edges belong to three triangles or more"),
        (wrong.disagreeing, "is partly inside out: at {} edges two triangles disagree"),
    ):
        if len(pairs):
            where = format_place(mesh.vertices[pairs[0]])
            return f"{words.format(len(pairs))}, the first at {where}"
    return ""


def _shell_fault(mesh: Mesh, shells: Shells, several: bool = False) -> str:
    """Describe a surface that is empty, inside out, or of more than one body unless `several` are allowed; or ""."""
    size = float((mesh.vertices.max(axis=0) - mesh.vertices.min(axis=0)).max())
    volume = float(shells.volumes.sum())
    if abs(volume) <= MIN_VOLUME_RATIO * size**3:
        return f"encloses nothing: its volume is {volume:.3g} mm^3 in a box of {size:.4g} mm"
    outward = np.flatnonzero(shells.volumes > 0.0)
    if len(outward) == 0:
        return f"is inside out: its volume is {volume:.4g} mm^3"
    if len(outward) > 1 and not several:
        sizes = np.sort(shells.volumes[outward])[::-1]
        listed = ", ".join(f"{size:.4g}" for size in sizes[:5]) + (", ..." if len(sizes) > 5 else "")
        return f"holds {len(outward)} bodies of {listed} mm^3. Give one"
    return _nesting_fault(mesh, shells) if shells.number > 1 else ""


def _nesting_fault(mesh: Mesh, shells: Shells) -> str:
    """Describe a cavity outside of a body, or a body within another. Return "" if there are none."""
    order = np.argsort(shells.label, kind="stable")
    pieces = np.split(mesh.triangles[order], np.cumsum(np.bincount(shells.label))[:-1])
    corners = [mesh.vertices[piece] for piece in pieces]
    low, high = np.array([c.min(axis=(0, 1)) for c in corners]), np.array([c.max(axis=(0, 1)) for c in corners])
    for number, is_cavity in enumerate(shells.volumes <= 0.0):
        point = corners[number][0, 0]
        near = set(np.flatnonzero(((low <= point) & (point <= high)).all(axis=1)).tolist()) - {number}
        turns = sum(winding_number(Mesh(mesh.vertices, pieces[other]), point) for other in near)
        if abs(turns - is_cavity) > 0.5:  # around a body lies nothing or a cavity, around a cavity its body
            what = "a second body, inside out," if is_cavity else "a body within another"
            return f"holds {what} at {format_place(corners[number][0])}. Remove it or turn it"
    return ""


def _crossing_fault(mesh: Mesh) -> str:
    """Describe triangles that cross each other. Return "" if there are none."""
    limit = crossing_tolerance(mesh)
    pairs = crossings.find(mesh.vertices, mesh.triangles, limit)
    if not pairs.number:
        return ""
    where = format_place(mesh.vertices[mesh.triangles[list(pairs.pair)]])
    return (
        f"crosses itself: {pairs.number} pairs of triangles (deeper than {limit:.2g} mm), one at "
        f"{where}; unite its parts in the program that made it (Blender: remesh)"
    )


def winding_number(mesh: Mesh, point: Array) -> float:
    """Return the winding number of a closed surface about a point that is not on it: 1 inside, 0 outside.

    Source: solid angle of a triangle by van Oosterom and Strackee (1983), summed.
    """
    a, b, c = (mesh.vertices - point)[mesh.triangles].transpose(1, 0, 2)
    p, q, r = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    triple = np.einsum("ki,ki->k", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("ki,ki->k", *pair) for pair in ((a, b), (b, c), (c, a)))
    return float(np.arctan2(triple, p * q * r + ab * r + bc * p + ca * q).sum() / (2.0 * np.pi))
