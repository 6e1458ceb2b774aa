"""Variants of a scene, each with one effect switched off or on, and their change of a walker's speed and CPU time.

Scene and variants start from the same drops and phases, run after run in turn. So a difference is
the variant's, and a busy machine slows all alike. A rule decides whether a scene has an effect.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.numerics import quantity
from walkergen.core.numerics.distributions import student_quantile
from walkergen.core.numerics.quantity import Quantity, Verdict
from walkergen.core.simulation import ensemble
from walkergen.core.simulation.batch import OneRun
from walkergen.core.simulation.effects import active_effects, harmonic
from walkergen.core.simulation.effects.effect import Effect, Rule
from walkergen.core.simulation.effects.resolve import replace_without_validation
from walkergen.core.simulation.plan import Plan
from walkergen.core.simulation.run import ENDED_WELL, Outcome, RunResult, compile_kernels, simulate
from walkergen.core.tolerance import Tolerance
from walkergen.points.experiments import Walker
from walkergen.points.walkers import speed_rule

MAX_RUN_S, MAX_DISCARD_S = 2.0, 0.5
"""Maximum measured time of a run, and of its start that is not measured, s: more runs give more than longer ones."""

RunSet = tuple[RunResult, ...]
"""Runs of one number: the run of the scene, then that of each variant."""


class Variant(NamedTuple):
    """Scene with one effect switched off, or switched on at its usual size."""

    effect: str
    change: str
    """Description of the difference."""
    walker: Walker
    values: Mapping[str, Any]
    """Changed values of the scene, by key."""

    @property
    def leaves_out(self) -> bool:
        """Whether an effect of the scene is switched off."""
        return self.change == "off"


class Change(NamedTuple):
    """Change of a walker's speed and CPU time by a variant of its scene."""

    effect: str
    change: str
    speed: Quantity
    """Mean speed of the variant less that of the scene, mm/s, by pairs of runs; no error of the step."""
    cpu: Quantity
    """CPU time of the variant over that of the scene (a ratio), by pairs of runs."""
    scatter: tuple[float, float] | None = None
    """Standard deviations of the speed over runs in the scene and in the variant, mm/s; None if they may be equal."""

    def changes_scatter(self, share: float) -> bool:
        """Return whether the standard deviation of runs changes by more than a share of that in the scene."""
        return self.scatter is not None and abs(self.scatter[1] - self.scatter[0]) > share * self.scatter[0]


class Pairs(NamedTuple):
    """Walker in its scene and variants of it, as an experiment. A run is one in the scene and one in each variant."""

    walker: Walker
    variants: tuple[Variant, ...]

    def prepare(self) -> OneRun[RunSet]:
        """Compile all kernels and return a function that simulates run `number` of the scene and of each variant."""
        plans = [
            _with_short_runs(walker).plan() for walker in (self.walker, *(variant.walker for variant in self.variants))
        ]
        for plan in plans:
            compile_kernels(plan)

        def simulate_all(number: int, stopped: Any, tell: Any) -> RunSet:
            """Simulate run `number`. `stopped`: returns True to stop. `tell`: receives the share that is done."""
            results = []
            for done, plan in enumerate(plans, start=1):
                results.append(simulate(plan, number, stopped))
                tell(done / len(plans))
            return tuple(results)

        return simulate_all

    def quantities(self, records: Sequence[RunSet]) -> list[Quantity]:
        """Return the mean speed in the scene, then the change of speed by each variant, mm/s."""
        return [self.mean_speed(records), *(change.speed for change in self.changes(records))]

    def finer(self) -> None:
        """Return None: the time step is never refined, since its error is left out of changes of speed."""

    def mean_speed(self, records: Sequence[RunSet]) -> Quantity:
        """Return the mean speed of the walker in the scene itself, mm/s."""
        return quantity.mean("speed", "mm_s", [runs[0].speed for runs in records if runs[0].outcome in ENDED_WELL])

    def changes(self, records: Sequence[RunSet]) -> list[Change]:
        """Compute the change of speed (mm/s) and of CPU time (a ratio) by each variant, from sets of runs."""
        changes = []
        for index, variant in enumerate(self.variants, start=1):
            pairs = [(runs[0], runs[index]) for runs in records]
            cpu = quantity.mean("cpu_ratio", "", [run.cpu_s / max(base.cpu_s, 1e-9) for base, run in pairs])
            speed = _speed_difference(pairs, self.walker.equivalent_drive.peak_speed)
            changes.append(Change(variant.effect, variant.change, speed, cpu, _scatter_change(pairs)))
        return changes


def verdict(walker: Walker, speed: Quantity, change: Change, tolerance: Tolerance) -> Verdict:
    """Return whether a change is within the tolerance of the walker's `speed`, with 95 % confidence, or undecided."""
    error = speed_rule(tolerance, walker.equivalent_drive).max_error(speed.value)
    return change.speed.compare_with_range(-error, error)


