"""Measurement of experiments: runs by seeds and threads, until there are enough of them.

An experiment is anything that runs: a walker in a scene, a crowd. An error has one meaning
everywhere: half of the 95 % bounds, from the scatter of runs and from biases that more runs do not
reduce, as a time step's. A relative error refers to the value, or to a floor if the value is smaller:
no number of runs measures a resting walker to a share of its speed.
"""

import math
import os
import time
from collections.abc import Mapping, Sequence
from typing import Any, Generic, NamedTuple, Protocol, Self, TypeVar

from walkergen.core.files.progress import Progress, range_progress, silent
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.simulation import batch
from walkergen.core.simulation.batch import OneRun
from walkergen.core.tolerance import Tolerance

FIRST_RUNS, MAX_RUNS = 8, 512
"""Number of runs at the start of an experiment with a requested error, and largest number."""

MIN_RUN_FACTOR, MAX_RUN_FACTOR = 1.1, 1.5
"""Smallest and largest factor of the number of runs per round, for any estimate from the scatter: more runs improve the
estimate. For normal runs this makes 5 to 9 % more than the fewest that meet the error, and the bounds still hold 95 %.
With 1.2 times the estimate, and at least half as many again, it would be 27 to 69 % more."""

MAX_BIAS_SHARE = 0.7
"""Share of the error that a bias may take up; above it the experiment is refined. If the bias falls with the square of
a step, the error left for the scatter is then worth double the steps."""


class Experiment(Protocol):
    """An experiment: its runs are independent, and each is reproducible to the bit."""

    def prepare(self) -> OneRun[Any]:
        """Return a function (see `OneRun`) that makes one run and returns its record. The run's number is its seed.

        Work that all runs share is done first, on this thread: kernels are compiled, invalid input is refused.
        """

    def quantities(self, records: Sequence[Any]) -> list[Quantity]:
        """Return the quantities that the experiment measures, each with its error, from the records of its runs."""

    def finer(self) -> Self | None:
        """Return the experiment with smaller biases, as from shorter time steps; None if it cannot reduce them."""


AnExperiment = TypeVar("AnExperiment", bound=Experiment)


class Measured(NamedTuple, Generic[AnExperiment]):
    """Experiment and its finished runs."""

    experiment: AnExperiment
    """Experiment as it was run at last."""
    records: list[Any]
    """Records of the finished runs, in the order of their numbers from 0."""
    runs: int
    """Number of requested runs."""
    wall_s: float
    """Time by the clock that the runs took, s."""

    @property
    def partial(self) -> bool:
        """Whether Ctrl-C ended the measurement before all requested runs were finished."""
        return len(self.records) < self.runs

    @property
    def quantities(self) -> Mapping[str, Quantity]:
        """Quantities from the finished runs, by their names (`Quantity.column`)."""
        return {quantity.column: quantity for quantity in self.experiment.quantities(self.records)}

    def with_runs(self, runs: int) -> "Measured[AnExperiment]":
        """Return the measurement with `runs` as the number of requested runs, finished ones included."""
        return self._replace(runs=runs)


class Until(Protocol):
    """Rule that decides when there are enough runs."""

    @property
    def first_runs(self) -> int:
        """Number of runs to begin with."""

    def request_more(self, measured: Measured[Any]) -> Measured[Any] | None:
        """Return the measurement with more runs requested, or with a finer experiment; None if it is good enough."""


class Runs(NamedTuple):
    """A fixed number of runs."""

    first_runs: int

    def request_more(self, measured: Measured[AnExperiment]) -> Measured[AnExperiment] | None:
        """Return None: no further runs are made."""
        return None


class Budget(NamedTuple):
    """The runs that fit into a wall-clock time, but at least `first_runs`."""

    seconds: float
    first_runs: int = FIRST_RUNS

    def request_more(self, measured: Measured[AnExperiment]) -> Measured[AnExperiment] | None:
        """Return the measurement with up to twice the runs requested, as time allows; None if no more fit."""
        affordable = int(self.seconds * measured.runs / max(measured.wall_s, 1e-9))
        return None if affordable <= measured.runs else measured.with_runs(min(2 * measured.runs, affordable))


class UntilError(NamedTuple):
    """Rule: add runs until the error of the quantity in `column` is at most `tolerance`, or cannot fall further."""

    tolerance: Tolerance
    column: str
    """Column of the quantity."""
    floor: float = 0.0
    """Value that a relative error refers to if the quantity is smaller."""
    first_runs: int = FIRST_RUNS
    max_runs: int = MAX_RUNS

    def max_error(self, value: float | None) -> float:
        """Return the largest allowed error of the quantity in its unit. `value` is the quantity's; None counts as 0."""
        tolerated, relative = self.tolerance
        return tolerated * max(abs(value or 0.0), self.floor) if relative else tolerated

    def request_more(self, measured: Measured[AnExperiment]) -> Measured[AnExperiment] | None:
        """Return the measurement with more runs requested or a finer experiment; None if met, or if neither helps."""
        quantity = measured.quantities[self.column]
        error, allowed, bias = quantity.half_width(), self.max_error(quantity.value), quantity.bias
        if error <= allowed or quantity.value is None or quantity.freedom == 0.0 or math.isinf(bias):
            return None  # small enough, or more runs would give no smaller error
        if bias > MAX_BIAS_SHARE * allowed:
            finer = self.select_resolution(measured)
            return None if finer is measured.experiment else Measured(finer, [], self.first_runs, 0.0)
        if measured.runs >= self.max_runs:
            return None
        shortfall = (error**2 - bias**2) / (allowed**2 - bias**2)
        runs = math.ceil(measured.runs * min(max(shortfall, MIN_RUN_FACTOR), MAX_RUN_FACTOR))
        return measured.with_runs(min(self.max_runs, runs))

    def select_resolution(self, measured: Measured[AnExperiment]) -> AnExperiment:
        """Return the coarsest of the experiment and its refinements with an allowed bias, or else the finest."""
        experiment = measured.experiment
        while (finer := experiment.finer()) is not None:
            quantity = measured._replace(experiment=experiment).quantities[self.column]
            if quantity.bias <= MAX_BIAS_SHARE * self.max_error(quantity.value):
                break
            experiment = finer
        return experiment


def core_count() -> int:
    """Count the cores that this process may use.

    Returns
    -------
    int
        Number of cores, at least 1.

    Examples
    --------
    >>> core_count() >= 1
    True
    """
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def measure(
    experiment: AnExperiment, until: Until, progress: Progress = silent, threads: int | None = None
) -> Measured[AnExperiment]:
    """Run an experiment until the rule `until` has enough runs, and return it with its records.

    `threads` is the number of threads (None: one for each core). Records do not depend on it, nor on later runs. Ctrl-C
    returns the finished runs, or is raised again if there are none.
    """
    request: Measured[AnExperiment] | None = Measured(experiment, [], until.first_runs, 0.0)
    while request is not None:
        measured = request
        if not measured.records:
            progress("kernels", 0, 100)
            make_run = measured.experiment.prepare()
        started = time.perf_counter()
        try:
            finished = len(measured.records)
            report = range_progress(progress, finished / measured.runs, 1.0)
            new_records = batch.run_parallel(make_run, range(finished, measured.runs), report, threads)
        except KeyboardInterrupt:
            if not measured.records:
                raise
            return measured
        records = [*measured.records, *new_records.values()]
        measured = measured._replace(records=records, wall_s=measured.wall_s + time.perf_counter() - started)
        request = None if measured.partial else until.request_more(measured)
    return measured
