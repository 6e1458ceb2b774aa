"""Settings of a simulation, and what was measured with each: quantities, their biases, the cost."""

from collections.abc import Mapping
from typing import NamedTuple

from walkergen.numerics.quantity import Quantity
from walkergen.simulation.observables import SPEED


class Setting(NamedTuple):
    """Choice of how to simulate."""

    step_us: float | None
    """Time step, us; None for the one that resolves the feet."""

    @property
    def label(self) -> str:
        """Name of the setting in tables and figures."""
        return "own step" if self.step_us is None else f"step {self.step_us:g} us"

    @property
    def flags(self) -> str:
        """Options of the command line that select the setting."""
        return "own step" if self.step_us is None else f"--step {self.step_us:g}"


class Measured(NamedTuple):
    """Quantities obtained with a setting, and their cost."""

    setting: Setting
    quantities: Mapping[str, Quantity]
    """Mean speed, mm/s, and all that is printed of runs, by names; without values when not all runs
    ended well."""
    runs: int
    seconds: float
    """Measured time of each run, s."""
    discard_seconds: float
    cpu_s: float
    outcomes: str
    """Ways in which the runs ended, with their numbers."""

    def of(self, name: str) -> Quantity:
        """Quantity by its name."""
        return self.quantities.get(name, Quantity(name, "", None, refused=self.outcomes))

    @property
    def speed(self) -> Quantity:
        """Mean speed, mm/s."""
        return self.of(SPEED)

    @property
    def cpu_per_s(self) -> float:
        """CPU seconds per simulated second, the discarded start included."""
        return self.cpu_s / (self.runs * (self.seconds + self.discard_seconds))

    def variance_time(self, name: str = SPEED) -> float:
        """Squared standard error of a quantity times the measured time, (its unit)^2 s."""
        se = self.of(name).se
        assert se is not None
        return se**2 * self.runs * self.seconds

    def cost_of(self, se: float, name: str = SPEED) -> float:
        """CPU time (s) for a quantity with the standard error `se`, with discarded starts."""
        return self.cpu_per_s * (self.variance_time(name) / se**2 + self.runs * self.discard_seconds)


class Bias(NamedTuple):
    """Systematic difference of a setting's speed from the reference's, with its error, mm/s."""

    size: float
    se: float

    @property
    def bound(self) -> float:
        """Upper limit of the bias's size with 95 % confidence."""
        return abs(self.size) + 2.0 * self.se

    @property
    def certain(self) -> float:
        """Size of the bias where it differs from zero by two standard errors, else 0."""
        return abs(self.size) if abs(self.size) > 2.0 * self.se else 0.0


class Unit(NamedTuple):
    """Unit in which errors of the mean speed are given."""

    size: float
    name: str
    relative: bool
    """True when errors are given as a share of the value."""
    fine: float
    """Standard error to which costs refer: 1 % of the value, or 0.1 mm/s."""
