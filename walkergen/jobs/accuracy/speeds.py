"""Mean speeds by every model, method and step: measured once, with their costs."""

import math
import os
from collections.abc import Sequence
from typing import NamedTuple

from walkergen.errors import InputError
from walkergen.files.progress import Progress
from walkergen.scene import Scene
from walkergen.simulation import points
from walkergen.simulation.effects.effect import ModelName
from walkergen.simulation.effects.resolve import MethodName
from walkergen.simulation.ensemble import listed
from walkergen.simulation.model import Plan
from walkergen.simulation.plan import prepare
from walkergen.simulation.points import Point
from walkergen.simulation.run import ENDED_WELL, RunResult, compile_kernels, simulate
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

STEPS_PER_PERIOD = (1000, 500, 300, 200, 100, 50, 30, 20)
"""Steps of the time-stepping method that are tried, as parts of the drive's period."""

EVENT_SHARE, FINEST_SHARE = 0.3, 0.15
"""Shares of the CPU budget for the two methods that certify the reference."""

EVENT_RUNS, STEP_RUNS = 8, 16
"""Independent runs of a measurement: as few as give an error bar where each start is dear."""


CLEAR = 10.0
"""A mean speed of this many standard errors is not zero: errors may be told as a share of it."""


class Setting(NamedTuple):
    """How to simulate."""

    model: ModelName
    method: MethodName
    step_us: float | None
    """None for method event."""

    @property
    def label(self) -> str:
        """For tables and figures."""
        step = "" if self.step_us is None else f" {self.step_us:g} us"
        return f"{self.model}, {self.method}{step}"

    @property
    def flags(self) -> str:
        """The same for the command line."""
        step = "" if self.step_us is None else f" --step {self.step_us:g}"
        return f"--model {self.model} --method {self.method}{step}"


class Measured(NamedTuple):
    """The mean speed found with a setting, and what it cost."""

    setting: Setting
    speed_mm_s: float | None
    """None when no run ended well."""
    se_mm_s: float | None
    """Standard error; None when the data are too few."""
    runs: int
    seconds: float
    """Measured time of each run, s."""
    discard_seconds: float
    cpu_s: float
    correlation_time_s: float | None
    outcomes: str
    """How the runs ended."""

    @property
    def cpu_per_s(self) -> float:
        """CPU seconds per simulated second, the discarded start included."""
        return self.cpu_s / (self.runs * (self.seconds + self.discard_seconds))

    @property
    def variance_time(self) -> float:
        """Squared standard error of the mean speed x measured time, mm^2/s."""
        assert self.se_mm_s is not None
        return self.se_mm_s**2 * self.runs * self.seconds

    def cost_of(self, se: float) -> float:
        """CPU seconds for a mean speed with standard error `se` (mm/s), discarded starts too."""
        return self.cpu_per_s * (self.variance_time / se**2 + self.runs * self.discard_seconds)


class Bias(NamedTuple):
    """Systematic difference of a setting's mean speed from the reference's."""

    mm_s: float
    se_mm_s: float

    @property
    def bound(self) -> float:
        """Upper limit of its size with 95 % confidence, mm/s."""
        return abs(self.mm_s) + 2.0 * self.se_mm_s

    @property
    def certain(self) -> float:
        """Its size where it is told from zero, else 0, mm/s."""
        return abs(self.mm_s) if abs(self.mm_s) > 2.0 * self.se_mm_s else 0.0


class Unit(NamedTuple):
    """In what the errors of mean speeds count."""

    mm_s: float
    name: str
    relative: bool
    """True: errors count as a share of the mean speed."""
    fine: float
    """The standard error to which costs refer, mm/s: 1 % of the speed, or 0.1 mm/s."""


