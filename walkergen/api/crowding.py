"""Crowds, as the command `crowd` makes them."""

from collections.abc import Mapping
from pathlib import Path

from walkergen.api.loading import Ground, Name, Walker, scene_of, walker_of
from walkergen.errors import InputError
from walkergen.files.progress import Progress, silent
from walkergen.jobs.run.crowd import files, make, members, report
from walkergen.jobs.run.crowd.report import CrowdReport

SCENE = "plane-90hz"

RUNS = 4
"""Independent runs unless asked otherwise."""


def crowd(
    design: Walker | None = None, scene: Ground = SCENE, *,
    count: int | Mapping[Name, int] | None = None, packing: float | None = None,
    arena: str | None = None, seconds: float | None = None, runs: int = RUNS,
    seed: int | None = None, rate_hz: float = 25.0, threads: int | None = None,
    out: Name | None = None, progress: Progress | None = None,
) -> CrowdReport:  # fmt: skip
    """Let many walkers run in a dish and meet: order, clusters and packing with their errors.

    `count` is a number of walkers of the design, or numbers by the names or paths of several
    designs, {"polar-disc": 20, "rotator": 10}; or `packing` says how many. `arena`: "disc:120",
    "ring:160,60", "rectangle:200x100" or "periodic:150", mm. What is None is the scene's. Every
    run begins at other places; their scatter gives the errors. With `out` a folder of tables,
    figures and tracks is written. Raises InputError.
    """
    mixed = isinstance(count, Mapping)
    if mixed and design is not None:
        raise InputError(f"design={design!r}: count={count!r} names the designs: leave one out")
    if mixed:
        assert isinstance(count, Mapping)
        walkers, counts = [walker_of(name) for name in count], list(count.values())
        total: int | None = sum(counts)
    else:
        walkers, counts = [walker_of("koumakis2016" if design is None else design)], None
        total = count if isinstance(count, int) else None
    if total is not None:
        members.check(total, f"count={count!r}")
    values = {
        "crowd.count": total, "crowd.packing": packing, "crowd.arena_mm": arena,
        "run.seconds": seconds, "run.runs": runs, "run.seed": seed,
    }  # fmt: skip
    ground = scene_of(scene).variant(**{k: v for k, v in values.items() if v is not None})
    job = make.asked(ground, walkers, counts, rate_hz)
    simulated = make.simulate(job, threads, progress or silent)
    folder = None if out is None else Path(out)
    result = report.of(simulated, folder)
    return result if folder is None else files.write(result, folder, True, progress or silent)
