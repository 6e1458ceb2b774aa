"""Points: a walker simulated in a scene, a pure function of inputs that a key names.

Whatever needs a simulated speed asks for a point: families, sweeps, surveys and the command line.
What is asked and what comes back can be sent to other processes, so that any executor of
`concurrent.futures` may do the work.
"""

import hashlib
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from walkergen import __version__
from walkergen.drive import Drive
from walkergen.files.progress import Progress, part
from walkergen.numerics import kernels
from walkergen.scene import Scene
from walkergen.simulation import ensemble, resolution
from walkergen.simulation.effects.effect import METHODS, ModelName
from walkergen.simulation.ensemble import Summary
from walkergen.simulation.plan import prepare
from walkergen.simulation.resolution import Verdict
from walkergen.simulation.run import RunResult
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties


class Experiment(NamedTuple):
    """Input of a point: all that its numbers depend on, apart from the kernels."""

    scene: Scene
    design: Design
    mass: MassProperties
    impacts: bool = False
    """True to keep every impact of every run."""
    sample_interval: float | None = None
    """Time (s) between samples of every run; None to keep none. Sampled flights end at samples:
    such runs are others of the same ensemble."""

    @property
    def shaken(self) -> Drive:
        """Drive of the plate, or of one that would move under the walker as its motor moves it."""
        return self.scene.drive.beneath(float(self.mass.total))


class Results(NamedTuple):
    """Result of a point: the ensemble of runs that the scene's [run] asks for."""

    key: str
    model: ModelName
    summary: Summary
    """Statistics of the runs; the bounds of the speed hold the step's error as well."""
    results: Sequence[RunResult]
    """Finished runs, sorted by number; fewer than asked for after Ctrl-C."""
    verdicts: Mapping[str, Verdict]
    """What the step leaves of each observable, by the names of `observables.NAMES`."""
    warnings: Sequence[str]
    """Warnings on the step."""
    step_us: float | None
    """Step that was taken; None for a model that goes from event to event."""

    @property
    def method(self) -> str:
        """Method of the model: "event" or "step"."""
        return METHODS[self.model]


def facts(scene: Scene, design: Design) -> list[Any]:
    """Inputs of a simulation, for keys: without names and what only theory or printer read.

    Of bodies from files, and of letters, also what the files hold.
    """
    shape = design.body.shape
    drawn = [shape.sha256, [contour.tolist() for contour in shape.plan]]
    return [
        *([] if design.body.plain else drawn),
        scene.model_dump(mode="json", exclude={"name", "description", "prediction"}),
        design.model_dump(
            mode="json",
            exclude={"name": True, "description": True, "family": True, "material": {"nozzle_deg_c", "bed_deg_c"}},
        ),
        __version__,
        kernels.digest(),
    ]


def key(experiment: Experiment) -> str:
    """Hash of all that is asked and of the kernels' sources, 32 hexadecimal digits."""
    masses = _plain(experiment.mass)
    kept = [experiment.impacts, experiment.sample_interval]
    text = json.dumps([*facts(experiment.scene, experiment.design), masses, *kept], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def _plain(value: Any) -> Any:
    """Named tuples, tuples of them and arrays as what JSON has."""
    if hasattr(value, "_asdict"):
        return {name: _plain(item) for name, item in value._asdict().items()}
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return value if value is None else np.asarray(value).tolist()


def measure(experiment: Experiment, progress: Progress, threads: int | None = None) -> Results:
    """Simulate a point on `threads` threads (None: every core); Ctrl-C gives the runs done.

    Any number of threads gives equal bits. Raises InputError where the scene contradicts itself
    or the design, and KeyboardInterrupt when no run was done.
    """
    plan = prepare(experiment.scene, experiment.design, experiment.mass)
    summary, results = ensemble.measure(plan, progress, threads, experiment.impacts, experiment.sample_interval)
    verdicts, step = resolution.judge(plan, summary), getattr(plan.world.options, "step", None)
    return Results(
        key(experiment),
        plan.resolved.model,
        resolution.bounded(verdicts, summary),
        results,
        verdicts,
        resolution.warnings(plan),
        None if step is None else 1e6 * step,
    )


def each(
    wanted: Sequence[Experiment], titles: Sequence[str], progress: Progress, executor: Executor | None
) -> Iterator[Results]:
    """Points in their order, yielded when done; progress is reported under their titles.

    Without an executor points are simulated in turn, each on every core; with it each is a task on
    a single thread. Raises KeyboardInterrupt rather than yield a point with runs missing.
    """
    if executor is not None:
        tasks = [executor.submit(measure, experiment, _silent, 1) for experiment in wanted]
        for number, task in enumerate(tasks):
            progress(titles[number], number, len(tasks))
            yield task.result()
        return
    for number, experiment in enumerate(wanted):
        point = measure(experiment, part(progress, number, len(wanted), titles[number]))
        if point.summary.runs < experiment.scene.run.runs:
            raise KeyboardInterrupt
        yield point


def on_threads(wanted: Sequence[Experiment], titles: Sequence[str], progress: Progress) -> Iterator[Results]:
    """Points in their order, each on a thread of its own: best for points of a single run.

    Ends without those not yet begun when it is left or interrupted.
    """
    pool = ThreadPoolExecutor(os.cpu_count() or 1)
    try:
        yield from each(wanted, titles, progress, pool)
    finally:
        pool.shutdown(cancel_futures=True)


def _silent(what: str, done: int, total: int) -> None:
    """Progress that reports nothing."""
