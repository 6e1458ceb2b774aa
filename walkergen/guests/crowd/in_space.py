"""A crowd in space: placing, runs, and the results of their films."""

import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core import Array, Design, InputError, OneRun, Quantity, Scene, Stopped, Tell, mass_of
from walkergen.guests.crowd import job as jobs
from walkergen.guests.crowd import walker_counts
from walkergen.guests.crowd.job import Job, Kind
from walkergen.guests.crowd.space import run as crowds
from walkergen.guests.crowd.space.result import CrowdRun
from walkergen.guests.crowd.space.run import CrowdPlan
from walkergen.guests.crowd.statistics import CrowdFilm, measure
from walkergen.points import run_time
from walkergen.readers.walkers import top_outline

MAX_WALKERS = 2000
"""Walkers of a crowd in space at most; a flat crowd has more."""

COMPILE_RUN_S = 1e-6
"""Length of a run that compiles."""


def make_job(scene: Scene, designs: Sequence[Design], counts: Sequence[int] | None, rate_hz: float) -> Job:
    """Make a crowd with these counts of each design; without counts of one, the scene's number.

    Raises InputError for too many walkers or frames, and the errors of the designs.
    """
    kinds = []
    for number, design in enumerate(designs):
        mass = mass_of(design)
        outline = tuple(top_outline.outline_of(design, mass))
        area = top_outline.area_of(outline)
        walkers = walker_counts.walker_count(scene, area) if counts is None else counts[number]
        kinds.append(Kind(design.name, walkers, outline, design, mass))
    total = sum(kind.walkers for kind in kinds)
    if total > MAX_WALKERS:
        raise InputError(
            f"{total} walkers: a crowd in space has at most {MAX_WALKERS}; of more of them take "
            "‹model=›flat, with a card of the walker (`walkergen crowd --card`)"
        )
    return jobs.check_job(Job(scene, tuple(kinds), rate_hz, "space"))


class InSpace(NamedTuple):
    """Crowd in space: an experiment (`points.measure`), a run a crowd from places of its own."""

    job: Job

    def prepare(self) -> OneRun[CrowdRun]:
        """Return a function that places and simulates the run of a number, with its kernels compiled.

        Raises InputError if the crowd does not fit, or contradicts the model in space.
        """
        job = self.job
        placed = _placement_function(job)

        def simulate_run(number: int, stopped: Stopped, tell: Tell) -> CrowdRun:
            def report_progress(seconds: float) -> None:
                tell(seconds / job.scene.run.seconds)

            return crowds.simulate(placed(number), number, job.rate_hz, stopped, report_progress)

        _compile_kernels(placed(0), job.rate_hz)
        return simulate_run

    def film(self, run: CrowdRun) -> CrowdFilm:
        """Film of a run, seen from above."""
        return jobs.make_film(self.job, run.times, run.poses)

    def quantities(self, records: Sequence[CrowdRun]) -> list[Quantity]:
        """Statistics of the films of runs."""
        return list(measure([self.film(run) for run in records]).numbers.values())

    def finer(self) -> None:
        """None: the step's effect on a crowd is unknown."""


def cpu_seconds(job: Job) -> float:
    """Estimate the CPU seconds of a crowd's run from a moment of the first, after its walkers have landed."""
    plan, times = _placement_function(job)(0), list[tuple[float, float]]()
    _compile_kernels(plan, job.rate_hz)
    over = run_time.stop_after_moment()

    def record_time(seconds: float) -> None:
        if seconds >= run_time.SETTLING_S:
            times.append((time.thread_time(), seconds))

    run = plan.scene.run.model_copy(update={"seconds": run_time.MAX_MOMENT_S, "discard_seconds": 0.0})
    lasting = plan._replace(scene=plan.scene.model_copy(update={"run": run}))
    crowds.simulate(lasting, 0, job.rate_hz, lambda: len(times) > 1 and over(), record_time)
    if len(times) < 2:  # all have fallen
        return 0.0
    spent, seconds = np.subtract(times[-1], times[0])
    return float(spent / seconds) * (job.scene.run.seconds + job.scene.run.discard_seconds)


def _placement_function(job: Job) -> Callable[[int], CrowdPlan]:
    """Return a function that places the walkers of the run of a number. Raises InputError."""
    plan = _make_plan(job)
    about_C = _contours_from_centre(job, plan)
    return lambda number: plan._replace(places=jobs.place_walkers(job, about_C, number))


def _make_plan(job: Job) -> CrowdPlan:
    """Plan of a crowd whose walkers have no places yet. Raises InputError."""
    designs = [(kind.design, kind.mass) for kind in job.kinds if kind.design and kind.mass]
    return crowds.prepare(job.scene, designs, job.numbers, np.zeros((len(job.numbers), 3)))


def _contours_from_centre(job: Job, plan: CrowdPlan) -> list[list[Array]]:
    """Return the contours of each kind relative to the centre of mass, for placing the walkers."""
    about_C = []
    for kind, own in zip(job.kinds, plan.plans, strict=True):
        forward, _, right = own.world.walker.centre  # from C to O
        about_C.append([np.add(contour, (forward, -right)) for contour in kind.outline])
    return about_C


def _compile_kernels(plan: CrowdPlan, rate_hz: float) -> None:
    """Compile, or load, the kernels of a plan in a short run: once, for all threads."""
    run = plan.scene.run.model_copy(update={"seconds": COMPILE_RUN_S, "discard_seconds": 0.0})
    crowds.simulate(plan._replace(scene=plan.scene.model_copy(update={"run": run})), 0, rate_hz)
