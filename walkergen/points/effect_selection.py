"""Selection of the effects that can be left out of a scene, as they change a walker's speed by too little to matter.

Leaving an effect out must pay: it is measured only for simulations that are long compared with the measurement, and
only if runs without it take less time. The store keeps the result, so that a second simulation measures nothing.
"""

import json
import math
from contextlib import closing
from typing import Any, NamedTuple

from walkergen.core.errors import InputError
from walkergen.core.files import formatting
from walkergen.core.files.progress import Progress, silent
from walkergen.core.measure import FIRST_RUNS, Measured, Runs, measure
from walkergen.core.numerics.quantity import Quantity, Verdict
from walkergen.core.scene import Scene
from walkergen.core.simulation.effects import active_effects
from walkergen.core.simulation.effects.effect import Rule
from walkergen.core.simulation.effects.resolve import replace_without_validation
from walkergen.core.simulation.ensemble import Summary
from walkergen.core.simulation.observables import SPEED
from walkergen.core.tolerance import Tolerance
from walkergen.points import variants
from walkergen.points.experiments import Walker
from walkergen.points.point import digest
from walkergen.points.store import Store
from walkergen.points.variants import Change, Pairs, Variant

PILOT_RUNS = 4
"""Pairs of runs, with and without each effect, that tell which effects take time and surely change the speed."""

MAX_PILOT_SHARE = 0.25
"""Maximum simulated time of these pairs over that of the simulation. A shorter simulation leaves nothing out."""

MAX_PAIRS = 64
"""Pairs of runs after which a change that is not decided counts as too large."""

MAX_SPENT_SHARE = 0.5
"""Maximum time for deciding on an effect over the time that the simulation saves without it."""

MAX_CPU_RATIO = 0.95
"""An effect takes time if the CPU time without it is at most this share of the time with it."""


class UntilDecided(NamedTuple):
    """Rule that adds pairs of runs, with and without an effect, until it is clear whether the change is tolerable."""

    tolerance: Tolerance
    max_runs: int = MAX_PAIRS
    first_runs: int = FIRST_RUNS

    def verdict(self, measured: Measured[Pairs]) -> Verdict:
        """Return whether the change of speed is within the allowed error, with 95 % confidence, or undecided."""
        pairs, records = measured.experiment, measured.records
        return variants.verdict(pairs.walker, pairs.mean_speed(records), pairs.changes(records)[0], self.tolerance)

    def request_more(self, measured: Measured[Pairs]) -> Measured[Pairs] | None:
        """Return the measurement with up to twice as many pairs; None if decided, undecidable, or at `max_runs`."""
        change = measured.experiment.changes(measured.records)[0].speed
        decided = self.verdict(measured) is not Verdict.UNDECIDED or change.se is None
        more = min(2 * measured.runs, self.max_runs)
        return None if decided or measured.runs >= more else measured.with_runs(more)


class Simplest(NamedTuple):
    """Walker in the simplest scene, and what was left out."""

    walker: Walker
    accepted: float | None = None
    """Error that was accepted, a share of the speed; None: nothing was tried."""
    left_out: tuple[Change, ...] = ()
    """Changes by the effects that are left out, each measured with all effects before it left out as well."""
    kept: tuple[tuple[Change, str], ...] = ()
    """Changes by the effects that were measured but not left out, each with the reason."""
    cpu_s: float = 0.0
    """CPU time of the measurement, s; 0 if the store had it."""
    reason: str = ""
    """Reason why nothing was measured, otherwise ""."""

    @property
    def error_mm_s(self) -> float:
        """Upper limit (95 %) of the change of speed, mm/s, by all effects left out together."""
        if not self.left_out:
            return 0.0
        change = self.left_out[-1].speed  # with all before it left out as well
        return abs(change.number) + change.half_width()

    @property
    def lines(self) -> list[tuple[str, str]]:
        """Lines of a report, pairs of name and text: on the effects left out, and on those kept."""
        if self.accepted is None:
            return []
        share = f"{100.0 * self.accepted:g} %"
        if not self.left_out:
            lines = [("left out", f"nothing to gain: {self.reason}" if self.reason else "nothing to gain")]
        else:
            out = ", ".join(map(_format_change, self.left_out))
            gain = 1.0 / self.left_out[-1].cpu.number
            lines = [("left out", f"{out}: within {share}; {gain:.2g} times as fast")]
        kept = ", ".join(f"{_format_change(change)}: {why}" for change, why in self.kept)
        return [*lines, *([("kept", kept)] if kept else [])]

    @property
    def facts(self) -> dict[str, Any]:
        """Effects that were left out and kept, under their keys in the JSON output; empty if nothing was tried."""
        if self.accepted is None:
            return {}
        listed = {
            name: [
                {"effect": change.effect, "change": change.change, "mm_s": change.speed.value, "se": change.speed.se}
                | ({"why": why} if why else {})
                for change, why in changes
            ]
            for name, changes in (("left_out", [(change, "") for change in self.left_out]), ("kept", self.kept))
        }
        return {"effects": {"accepted_error": self.accepted, "reason": self.reason} | listed}

    def widen(self, summary: Summary) -> Summary:
        """Return the summary of the simplest scene's runs with bounds of the speed that include what was left out."""
        return summary._replace(numbers={**summary.numbers, SPEED: self.widen_speed(summary.speed)})

    def widen_speed(self, speed: Quantity) -> Quantity:
        """Return a speed in the simplest scene, mm/s, with bounds that include what was left out.

        The change of the speed is known and adds to the other errors; its own error is independent of them.
        """
        if not self.left_out or speed.value is None:
            return speed
        change, half = self.left_out[-1].speed, speed.half_width()
        error, ends = self.error_mm_s, speed.ends
        if ends is not None:
            return speed._replace(ends=(ends[0] - error, ends[1] - error, ends[2] + error, ends[3] + error))
        if math.isinf(half):
            return speed
        wanted = abs(change.number) + math.hypot(half, change.half_width())
        return speed._replace(bias=math.sqrt(wanted**2 - half**2 + speed.bias**2))


