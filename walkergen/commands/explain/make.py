"""Report of the effects of a scene: which are on, their sizes, and their influence on speed and CPU time."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

from walkergen.commands.explain import effect_costs as measuring
from walkergen.commands.explain.effect_costs import EffectChanges
from walkergen.core.files.output import Folder
from walkergen.core.files.progress import Progress
from walkergen.core.numerics.quantity import Quantity, column_values
from walkergen.core.scene import Scene
from walkergen.core.simulation.effects.effect import Effect
from walkergen.core.simulation.plan import prepare
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import report
from walkergen.files.report import Column, Report, Table
from walkergen.points import effect_selection, variants
from walkergen.points.effect_selection import Simplest
from walkergen.points.experiments import Walker
from walkergen.points.variants import Change


class Row(NamedTuple):
    """Effect of a scene: its size, the reason why it is on or off, and the changes of the result if it is switched."""

    effect: str
    on: bool
    number: float
    meaning: str
    reason: str
    switch: str
    change: str
    """Difference of the measured variant of the scene; "" if none was measured."""
    speed: Quantity
    """Mean speed of the variant minus that of the scene."""
    cpu: Quantity
    """CPU time of the variant over that of the scene."""


CHANGE_COLUMNS = (
    report.text_column("effect", "effect"),
    Column("change without it\nmm/s", lambda row: measuring.format_signed(row.speed), True),
    Column("its share of\nthe CPU time", lambda row: measuring.format_share(row.cpu), True),
)
SIZE_COLUMNS = (
    report.text_column("effect", "effect"),
    report.number_column("size", "number", 3),
    report.text_column("of", "meaning"),
)
REASON_COLUMNS = (
    report.text_column("effect", "effect"),
    Column("", lambda row: "on" if row.on else "off"),
    report.number_column("size", "number", 3),
    Column("why", lambda row: f"{row.reason} ({row.meaning})" + (f"; switch {row.switch}" if row.switch else "")),
)


NOTE = (
    "± is one standard error, from pairs of runs with common random numbers; a negative share: runs are slower without "
    "the effect"
)
"""Note under a table of changes."""


def explain(
    scene: Scene,
    design: Design,
    progress: Progress,
    cost: bool = True,
    measure: bool = False,
    whole: bool = False,
    folder: Path | None = None,
) -> Report:
    """Return the report of the effects that a scene requires, with the measured influence and cost of each.

    Parameters
    ----------
    scene, design : Scene, Design
        Scene, and walker in it.
    progress : Progress
        Callback for progress.
    cost : bool
        True to measure the active effects.
    measure : bool
        True to measure all effects, also inactive ones, for ten seconds.
    whole : bool
        True to print all effects with reasons.
    folder : Path, optional
        Folder to write the report to.

    Returns
    -------
    Report
        Effects, and those that the scene's accepted error leaves out.

    Raises
    ------
    InputError
        If the scene contradicts itself or the design.
    """
    walker = Walker(scene, design, solids.mass_of(design))
    plan = prepare(scene, design, walker.mass)
    effects = [effect for _, effect in variants.decide_effects(plan)]
    found: EffectChanges | None = None
    if measure:
        found = measuring.measure_all_effects(walker, progress)
    elif cost:
        found = measuring.measure_active_effects(walker, progress)
    simple = (
        effect_selection.find_simplest(walker, progress)
        if cost or measure
        else Simplest(walker, scene.run.accepted_error)
    )
    rows = _rows(effects, () if found is None else found.changes)
    row_facts = [column_values(row) for row in rows]
    columns, shown = _choose_columns(rows, found is not None, whole)
    effects_table = Table(
        "effects",
        [tuple(row.values()) for row in row_facts],
        [*row_facts[0]],
        columns,
        read=shown,
        notes=[] if found is None else [NOTE],
    )
    caption = f"{design.name}, tilt {design.tilt_deg:g} deg, on {scene.name}"
    headline = caption if found is None else f"{caption}: {measuring.format_change(found.speed)} mm/s"
    made = Report(
        name="explain",
        title="Effects",
        caption=headline,
        tables=[effects_table, *([measuring.table(found)] if measure and found is not None else [])],
        facts=_facts(row_facts, found) | (simple.facts if found is not None else {}),
        lines=[
            *([] if whole else _list_others(rows, shown)),
            *([] if found is None else [found.advice]),
            *_format_omissions(simple, found is not None),
        ],
        warnings=[plan.resolved.idle] if plan.resolved.idle else [],
        figures={} if found is None or not measure else {"explain": partial(measuring.draw_changes, found, caption)},
        folder=folder,
    )
    if folder is not None:
        with Folder(folder) as target:
            made.write(target, pictures=measure)
    return made


def _choose_columns(rows: Sequence[Row], measured: bool, whole: bool) -> tuple[Sequence[Column], list[Row]]:
    """Return the columns of the table, and the rows that it shows."""
    if whole:
        return REASON_COLUMNS, list(rows)
    on = [row for row in rows if row.on]
    return (CHANGE_COLUMNS, [row for row in on if row.change]) if measured else (SIZE_COLUMNS, on)


def _list_others(rows: Sequence[Row], shown: Sequence[Row]) -> list[str]:
    """Return a line on the effects that are always on, if the table does not show them, and one on those off."""
    always = ", ".join(row.effect for row in rows if row.on and row not in shown)
    off = ", ".join(row.effect for row in rows if not row.on)
    return [*([f"always on: {always}"] if always else []), f"off: {off}; ‹all› prints sizes and reasons"]


def _rows(effects: Sequence[Effect], changes: Sequence[Change]) -> list[Row]:
    """Make the rows of all effects, with their measured changes."""
    by_effect: Mapping[str, Change] = {change.effect: change for change in reversed(changes)}
    unmeasured = Change("", "", Quantity("change", "mm_s", None), Quantity("cpu_ratio", "", None))
    return [Row(*effect, *by_effect.get(effect.name, unmeasured)[1:4]) for effect in effects]


def _format_omissions(simple: Simplest, measured: bool) -> list[str]:
    """Return lines on the effects that simulations leave out because of the scene's accepted error."""
    if simple.accepted is None:
        return []
    key = f"run.accepted_error = {simple.accepted:g}"
    if not measured:
        return [f"{key}: omitted effects are found by measurement. Remove ‹cost=False›."]
    return [key, *(f"{name}: {value}" for name, value in simple.lines)]


def _facts(rows: Sequence[dict[str, object]], measured: EffectChanges | None) -> dict[str, object]:
    facts: dict[str, object] = {"rows": rows}
    if measured is not None:
        facts |= {"measured": list(measuring.table(measured)), "runs": measured.pairs}
        facts |= {"speed_mm_s": measured.speed.value, "advice": measured.advice}
    return facts
