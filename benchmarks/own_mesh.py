"""What a body of one's own costs: united with two legs, weighed, written; and to read and check.

A sphere with a rough skin, of 100 000 triangles unless asked otherwise, gets two legs. Timed are
the union, its check, the inertia tensor and the binary STL on disk; not timed are loading
(with the conversion of the body for the modeller, which is in the second table) and
compilation. Next to the wall time is the processor's, which a shared machine stretches less.
trimesh does the same with its own union (manifold engine), mass properties and writer, in turns in
the same run; it converts in its union, so that a row with our conversion is next to it.
Reading and checking (open, inside out, crossings) are timed by parts. The last table is of one mesh
of a million triangles, in a process of its own, with its peak of memory.

    python benchmarks/own_mesh.py [--triangles 100000] [--repeats 5] [--million]
"""

import argparse
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from parts import machine

from walkergen.core.files import output
from walkergen.core.printing import export
from walkergen.core.shapes import joining, stl
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import mass
from walkergen.readers.drawings import crossings
from walkergen.readers.meshes import faults, meshes
from walkergen.readers.walkers import body_mesh, footing

DENSITY = 1.24e-3
LIMIT = 0.3
AGREEMENT = 1e-7  # relative, of volumes and moments; trimesh hands 32-bit floats to manifold3d


def rough_sphere(triangles: int) -> Mesh:
    """Sphere of 10 mm with a skin rough by a hundredth of a triangle's side."""
    import trimesh

    side = round((triangles / 8) ** 0.5) + 1
    ball = trimesh.creation.uv_sphere(radius=10.0, count=[side, 2 * side])
    rng = np.random.default_rng(13)
    vertices = ball.vertices * (1.0 + 0.03 / side * rng.uniform(size=(len(ball.vertices), 1)))
    return Mesh(*meshes.merge_vertices(vertices, np.asarray(ball.faces, np.int64)))


def two_legs(body: joining.Body) -> list[Mesh]:
    upward = np.array([np.sin(0.2), np.cos(0.2), 0.0])
    found = []
    middle = 0.5 * (body.mesh.vertices[:, 2].min() + body.mesh.vertices[:, 2].max())
    for x in (-5.0, 2.0):
        foot = np.array([x, -16.0, middle + 0.1])
        reach = footing.find_footing(body, foot, upward, 0.4, 5.0).reach
        found.append(joining.leg_prism(foot, upward, 0.4, 5.0, reach + 0.7))
    return found


def with_walkergen(body: joining.Body, legs: list[Mesh], path: Path) -> tuple[float, Any]:
    whole = joining.unite_with_legs(body, legs)
    weighed = mass.weigh(whole, DENSITY)
    output.write(path, export.stl_bytes(whole, "own"))
    return weighed.volume, weighed.tensor


def with_trimesh(body: Any, legs: list[Any], path: Path) -> tuple[float, Any]:
    import trimesh

    whole = trimesh.boolean.union([body, *legs], engine="manifold")
    whole.density = DENSITY
    weighed = whole.mass_properties
    whole.export(path)
    return weighed.volume, weighed.inertia


def time_call(call: Callable[[], Any]) -> tuple[float, Any]:
    started = time.perf_counter()
    result = call()
    return time.perf_counter() - started, result


def timed_twice(call: Callable[[], Any]) -> tuple[tuple[float, float], Any]:
    """Wall time and processor time of a call, s, and its result."""
    started = time.process_time()
    seconds, result = time_call(call)
    return (seconds, time.process_time() - started), result