def _format_change(change: Change) -> str:
    """Format an effect's name with the change of speed (mm/s) when it is left out."""
    speed, named = change.speed, change.effect
    if speed.value is None:
        return f"{named} ({speed.refused})"
    number = formatting.format_fixed(speed.value, 2) if speed.se is None else formatting.format_with_error(*speed.pair)
    return f"{named} ({number} mm/s)"


def check_no_accepted_error(scene: Scene, why: str) -> None:
    """Raise InputError if the scene sets `run.accepted_error`. `why`: reason that the message gives."""
    accepted = scene.run.accepted_error
    if accepted is not None:
        key = "scene.run.accepted_error"
        raise InputError(f"{key} = {accepted:g}: {why}. Remove this key.", key)


def find_simplest(
    walker: Walker, progress: Progress = silent, threads: int | None = None, simulated_s: float | None = None
) -> Simplest:
    """Return the walker in the simplest scene whose speed stays within the scene's `run.accepted_error` (95 %).

    An effect is left out if runs without it take less time, and their mean and scatter are not changed by more. Each
    is compared with the complete scene, with those before it left out as well. Effects in `effects.on` stay.

    Parameters
    ----------
    walker : Walker
        Walker in its complete scene. Without the key, nothing is measured or left out.
    progress : Progress
        Callback for progress.
    threads : int, optional
        Number of threads for runs.
    simulated_s : float, optional
        Simulated time of the simulation to be shortened, s. None: that of the scene's runs.

    Returns
    -------
    Simplest
        Walker in the simplest scene, and what was left out.
    """
    accepted, run = walker.scene.run.accepted_error, walker.scene.run
    if accepted is None:
        return Simplest(walker)
    complete = walker._replace(scene=replace_without_validation(walker.scene, {"run.accepted_error": None}))
    if simulated_s is None:
        simulated_s = run.runs * (run.discard_seconds + run.seconds)
    rules = _switchable_rules(complete)
    pilot_s = (1 + len(rules)) * PILOT_RUNS * variants.short_run_s(complete)
    if pilot_s > MAX_PILOT_SHARE * simulated_s:
        spent, whole = (formatting.format_number(seconds, 2) for seconds in (pilot_s, simulated_s))
        return Simplest(
            complete, accepted, reason=f"measuring the effects takes {spent} s of simulation, the runs {whole} s"
        )
    key = f"effects {complete.key} {digest()} {accepted:g} {simulated_s:g}"
    with closing(Store()) as store:
        stored = store.get([key]).get(key)
        if stored is not None:
            return _restore(Simplest(complete, accepted), rules, json.loads(str(stored["effects"])))
        found = _measure(Simplest(complete, accepted), rules, simulated_s, progress, threads)
        changes = [(change, "") for change in found.left_out], found.kept
        store.save([(key, {"effects": json.dumps(changes)})])
    return found


