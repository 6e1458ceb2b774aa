"""The ladder of shape: effects of tessellation, float32 files and far origins on masses and speed."""

import io
import math
import statistics
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

import numpy as np

from walkergen.commands.accuracy.report import Ladder, Rung, format_order
from walkergen.core.errors import GeometryError
from walkergen.core.files.progress import Progress
from walkergen.core.printing.export import stl_bytes
from walkergen.core.scene import Scene
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.theory.stationary import stationary
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties, weigh

SEGMENT_COUNTS = (2, 4, 8, 16, 32, 64, 128, 256, 512)
EXACT_SEGMENTS = 4096
"""Number of edges of a half circle that counts as round: its error, of second order, is
(512/4096)^2 of the last rung's. tests/commands/accuracy/test_study.py compares it with the closed form."""

DISTANCES_MM = (0.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6)
"""Distances of the part from the coordinates' origin, mm."""


class Errors(NamedTuple):
    """Relative errors; m and j are the largest of all legs, or None for braced legs, which are part of M and J."""

    M: float
    J: float
    m: float | None
    j: float | None
    speed: float


def measure_shapes(design: Design, scene: Scene, progress: Progress) -> Ladder:
    """Measure relative errors of M, J, m, j and of the predicted speed, with the time each shape takes."""
    progress("tessellated", 0, 2)
    try:
        rungs = list(_tessellation_rungs(_with_round_feet(design), scene))
        measured = format_order([1.0 / count for count in SEGMENT_COUNTS], [rung.error or math.nan for rung in rungs])
        note = f"round foot: {measured} in the number of edges, claimed 2"
    except GeometryError as refused:
        rungs, note = [], f"Left out: round feet, {refused}"
    progress("far", 1, 2)
    rungs += _distance_rungs(design, scene)
    return Ladder(
        "shape",
        "What tessellation, files and distance do to the masses and the predicted speed",
        "largest relative error of M, J, m, j and the predicted speed",
        "CPU time to make the solids and weigh them, s",
        f"round feet: {EXACT_SEGMENTS} edges a half circle; files and distances: the mesh as built",
        rungs,
        (note, "Rectangles and flat feet are polygons: their meshes are exact, as is that of a file."),
    )


def _tessellation_rungs(rounded: Design, scene: Scene) -> Iterator[Rung]:
    def compute_mass(segments: int) -> MassProperties:
        return solids.weigh(rounded, solids.build(rounded, segments))

    true = compute_mass(EXACT_SEGMENTS)
    for segments in SEGMENT_COUNTS:
        seconds = measure_cpu_time(partial(compute_mass, segments), repeats=3)
        setting = f"{segments} edges"
        yield _rung("round foot", setting, compute_mass(segments), true, rounded, scene, seconds)


def _with_round_feet(design: Design) -> Design:
    """Return the design on round feet. Raises GeometryError if it cannot stand on them."""
    data = design.model_dump(exclude_unset=True)
    if design.pair:
        return Design.model_validate(data | {"legs": data.get("legs", {}) | {"foot": "round"}})
    legs = [leg | {"foot": "round"} for leg in data["legs"]]
    return Design.model_validate(data | {"legs": legs})


def _distance_rungs(design: Design, scene: Scene) -> Iterator[Rung]:
    """Yield rungs at growing distance, in double precision and through a binary STL file."""
    built = solids.build(design)
    true = solids.weigh(design, built)
    for series, form in (("double precision", _identity), ("through STL (float32)", _stl_round_trip)):
        for distance in DISTANCES_MM:
            weighed = partial(_mass_at_distance, design, built, distance, form)
            seconds = measure_cpu_time(weighed, repeats=3)
            setting = f"{distance:g} mm away"
            yield _rung(series, setting, weighed(), true, design, scene, seconds)


def _mass_at_distance(
    design: Design, built: solids.Solids, distance: float, form: Callable[[Mesh], Mesh]
) -> MassProperties:
    shift = distance * np.array([0.6, 0.8, 0.0])
    body, *legs = (form(mesh.shift(shift)) for mesh in (built.body, *built.legs))
    weighed = solids.assemble(design, weigh(body, 1.0), legs)
    # Anchors stay where the design has them: only O and the leg's centre have moved.
    at = shift[:2]
    return weighed._replace(
        legs=tuple(leg._replace(anchor=leg.anchor + at, c_A=leg.c_A - at, c_T=leg.c_T + at) for leg in weighed.legs)
    )


def _identity(mesh: Mesh) -> Mesh:
    return mesh


def _stl_round_trip(mesh: Mesh) -> Mesh:
    import trimesh

    data = io.BytesIO(stl_bytes(mesh, "part"))
    loaded = trimesh.load_mesh(data, file_type="stl", process=False)
    return Mesh(np.asarray(loaded.vertices, dtype=np.float64), np.asarray(loaded.faces))


def _rung(
    series: str, setting: str, mass: MassProperties, true: MassProperties, design: Design, scene: Scene, seconds: float
) -> Rung:
    errors = relative_errors(mass, true, design, scene)
    largest = max(error for error in errors if error is not None)
    return Rung(series, setting, largest, None, seconds, errors._asdict())


def relative_errors(weighed: MassProperties, true: MassProperties, design: Design, scene: Scene) -> Errors:
    """Compute the relative errors of a walker's masses and of its predicted speed.

    The speed's error counts against the larger foot's factor: the mean of braced feet may vanish.
    """
    contact = scene.contact
    predicted, true_prediction = (
        stationary(design, mass, contact.restitution, contact.friction, "coulomb") for mass in (weighed, true)
    )
    size = max(*(abs(float(foot)) for foot in true_prediction.feet), 1e-300)

    def relative(name: str) -> float:
        return abs(float(getattr(weighed, name)) / float(getattr(true, name)) - 1.0)

    def largest_leg_error(name: str) -> float:
        pairs = ((getattr(a, name), getattr(b, name)) for a, b in zip(weighed.legs, true.legs, strict=True))
        return max(abs(float(own) / float(exact) - 1.0) for own, exact in pairs if exact)

    return Errors(
        relative("M"),
        relative("J"),
        None if true.rigid else largest_leg_error("m"),
        None if true.rigid else largest_leg_error("j"),
        abs(float(predicted.factor - true_prediction.factor)) / size,
    )


def measure_cpu_time(call: Callable[[], object], repeats: int = 5, at_least: float = 1e-2) -> float:
    """Measure the CPU time of one call, s: the median of `repeats` batches of at least `at_least` s each.

    An untimed first call compiles, imports and fills caches.
    """
    call()
    count = 1
    while (spent := _time_batch(call, count)) < at_least:
        count = max(2 * count, math.ceil(count * at_least / max(spent, 1e-6)))
    return statistics.median(_time_batch(call, count) for _ in range(repeats)) / count


def _time_batch(call: Callable[[], object], count: int) -> float:
    started = time.thread_time()
    for _ in range(count):
        call()
    return time.thread_time() - started
