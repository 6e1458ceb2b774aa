"""The ways to make a printable part that parts.py compares, each timed in a process of its own.

A part is one walker of koumakis2016: solid, mass properties and a binary STL file. Every way
starts from the same numbers and must give the same volume and the same inertia about z. The
rivals weigh the printed solid once. walkergen, and the bare script that is its lower bound, do
more: they build the body and a leg as well and weigh these two, because the mechanics needs
M, J, m and j apart.

    python benchmarks/modellers.py WAY FOLDER REPEATS COUNT    prints JSON
    python benchmarks/modellers.py --all WAY FOLDER            all 160 parts, no more
"""

import json
import math
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

LENGTH, DEPTH, THICKNESS = 28.0, 8.0, 3.0  # body; mm, like everything here
LEG, SPACING, BRACE = 7.5, 13.0, 0.5
LEG_THICKNESS = {"flexible": 0.4, "braced": 1.0}
WARM_TILTS = [45.0 * step / 79 for step in range(80)]
COLD_TILTS = [0.5 * step for step in range(80)]

Part = tuple[float, str]
Weighed = tuple[float, float]
"""Volume in mm^3 and, for density 1, inertia about z through the centre of mass in mm^5."""
Maker = Callable[[Part, Path], Any]


def outlines(part: Part) -> list[Any]:
    """Counter-clockwise polygons of body, legs and braces; limbs reach 0.75 mm into the body."""
    tilt, kind = math.radians(part[0]), part[1]
    half, up = 0.5 * LEG_THICKNESS[kind] / math.cos(tilt), 0.25 * THICKNESS
    foot_x, foot_y = -LEG * math.sin(tilt), -LEG * math.cos(tilt)
    limbs = [[(-half, up), (-half, 0), (foot_x - half, foot_y), (foot_x + half, foot_y), (half, 0), (half, up)]]
    if kind == "braced":
        left, right = foot_x - 0.5 * BRACE, foot_x + 0.5 * BRACE
        limbs.append([(left, up), (left, 0), (left, foot_y), (right, foot_y), (right, 0), (right, up)])
    x, y = 0.5 * LENGTH, 0.5 * THICKNESS
    anchors = (-foot_x - 0.5 * SPACING, -foot_x + 0.5 * SPACING)
    placed = [[(px + a, py - y) for px, py in limb] for a in anchors for limb in limbs]
    return [[(-x, -y), (x, -y), (x, y), (-x, y)], *placed]


def with_walkergen() -> Maker:
    from walkergen.core.files import output
    from walkergen.core.printing import export
    from walkergen.core.walker import mass, names, solids
    from walkergen.core.walker.design import Design
    from walkergen.files import templates

    design = templates.load("koumakis2016", "walkers", Design)

    def make(part: Part, folder: Path) -> Callable[[], Weighed]:
        member = design.variant(tilt_deg=part[0], kind=part[1])  # type: ignore[arg-type]
        built, name = solids.build(member), names.part_name(member)
        solids.weigh(member, built)
        output.write(folder / f"{name}.stl", export.stl_bytes(built.walker, name))

        def check() -> Weighed:
            whole = mass.weigh(built.walker, 1.0)
            return float(whole.volume), float(whole.inertia)

        return check

    return make


