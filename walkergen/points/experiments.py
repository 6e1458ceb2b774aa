"""A walker in a scene as an experiment: its results depend only on its inputs, whose hash is its key.

Families, sweeps, surveys and the command line get their simulated speeds from it.
"""

import hashlib
import json
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from walkergen import __version__
from walkergen.core.drive import Drive
from walkergen.core.numerics import kernels
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.scene import Scene
from walkergen.core.simulation import ensemble
from walkergen.core.simulation.batch import OneRun
from walkergen.core.simulation.ensemble import Summary
from walkergen.core.simulation.plan import Plan, prepare
from walkergen.core.simulation.run import RunResult, compile_kernels
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties
from walkergen.points import step_errors

MIN_STEP_US = 0.05
"""Minimum step (us) after halving."""


class Walker(NamedTuple):
    """Walker in a scene: an experiment (`core.measure`) whose runs are independent drops of it."""

    scene: Scene
    design: Design
    mass: MassProperties
    impacts: bool = False
    """True to keep every impact of every run."""
    sample_interval: float | None = None
    """Time (s) between samples of every run; None to keep none. Sampled flights end at samples:
    such runs are others of the same ensemble."""

    @property
    def equivalent_drive(self) -> Drive:
        """Drive of the plate. For a walker with a motor: the drive of a plate that would move it in the same way."""
        return self.scene.drive.equivalent_plate_drive(float(self.mass.total))

    @property
    def key(self) -> str:
        """Hash of all inputs and of the kernels' sources, 32 hexadecimal digits."""
        masses = _to_json(self.mass)
        kept = [self.impacts, self.sample_interval]
        text = json.dumps([*key_facts(self.scene, self.design), masses, *kept], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:32]

    def plan(self) -> Plan:
        """Return the plan of the walker's simulation. Raises InputError if scene and design contradict each other."""
        return prepare(self.scene, self.design, self.mass)

    def prepare(self) -> OneRun[RunResult]:
        """Compile the kernels and return a function that simulates the run with a given number."""
        plan = self.plan()
        compile_kernels(plan)
        return ensemble.runner(plan, self.impacts, self.sample_interval)

    def quantities(self, records: Sequence[RunResult]) -> list[Quantity]:
        """Return the observables averaged over runs, each with its error from the time step as `bias`."""
        plan = self.plan()
        summary = ensemble.summarise(records, plan.equivalent_drive.peak_speed, 0.0)
        return list(step_errors.add_step_bias(plan, summary.numbers).values())

    def finer(self) -> "Walker | None":
        """Return the walker with half the time step; None if that is below MIN_STEP_US."""
        step = _step_us(self.plan())
        return None if step < 2.0 * MIN_STEP_US else self.with_run_settings(step_us=0.5 * step)

    def with_run_settings(self, **run: float) -> "Walker":
        """Return the walker with a changed scene. `run`: new values of keys in the scene's table [run]."""
        return self._replace(scene=self.scene.model_copy(update={"run": self.scene.run.model_copy(update=run)}))


class Results(NamedTuple):
    """Runs of a walker, and their numbers."""

    walker: Walker
    """Walker; its scene has the number of runs and the time step that were used."""
    summary: Summary
    """Statistics of the runs; each number has its error by the time step as bias."""
    results: Sequence[RunResult]
    """Finished runs, sorted by number; fewer than requested after Ctrl-C."""
    warnings: Sequence[str]
    """Warnings on keys without a part."""
    step_us: float
    """Time step of the runs, µs."""

    @property
    def partial(self) -> bool:
        """Whether runs are missing after Ctrl-C."""
        return self.summary.runs < self.walker.scene.run.runs


def key_facts(scene: Scene, design: Design) -> list[Any]:
    """Return all inputs that a simulation's results depend on, as JSON values to be hashed to a key.

    Names, and values that only theory or printer use, are left out. Bodies from files, and letters, add their shape.
    """
    shape = design.shape
    drawn = [shape.sha256, [contour.tolist() for contour in shape.plan]]
    return [
        *([] if design.body.plain else drawn),
        scene.model_dump(mode="json", exclude={"name", "description", "prediction"}),
        design.model_dump(
            mode="json",
            exclude={"name": True, "description": True, "family": True, "material": {"nozzle_deg_c", "bed_deg_c"}},
        ),
        __version__,
        kernels.source_digest(),
    ]


def from_records(walker: Walker, records: Sequence[RunResult], runs: int, wall_s: float) -> Results:
    """Return the results of a walker's finished runs, `records`. `runs`: requested number. `wall_s`: their time, s."""
    plan = walker.plan()
    summary = ensemble.summarise(records, plan.equivalent_drive.peak_speed, wall_s)
    return Results(
        walker.with_run_settings(runs=runs),
        summary._replace(numbers=step_errors.add_step_bias(plan, summary.numbers)),
        records,
        [plan.resolved.idle] if plan.resolved.idle else [],
        _step_us(plan),
    )


def _step_us(plan: Plan) -> float:
    """Return the time step of a simulation, µs."""
    return 1e6 * plan.world.options.step


def _to_json(value: Any) -> Any:
    """Convert named tuples (to dicts), tuples, arrays and numbers to values of JSON, recursively."""
    if hasattr(value, "_asdict"):
        return {name: _to_json(item) for name, item in value._asdict().items()}
    if isinstance(value, tuple):
        return [_to_json(item) for item in value]
    return value if value is None else np.asarray(value).tolist()
