"""Report of the designs that were found for a wish: a row each, how sure they are, what is next."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from walkergen.files import templates, words
from walkergen.files.report import Column, Report, Table
from walkergen.jobs.make.design.lab import FRICTION_STEP, Job
from walkergen.jobs.make.design.search import Search
from walkergen.jobs.make.design.verify import Verified
from walkergen.jobs.make.design.wish import UNITS
from walkergen.points.point import PREDICTION

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TREND = "dv_dmu_mm_s"
"""Key of the change of speed with friction."""

ALIGNMENT = "self_alignment_per_mm", "self_alignment_se_per_mm"
"""Keys of the self-alignment and of its standard error."""


@dataclass(frozen=True, kw_only=True, repr=False)
class DesignReport(Report):
    """Designs that were found for a wish."""

    job: Job
    search: Search
    designs: Sequence[Verified]
    """Best distinct ones, best first."""
    stopped: str
    """Reason why none meets the wish; "" when one does."""


def of(job: Job, result: Search, designs: Sequence[Verified], stopped: str, folder: Path) -> DesignReport:
    """Report of designs that are written into a folder."""
    rows = [_row(job, number, design) for number, design in enumerate(designs, start=1)]
    keys = list(rows[0])
    table = Table("design", [tuple(row.values()) for row in rows], keys, _columns(job, keys))
    facts = {
        "wish": job.wish.words,
        "error": str(job.wish.error),
        "model": job.model,
        "scene": job.scene.name,
        "printer": job.printer.name,
        "met": sum(design.met for design in designs),
        "rows": rows,
        "stopped": stopped or None,
        "surveyed": len(result.survey.x),
        "made": int(result.survey.feasible.sum()),
        "tried": len(result.trials),
    }

    def draw() -> "Figure":
        from walkergen.jobs.make.design import figures

        return figures.trade_off(title(job), job, result, designs)

    return DesignReport(
        name="design",
        title=f"Designs as {job.design.name}: {job.wish.words}",
        caption=title(job),
        tables=[table],
        facts=facts,
        figures={"design": draw},
        folder=folder,
        lines=[_units(job), *_how(job, result), *_notes(designs, stopped), *_next(job, folder)],
        job=job,
        search=result,
        designs=designs,
        stopped=stopped,
    )


def title(job: Job) -> str:
    """Wish, error, model, scene and printer in a line."""
    how = "predictions" if job.model == PREDICTION else f"model {job.model}"
    return f"{job.wish.words}, within {job.wish.error}: {how}, {job.scene.name}, {job.printer.name}"


def _quantity(job: Job) -> str:
    """Key of the wish's quantity, with its unit."""
    return {
        "speed": "speed_mm_s",
        "persistence length": "persistence_length_mm",
        "turning radius": "turning_radius_mm",
        "turning down the slope": "turning_down_rad_s",
        "turning up the slope": "turning_up_rad_s",
    }[job.wish.of]


def _row(job: Job, number: int, design: Verified) -> dict[str, Any]:
    """Row of a design, every digit, None for what is not known."""
    name = _quantity(job)
    low, high = design.bounds or (None, None)
    row: dict[str, Any] = {
        "design": f"design-{number}.toml",
        **design.values,
        "predicted_mm_s": design.predicted_mm_s,
        f"chosen_{name}": design.chosen.value,
        f"chosen_se_{name}": design.chosen.se,
        f"verified_{name}": design.verified and design.verified.value,
        f"verified_se_{name}": design.verified and design.verified.se,
        f"low_95_{name}": low,
        f"high_95_{name}": high,
    }
    if job.wish.of != "speed":
        row["verified_speed_mm_s"] = design.speed_mm_s
    if job.wish.way is not None:
        row |= zip(ALIGNMENT, design.alignment or (None, None), strict=True)
    if job.wish.calm:
        row |= {TREND: design.slope and design.slope.value, f"{TREND}_se": design.slope and design.slope.se}
    return row | {
        "runs": design.runs,
        "met": design.met,
        "print_warnings": design.warnings,
        "print_told": design.finding or None,
    }


