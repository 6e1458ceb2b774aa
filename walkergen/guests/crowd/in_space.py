"""A crowd in space (simulated in 3D): placing, runs, and the results of their films.

A `CrowdPlan` has all that a run needs: scene, walkers, shapes of bodies, and initial positions.
"""

import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core import Array, Design, InputError, OneRun, Quantity, Scene, Stopped, Tell, mass_of
from walkergen.guests.crowd import population as populations
from walkergen.guests.crowd import walker_counts
from walkergen.guests.crowd.population import Kind, Population
from walkergen.guests.crowd.request import CrowdRequest
from walkergen.guests.crowd.space import run as crowds
from walkergen.guests.crowd.space.result import CrowdRun
from walkergen.guests.crowd.space.run import CrowdPlan
from walkergen.guests.crowd.statistics import CrowdFilm, measure
from walkergen.points import run_time
from walkergen.readers.walkers import top_outline

MAX_WALKERS = 2000
"""Walkers of a crowd in space at most; a flat crowd has more."""

COMPILE_RUN_S = 1e-6
"""Simulated time of a run that only compiles the kernels, s."""


def make_population(
    request: CrowdRequest, scene: Scene, designs: Sequence[Design], counts: Sequence[int] | None = None
) -> Population:
    """Return a population of `counts` walkers of each design, by default as many as the scene sets.

    Raises
    ------
    InputError
        For more than MAX_WALKERS, and as `check_population` does.
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
            f"{total} walkers: ‹model=›space simulates at most {MAX_WALKERS}. Use fewer, or ‹model=›flat "
            "with a card of the walker (`walkergen crowd --card`)."
        )
    population = Population(scene, tuple(kinds))
    populations.check_population(request, population)
    return population


class InSpace(NamedTuple):
    """Crowd in space, as an experiment of `core.measure`. Each run starts at its own positions."""

    request: CrowdRequest
    population: Population

    def prepare(self) -> OneRun[CrowdRun]:
        """Return a function that places and simulates the walkers of run `number`, with its kernels compiled.

        Raises InputError if the crowd does not fit, or contradicts the model in space.
        """
        plan_for_run, rate_hz = _placement_function(self.population), self.request.rate_hz

        def simulate_run(number: int, stopped: Stopped, tell: Tell) -> CrowdRun:
            """Simulate run `number`. `tell` receives the share that is done. `stopped`: whether to end early."""

            def report_progress(seconds: float) -> None:
                """Report simulated seconds as a share of the run."""
                tell(seconds / self.population.scene.run.seconds)

            return crowds.simulate(plan_for_run(number), number, rate_hz, stopped, report_progress)

        _compile_kernels(plan_for_run(0), rate_hz)
        return simulate_run

    def film(self, run: CrowdRun) -> CrowdFilm:
        """Return the film of a run, seen from above."""
        return populations.make_film(self.population, run.times, run.poses)

    def quantities(self, records: Sequence[CrowdRun]) -> list[Quantity]:
        """Compute the statistics of the crowd from the films of its runs."""
        return list(measure([self.film(run) for run in records]).numbers.values())

    def finer(self) -> None:
        """Return None: there is no finer experiment, as the step's effect on a crowd is unknown."""


def cpu_seconds(request: CrowdRequest, population: Population) -> float:
    """Estimate the CPU seconds of one run from a short piece of run 0. Return 0 if all walkers fall in that piece."""
    plan, times = _placement_function(population)(0), list[tuple[float, float]]()
    _compile_kernels(plan, request.rate_hz)
    is_moment_over = run_time.stop_after_moment()

    def record_time(seconds: float) -> None:
        """Record CPU time and simulated time of a crowd that has landed."""
        if seconds >= run_time.SETTLING_S:
            times.append((time.thread_time(), seconds))

    run = plan.scene.run.model_copy(update={"seconds": run_time.MAX_MOMENT_S, "discard_seconds": 0.0})
    long_plan = plan._replace(scene=plan.scene.model_copy(update={"run": run}))
    crowds.simulate(long_plan, 0, request.rate_hz, lambda: len(times) > 1 and is_moment_over(), record_time)
    if len(times) < 2:  # all have fallen
        return 0.0
    spent, seconds = np.subtract(times[-1], times[0])
    return float(spent / seconds) * (population.scene.run.seconds + population.scene.run.discard_seconds)


def _placement_function(population: Population) -> Callable[[int], CrowdPlan]:
    """Return a function from a run's number to its `CrowdPlan`, with walkers placed at random. Raises InputError."""
    plan = _make_plan(population)
    about_C = _contours_from_centre(population, plan)
    return lambda number: plan._replace(places=populations.place_walkers(population, about_C, number))


def _make_plan(population: Population) -> CrowdPlan:
    """Make the plan of a crowd, with every walker at the origin. Raises InputError."""
    designs = [(kind.design, kind.mass) for kind in population.kinds if kind.design and kind.mass]
    return crowds.prepare(
        population.scene, designs, population.kind_indices, np.zeros((len(population.kind_indices), 3))
    )


def _contours_from_centre(population: Population, plan: CrowdPlan) -> list[list[Array]]:
    """Return the contours of each kind relative to the centre of mass C: shape (corners, 2), forward and left, mm."""
    about_C = []
    for kind, kind_plan in zip(population.kinds, plan.plans, strict=True):
        forward, _, right = kind_plan.world.walker.centre  # from C to O
        about_C.append([np.add(contour, (forward, -right)) for contour in kind.outline])
    return about_C


def _compile_kernels(plan: CrowdPlan, rate_hz: float) -> None:
    """Compile the kernels that a plan needs, or load them, by a very short run. Threads then share them."""
    run = plan.scene.run.model_copy(update={"seconds": COMPILE_RUN_S, "discard_seconds": 0.0})
    crowds.simulate(plan._replace(scene=plan.scene.model_copy(update={"run": run})), 0, rate_hz)
