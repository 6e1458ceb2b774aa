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


SHORT_COLUMNS = (
    report.text_column("effect", "effect"),
    report.number_column("size", "number", 3),
    Column("without it\nmm/s", lambda row: measuring.format_change(row.speed), True),
    Column("CPU time\nwithout it", lambda row: measuring.format_factor(row.cpu), True),
)
REASON_COLUMNS = (
    report.text_column("effect", "effect"),
    Column("", lambda row: "on" if row.on else "off"),
    report.number_column("size", "number", 3),
    Column("why", lambda row: f"{row.reason} ({row.meaning})" + (f"; switch {row.switch}" if row.switch else "")),
)


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
    on, off = ([row for row in rows if row.on == wanted] for wanted in (True, False))
    effects_table = Table(
        "effects",
        [tuple(row.values()) for row in row_facts],
        [*row_facts[0]],
        REASON_COLUMNS if whole else SHORT_COLUMNS,
        read=rows if whole else on,
        notes=[] if found is None else ["± is one standard error, from pairs of runs with common random numbers"],
    )
    caption = f"{design.name}, tilt {design.tilt_deg:g} deg, on {scene.name}"
    made = Report(
        name="explain",
        title="Effects",
        caption=caption,
        tables=[effects_table, *([measuring.table(found)] if measure and found is not None else [])],
        facts=_facts(row_facts, found) | (simple.facts if found is not None else {}),
        lines=[
            *(
                []
                if whole
                else [f"off: {', '.join(row.effect for row in off)}; ‹all› prints reasons and the meaning of sizes"]
            ),
            *([] if found is None or not measure else [found.advice]),
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


def _rows(effects: Sequence[Effect], changes: Sequence[Change]) -> list[Row]:
    """Make the rows of all effects, with their measured changes."""
    by_effect: Mapping[str, Change] = {change.effect: change for change in reversed(changes)}
    unmeasured = Change("", "", Quantity("change", "mm_s", None), Quantity("cpu_ratio", "", None))
    return [Row(*effect, *by_effect.get(effect.name, unmeasured)[1:]) for effect in effects]


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
