"""Survey of a walker in a scene: its speed and all other printed quantities at every step, each measured once.

Each step is an experiment that uses its part of the budget (`points.measure`).
"""

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

from walkergen.analysis import motion
from walkergen.analysis.tracks import from_positions
from walkergen.commands.accuracy import step_law
from walkergen.commands.accuracy.choice import Candidate
from walkergen.core.errors import InputError
from walkergen.core.files.progress import Progress, part_progress
from walkergen.core.measure import Budget, measure
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.scene import Scene
from walkergen.core.simulation import observables
from walkergen.core.simulation.ensemble import MIN_RUNS, format_outcomes
from walkergen.core.simulation.observables import SPEED
from walkergen.core.simulation.plan import Plan, prepare
from walkergen.core.simulation.run import ENDED_WELL
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties
from walkergen.points import experiments
from walkergen.points.experiments import Results

STEP_SHARES = (0.25, 0.5, 1.0, 1.25, 1.6)
"""Measured steps, relative to the step that resolves the feet."""

BUDGET_WEIGHTS = (0.3, 0.15)
"""Shares of the budget for the finest step, and for the next finest step, which certifies it. The others share the
rest."""

MIN_RUN_S, BUDGET_PER_SECOND_S = 2.0, 30.0
"""Shortest measured time of a run, s, and the budget that lengthens runs by a second. The number of runs grows first,
then their length, so that walkers spread."""

MOTION_KEYS = {"motion.rotational_diffusion_rad2_s": "rotational_diffusion", "motion.diffusivity_mm2_s": "diffusivity"}
"""Names of the studied statistics of motion: turning of headings, spreading of walkers."""

OBSERVABLE_NAMES = (*observables.OBSERVABLE_NAMES, *MOTION_KEYS)
"""Names of all studied quantities, as in `simulate --json`."""


class StepMeasurement(NamedTuple):
    """Quantities obtained with a step, and their cost."""

    step_us: float
    quantities: Mapping[str, Quantity]
    """Quantities by their names; without values if a run did not end well."""
    runs: int
    seconds: float
    """Measured time of each run, s."""
    discard_s: float
    cpu_s: float
    wall_s: float
    outcomes: str
    """Endings of the runs, with their counts."""

    @property
    def label(self) -> str:
        """Name of the step in tables and figures."""
        return f"step {self.step_us:g} us"

    def quantity(self, name: str) -> Quantity:
        """Return a quantity by its name."""
        return self.quantities.get(name, Quantity(name, "", None, refused=self.outcomes))

    @property
    def speed(self) -> Quantity:
        """Mean speed, mm/s."""
        return self.quantity(SPEED)

    @property
    def cpu_per_s(self) -> float:
        """CPU seconds per simulated second, the discarded start included."""
        return self.cpu_s / (self.runs * (self.seconds + self.discard_s))

    def variance_time(self, name: str = SPEED) -> float:
        """Return the squared standard error of a quantity times the measured time, (its unit)^2 s."""
        return (self.quantity(name).se or 0.0) ** 2 * self.runs * self.seconds

    def cpu_time_for(self, se: float, name: str = SPEED) -> float:
        """Return the CPU time (s) for a quantity with a standard error, with discarded starts."""
        return self.cpu_per_s * (self.variance_time(name) / se**2 + self.runs * self.discard_s)


