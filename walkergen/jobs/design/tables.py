"""Tables of the designs that were found: CSV, Markdown, JSON, and for the terminal."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from walkergen.exploring.point import PREDICTION
from walkergen.files import templates, words
from walkergen.files.tables import as_markdown, csv_text
from walkergen.jobs.design.lab import Job
from walkergen.jobs.design.verify import Verified
from walkergen.jobs.design.wish import UNITS, Seen

if TYPE_CHECKING:
    from rich.box import Box as Frame
    from rich.table import Table

    from walkergen.jobs.design.make import Result

TREND = "dv_dmu_mm_s"
"""Column of the change of speed with friction."""


def column(job: Job) -> str:
    """Name of the column of the wish's quantity, with its unit."""
    return {"speed": "speed_mm_s", "persistence length": "persistence_length_mm",
            "turning radius": "turning_radius_mm"}[job.wish.of]  # fmt: skip


def row(job: Job, number: int, one: Verified) -> dict[str, Any]:
    """Row of a design, every digit, None for what is not known."""
    name = column(job)
    low, high = one.bounds or (None, None)
    found: dict[str, Any] = {
        "design": f"design-{number}.toml", **one.values, "predicted_mm_s": one.predicted_mm_s,
        f"chosen_{name}": one.chosen.value, f"chosen_se_{name}": one.chosen.se,
        f"verified_{name}": one.verified and one.verified.value,
        f"verified_se_{name}": one.verified and one.verified.se,
        f"low_95_{name}": low, f"high_95_{name}": high,
    }  # fmt: skip
    if job.wish.of != "speed":
        found["verified_speed_mm_s"] = one.speed_mm_s
    if job.wish.calm:
        found |= {TREND: one.slope and one.slope.value, f"{TREND}_se": one.slope and one.slope.se}
    return found | {
        "runs": one.runs, "met": one.met, "print_warnings": one.warnings,
        "print_told": one.told or None,
    }  # fmt: skip


def to_csv(job: Job, designs: Sequence[Verified]) -> str:
    """All numbers of the designs, a row each."""
    rows = [row(job, number, one) for number, one in enumerate(designs, start=1)]
    return csv_text(list(rows[0]), [list(one.values()) for one in rows])


def as_dict(result: "Result") -> dict[str, Any]:
    """Results for JSON."""
    job = result.job
    return {
        "wish": job.wish.words, "error": str(job.wish.error), "model": job.model,
        "scene": job.scene.name, "printer": job.printer.name,
        "met": sum(one.met for one in result.designs),
        "rows": [row(job, number, one) for number, one in enumerate(result.designs, start=1)],
        "stopped": result.stopped or None, "surveyed": len(result.found.survey.x),
        "made": int(result.found.survey.feasible.sum()), "tried": len(result.found.trials),
        "folder": str(result.folder),
    }  # fmt: skip


def to_table(job: Job, designs: Sequence[Verified], frame: "Frame", every: bool) -> "Table":
    """Table of the designs, as people read it; `every` column, or as fits a terminal."""
    from rich.table import Table

    table = Table(title=title(job), box=frame, pad_edge=every)
    rows = [_cells(job, number, one) for number, one in enumerate(designs, start=1)]
    left_out = (
        set() if every else {"chosen"} | ({"predicted"} if job.model == PREDICTION else set())
    )
    heads = [head for head in rows[0] if head not in left_out]
    for head in heads:
        table.add_column(head, justify="left" if head in ("met", "print") else "right")
    for cells in rows:
        table.add_row(*(cells[head] for head in heads))
    return table


def _cells(job: Job, number: int, one: Verified) -> dict[str, str]:
    """Row of the table by its headings."""
    known = zip(_short(job.box.keys), one.values.values(), strict=True)
    cells = {"": str(number)} | {key: f"{value:g}" for key, value in known} | {
        "predicted": "unknown" if one.predicted_mm_s is None else f"{one.predicted_mm_s:.1f}",
        "chosen": _with_error(one.chosen),
        "prediction" if job.model == PREDICTION else "verified": _with_error(one.verified),
        "95 %": "unknown" if one.bounds is None else "{:.1f}..{:.1f}".format(*one.bounds),
    }  # fmt: skip
    if job.wish.calm:
        cells["dv/dmu"] = _with_error(one.slope)
    print_as = "warning" if one.warnings else "ok"
    return cells | {"met": "yes" if one.met else "no", "print": print_as}