class Survey:
    """Measures settings for one walker in one scene, each once; keeps what it has measured."""

    def __init__(self, scene: Scene, design: Design, mass: MassProperties, budget_s: float) -> None:
        """`budget_s`: wall time for all settings of the complete model, on all cores."""
        self.scene, self.design, self.mass = scene, design, mass
        self.cores = os.cpu_count() or 1
        self.budget_s = budget_s * self.cores
        self.known: dict[Setting, Measured] = {}
        self.complete: ModelName = "rigid" if design.braced else "compliant"

    @property
    def events(self) -> Setting:
        """The complete model by events: the second method, which certifies the reference."""
        return Setting(self.complete, "event", None)

    @property
    def steps(self) -> list[Setting]:
        """The complete model by steps, finest first; its finest is the reference."""
        found = (_round(1e6 / self.scene.drive.frequency / part) for part in STEPS_PER_PERIOD)
        inside = dict.fromkeys(min(max(step, 0.01), 1000.0) for step in found)
        return [Setting(self.complete, "step", step) for step in inside]

    @property
    def own(self) -> Setting:
        """The complete model by steps, with the scene's own step."""
        return Setting(self.complete, "step", self.scene.run.step_us)

    @property
    def simpler(self) -> list[Setting]:
        """The models that leave something out."""
        if self.design.braced:
            return []
        return [Setting("rigid", "event", None), Setting("relaxed", "event", None)]

    def plan(self, setting: Setting) -> Plan:
        """The plan of a setting."""
        return prepare(self.scene_of(setting), self.design, self.mass)

    def measure(self, settings: Sequence[Setting], progress: Progress) -> list[Measured]:
        """Measure settings that are not known yet; all of them, in their order."""
        for place, setting in enumerate(settings):
            if setting not in self.known:

                def told(what: str, done: int, total: int, place: int = place) -> None:
                    progress(what, place * total + done, len(settings) * total)

                self.known[setting] = self._measured(setting, told)
        return [self.known[setting] for setting in settings]

    def ensemble(
        self, setting: Setting, runs: int, seconds: float, progress: Progress
    ) -> tuple[Sequence[RunResult], float]:
        """The runs of a setting one by one, and CPU seconds per simulated second."""
        point = self._run(setting, runs, seconds, progress)
        simulated = runs * (seconds + self.scene.run.discard_seconds)
        return point.results, point.summary.cpu_s / simulated

    def reference(self, progress: Progress) -> Measured:
        """The finest step of the complete model.

        Raises InputError when it gives no mean speed with an error bar.
        """
        (found,) = self.measure(self.steps[:1], progress)
        if found.speed_mm_s is None or found.se_mm_s is None:
            raise InputError(
                f"{self.scene.name}: the runs end as {found.outcomes}: there is no mean speed "
                "whose error could be studied; try another drive, tilt or restitution"
            )
        return found

    def unit(self, reference: Measured) -> Unit:
        """In what errors count: the reference's mean speed, or mm/s where that may be zero."""
        assert reference.speed_mm_s is not None
        assert reference.se_mm_s is not None
        size = abs(reference.speed_mm_s)
        if size > CLEAR * reference.se_mm_s:
            return Unit(size, "share of the mean speed", True, 0.01 * size)
        return Unit(1.0, "mm/s (the mean speed may be zero)", False, 0.1)

    def bias(self, measured: Measured, reference: Measured) -> Bias | None:
        """How far a setting lies from the reference; None when it found no speed."""
        if measured.speed_mm_s is None or measured.se_mm_s is None:
            return None
        assert reference.speed_mm_s is not None
        assert reference.se_mm_s is not None
        if measured.setting == reference.setting:
            return Bias(0.0, reference.se_mm_s)
        difference = measured.speed_mm_s - reference.speed_mm_s
        return Bias(difference, math.hypot(measured.se_mm_s, reference.se_mm_s))

    def bound(self, measured: Measured, reference: Measured) -> float | None:
        """Upper limit of a setting's bias, mm/s, with 95 % confidence; None without a speed.

        Biases of finer steps count as well where they are told from zero: that a coarse step does
        better than a finer one is luck, where errors of both signs cross.
        """
        bias = self.bias(measured, reference)
        if bias is None:
            return None
        return max(bias.bound, self._finer(measured, reference) + 2.0 * bias.se_mm_s)

    def _finer(self, measured: Measured, reference: Measured) -> float:
        """The largest bias, mm/s, that finer steps certainly have; infinite where one failed."""
        biases = [
            self.bias(one, reference)
            for one in self.known.values()
            if one.setting.method == "step"
            and one.setting.model == measured.setting.model
            and (one.setting.step_us or 0.0) < (measured.setting.step_us or 0.0)
        ]
        sizes = (math.inf if bias is None else bias.certain for bias in biases)
        return max(sizes, default=0.0)

    def _share(self, setting: Setting) -> float:
        if setting == self.events:
            return EVENT_SHARE
        if setting == self.steps[0]:
            return FINEST_SHARE
        others = len(self.steps) - 1 + len(self.simpler)
        return (1.0 - EVENT_SHARE - FINEST_SHARE) / others

    def scene_of(self, setting: Setting, **run: float) -> Scene:
        """The scene with a setting, and with other values of its [run]."""
        step = {} if setting.step_us is None else {"step_us": setting.step_us}
        changed = self.scene.run.model_copy(update={"method": setting.method, **step, **run})
        legs = self.scene.legs.model_copy(update={"model": setting.model})
        return self.scene.model_copy(update={"run": changed, "legs": legs})

    def _run(self, setting: Setting, runs: int, seconds: float, progress: Progress) -> Point:
        scene = self.scene_of(setting, seconds=seconds, runs=runs)
        asked = points.Asked(scene, self.design, self.mass)
        (point,) = points.each([asked], [setting.label], progress, None)
        return point

    def _measured(self, setting: Setting, progress: Progress) -> Measured:
        """Runs of as many seconds as the setting's share of the budget allows.

        The length is rounded down to 1, 2 or 5 x 10^n, so that it, and the speed with it, does not
        follow every fluctuation of the machine's speed.
        """
        plan = self.plan(setting).lasting(seconds=0.5, discard_seconds=0.0)
        runs = EVENT_RUNS if setting.method == "event" else STEP_RUNS
        discard = self.scene.run.discard_seconds
        compile_kernels(plan)
        pilot = simulate(plan, 0)
        per_run = self.budget_s * self._share(setting) / runs
        cpu_per_s = pilot.cpu_s / max(pilot.measured_s, 1e-3)
        seconds = max(_one_two_five(per_run / max(cpu_per_s, 1e-6) - discard), 1.0)
        summary = self._run(setting, runs, seconds, progress).summary
        complete = set(summary.outcomes) <= {outcome.value for outcome in ENDED_WELL}
        return Measured(
            setting,
            summary.speed_mm_s if complete else None,
            summary.speed_se_mm_s if complete else None,
            runs,
            seconds,
            discard,
            summary.cpu_s,
            summary.correlation_time_s,
            listed(summary.outcomes),
        )


def _round(value: float) -> float:
    """Two significant digits."""
    return float(f"{value:.2g}")


def _one_two_five(value: float) -> float:
    """The largest of 1, 2, 5 x 10^n that is not above a positive value; else 0."""
    if value <= 0:
        return 0.0
    power = 10.0 ** math.floor(math.log10(value))
    return float(max(digit for digit in (1, 2, 5) if digit * power <= value * (1 + 1e-9)) * power)
