"""Selection of the effects that can be left out of a scene, as they change a walker's speed by too little to matter."""

from typing import Any, NamedTuple

from walkergen.core.errors import InputError
from walkergen.core.files import formatting
from walkergen.core.files.progress import Progress, silent
from walkergen.core.measure import FIRST_RUNS, Measured, measure
from walkergen.core.numerics.quantity import Verdict
from walkergen.core.scene import Scene
from walkergen.core.simulation.effects import active_effects
from walkergen.core.simulation.effects.resolve import replace_without_validation
from walkergen.core.tolerance import Tolerance
from walkergen.points import variants
from walkergen.points.experiments import Walker
from walkergen.points.variants import Change, Pairs, Variant

MAX_PAIRS = 64
"""Pairs of runs after which a change that is not decided counts as too large."""


class UntilDecided(NamedTuple):
    """Rule that adds pairs of runs, with and without an effect, until it is clear whether the change is tolerable."""

    tolerance: Tolerance
    first_runs: int = FIRST_RUNS

    def verdict(self, measured: Measured[Pairs]) -> Verdict:
        """Return whether the change of speed is within the allowed error, with 95 % confidence, or undecided."""
        pairs, records = measured.experiment, measured.records
        return variants.verdict(pairs.walker, pairs.mean_speed(records), pairs.changes(records)[0], self.tolerance)

    def request_more(self, measured: Measured[Pairs]) -> Measured[Pairs] | None:
        """Return the measurement with twice as many pairs requested; None if decided, undecidable, or at MAX_PAIRS."""
        change = measured.experiment.changes(measured.records)[0].speed
        decided = self.verdict(measured) is not Verdict.UNDECIDED or change.se is None
        return None if decided or measured.runs >= MAX_PAIRS else measured.with_runs(2 * measured.runs)


class Simplest(NamedTuple):
    """Walker in the simplest scene, and what was left out."""

    walker: Walker
    accepted: float | None = None
    """Error that was accepted, a share of the speed; None: nothing was tried."""
    left_out: tuple[Change, ...] = ()
    """Changes by the effects that are left out, each measured with all effects before it left out as well."""
    kept: tuple[Change, ...] = ()
    cpu_s: float = 0.0
    """CPU time that finding it out took, s."""

    @property
    def error_mm_s(self) -> float:
        """Upper limit (95 %) of the change of speed, mm/s, by all effects left out together."""
        if not self.left_out:
            return 0.0
        change = self.left_out[-1].speed  # with all before it left out as well
        return abs(change.number) + change.half_width()

    @property
    def lines(self) -> list[tuple[str, str]]:
        """Report lines (name, text): the effects left out, and those kept."""
        if self.accepted is None:
            return []
        share = f"{100.0 * self.accepted:g} %"
        out, kept = ([_format_change(change) for change in changes] for changes in (self.left_out, self.kept))
        faster = 1.0 if not self.left_out else 1.0 / self.left_out[-1].cpu.number
        gain = f"; {faster:.2g} times as fast" if out else ""
        return [
            ("left out", f"{', '.join(out) or 'nothing'}: within {share}{gain}"),
            *([("kept", f"{', '.join(kept)}: not known to be within {share}")] if kept else []),
        ]

    @property
    def facts(self) -> dict[str, Any]:
        """Effects that were left out and kept, under their keys in the JSON output; empty if nothing was tried."""
        if self.accepted is None:
            return {}
        listed = {
            name: [
                {"effect": change.effect, "change": change.change, "mm_s": change.speed.value, "se": change.speed.se}
                for change in changes
            ]
            for name, changes in (("left_out", self.left_out), ("kept", self.kept))
        }
        return {"effects": {"accepted_error": self.accepted} | listed}


def _format_change(change: Change) -> str:
    """Format an effect's name with the change of speed (mm/s) when it is left out."""
    speed, named = change.speed, change.effect
    if speed.value is None:
        return f"{named} ({speed.refused})"
    number = formatting.format_fixed(speed.value, 2) if speed.se is None else formatting.format_with_error(*speed.pair)
    return f"{named} ({number} mm/s)"


def check_no_accepted_error(scene: Scene, why: str) -> None:
    """Raise InputError if the scene sets `run.accepted_error`. `why`: reason in the message."""
    accepted = scene.run.accepted_error
    if accepted is not None:
        key = "scene.run.accepted_error"
        raise InputError(f"{key} = {accepted:g}: {why}. Remove this key.", key)


def find_simplest(walker: Walker, progress: Progress = silent, threads: int | None = None) -> Simplest:
    """Return the walker in the simplest scene whose speed stays within the scene's `run.accepted_error` (95 %).

    Try to leave out one effect after the other, except those listed in `effects.on`. Each time, compare with the speed
    in the complete scene. If the key is not set, nothing is tried or left out.
    """
    accepted = walker.scene.run.accepted_error
    if accepted is None:
        return Simplest(walker)
    complete = walker._replace(scene=replace_without_validation(walker.scene, {"run.accepted_error": None}))
    found = Simplest(complete, accepted)

    def try_variant(variant: Variant | None) -> Simplest:
        """Measure a variant. Return `found` with its change in `left_out` or `kept`, unchanged for None."""
        if variant is None:
            return found
        measured = measure(Pairs(complete, (variant,)), until, progress, threads)
        if measured.partial:
            raise KeyboardInterrupt
        change = measured.experiment.changes(measured.records)[0]
        spent = found.cpu_s + sum(run.cpu_s for runs in measured.records for run in runs)
        if until.verdict(measured) is Verdict.AGREE:
            return found._replace(walker=variant.walker, left_out=(*found.left_out, change), cpu_s=spent)
        return found._replace(kept=(*found.kept, change), cpu_s=spent)

    until = UntilDecided(Tolerance(accepted, relative=True))
    for rule in active_effects.all_rules():
        effect = rule.decide(found.walker.plan().case)
        if effect.on and rule.switch and rule.switch not in complete.scene.effects.on:
            variant = variants.without_effect(found.walker, rule)
            found = try_variant(None if variant is None else variant._replace(effect=effect.name))
    return found