class Survey:
    """Measurements of steps for one walker in one scene, each made once and kept."""

    def __init__(self, scene: Scene, design: Design, mass: MassProperties, budget_s: float) -> None:
        """Start a survey with nothing measured; `budget_s` is the wall time of all simulations, s."""
        self.scene, self.design, self.mass = scene, design, mass
        self.budget_s, self.simulated_s = budget_s, 0.0
        self.too_short = False
        """Whether the fewest runs took longer than their budget."""
        self.due: dict[float, float] = {}
        """Budget weights of the steps that remain."""
        self.measured: dict[float, StepMeasurement] = {}

    @cached_property
    def plan(self) -> Plan:
        """Plan with the step that resolves the feet."""
        return prepare(self._scene_with_step(None), self.design, self.mass)

    @cached_property
    def steps(self) -> list[float]:
        """All steps, us, from the finest, the reference, to the coarsest."""
        steps_us = [_round_two_digits(share * 1e6 * self.plan.world.options.step) for share in STEP_SHARES]
        return list(dict.fromkeys(min(max(step, 0.01), 1000.0) for step in steps_us))

    def allot_budget(self) -> None:
        """Reserve a part of the budget for each step."""
        others = (1.0 - sum(BUDGET_WEIGHTS)) / max(len(self.steps) - len(BUDGET_WEIGHTS), 1)
        of_steps = [*BUDGET_WEIGHTS, *[others] * len(self.steps)]
        self.due.update(zip(self.steps, of_steps, strict=False))

    def claim_budget(self, step_us: float) -> float:
        """Return the wall time for a step, s. Unused time of earlier steps is shared out."""
        weight, left_s = self.due.pop(step_us, BUDGET_WEIGHTS[1]), max(self.budget_s - self.simulated_s, 0.0)
        return left_s * weight / (weight + sum(self.due.values()))

    def measure(self, steps: Sequence[float], progress: Progress) -> list[StepMeasurement]:
        """Measure the steps that are not measured yet, and return all of them in order."""
        for index, step_us in enumerate(steps):
            if step_us not in self.measured:
                self.measured[step_us] = self._measure_step(step_us, part_progress(progress, index, len(steps)))
        return [self.measured[step_us] for step_us in steps]

    def measure_reference(self, progress: Progress) -> StepMeasurement:
        """Measure the finest step, which is the reference.

        Raises InputError if it gives no speed with an error bar.
        """
        (reference,) = self.measure(self.steps[:1], progress)
        if not reference.speed.known:
            raise InputError(
                f"{self.scene.name}: the runs end as {reference.outcomes}. There is no "
                "mean speed to study. Try another drive, tilt or restitution."
            )
        return reference

    @property
    def unit(self) -> float:
        """Speed that relative errors refer to, mm/s; requires the measured reference."""
        return step_law.speed_scale(self.measured[self.steps[0]].speed.number, self.plan.equivalent_drive.peak_speed)

    def bias(self, measured: StepMeasurement) -> Quantity:
        """Return the difference of a step's speed from the reference's, mm/s. It is 0 for the reference itself."""
        reference = self.measured[self.steps[0]]
        if measured is reference:
            return reference.speed._replace(value=0.0)
        return measured.speed.minus(reference.speed)

    def bias_bound(self, measured: StepMeasurement) -> float:
        """Return the upper limit of a step's bias with 95 % confidence, mm/s.

        The limit is infinite if this step or a finer one has no speed.
        Significant biases of finer steps count as well: a coarse step that does better than a
        finer one profits from errors of opposite signs.
        """
        bias = self.bias(measured)
        finer = [self.bias(other) for other in self.measured.values() if other.step_us < measured.step_us]
        if any(one.value is None for one in (bias, *finer)):
            return math.inf
        certain = [abs(one.number) for one in finer if abs(one.number) > one.half_width()]
        return max(abs(bias.number), *certain, 0.0) + bias.half_width()

    def to_candidate(self, measured: StepMeasurement) -> Candidate:
        """Return a measured step as a candidate. Its bias is infinite if it has no speed."""
        return Candidate(
            measured.step_us,
            self.bias_bound(measured) / self.unit,
            measured.variance_time() / self.unit**2,
            measured.cpu_per_s,
            measured.discard_s,
        )

    def _scene_with_step(self, step_us: float | None, **run: float) -> Scene:
        """Return the scene with a step (us; None: automatic) and other settings of its `run`."""
        changed = self.scene.run.model_copy(update={"step_us": step_us, **run})
        return self.scene.model_copy(update={"run": changed})

    def _measure_step(self, step_us: float, progress: Progress) -> StepMeasurement:
        """Simulate a step for its part of the budget. Raises KeyboardInterrupt if Ctrl-C leaves runs out."""
        seconds, granted_s = (
            max(MIN_RUN_S, _round_two_digits(self.budget_s / BUDGET_PER_SECOND_S)),
            self.claim_budget(step_us),
        )
        walker = experiments.Walker(self._scene_with_step(step_us, seconds=seconds), self.design, self.mass)
        result = measure(walker, Budget(granted_s, MIN_RUNS), progress)
        if result.partial:
            raise KeyboardInterrupt
        self.simulated_s += result.wall_s
        results = experiments.from_records(result.experiment, result.records, result.runs, result.wall_s)
        summary = results.summary
        self.too_short |= summary.runs == MIN_RUNS and summary.wall_s > granted_s
        all_ended_well = (
            set(summary.outcomes) <= {outcome.value for outcome in ENDED_WELL} and summary.speed.value is not None
        )
        outcomes = format_outcomes(summary.outcomes)
        quantities = {
            name: Quantity(name, "", number.value if all_ended_well else None, number.se, summary.runs - 1.0, outcomes)
            for name, number in _observable_values(results, self.scene.arena.kind == "lane").items()
        }
        run = self.scene.run
        return StepMeasurement(
            step_us, quantities, summary.runs, seconds, run.discard_seconds, summary.cpu_s, summary.wall_s, outcomes
        )


def _observable_values(results: Results, lane: bool) -> dict[str, Quantity]:
    """Return all studied quantities of runs by name, without refused ones. `lane`: walkers run in a lane."""
    quantities = {name: results.summary.numbers[name] for name in observables.OBSERVABLE_NAMES}
    good = [result for result in results.results if result.outcome in ENDED_WELL]
    if good and len(good[0].places) >= 4:
        estimates = motion.analyse(from_positions([result.places for result in good], good[0].block_s, lane)).estimates
        named = ((name, estimates[key]) for name, key in MOTION_KEYS.items())
        quantities |= {name: estimate for name, estimate in named if estimate.value is not None}
    return quantities


def _round_two_digits(value: float) -> float:
    """Round to two significant digits."""
    return float(f"{value:.2g}")
