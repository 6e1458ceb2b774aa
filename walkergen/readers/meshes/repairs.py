"""Repair of a surface that is not yet a solid: each step returns the mesh and what it changed, or "".

Vertices along open edges are merged, triangles without area and doubled ones dropped, triangles
turned alike, small holes filled, bodies that overlap united by manifold3d, and crumbs
next to the largest body dropped. `faults` refuses what is still unsound afterwards.
A body that crosses itself is not repaired.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise

import manifold3d
import numpy as np

from walkergen.core.files import formatting
from walkergen.core.numerics import Array, Whole
from walkergen.core.shapes import modeller
from walkergen.core.shapes.mesh import Mesh
from walkergen.readers.meshes import faults

MAX_HOLE_EDGES = 200
"""Maximum number of open edges whose holes are filled: a larger hole is a missing side, not a flaw."""

MERGE_DISTANCE_FACTOR = 10.0
"""Maximum distance between vertices of open edges that are one, over the tolerance of crossings."""

MAX_CRUMB_SHARE = 0.01
"""Maximum volume of the bodies that are dropped, all but the largest, over the volume of the largest."""


def repair(mesh: Mesh) -> tuple[Mesh, tuple[str, ...]]:
    """Return a repaired mesh, and one text for each change, such as "filled holes of ..."; no texts without changes."""
    steps: tuple[Callable[[Mesh], tuple[Mesh, str]], ...] = (
        _merge_vertices,
        _drop_duplicates,
        _fix_orientation,
        _fill_holes,
        _fix_orientation,
        _unite_bodies,
    )
    before, changes = mesh, []
    for step in steps:
        mesh, change = step(mesh)
        if change:
            changes.append(change)
        if len(mesh.triangles) == 0:
            break
    if changes and len(mesh.triangles):
        changes.append(f"volume {_format_volume(before)} -> {_format_volume(mesh)} mm^3")
    return mesh, tuple(changes)


def _format_volume(mesh: Mesh) -> str:
    """Format the volume of a mesh, mm^3, or return "(open)" if it is not closed."""
    if len(faults.faulty_edges(mesh.triangles).open):
        return "(open)"
    return f"{faults.shells(mesh).volumes.sum():.6g}"


def _merge_vertices(mesh: Mesh) -> tuple[Mesh, str]:
    """Merge vertices of open edges that lie within MERGE_DISTANCE_FACTOR tolerances of each other."""
    within = MERGE_DISTANCE_FACTOR * faults.crossing_tolerance(mesh)
    closer, count = merge_rim_vertices(mesh, within)
    return closer, f"merged {count} vertices with others less than {within:.2g} mm away" if count else ""


def merge_rim_vertices(mesh: Mesh, max_distance: float) -> tuple[Mesh, int]:
    """Merge vertices along open edges within a distance, mm. Return the mesh and the number of merged vertices."""
    from scipy.sparse import coo_matrix, csgraph
    from scipy.spatial import KDTree

    rim = np.unique(faults.faulty_edges(mesh.triangles).open)
    if not len(rim):
        return mesh, 0
    pairs = KDTree(mesh.vertices[rim]).query_pairs(max_distance, output_type="ndarray")
    links = np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])
    groups = coo_matrix(links, (len(rim), len(rim)))
    number, label = csgraph.connected_components(groups, directed=False)
    first = np.full(number, len(mesh.vertices))
    np.minimum.at(first, label, rim)
    index = np.arange(len(mesh.vertices))
    index[rim] = first[label]
    return Mesh(mesh.vertices, index[mesh.triangles]), len(rim) - number


def _drop_duplicates(mesh: Mesh) -> tuple[Mesh, str]:
    """Drop triangles without area and repeated ones. Of two equal triangles that are back to back, drop both."""
    triangles = mesh.triangles
    real = ~(triangles == np.roll(triangles, 1, axis=1)).any(axis=1)
    triangles = triangles[real]
    corners = np.sort(triangles, axis=1)
    start = np.argmin(triangles, axis=1)
    following = triangles[np.arange(len(triangles)), (start + 1) % 3]
    turned = np.where(following == corners[:, 1], 1, -1)  # 1 or -1: sense of rotation of a triangle
    _, first, index = np.unique(corners, axis=0, return_index=True, return_inverse=True)
    index = index.reshape(-1)
    net = np.bincount(index, weights=turned, minlength=len(first)).astype(np.int64)
    # Of triangles with equal corners, the first that is turned as most of them are
    candidates = np.flatnonzero(turned * np.sign(net)[index] > 0)
    keep = np.sort(candidates[np.unique(index[candidates], return_index=True)[1]])
    flat, doubled = int((~real).sum()), len(triangles) - len(keep)
    drops = [f"{flat} triangles without area"] * (flat > 0) + [f"{doubled} doubled"] * (doubled > 0)
    return Mesh(mesh.vertices, triangles[keep]), f"dropped {' and '.join(drops)}" if drops else ""


def _fill_holes(mesh: Mesh) -> tuple[Mesh, str]:
    """Close small holes by fans of triangles, whose new edges are not in the mesh already."""
    rim = faults.faulty_edges(mesh.triangles).open
    if not 0 < len(rim) <= MAX_HOLE_EDGES:
        return mesh, ""
    triangles_at_rim = mesh.triangles[np.isin(mesh.triangles, rim).any(axis=1)]
    edges_at_rim = {(a, b) for row in triangles_at_rim.tolist() for a, b in zip(row, (*row[1:], row[0]), strict=True)}
    fans: list[tuple[int, int, int]] = []  # new triangles
    vertices = mesh.vertices
    pairs = set(map(tuple, rim.tolist()))
    for hole in _trace_holes(mesh.vertices, [edge for edge in sorted(edges_at_rim) if (min(edge), max(edge)) in pairs]):
        for start in range(len(hole)):
            first, *others = hole[start:] + hole[:start]
            if not any((first, other) in edges_at_rim or (other, first) in edges_at_rim for other in others[1:-1]):
                fans += [(first, ahead, behind) for behind, ahead in pairwise(others)]
                break
        else:  # about a new vertex in its middle
            fans += [(len(vertices), ahead, behind) for behind, ahead in pairwise([*hole, hole[0]])]
            vertices = np.vstack([vertices, mesh.vertices[hole].mean(axis=0)])
    if not fans:
        return mesh, ""
    filled = Mesh(vertices, np.concatenate([mesh.triangles, np.array(fans, np.int64)]))
    return (
        filled,
        f"filled holes of {len(rim)} open edges by {formatting.format_count(len(fans), 'triangle', 'triangles')}",
    )


def _trace_holes(vertices: Array, edges: Sequence[tuple[int, int]]) -> list[list[int]]:
    """Return the vertex indices around each hole. `edges`: open edges (start, end), in the direction of their triangle.

    Where holes touch in a vertex, the boundary goes on along the edge that is nearest in direction.
    """
    successors: dict[int, list[int]] = {}
    for start, end in edges:
        successors.setdefault(start, []).append(end)
    holes = []
    while successors:
        hole = [next(iter(successors))]
        while (here := hole[-1]) in successors:
            directions = vertices[successors[here]] - vertices[here]
            back = vertices[hole[-2]] - vertices[here] if len(hole) > 1 else directions[0]
            nearest = int(np.argmax(directions @ back / np.linalg.norm(directions, axis=1)))
            end = successors[here].pop(nearest)
            if not successors[here]:
                del successors[here]
            if end in hole:  # the hole is closed; what led to it goes on
                holes.append(hole[hole.index(end) :])
                hole = hole[: hole.index(end) + 1]
            else:
                hole.append(end)
    return holes


def _fix_orientation(mesh: Mesh) -> tuple[Mesh, str]:
    """Turn triangles until neighbours agree. Then turn every closed piece that is inside out, except cavities."""
    triangles = mesh.triangles
    edges = faults.faulty_edges(triangles)
    if len(edges.disagreeing):
        import trimesh

        agreeing = trimesh.Trimesh(mesh.vertices, triangles, process=False)
        trimesh.repair.fix_winding(agreeing)
        triangles = np.asarray(agreeing.faces, np.int64)
    if not len(edges.open):
        triangles = _orient_outward(Mesh(mesh.vertices, triangles))
    rotated = [np.roll(triangles, shift, axis=1) for shift in range(3)]
    same = np.any([(mesh.triangles == shifted).all(axis=1) for shifted in rotated], axis=0)
    number = int((~same).sum())
    turned = Mesh(mesh.vertices, np.ascontiguousarray(triangles))
    return turned, f"turned {number} of {len(same)} triangles" if number else ""


def _orient_outward(mesh: Mesh) -> Whole:
    """Return the triangles with every closed piece of negative volume turned, unless it is a cavity."""
    pieces = faults.shells(mesh)
    triangles = mesh.triangles.copy()
    for number in np.flatnonzero(pieces.volumes < 0.0):
        is_piece = pieces.label == number
        rest = Mesh(mesh.vertices, mesh.triangles[~is_piece])
        within = faults.winding_number(rest, mesh.vertices[triangles[is_piece][0, 0]])
        if round(within) % 2 == 0:
            triangles[is_piece] = triangles[is_piece][:, ::-1]
    return triangles


def _unite_bodies(mesh: Mesh) -> tuple[Mesh, str]:
    """Unite bodies that overlap. Keep only the largest if all others together are small (MAX_CRUMB_SHARE)."""
    edges = faults.faulty_edges(mesh.triangles)
    if any(len(pairs) for pairs in edges):
        return mesh, ""
    pieces = faults.shells(mesh)
    outward = np.flatnonzero(pieces.volumes > 0.0)
    if len(outward) < 2 or len(outward) < pieces.number:
        return mesh, ""
    solids = [modeller.to_solid(Mesh(mesh.vertices, mesh.triangles[pieces.label == number])) for number in outward]
    union = modeller.check_solid(manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add))
    bodies = sorted(union.decompose(), key=lambda body: -body.volume())
    rest = sum(abs(body.volume()) for body in bodies[1:])
    change = f"united {len(solids)} bodies to {len(bodies)}" if len(bodies) < len(solids) else ""
    if len(bodies) > 1 and rest <= MAX_CRUMB_SHARE * bodies[0].volume():
        dropped = f"dropped {formatting.format_count(len(bodies) - 1, 'body', 'bodies')} of {rest:.3g} mm^3 together"
        return modeller.to_mesh(bodies[0]), "; ".join(filter(None, (change, dropped)))
    return (modeller.to_mesh(union), change) if change else (mesh, "")
