"""A crowd in space: walkers placed, their runs on threads, and what the films of them say."""

import time
from collections.abc import Callable, Sequence

import numpy as np

from walkergen.crowd import members
from walkergen.crowd import runs as jobs
from walkergen.crowd.runs import Array, Job, Kind, Simulated
from walkergen.crowd.space import run as crowds
from walkergen.crowd.space.result import CrowdRun
from walkergen.crowd.space.run import CrowdPlan
from walkergen.crowd.statistics import CrowdFilm, measure
from walkergen.crowd.statistics.film import of_places
from walkergen.errors import InputError
from walkergen.files.progress import Progress
from walkergen.scene import Scene
from walkergen.walker import seen_above, solids
from walkergen.walker.design import Design

MOST = 2000
"""Walkers of a crowd in space at most; a flat crowd has more."""

MOMENT_S = 1e-6
"""Length of a run that compiles."""


def asked(scene: Scene, designs: Sequence[Design], counts: Sequence[int] | None, rate_hz: float) -> Job:
    """Crowd of so many walkers of each design; without counts of one, as many as the scene says.

    Raises InputError for too many walkers or frames, and what the designs raise.
    """
    kinds = []
    for number, design in enumerate(designs):
        mass = solids.mass_of(design)
        outline = tuple(seen_above.outline_of(design, mass))
        area = seen_above.area_of(outline)
        walkers = members.number_of(scene, area) if counts is None else counts[number]
        kinds.append(Kind(design.name, walkers, outline, design, mass))
    total = sum(kind.walkers for kind in kinds)
    if total > MOST:
        raise InputError(
            f"{total} walkers: a crowd in space has at most {MOST}; of more of them take "
            "--model flat, with a card of the walker (`walkergen card`)"
        )
    return jobs.checked(Job(scene, tuple(kinds), rate_hz, "space"))


def simulate(job: Job, threads: int | None, progress: Progress) -> Simulated:
    """Place and simulate every run, on `threads` threads (None: every core), and measure them.

    Any number of threads gives equal bits. Ctrl-C gives the runs that were done, without any it is
    raised again. Raises InputError where a crowd has no room, or contradicts the model in space.
    """
    progress("kernels", 0, 100)
    plan, started = _plan(job), time.perf_counter()
    about_C = _about_C(job, plan)
    plans = [plan._replace(places=jobs.placed(job, about_C, number)) for number in range(job.scene.run.runs)]
    _compile(plans[0], job.rate_hz)

    def one(number: int, stopped: Callable[[], bool], told: Callable[[float], None]) -> CrowdRun:
        return crowds.simulate(plans[number], number, job.rate_hz, stopped, told)

    runs = tuple(jobs.on_threads(one, job, threads, progress))
    progress("measuring", 99, 100)
    films = tuple(film_of(job, run) for run in runs)
    return Simulated(job, films, runs, measure(films), time.perf_counter() - started)


def film_of(job: Job, run: CrowdRun) -> CrowdFilm:
    """Film of a run, seen from above."""
    outlines = {kind.name: kind.outline for kind in job.kinds}
    return of_places(run.times, run.poses, run.kinds, outlines, job.scene.crowd.dish)


def _plan(job: Job) -> CrowdPlan:
    """Plan of a crowd whose walkers have no places yet. Raises InputError."""
    designs = [(kind.design, kind.mass) for kind in job.kinds if kind.design and kind.mass]
    return crowds.prepare(job.scene, designs, job.numbers, np.zeros((len(job.numbers), 3)))


def _about_C(job: Job, plan: CrowdPlan) -> list[list[Array]]:
    """Contours of each kind from the centre of mass, by which walkers are let go."""
    about_C = []
    for kind, own in zip(job.kinds, plan.plans, strict=True):
        forward, _, right = own.world.walker.centre  # from C to O
        about_C.append([np.add(contour, (forward, -right)) for contour in kind.outline])
    return about_C


def _compile(plan: CrowdPlan, rate_hz: float) -> None:
    """Compile, or load, the kernels of a plan by a moment of a run: once, for all threads."""
    run = plan.scene.run.model_copy(update={"seconds": MOMENT_S, "discard_seconds": 0.0})
    crowds.simulate(plan._replace(scene=plan.scene.model_copy(update={"run": run})), 0, rate_hz)