def with_bare() -> Maker:
    """manifold3d and numpy, no package, no checks: what the same work costs at least."""
    import manifold3d

    triangle = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    unit = 2.0**25  # Clipper's grid is absolute: small numbers would lose their digits

    def extrude(polygons: list[Any]) -> Any:
        scaled = [unit * np.array(polygon) for polygon in polygons]
        section = manifold3d.CrossSection(scaled, manifold3d.FillRule.Positive)
        mesh = manifold3d.Manifold.extrude(section, unit * DEPTH).to_mesh64()
        return (np.asarray(mesh.vert_properties)[:, :3] / unit)[np.asarray(mesh.tri_verts)]

    def weigh(corners: Any) -> Weighed:
        p, q, r = corners[:, 0], corners[:, 1], corners[:, 2]
        six = np.einsum("ij,ij->i", p, np.cross(q, r))
        volume, total = six.sum() / 6, p + q + r
        centre = six @ total / (24 * volume)
        squares = (p * p + q * q + r * r + total * total)[:, :2].sum(axis=1)
        return volume, six @ squares / 120 - volume * (centre[0] ** 2 + centre[1] ** 2)

    def make(part: Part, folder: Path) -> Callable[[], Weighed]:
        polygons = outlines(part)
        limb = [polygon[1:-1] for polygon in polygons[1 : 1 + len(polygons) // 2]]
        walker, body, leg = (extrude(some) for some in (polygons, polygons[:1], limb))
        weigh(body)
        weigh(leg)
        records = np.zeros(len(walker), triangle)
        records["corners"] = walker
        normal = np.cross(walker[:, 1] - walker[:, 0], walker[:, 2] - walker[:, 0])
        records["normal"] = normal / np.linalg.norm(normal, axis=1, keepdims=True)
        data = b"binary STL".ljust(80) + len(records).to_bytes(4, "little") + records.tobytes()
        (folder / f"{part[0]:.3f}_{part[1]}.stl").write_bytes(data)
        return lambda: weigh(walker)

    return make


def with_trimesh() -> Maker:
    """Extruded polygons united in 3D by trimesh's manifold engine."""
    import trimesh
    from manifold3d import triangulate

    def extrude(polygon: list[Any]) -> Any:
        points = np.array(polygon, dtype=float)
        return trimesh.creation.extrude_triangulation(points, triangulate([points]), DEPTH)

    def make(part: Part, folder: Path) -> Weighed:
        walker = trimesh.boolean.union([extrude(p) for p in outlines(part)], engine="manifold")
        weighed = walker.mass_properties
        walker.export(folder / "part.stl")
        return weighed.volume, weighed.inertia[2][2]

    return make


def with_openscad() -> Maker:
    """Return a maker that runs OpenSCAD on a generated program, a process for each part; trimesh weighs."""
    import trimesh

    finer = 1024.0  # OpenSCAD's polygons lie on a grid of 2^-16 units: too coarse for 1e-6

    def make(part: Part, folder: Path) -> Weighed:
        program, target = folder / "part.scad", folder / "part.stl"
        shapes = "".join(
            f"linear_extrude({finer * DEPTH!r}) polygon({[[finer * x, finer * y] for x, y in polygon]!r});\n"
            for polygon in outlines(part)
        )
        program.write_text(f"scale({1 / finer!r}) union() {{\n{shapes}}}\n", encoding="utf-8")
        command = ["openscad", "-q", "--export-format", "binstl", "-o", str(target), str(program)]
        subprocess.run(command, check=True, capture_output=True)
        weighed = trimesh.load_mesh(target).mass_properties
        return weighed.volume, weighed.inertia[2][2]

    return make


def with_cadquery() -> Maker:
    """Return a maker that joins pieces by the documented chain of unions; a single fuse would take a third less."""
    import cadquery

    def make(part: Part, folder: Path) -> Weighed:
        pieces = [cadquery.Workplane("XY").polyline(polygon).close().extrude(DEPTH) for polygon in outlines(part)]
        walker = pieces[0]
        for piece in pieces[1:]:
            walker = walker.union(piece)
        solid = walker.val()
        inertia = cadquery.Shape.matrixOfInertia(solid)[2][2]
        cadquery.exporters.export(walker, str(folder / "part.stl"))
        return solid.Volume(), inertia

    return make


def with_build123d() -> Maker:
    import build123d

    def make(part: Part, folder: Path) -> Weighed:
        faces = [build123d.make_face(build123d.Polyline(*polygon, close=True)) for polygon in outlines(part)]
        pieces = [build123d.extrude(face, amount=DEPTH, dir=(0, 0, 1)) for face in faces]
        walker = pieces[0].fuse(*pieces[1:])
        inertia = walker.matrix_of_inertia[2][2]
        build123d.export_stl(walker, str(folder / "part.stl"))
        return walker.volume, inertia

    return make


WAYS: dict[str, tuple[Callable[[], Maker], str]] = {
    "walkergen": (with_walkergen, "pip install -e ."),
    "bare": (with_bare, "pip install manifold3d"),
    "trimesh": (with_trimesh, "pip install trimesh manifold3d"),
    "openscad": (with_openscad, "apt-get install openscad; pip install trimesh"),
    "cadquery": (with_cadquery, "pip install cadquery, in another environment: --install"),
    "build123d": (with_build123d, "pip install build123d, in another environment: --install"),
}


def worker(way: str, repeats: int, count: int, folder: Path) -> dict[str, Any]:
    """Make `count` parts `repeats` times over, timed; or say why this cannot be done here."""
    if way == "openscad" and shutil.which("openscad") is None:
        return {"skipped": "openscad is not on the PATH"}
    started = time.perf_counter()
    try:
        make = WAYS[way][0]()
    except ModuleNotFoundError as error:
        return {"skipped": str(error)}
    imports = time.perf_counter() - started
    parts = [(tilt, kind) for tilt in WARM_TILTS for kind in LEG_THICKNESS]
    chosen = [parts[round(step * (len(parts) - 1) / max(1, count - 1))] for step in range(count)]
    make(chosen[0], folder)
    per_part = []
    for _ in range(repeats):
        started = time.perf_counter()
        made = [make(part, folder) for part in chosen]
        per_part.append((time.perf_counter() - started) / count)
    weighed = [entry() if callable(entry) else entry for entry in made]
    return {
        "per_part": per_part,
        "imports": imports,
        "version": _version(way),
        "weighed": list(zip(chosen, weighed, strict=True)),
    }


def _version(way: str) -> str:
    if way == "openscad":
        said = subprocess.run(["openscad", "--version"], check=True, capture_output=True, text=True)
        return (said.stdout + said.stderr).split()[-1]
    return version({"bare": "manifold3d"}.get(way, way))


def make_all(way: str, folder: Path) -> None:
    make = WAYS[way][0]()
    folder.mkdir(exist_ok=True)
    for tilt in COLD_TILTS:
        for kind in LEG_THICKNESS:
            make((tilt, kind), folder)


if __name__ == "__main__":
    if sys.argv[1] == "--all":
        make_all(sys.argv[2], Path(sys.argv[3]))
    else:
        way, folder, repeats, count = sys.argv[1:]
        print(json.dumps(worker(way, int(repeats), int(count), Path(folder))))
