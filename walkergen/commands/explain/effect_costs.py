"""Change of a walker's speed and CPU time by each effect, measured with simulations of a few seconds."""

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from walkergen.core import measure as measuring
from walkergen.core.files import formatting
from walkergen.core.files.progress import Progress
from walkergen.core.measure import Budget, Runs
from walkergen.core.numerics.quantity import Quantity, Verdict
from walkergen.core.tolerance import Tolerance
from walkergen.files.report import Column, Table, text_column
from walkergen.points import variants
from walkergen.points.effect_selection import MAX_CPU_RATIO
from walkergen.points.experiments import Walker
from walkergen.points.variants import Change, Pairs, Variant

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BUDGET_S, SINGLE_EFFECT_SHARE = 10.0, 0.8
"""Time for all runs, s, and the share of it for switching effects one at a time."""

MIN_RUNS, ACTIVE_RUNS = 4, 4
"""Smallest number of runs of each scene within BUDGET_S, and number of runs if only active effects are measured."""

ADVICE_LEVELS = (0.01, 0.05, 0.2)
"""Shares of the speed. For each, the advice names what changes mean and scatter of the speed by less."""


class EffectChanges(NamedTuple):
    """Changes of speed and CPU time in variants of a scene, which differ by effects that are switched off or on."""

    speed: Quantity
    """Mean speed of the scene, mm/s."""
    changes: tuple[Change, ...]
    """Change in each variant."""
    pairs: int
    """Number of runs of each variant."""
    advice: str = ""
    """Sentence on the effects that can be left out."""


KEYS = ("effect", "change", "change_mm_s", "change_se_mm_s", "refused", "cpu_ratio", "cpu_ratio_se")
COLUMNS = (
    text_column("effect", "effect"),
    text_column("how", "change"),
    Column("change\nmm/s", lambda row: row.speed.refused or format_change(row.speed), True),
    Column("CPU time", lambda row: format_factor(row.cpu), True),
)


def format_factor(number: Quantity) -> str:
    """Format a ratio with its standard error, to hundredths."""
    return (
        "-"
        if number.value is None
        else "x " + " ± ".join(formatting.format_fixed(one, 2) for one in (number.value, number.se) if one is not None)
    )


def format_change(number: Quantity) -> str:
    """Format a change of the speed with its standard error."""
    if number.value is None:
        return "-"
    return (
        formatting.format_fixed(number.value, 2)
        if number.se is None
        else formatting.format_with_error(number.value, number.se)
    )


def format_signed(number: Quantity) -> str:
    """Format a change of the speed with its sign and its standard error; "-" without a value."""
    return f"+{format_change(number)}" if number.value is not None and number.value > 0.0 else format_change(number)


def format_share(ratio: Quantity) -> str:
    """Format the share of the CPU time, in %, that an effect takes, from the ratio of the times without and with it."""
    return "-" if ratio.value is None else f"{100.0 * (1.0 - ratio.value):.0f} %"


def measure_active_effects(walker: Walker, progress: Progress) -> EffectChanges:
    """Measure how speed and CPU time change when each active effect is switched off in turn, with ACTIVE_RUNS runs.

    The result has advice on effects to leave out.
    """
    active = tuple(variants.effect_variants(walker, also_on=False))
    alone = _measure_variants(walker, active, Runs(ACTIVE_RUNS), progress)
    return alone._replace(advice=_advise(walker, active, alone, Runs(ACTIVE_RUNS), progress))


def measure_all_effects(walker: Walker, progress: Progress) -> EffectChanges:
    """Measure the changes if each effect is switched off, or on at its usual size, and if the two largest are together.

    The result has advice on effects to leave out.
    """
    budget_progress = _budget_progress(progress)
    candidates = tuple(variants.effect_variants(walker, also_on=True))
    alone = _measure_variants(walker, candidates, Budget(SINGLE_EFFECT_SHARE * BUDGET_S, MIN_RUNS), budget_progress)
    rest, changes = Budget((1.0 - SINGLE_EFFECT_SHARE) * BUDGET_S, MIN_RUNS), list(alone.changes)
    largest = _combine(walker, _largest_variants(candidates, alone))
    if largest is not None:
        changes += _measure_variants(walker, (largest,), rest, budget_progress).changes
    advice = _advise(walker, candidates, alone, rest, budget_progress)
    return alone._replace(changes=tuple(sorted(changes, key=_change_size, reverse=True)), advice=advice)


def _measure_variants(
    walker: Walker, candidates: tuple[Variant, ...], until: Runs | Budget, progress: Progress
) -> EffectChanges:
    """Simulate variants `until` a number of runs or a time is reached. Return their changes."""
    measured = measuring.measure(Pairs(walker, candidates), until, progress)
    if measured.partial:
        raise KeyboardInterrupt
    pairs, records = measured.experiment, measured.records
    return EffectChanges(pairs.mean_speed(records), tuple(pairs.changes(records)), measured.runs)


