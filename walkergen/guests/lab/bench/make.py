"""Drop of a walker: simulated, inverted where its rebound was measured, and reported."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from walkergen.core.files import formatting
from walkergen.core.files.progress import Progress
from walkergen.core.walker import names
from walkergen.core.walker.design import Design
from walkergen.files import report
from walkergen.files.report import Table
from walkergen.guests.lab import drops, inverse, still_plate
from walkergen.guests.lab.bench import drop
from walkergen.guests.lab.bench.drop import Dropped
from walkergen.guests.lab.calibrate.make import Job
from walkergen.guests.lab.inverse import Answer, Curve, Measured
from walkergen.guests.lab.report import LabReport, write_report

if TYPE_CHECKING:
    from matplotlib.figure import Figure

REBOUND_COLUMNS = ("flat", "from_hand", "sd_of_a_drop", "fell_over")
"""Columns of the rebounds under one condition."""

Value = float | str | None


def default_folder(design: Design) -> Path:
    """Folder of a drop by default: below out/ and the walker's name."""
    return Path("out") / design.name / f"bench_drop_{names.part_name(design)}"


def run_drop_test(job: Job, height: float, measured: Measured | None, folder: Path, progress: Progress) -> LabReport:
    """Drop a walker from a height (mm); writes drop.csv and a table for all else that counts, figure and page.

    Without a first turn only the flat drop counts. Raises InputError before anything is simulated.
    """
    rebounds = drop.simulate_drop_test(job.scene, job.design, height, job.turn_deg, job.drops, progress)
    hand = f"pitch and roll ± {job.turn_deg:g} deg"
    curves = {"let go flat": rebounds.curve(flat=True), f"from the hand ({hand})": rebounds.curve(flat=False)}
    if job.turn_deg == 0.0:
        curves.popitem()
    answers = _answers(job.design, measured, curves)
    notes = [
        f"from the hand: {hand}, {height:g} mm; rebound: root of the height regained over that "
        "of the drop, of the body's middle over where it stands",
        *_flatness_notes(rebounds),
    ]
    settings = _settings(answers)
    caption = f"{still_plate.describe_test(job.scene, job.design)}; dropped by {height:g} mm"
    title = f"Drop of {job.design.name}, {job.design.tilt_deg:g} deg, {job.design.kind}"
    tables = _drop_tables(rebounds)

    def draw() -> "Figure":
        from walkergen.guests.lab.bench import figures

        return figures.draw_drop(rebounds, title, job.turn_deg, measured)

    lines = [f"{condition}: {answer.text}" for condition, answer in answers]
    if settings:
        lines.append(
            "set " + ", ".join(f"{key} = {formatting.format_number(value, 4)}" for key, value in settings.items())
        )
    facts = {
        "bench": "drop",
        "caption": caption,
        "tables": {table.name: list(table) for table in tables},
        "answers": [{"condition": condition, **answer.facts} for condition, answer in answers],
        "settings": settings,
        "notes": notes,
    }
    made = LabReport(
        name="drop",
        title=title,
        caption=caption,
        tables=tables,
        facts=facts,
        lines=[*lines, *notes],
        settings=settings,
        notes=notes,
        figures={"drop": draw},
        folder=folder,
        design=job.design,
        scene=job.scene,
    )
    asked = {"height": height, "turn_deg": job.turn_deg, "drops": job.drops}
    return write_report(made, job, {"bench": "drop", "measured": measured and measured.facts, **asked})


def _answers(design: Design, measured: Measured | None, curves: Mapping[str, Curve | None]) -> list[tuple[str, Answer]]:
    """Find the restitution on each curve for the measured rebound, with the curve's condition."""
    if measured is None:
        return []
    return [
        (condition, inverse.invert(curve, measured, "foot restitution", f" at {design.tilt_deg:g} deg"))
        for condition, curve in curves.items()
        if curve is not None
    ]


def _settings(answers: Sequence[tuple[str, Answer]]) -> dict[str, float]:
    """Return the scene's restitution and its standard deviation from the last answer, if it has a single branch."""
    if not answers:
        return {}
    number = answers[-1][1].number("restitution")
    keys = ("contact.restitution", "contact.restitution_sd")
    return dict(zip(keys, number.pair, strict=True)) if number.known else {}


def _make_table(name: str, title: str, keys: Sequence[str], values: Sequence[Sequence[Value]]) -> Table:
    """Return the table of a bench test; all its keys are shown to people."""
    texts = [key for key, first in zip(keys, values[0], strict=True) if isinstance(first, str)]
    return Table(name, values, keys, report.key_columns(keys, texts), title)


def _drop_tables(rebounds: Dropped) -> list[Table]:
    """Return rebounds by restitution, by other conditions, and by the first turn."""
    conditions = {"restitution": list(zip(drops.RESTITUTIONS, rebounds.by_label, strict=True)), **rebounds.by}
    units = {"tilt": "tilt_deg", "height": "height_mm"}
    tables = []
    for what, table in conditions.items():
        name, title = ("drop", "the feet's restitution") if what == "restitution" else (f"{what}s", what)
        keys = (units.get(what, what), *REBOUND_COLUMNS)
        rows = [(float(at), each.flat, each.mean, each.sd, each.fell) for at, each in table]
        tables.append(_make_table(name, f"rebound by {title}", keys, rows))
    turns = ("turn_deg", "rebound_rolled", "rebound_pitched")
    return [*tables, _make_table("turns", "rebound by the first turn", turns, rebounds.by_turn)]


def _flatness_notes(rebounds: Dropped) -> list[str]:
    """Note on how flat a drop has to be to count as flat."""
    alike = rebounds.flat_within
    if alike is None:
        return []
    if alike == rebounds.by_turn[-1][0]:
        return [f"a first roll up to {alike:g} deg changes nothing that shows"]
    return [f"flat means a roll of at most {alike:g} deg: beyond it one corner lands alone"]