def _short(keys: Sequence[str]) -> list[str]:
    """Keys without their tables, where that leaves them different."""
    last = [key.rpartition(".")[2] for key in keys]
    return last if len(set(last)) == len(keys) else list(keys)


def _with_error(seen: Seen | None) -> str:
    if seen is None:
        return "unknown"
    value = words.number(seen.value, 4)
    return f"{value} ± {words.number(seen.se, 2)}" if seen.se else value


def title(job: Job) -> str:
    """Wish, error, model, scene and printer in a line."""
    how = "predictions" if job.model == PREDICTION else f"model {job.model}"
    return f"{job.wish.words}, within {job.wish.error}: {how}, {job.scene.name}, {job.printer.name}"


def units(job: Job) -> str:
    """Units of the table."""
    length = "" if job.wish.of == "speed" else f"; the {job.wish.of} in {UNITS[job.wish.of]}"
    return f"Speeds in mm/s{length}; chosen and verified with their standard error."


def to_markdown(result: "Result") -> str:
    """Page on the designs: the table, how they were found, how sure they are, what to do next."""
    from rich import box

    job = result.job
    lines = [f"# {title(job)[0].upper()}{title(job)[1:]}", ""]
    lines += [
        as_markdown(_untitled(job, result.designs, box.MARKDOWN)),
        "",
        units(job),
        "",
        *notes(result),
        "",
    ]
    lines += ["![Speed against the keys that vary](design.png)", "", "```sh"]
    folder, known = result.folder, templates.names("printers")
    printer = job.printer.name if job.printer.name in known else "PRINTER"
    lines += [f"walkergen {command}" for command in (
        f"family {folder}/design-1.toml --scene {folder}/scene-1.toml --printer {printer}",
        f"plate {folder}/design-1.toml --printer {printer}",
        f"simulate {folder}/design-1.toml --scene {folder}/scene-1.toml --seconds 4 --runs 32",
    )]  # fmt: skip
    return "\n".join([*lines, "```", ""])


def _untitled(job: Job, designs: Sequence[Verified], frame: "Frame") -> "Table":
    table = to_table(job, designs, frame, True)
    table.title = None
    return table


def notes(result: "Result") -> list[str]:
    """Sentences on what was done, and on how sure the numbers are."""
    job, found = result.job, result.found
    unmade = len(found.survey.x) - int(found.survey.feasible.sum())
    ranges = ", ".join(f"{span.key} {span.low:g} to {span.high:g}" for span in job.box.spans)
    lines = [
        f"- {ranges}; held: all else of {job.design.name}.",
        f"- {len(found.survey.x)} designs predicted, {unmade} of which cannot be made "
        f"or printed on {job.printer.name}; {len(found.trials)} tried with "
        + ("predictions." if job.model == PREDICTION else f"model {job.model}, seed {job.seed}."),
    ]
    if job.simulated:
        lines.append(
            "- Verified by fresh runs with another seed, that did not choose the designs; the "
            "bounds are theirs, of the model alone, "
            + (
                "and the step's error is not in them."
                if job.wish.asks_space
                else "and hold the step's error where it is known."
            )
        )
    else:
        lines.append(
            "- Designs were read back from their files and computed anew. Predictions have no "
            "runs: bounds hold what is not known of print and contact, and the model's own error; "
            "--model space simulates."
        )
    if job.wish.calm:
        lines.append(
            "- dv/dmu is the difference of the speeds at "
            + ("5 %" if not job.simulated else "20 %")
            + " less and more friction over that of the frictions."
        )
    told = {one.told for one in result.designs if one.told}
    lines += [f"- Print: {one}." for one in sorted(told)]
    if result.stopped:
        lines.append(f"- None meets the wish: {result.stopped}.")
    elif 0 < len(result.designs) < 3:
        lines.append(f"- There are {len(result.designs)} that differ clearly, no more.")
    return lines