def _speed_difference(pairs: Sequence[tuple[RunResult, RunResult]], plate_speed: float) -> Quantity:
    """Return the mean speed in a variant less that in the scene, mm/s. `pairs`: runs (scene, variant).

    It has no standard error if the runs share an orbit, and no value if one ended badly. `plate_speed`: its peak, mm/s.
    """
    ended = [result for pair in pairs for result in pair if result.outcome not in ENDED_WELL]
    if ended:
        return Quantity(
            "change", "mm_s", None, refused=f"{len(ended)} of {2 * len(pairs)} runs: {ended[0].outcome.value}"
        )
    speeds = np.array([[base.speed, run.speed] for base, run in pairs])
    mean = quantity.mean("change", "mm_s", speeds[:, 1] - speeds[:, 0])
    if ensemble.ORBIT in (ensemble.common_orbit(column, plate_speed) for column in speeds.T):
        return mean._replace(se=None, refused=Outcome.ORBIT.value)
    return mean


def _scatter_change(pairs: Sequence[tuple[RunResult, RunResult]]) -> tuple[float, float] | None:
    """Return the standard deviations (mm/s) of runs in the scene and in a variant if they differ, otherwise None.

    `pairs`: runs (scene, variant). The test is Pitman's and Morgan's for variances of pairs, with 95 % confidence.

    References
    ----------
    Pitman, Biometrika 31 (1939) 9; Morgan, Biometrika 31 (1939) 13.
    """
    if len(pairs) < 4:
        return None
    speeds = np.array([[runs[0].speed, runs[1].speed] for runs in pairs]).T
    first, second = float(speeds[0].std(ddof=1)), float(speeds[1].std(ddof=1))
    difference, total = speeds[1] - speeds[0], speeds[1] + speeds[0]
    spread = float(difference.std() * total.std())
    if spread <= 0.0:
        return None
    freedom = speeds.shape[1] - 2
    correlation = float(((difference - difference.mean()) * (total - total.mean())).mean()) / spread
    t = abs(correlation) * math.sqrt(freedom / max(1.0 - correlation**2, 1e-12))
    return (first, second) if t > student_quantile(freedom, 0.975) else None


def _with_short_runs(walker: Walker) -> Walker:
    """Return the walker with runs of at most MAX_RUN_S after a discarded start of at most MAX_DISCARD_S."""
    run = walker.scene.run
    seconds, discarded = min(run.seconds, MAX_RUN_S), min(run.discard_seconds, MAX_DISCARD_S)
    return walker.with_run_settings(seconds=seconds, discard_seconds=discarded)


def short_run_s(walker: Walker) -> float:
    """Return the simulated time of one run of a walker or of a variant, s, with the start that is not measured."""
    run = _with_short_runs(walker).scene.run
    return run.discard_seconds + run.seconds


def decide_effects(plan: Plan) -> list[tuple[Rule, Effect]]:
    """Return the rule of every effect with its decision for a plan: the effect, which is on or off."""
    return [(rule, rule.decide(plan.case)) for rule in active_effects.all_rules()]


def without_effect(walker: Walker, rule: Rule) -> Variant | None:
    """Return the variant of the walker's scene without a rule's effect; None if it cannot be simulated."""
    return _build_variant(walker, "", "off", rule.off)


def effect_variants(walker: Walker, also_on: bool) -> Iterator[Variant]:
    """Yield a variant without each effect that is on. `also_on`: also variants with each effect that is off."""
    by_motor = walker.scene.drive.kind == "motor"
    for rule, effect in decide_effects(walker.plan()):
        variant = None
        if effect.on and effect.switch:
            variant = without_effect(walker, rule)
        elif (
            also_on and not effect.on and rule.typical_values and not (by_motor and harmonic.KEY in rule.typical_values)
        ):
            variant = _build_variant(
                walker, "", _format_usual(rule), {f"effects.{rule.switch}": None, **rule.typical_values}
            )
        if variant is not None:
            yield variant._replace(effect=effect.name)


def _format_usual(rule: Rule) -> str:
    """Return words for the change by a variant with an effect at its usual size, such as "on, slope_deg = 2.0"."""
    sizes = {key.rpartition(".")[2]: value for key, value in rule.typical_values.items()}
    words = ", ".join(f"{name} = {value}" for name, value in sizes.items() if value is not True)
    return f"on, {words}" if words else "on"


def combine(walker: Walker, first: Variant, second: Variant) -> Variant | None:
    """Return a variant with the changes of two variants together; None if it cannot be simulated."""
    words = first.change if first.change == second.change else "both"
    return _build_variant(walker, f"{first.effect} and {second.effect}", words, {**first.values, **second.values})


def _build_variant(walker: Walker, effect: str, change: str, values: Mapping[str, Any]) -> Variant | None:
    """Return a variant with `values`, by key, in the scene; None if it cannot be simulated."""
    return _valid_variant(
        Variant(effect, change, walker._replace(scene=replace_without_validation(walker.scene, values)), values)
    )


def _valid_variant(variant: Variant) -> Variant | None:
    """Return the variant if it can be simulated, else None."""
    try:
        _with_short_runs(variant.walker).plan()
    except InputError:
        return None
    return variant