def _switchable_rules(walker: Walker) -> dict[str, Rule]:
    """Return the rules of the effects that may be left out of a walker's scene, by the effects' names."""
    found, case = {}, walker.plan().case
    for rule in active_effects.all_rules():
        effect = rule.decide(case)
        if effect.on and rule.switch and rule.switch not in walker.scene.effects.on:
            found[effect.name] = rule
    return found


def _restore(found: Simplest, rules: dict[str, Rule], stored: list[list[Any]]) -> Simplest:
    """Return `found` with the changes that the store has, and the walker without the effects left out."""
    left_out, kept = (tuple((_restore_change(*change), why) for change, why in part) for part in stored)
    for change, _ in left_out:
        variant = variants.without_effect(found.walker, rules[change.effect])
        assert variant is not None
        found = found._replace(walker=variant.walker)
    return found._replace(left_out=tuple(change for change, _ in left_out), kept=kept)


def _restore_change(effect: str, words: str, speed: list[Any], cpu: list[Any], scatter: list[float] | None) -> Change:
    """Return a change from its values in the store."""
    return Change(
        effect, words, Quantity(*speed), Quantity(*cpu), None if scatter is None else (scatter[0], scatter[1])
    )


def _measure(
    found: Simplest, rules: dict[str, Rule], simulated_s: float, progress: Progress, threads: int | None
) -> Simplest:
    """Leave out one effect of `rules` after the other, the slowest first, and return what is left."""
    complete, until = found.walker, UntilDecided(Tolerance(found.accepted or 0.0, relative=True))
    singles = [_without(complete, name, rule) for name, rule in rules.items()]
    pilot = _run(Pairs(complete, tuple(filter(None, singles))), Runs(PILOT_RUNS), progress, threads)
    speed, spent = pilot.experiment.mean_speed(pilot.records), found.cpu_s + _cpu_s(pilot)
    found = found._replace(cpu_s=spent)
    for change in sorted(pilot.experiment.changes(pilot.records), key=lambda change: change.cpu.number):
        if change.cpu.number > MAX_CPU_RATIO:
            continue  # leaving it out saves nothing
        judged = variants.verdict(complete, speed, change, until.tolerance)
        saved_s = MAX_SPENT_SHARE * (1.0 - change.cpu.number) * simulated_s
        pairs = min(MAX_PAIRS, math.floor(saved_s / (2.0 * variants.short_run_s(complete))))
        variant = _without(found.walker, change.effect, rules[change.effect])
        if judged is Verdict.UNDECIDED or judged is Verdict.AGREE:
            if variant is None or pairs < FIRST_RUNS:
                found = found._replace(kept=(*found.kept, (change, "deciding on it takes longer than it saves")))
                continue
            found = _decide(found, Pairs(complete, (variant,)), until._replace(max_runs=pairs), progress, threads)
        else:
            found = found._replace(kept=(*found.kept, (change, "changes the speed by more")))
    return found


def _decide(found: Simplest, pairs: Pairs, until: UntilDecided, progress: Progress, threads: int | None) -> Simplest:
    """Return `found` with an effect left out if its change is within the tolerance, otherwise kept with the reason."""
    measured = _run(pairs, until, progress, threads)
    (change,) = pairs.changes(measured.records)
    found, judged = found._replace(cpu_s=found.cpu_s + _cpu_s(measured)), until.verdict(measured)
    if judged is not Verdict.AGREE:
        why = "changes the speed by more" if judged is Verdict.DISAGREE else "not known to change it by less"
    elif change.changes_scatter(until.tolerance.value):
        with_it, without = (formatting.format_number(scatter, 2) for scatter in change.scatter or ())
        why = f"without it, runs scatter by {without} mm/s instead of {with_it}"
    else:
        return found._replace(walker=pairs.variants[0].walker, left_out=(*found.left_out, change))
    return found._replace(kept=(*found.kept, (change, why)))


def _without(walker: Walker, name: str, rule: Rule) -> Variant | None:
    """Return the variant of a walker's scene without an effect, under its name; None if it cannot be simulated."""
    variant = variants.without_effect(walker, rule)
    return None if variant is None else variant._replace(effect=name)


def _run(pairs: Pairs, until: Runs | UntilDecided, progress: Progress, threads: int | None) -> Measured[Pairs]:
    """Simulate pairs until a rule has enough. Raises KeyboardInterrupt after Ctrl-C."""
    measured = measure(pairs, until, progress, threads)
    if measured.partial:
        raise KeyboardInterrupt
    return measured


def _cpu_s(measured: Measured[Pairs]) -> float:
    """Return the CPU time of a measurement's runs, s."""
    return float(sum(run.cpu_s for runs in measured.records for run in runs))
