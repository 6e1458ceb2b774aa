"""Survey of a walker in a scene: speeds and all else by every step, measured once each."""

import math
import os
import time
from collections.abc import Hashable, Sequence
from functools import cached_property

from walkergen.analysis import motion
from walkergen.analysis.tracks import of_places
from walkergen.errors import InputError
from walkergen.files.progress import Progress, part, silent
from walkergen.jobs.trust.accuracy.budget import KINDS, RUNS, Budget, Runs, widened
from walkergen.jobs.trust.accuracy.setting import Bias, Measured, Setting, Unit
from walkergen.numerics.quantity import Quantity
from walkergen.points import walkers
from walkergen.scene import Scene
from walkergen.simulation import ensemble, experiments, observables, resolution
from walkergen.simulation.ensemble import listed
from walkergen.simulation.experiments import Results
from walkergen.simulation.observables import SPEED
from walkergen.simulation.plan import Plan, prepare
from walkergen.simulation.run import ENDED_WELL, RunResult, compile_kernels
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

OWN = Setting(None)
"""Setting by the step that resolves the feet."""

STEPS = (0.25, 0.5, 1.0, 1.25, 1.6)
"""Steps over that which resolves the feet, which are measured."""

FINEST_SHARE, CERTIFYING_SHARE = 0.3, 0.15
"""Shares of the CPU budget for the finest step and for that next to it, which certifies it."""

PILOT = 0.25
"""Simulated time, s, of each run that tells what a setting costs."""

CLEAR = 10.0
"""Standard errors from which a mean speed is not zero, so that errors can be a share of it."""

MOTION = {"motion.rotational_diffusion_rad2_s": "rotational_diffusion", "motion.diffusivity_mm2_s": "diffusivity"}
"""Names of the statistics of motion that are studied: how headings turn, how walkers spread."""

NAMES = (*observables.NAMES, *MOTION)
"""Names of all that is studied, as `simulate --json` has them."""


