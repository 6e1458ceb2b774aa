"""Time of a study: shared out among what is still to be simulated, and spent."""

import math
from collections.abc import Hashable, Mapping, Sequence
from typing import NamedTuple

from walkergen.numerics.tails import student
from walkergen.simulation.ensemble import FEWEST_RUNS

RUNS = 16
"""Independent runs of a measurement: few, because each start is dear."""

SHORTEST = 0.5
"""Shortest run, s: a still shorter run is mostly its discarded start."""


class Runs(NamedTuple):
    """Number of runs, and the measured time of each, s."""

    number: int
    seconds: float


KINDS = (Runs(RUNS, 1.0), Runs(8, 1.0), Runs(FEWEST_RUNS, SHORTEST))
"""Numbers of runs, each with the time from which it is better than the next fewer."""

ROUND = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)
"""Digits of a run's length: it does not follow every fluctuation of the machine's speed, and with
it the measured speed does not."""


class Budget:
    """Wall time of a study, s, and how much slower it is than its CPU time says.

    Simulations share out what solids and pictures leave.
    """

    def __init__(self, budget_s: float, cores: int) -> None:
        """Budget of `budget_s` s for a study whose ensembles run on `cores` threads."""
        self.budget_s, self.cores = budget_s, cores
        self.spent_s = self.simulated_s = 0.0
        self.others_s = 0.0
        """Time of all that is not simulated, on an idle machine."""
        self.kept_s = 0.0
        """Time of it that is still to come."""
        self._expected_s = self._took_s = 0.0

    @property
    def slowness(self) -> float:
        """Wall time of the ensembles so far over that of threads which nothing else disturbs."""
        return self._took_s / self._expected_s if self._expected_s else 1.0

    def grant(self, what: Hashable, due: Mapping[Hashable, float]) -> float:
        """Time for one of those `due` by their weights, s: what others left over is shared out."""
        free_s = self.budget_s - self.spent_s - self.kept_s * self.slowness
        return max(free_s, 0.0) * due[what] / sum(due.values())

    def affords(self, granted_s: float, rate: float, discard_s: float, kinds: Sequence[Runs]) -> Runs:
        """Runs that take the time granted, at `rate` CPU seconds per simulated second.

        Fewer where they would be too short; the last of `kinds` is the least that means something.
        """
        for kind in kinds:
            lasting_s = granted_s / (self._idle_s(kind.number, rate) * self.slowness)
            seconds = rounded_down(lasting_s - discard_s)
            if seconds >= kind.seconds:
                return Runs(kind.number, seconds)
        return kinds[-1]

    def cost(self, runs: Runs, rate: float, discard_s: float) -> float:
        """Wall time expected of runs, s."""
        idle = self._idle_s(runs.number, rate) * (runs.seconds + discard_s)
        return float(idle * self.slowness)

    def keep(self, expected_s: float) -> None:
        """Keep time for what will not be simulated, s on an idle machine."""
        self.others_s += expected_s
        self.kept_s += expected_s

    def pay_other(self, expected_s: float, wall_s: float) -> None:
        """Note time spent on what time was kept for, s."""
        self.kept_s -= expected_s
        self.spent_s += wall_s

    def pay(self, wall_s: float) -> None:
        """Note time spent on simulations, s."""
        self.spent_s += wall_s
        self.simulated_s += wall_s

    def pay_runs(self, runs: Runs, rate: float, discard_s: float, wall_s: float) -> None:
        """Note time spent on runs, and learn from it what those to come will take."""
        self.pay_turns(self._idle_s(runs.number, rate) * (runs.seconds + discard_s), wall_s)

    def pay_turns(self, expected_s: float, wall_s: float) -> None:
        """Note time spent on what would have taken `expected_s` undisturbed, and learn from it."""
        self._expected_s += expected_s
        self._took_s += wall_s
        self.pay(wall_s)

    def _idle_s(self, runs: int, rate: float) -> float:
        """Wall time of a simulated second of every run, in turns of one run a core."""
        return max(math.ceil(runs / self.cores) * rate, 1e-9)


def rounded_down(value: float) -> float:
    """Largest ROUND x 10^n that is not above a positive value; else 0."""
    if value <= 0.0:
        return 0.0
    power = 10.0 ** math.floor(math.log10(value))
    fitting = [digit for digit in ROUND if digit * power <= value * (1 + 1e-9)]
    return float(f"{max(fitting, default=1.0) * power:.2g}")


def widened(runs: int) -> float:
    """Factor on the standard error of few runs, so that twice it is as sure as of RUNS.

    By Student's t at 95 %: 1.49 for 4 runs, 1.11 for 8.
    """
    few, usual = (student(count - 1.0, 0.975) for count in (runs, RUNS))
    return few / usual if runs < RUNS else 1.0