def _columns(job: Job, keys: Sequence[str]) -> list[Column]:
    """Columns that people read; values when chosen, and runs, are in the CSV alone.

    So are predicted speeds where a slope shall turn headings: with these all ways few are known.
    """

    def column(heading: str, cell: Callable[..., str], *names: str, right: bool = True) -> Column:
        places = [keys.index(name) for name in names]

        def text(row: Sequence[Any]) -> str:
            values = [row[place] for place in places]
            return "unknown" if None in values else cell(*values)

        return Column(heading, text, right)

    name, predicted = _quantity(job), job.model == PREDICTION
    varied = zip(_short(job.box.keys), job.box.keys, strict=True)
    return [
        column("design", str, "design", right=False),
        *(column(heading, lambda value: words.number(value, 6), key) for heading, key in varied),
        *([] if predicted or job.wish.way else [column("predicted", words.number, "predicted_mm_s")]),
        column("prediction" if predicted else "verified", words.with_error, f"verified_{name}", f"verified_se_{name}"),
        column("95 %", words.span, f"low_95_{name}", f"high_95_{name}"),
        *([column("dv/dmu", words.with_error, TREND, f"{TREND}_se")] if job.wish.calm else []),
        *([column("self-alignment", words.with_error, *ALIGNMENT)] if job.wish.way else []),
        column("met", lambda met: "yes" if met else "no", "met", right=False),
        column("print", lambda count: "warning" if count else "ok", "print_warnings", right=False),
    ]


def _short(keys: Sequence[str]) -> list[str]:
    """Keys without their tables, where that leaves them different."""
    last = [key.rpartition(".")[2] for key in keys]
    return last if len(set(last)) == len(keys) else list(keys)


def _units(job: Job) -> str:
    other = "" if job.wish.of == "speed" else f"; the {job.wish.of} in {UNITS[job.wish.of]}"
    if job.wish.way is not None:
        other += ", at 90 deg to the descent; the self-alignment in 1/mm, above 0 down the slope"
    error = "; verified with the standard error" if job.simulated else ""
    return f"speeds in mm/s{other}{error}"


def _how(job: Job, result: Search) -> list[str]:
    """Sentences on what was searched, and on how the numbers were found."""
    unmade = len(result.survey.x) - int(result.survey.feasible.sum())
    ranges = ", ".join(f"{span.key} {span.low:g} to {span.high:g}" for span in job.box.spans)
    by = f"model {job.model}, seed {job.seed}" if job.simulated else "predictions"
    lines = [
        f"{ranges}; held: all else of {job.design.name}",
        f"{len(result.survey.x)} designs predicted, {unmade} of which cannot be made or printed on "
        f"{job.printer.name}; {len(result.trials)} tried with {by}",
    ]
    if job.simulated:
        step = "is not in them" if job.wish.asks_space else "is in them where it is known"
        lines.append(
            "verified by fresh runs with another seed, that did not choose the designs; the bounds "
            f"are theirs, of the model alone: the step's error {step}"
        )
    else:
        lines.append(
            "designs were read back from their files and computed anew; predictions have no runs: "
            "bounds hold what is not known of print and contact, and the model's own error; "
            "--model space simulates"
        )
    if job.wish.calm:
        share = 100.0 * FRICTION_STEP[job.simulated]
        lines.append(
            f"dv/dmu is the difference of the speeds at {share:g} % less and more friction over that of the frictions"
        )
    return lines


def _notes(designs: Sequence[Verified], stopped: str) -> list[str]:
    """Sentences on printing, and on why there are not three designs that meet the wish."""
    lines = [f"print: {worst}" for worst in sorted({design.finding for design in designs if design.finding})]
    if stopped:
        lines.append(f"none meets the wish: {stopped}")
    elif len(designs) < 3:
        lines.append(f"there are {len(designs)} that differ clearly, no more")
    return lines


def _next(job: Job, folder: Path) -> list[str]:
    """Commands that go on from the first design."""
    printer = job.printer.name if job.printer.name in templates.names("printers") else "PRINTER"
    design, scene = f"{folder}/design-1.toml", f"--scene {folder}/scene-1.toml"
    commands = (
        f"family {design} {scene} --printer {printer}",
        f"plate {design} --printer {printer}",
        f"simulate {design} {scene} --seconds 4 --runs 32",
    )
    return [f"next: `walkergen {command}`" for command in commands]