def _budget_progress(progress: Progress) -> Progress:
    """Return a progress callback that reports elapsed seconds of BUDGET_S instead of runs."""
    started: list[float] = []  # times of all reports, the first of which counts

    def report_seconds(step: str, done: int, total: int) -> None:
        """Report elapsed seconds instead of runs; other steps unchanged."""
        if step != "runs":
            return progress(step, done, total)
        started.append(time.perf_counter())
        return progress("seconds", min(int(started[-1] - started[0]), int(BUDGET_S)), int(BUDGET_S))

    return report_seconds


def _change_size(change: Change) -> float:
    """Return the size of a change, mm/s; unknown sizes sort last."""
    return -1.0 if change.speed.value is None else abs(change.speed.value)


def _largest_variants(candidates: Sequence[Variant], measured: EffectChanges) -> list[Variant]:
    """Return the two variants, among those that set keys of the scene, that change the speed most."""
    sizes = {change.effect: _change_size(change) for change in measured.changes}
    by_size = sorted((variant for variant in candidates if variant.values), key=lambda variant: -sizes[variant.effect])
    return by_size[:2]


def _is_within(walker: Walker, measured: EffectChanges, change: Change, share: float) -> bool:
    """Return whether a change of mean and scatter is within a share of those of `measured`, with 95 % confidence."""
    mean = variants.verdict(walker, measured.speed, change, Tolerance(share, relative=True))
    return mean is Verdict.AGREE and not change.changes_scatter(share)


def _advise(
    walker: Walker, candidates: Sequence[Variant], alone: EffectChanges, until: Runs | Budget, progress: Progress
) -> str:
    """Return a sentence on what may be left out for each of ADVICE_LEVELS, and how much faster runs are without it.

    Several effects are measured together `until` a rule has enough runs; if they change the speed by more, only the
    slowest is named.
    """
    together: dict[tuple[str, ...], Change] = {}
    found = []
    for level in ADVICE_LEVELS:
        pairs = zip(candidates, alone.changes, strict=True)
        fitting = [
            (variant, change)
            for variant, change in pairs
            if variant.leaves_out and change.cpu.number < MAX_CPU_RATIO and _is_within(walker, alone, change, level)
        ]
        names = tuple(variant.effect for variant, _ in fitting)
        if len(names) > 1 and names not in together:
            combined = _combine(walker, [variant for variant, _ in fitting])
            if combined is not None:
                (together[names],) = _measure_variants(walker, (combined,), until, progress).changes
        best = min((change for _, change in fitting), key=lambda change: change.cpu.number, default=None)
        if names in together and _is_within(walker, alone, together[names], level):
            best = together[names]
        gain = "" if best is None else f" ({formatting.format_number(1.0 / best.cpu.number, 2)} times as fast)"
        found.append(f"for {100.0 * level:g} %: {'nothing' if best is None else best.effect}{gain}")
    return f"may be left out {'; '.join(found)}"


def _combine(walker: Walker, chosen: Sequence[Variant]) -> Variant | None:
    """Return one variant with the changes of all `chosen` ones; None for fewer than two, or if they do not combine."""
    if len(chosen) < 2:
        return None
    combined: Variant | None = chosen[0]
    for variant in chosen[1:]:
        combined = None if combined is None else variants.combine(walker, combined, variant)
    return combined


def table(measured: EffectChanges) -> Table:
    """Return the table of all changes, the largest first."""
    title = f"Change by each effect: {measured.pairs} runs of each, compared with {format_change(measured.speed)} mm/s"
    note = "CPU time: over that of the scene; ± is one standard error"
    rows = [
        (one.effect, one.change, *one.speed.row().values(), one.speed.refused, *one.cpu.row().values())
        for one in measured.changes
    ]
    return Table("measured", rows, KEYS, COLUMNS, title, [note], read=measured.changes)


def draw_changes(measured: EffectChanges, title: str) -> "Figure":
    """Draw the changes of the speed, with bars of 95 % confidence, next to the changes of the CPU time."""
    from walkergen.files import figures
    from walkergen.files.figures import FITTED, MEASURED

    known = [change for change in measured.changes if change.speed.value is not None][::-1]
    places = list(range(len(known)))
    figure, (speeds, costs) = figures.new_grid(title, 2, 2, 0.6 + 0.19 * len(known), share_y=True)
    for axes, numbers, look in (
        (speeds, [change.speed for change in known], MEASURED),
        (costs, [change.cpu for change in known], FITTED),
    ):
        halves = [0.0 if number.se is None else number.half_width() for number in numbers]
        axes.errorbar(
            [number.number for number in numbers],
            places,
            xerr=halves,
            fmt=look.marker,
            color=look.colour,
            markersize=4.0,
            capsize=2.0,
            elinewidth=0.8,
        )
    figures.draw_level(speeds, 0.0, upright=True)
    figures.draw_level(costs, 1.0, upright=True)
    speeds.set_yticks(places, [f"{change.effect}: {change.change}" for change in known])
    figures.label_axes(speeds, "change of speed (mm/s)")
    figures.label_axes(costs, "CPU time, ratio")
    return figure