def unite(body: Mesh, repeats: int, folder: Path) -> bool:
    """Print the times of union, weighing and writing; True when both agree within AGREEMENT."""
    import trimesh

    made = joining.prepare_body(body)
    legs = two_legs(made)
    taken: dict[str, list[tuple[float, float]]] = {"walkergen": [], "the same, with its conversion": [], "trimesh": []}
    apart = 0.0
    for _ in range(repeats):
        # trimesh keeps what it has computed: each time a mesh that knows nothing yet
        theirs = [trimesh.Trimesh(*mesh, process=False) for mesh in (body, *legs)]
        path = folder / "own.stl"
        seconds, mine = timed_twice(lambda path=path: with_walkergen(made, legs, path))
        taken["walkergen"].append(seconds)
        seconds, _ = timed_twice(lambda path=path: with_walkergen(joining.prepare_body(body), legs, path))
        taken["the same, with its conversion"].append(seconds)
        seconds, other = timed_twice(lambda given=theirs: with_trimesh(given[0], given[1:], folder / "rival.stl"))
        taken["trimesh"].append(seconds)
        for a, b in zip(mine, other, strict=True):
            apart = max(apart, float(np.abs(np.subtract(a, b)).max() / np.abs(b).max()))
    print(f"{len(body.triangles)} triangles, two legs: union, mass, STL")
    print(f"  {'':<30}{'wall s':>8}{'least..most':>16}{'cpu s':>8}{'ratio':>8}")
    own = statistics.median(wall for wall, _ in taken["walkergen"])
    for way, times in taken.items():
        walls, busy = zip(*times, strict=True)
        spread, median = f"{min(walls):.3f}..{max(walls):.3f}", statistics.median(walls)
        print(f"  {way:<30}{median:8.3f}{spread:>16}{statistics.median(busy):8.3f}{median / own:8.2f}")
    print(f"  volumes and tensors differ by {apart:.1e}; the limit of time is {LIMIT} s")
    return apart <= AGREEMENT


def time_reading(body: Mesh, folder: Path) -> None:
    """Print the times of reading a file and of each check."""
    path = folder / "body.stl"
    path.write_bytes(stl.pack(body.vertices[body.triangles], "body"))
    total, found = time_call(lambda: body_mesh.read_body(path))
    mesh = found.mesh
    rows = {
        "file to merged vertices": time_call(lambda: meshes.read_mesh(path, "body"))[0],
        "edges": time_call(lambda: faults.faulty_edges(mesh.triangles))[0],
        "closed pieces": time_call(lambda: faults.shells(mesh))[0],
        "conversion for the modeller": time_call(lambda: joining.prepare_body(mesh))[0],
        "crossings": time_call(lambda: crossings.find(mesh.vertices, mesh.triangles, 1e-5))[0],
        "all of reading and checks": total,
    }
    print(f"{len(mesh.triangles)} triangles, read and checked")
    for name, seconds in rows.items():
        print(f"  {name:<28}{seconds:8.3f} s")


def million() -> None:
    """Print time and peak memory of a million triangles, in this process alone."""
    small = rough_sphere(1000)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        time_reading(small, folder)  # imports, compiles
        path = folder / "million.stl"
        body = rough_sphere(1_000_000)
        path.write_bytes(stl.pack(body.vertices[body.triangles], "body"))
        del body
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        seconds, found = time_call(lambda: body_mesh.read_body(path))
        after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        print(f"a million: {len(found.mesh.triangles)} triangles, {path.stat().st_size / 1e6:.0f} MB")
        print(f"  read and checked in {seconds:.2f} s, peak {after / 1e6:.2f} GB (before {before / 1e6:.2f} GB)")
        made = joining.prepare_body(found.mesh)
        legs = two_legs(made)
        seconds, _ = time_call(lambda: with_walkergen(made, legs, folder / "own.stl"))
        after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        print(f"  united, weighed, written in {seconds:.2f} s, peak {after / 1e6:.2f} GB")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--triangles", type=int, default=100_000)
    parser.add_argument("--repeats", type=int, default=5, help="medians of this many runs")
    parser.add_argument("--million", action="store_true", help="only the mesh of a million")
    options = parser.parse_args()
    if options.million:
        million()
        return
    print(machine())
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        time_reading(rough_sphere(1000), folder)  # imports, compiles
        body = rough_sphere(options.triangles)
        agree = unite(body, options.repeats, folder)
        time_reading(body, folder)
    subprocess.run([sys.executable, __file__, "--million"], check=True)
    if not agree:
        raise SystemExit(f"trimesh finds another volume or tensor: more than {AGREEMENT:g} apart")


if __name__ == "__main__":
    main()