class Survey:
    """Measurements of settings for one walker in one scene, each made once and kept."""

    def __init__(self, scene: Scene, design: Design, mass: MassProperties, budget_s: float) -> None:
        """Survey with nothing measured; `budget_s`: wall time of all of it, s."""
        self.scene, self.design, self.mass = scene, design, mass
        self.cores = os.cpu_count() or 1
        self.budget = Budget(budget_s, self.cores)
        self.others: dict[str, float] = {}
        """Weights of what else is to be simulated within the budget; all settings together: 1."""
        self.measured: dict[Setting, Measured] = {}
        self._rates: dict[Setting, float] = {}
        self.scheduled = self.steps
        """Settings that are to be measured within the budget."""

    @property
    def certifying(self) -> Setting:
        """Setting that certifies the reference: the step next to the finest."""
        return self.steps[1]

    @property
    def steps(self) -> list[Setting]:
        """Settings of all steps, the finest first, which is the reference."""
        steps_us = [_round(share * self.resolving_us) for share in STEPS]
        inside = dict.fromkeys(min(max(step, 0.01), 1000.0) for step in steps_us)
        return [Setting(step) for step in inside]

    @cached_property
    def resolving_us(self) -> float:
        """Step that resolves elastic feet, us."""
        return float(1e6 * self.plan(OWN).world.options.step)

    @property
    def own(self) -> Setting:
        """Setting of the scene's own step."""
        step = self.scene.run.step_us
        return Setting(_round(self.resolving_us) if step is None else step)

    def plan(self, setting: Setting) -> Plan:
        """The plan of a setting."""
        return prepare(self.scene_of(setting), self.design, self.mass)

    def measure(self, settings: Sequence[Setting], progress: Progress) -> list[Measured]:
        """Measure the settings that are not known yet; returns all of them in their order."""
        for place, setting in enumerate(settings):
            if setting not in self.measured:
                part_progress = part(progress, place, len(settings))
                self.measured[setting] = self._measured(setting, part_progress)
        return [self.measured[setting] for setting in settings]

    def ensemble(self, setting: Setting, runs: Runs, progress: Progress) -> tuple[Sequence[RunResult], float]:
        """The runs of a setting one by one, and CPU seconds per simulated second."""
        point = self._run(setting, runs, progress)
        simulated = runs.number * (runs.seconds + self.scene.run.discard_seconds)
        return point.results, point.summary.cpu_s / simulated

    def rate(self, setting: Setting) -> float:
        """CPU seconds per simulated second of a setting, by short runs; compiles its kernels.

        They are one a core, at once: what else runs on the machine is learnt with them.
        """
        if setting in self.measured:
            return self.measured[setting].cpu_per_s
        if setting not in self._rates:
            runs = min(self.cores, RUNS)
            plan = self.plan(setting).lasting(seconds=PILOT, discard_seconds=0.0, runs=runs)
            compile_kernels(plan)
            started = time.perf_counter()
            pilots = ensemble.run(plan, silent)
            took = time.perf_counter() - started
            cpu_s = sum(pilot.cpu_s for pilot in pilots) / runs
            simulated_s = sum(pilot.measured_s for pilot in pilots) / runs
            self._rates[setting] = max(cpu_s / max(simulated_s, 1e-3), 1e-6)
            self.budget.pay_turns(cpu_s, took)
        return self._rates[setting]

    def granted(self, what: Hashable) -> float:
        """Wall time for a setting or for one of `others`, s, of what is left of the budget."""
        due: dict[Hashable, float] = {setting: self.share(setting) for setting in self.due}
        if isinstance(what, Setting):
            due[what] = self.share(what)
        due.update(self.others)
        return self.budget.grant(what, due)

    def take(self, name: str) -> float:
        """Wall time granted to one of `others`, s, which is then no longer due."""
        granted = self.granted(name)
        del self.others[name]
        return granted

    @property
    def due(self) -> list[Setting]:
        """Settings that are still to be measured."""
        return [setting for setting in dict.fromkeys(self.scheduled) if setting not in self.measured]

    def least(self, setting: Setting) -> float:
        """Wall time (s) of the least measurement of a setting that means something."""
        return self.budget.cost(KINDS[-1], self.rate(setting), self.scene.run.discard_seconds)

    def reference(self, progress: Progress) -> Measured:
        """Measure the setting that counts as true: the finest step.

        Raises InputError when it gives no speed with an error bar.
        """
        (reference,) = self.measure(self.steps[:1], progress)
        if not reference.speed.known:
            raise InputError(
                f"{self.scene.name}: the runs end as {reference.outcomes}: there is no "
                "mean speed whose error could be studied; try another drive, tilt or restitution"
            )
        return reference

    def unit(self, reference: Measured) -> Unit:
        """Unit of errors: the reference's speed, or 1 mm/s where that may be zero."""
        value, se = reference.speed.value, reference.speed.se
        assert value is not None
        assert se is not None
        if abs(value) > CLEAR * se:
            return Unit(abs(value), "share of the mean speed", True, 0.01 * abs(value))
        return Unit(1.0, "mm/s (the mean speed may be zero)", False, 0.1)

    def bias(self, measured: Measured, reference: Measured) -> Bias | None:
        """Bias of a setting's speed against the reference's; None when it gave none."""
        gap = measured.speed.less(reference.speed)
        if gap.value is None or gap.se is None:
            return None
        if measured.setting == reference.setting:
            return Bias(0.0, reference.speed.se or 0.0)
        return Bias(gap.value, gap.se)

    def bound(self, measured: Measured, reference: Measured) -> float | None:
        """Upper limit of a setting's bias with 95 % confidence; None without a value.

        Significant biases of finer steps count as well: where a coarse step does better than a
        finer step, errors of opposite signs happen to cancel.
        """
        bias = self.bias(measured, reference)
        if bias is None:
            return None
        return max(bias.bound, self._finer(measured, reference) + 2.0 * bias.se)

    def _finer(self, measured: Measured, reference: Measured) -> float:
        """Largest significant bias of finer steps; infinite where a finer step failed."""
        biases = [
            self.bias(finer, reference)
            for finer in self.measured.values()
            if (finer.setting.step_us or 0.0) < (measured.setting.step_us or 0.0)
        ]
        sizes = (math.inf if bias is None else bias.certain for bias in biases)
        return max(sizes, default=0.0)

    def share(self, setting: Setting) -> float:
        """Weight of a setting in the budget; of all settings together: 1."""
        shares = {self.certifying: CERTIFYING_SHARE, self.steps[0]: FINEST_SHARE}
        others = {*self.steps} - shares.keys()
        return shares.get(setting, (1.0 - sum(shares.values())) / len(others))

    def scene_of(self, setting: Setting, **run: float) -> Scene:
        """Scene with a setting, and with other values of its [run]."""
        changed = self.scene.run.model_copy(update={"step_us": setting.step_us, **run})
        return self.scene.model_copy(update={"run": changed})

    def _run(self, setting: Setting, runs: Runs, progress: Progress) -> Results:
        scene = self.scene_of(setting, seconds=runs.seconds, runs=runs.number)
        experiment = experiments.Walker(scene, self.design, self.mass)
        (point,) = walkers.each([experiment], [setting.label], progress)
        took, discard = point.summary.wall_s, scene.run.discard_seconds
        self.budget.pay_runs(runs, self.rate(setting), discard, took)
        return point

    def _measured(self, setting: Setting, progress: Progress) -> Measured:
        """Simulate for as long as the setting's share of the budget allows.

        Errors of few runs are widened, so that twice them means 95 % confidence as ever.
        """
        discard, rate = self.scene.run.discard_seconds, self.rate(setting)
        runs = self.budget.affords(self.granted(setting), rate, discard, KINDS)
        point = self._run(setting, runs, progress)
        summary, wider = point.summary, widened(runs.number)
        well = set(summary.outcomes) <= {outcome.value for outcome in ENDED_WELL} and summary.speed_mm_s is not None
        outcomes = listed(summary.outcomes)
        quantities = {
            name: Quantity(name, "", value if well else None, None if se is None else wider * se, refused=outcomes)
            for name, (value, se) in _observed(point, self.scene_of(setting).arena.kind == "lane").items()
        }
        return Measured(setting, quantities, *runs, discard, summary.cpu_s, outcomes)


def _observed(point: Results, lane: bool) -> dict[str, tuple[float | None, float | None]]:
    """Values and standard errors of all that is studied of runs; without what they refuse."""
    summary = point.summary
    errors = {**summary.errors, SPEED: summary.speed_se_mm_s}
    quantities: dict[str, tuple[float | None, float | None]] = {
        name: (value, errors[name]) for name, value in resolution.values(summary).items()
    }
    good = [result for result in point.results if result.outcome in ENDED_WELL]
    if good and len(good[0].places) >= 4:
        tracks = of_places([result.places for result in good], good[0].block_s, lane)
        estimates = motion.analyse(tracks).estimates
        named = ((name, estimates[key]) for name, key in MOTION.items())
        quantities |= {name: (estimate.value, estimate.se) for name, estimate in named if estimate.value is not None}
    return quantities


def _round(value: float) -> float:
    """Round to two significant digits."""
    return float(f"{value:.2g}")
