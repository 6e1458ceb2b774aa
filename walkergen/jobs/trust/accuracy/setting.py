"""Settings of a simulation, and what is known of each: value, error, cost, bias."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from walkergen.simulation.effects.effect import METHODS, ModelName
from walkergen.simulation.observables import SPEED


class Setting(NamedTuple):
    """Choice of how to simulate."""

    model: ModelName
    step_us: float | None
    """Time step, us; None for the model's own, or where it has none."""

    @property
    def label(self) -> str:
        """Name of the setting in tables and figures."""
        step = "" if self.step_us is None else f" {self.step_us:g} us"
        return f"{self.series}{step}"

    @property
    def series(self) -> str:
        """Name of all settings that differ in the step alone."""
        return f"{self.model}, {METHODS[self.model]}"

    @property
    def flags(self) -> str:
        """Options of the command line that select the setting."""
        step = "" if self.step_us is None else f" --step {self.step_us:g}"
        return f"--model {self.model}{step}"


PLANAR = Setting("rigid", None), Setting("relaxed", None), Setting("compliant", None)
"""Settings of the models in a plane, with a law of impact; braced walkers have the first."""


class Measured(NamedTuple):
    """Value of an observable (the mean speed, mm/s) obtained with a setting, and its cost."""

    setting: Setting
    value: float | None
    """None when not all runs ended well."""
    se: float | None
    """Standard error of the value; None when the data are too few."""
    runs: int
    seconds: float
    """Measured time of each run, s."""
    discard_seconds: float
    cpu_s: float
    correlation_time_s: float | None
    outcomes: str
    """Ways in which the runs ended, with their numbers."""
    observed: Mapping[str, Sequence[float | None]] = {}
    """Values and standard errors of all observables, by their names."""

    def seen(self, of: str) -> "Measured":
        """The same measurement of another observable."""
        if of == SPEED:
            return self
        value, se = self.observed.get(of, (None, None))
        return self._replace(value=value if self.value is not None else None, se=se)

    @property
    def cpu_per_s(self) -> float:
        """CPU seconds per simulated second, the discarded start included."""
        return self.cpu_s / (self.runs * (self.seconds + self.discard_seconds))

    @property
    def variance_time(self) -> float:
        """Squared standard error times the measured time, (unit of the value)^2 s."""
        assert self.se is not None
        return self.se**2 * self.runs * self.seconds

    def cost_of(self, se: float) -> float:
        """CPU time (s) for a value with the standard error `se`, with discarded starts."""
        return self.cpu_per_s * (self.variance_time / se**2 + self.runs * self.discard_seconds)


class Bias(NamedTuple):
    """Systematic difference of a setting's value from the reference's, with its error."""

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
    """Unit in which errors are given."""

    size: float
    name: str
    relative: bool
    """True when errors are given as a share of the value."""
    fine: float
    """Standard error to which costs refer: 1 % of the value, or 0.1 mm/s."""
