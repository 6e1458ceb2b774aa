"""What commands print: JSON, tables, progress."""

import json
import math
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from walkergen.accuracy import Study
    from walkergen.batch import Row
    from walkergen.design import Design
    from walkergen.prediction import Prediction
    from walkergen.report.tables import Simulated
    from walkergen.scene import Scene
    from walkergen.simulation.costs import Explained
    from walkergen.simulation.engines import Plan
    from walkergen.simulation.ensemble import Summary
    from walkergen.simulation.run import Engine
    from walkergen.study.choose import Met
    from walkergen.study.compare import Findings
    from walkergen.study.compare import Row as Compared
    from walkergen.templates import Entry


def as_json(data: dict[str, Any]) -> None:
    """Print JSON, refusing NaN and infinity, which JSON does not have."""
    print(json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False))


def rows_as_json(rows: Sequence[Any], more: Sequence[Any] = (), files: Sequence[Path] = ()) -> None:
    """Print {"rows": [...]} of named tuples, side by side with `more`, and the files written."""
    listed = [row._asdict() for row in rows]
    for row, extra in zip(listed, more, strict=False):
        row |= extra._asdict()
    data: dict[str, Any] = {"rows": listed}
    if files:
        data["files"] = [str(path) for path in files]
    as_json(data)


def files(paths: Sequence[Path], json: bool, quiet: bool) -> None:
    """Print the files written, one a line or as JSON."""
    if json:
        as_json({"files": [str(path) for path in paths]})
    elif not quiet:
        print("\n".join(str(path) for path in paths))


def predictions(
    rows: "Sequence[Prediction]", caption: str, title: str, simulated: "Sequence[Simulated]" = ()
) -> None:
    """Print the table of predicted speeds, its notes and what it rests on."""
    from rich.console import Console

    from walkergen.report import tables

    console = Console(highlight=False)
    console.print(tables.to_table(rows, title, simulated))
    for number, note in enumerate(tables.notes_of(rows), start=1):
        console.print(f"[{number}] {note}", markup=False)
    console.print(caption, markup=False)


def placements(rows: "Sequence[Row]", paths: Sequence[Path]) -> None:
    """Print how many copies of each part lie on each plate."""
    from collections import Counter

    counts = Counter((row.plate, row.part) for row in rows)
    for number, path in enumerate(paths, start=1):
        print(path)
        for (plate, part), count in counts.items():
            if plate == number:
                print(f"  {count:4d} x {part}")
    print(f"{len(rows)} parts on {len(paths)} plate{'s' if len(paths) > 1 else ''}")


def templates(rows: "Sequence[Entry]") -> None:
    """Print the shipped templates by kind."""
    for kind in dict.fromkeys(row.kind for row in rows):
        print(kind)
        for row in rows:
            if row.kind == kind:
                print(f"  {row.name:18s}  {row.description}")


def summary_as_dict(
    engine: "Engine", scene: "Scene", found: "Summary", met: "Met | None"
) -> dict[str, Any]:
    """An ensemble's summary with what was simulated, and for which error, for JSON."""
    settings = {"model": engine.model, "method": engine.method, "law": scene.contact.law}
    chosen = {}
    if met is not None:
        obtained = None if math.isinf(met.error_mm_s) else met.error_mm_s
        chosen = met.choice._asdict() | {
            "setting": met.choice.setting.flags,
            "error_mm_s": obtained,
            "allowed_mm_s": met.allowed_mm_s,
        }
    return settings | found._asdict() | ({"chosen": chosen} if chosen else {})


def _met_rows(met: "Met", found: "Summary") -> list[tuple[str, str]]:
    """What --error chose, why, and what came out."""
    choice = met.choice
    source = "on record" if met.on_record else "measured just now"
    bars = math.nan if found.speed_se_mm_s is None else found.speed_se_mm_s
    verdict = "within" if met.error_mm_s <= met.allowed_mm_s else "NOT within"
    return [
        ("chosen", f"{choice.setting.label}, {choice.runs} x {choice.seconds:g} s"),
        ("because", f"cheapest of the ladders {source}; its bias is at most "
                    f"{choice.bias_bound_mm_s:.2g} mm/s (95 %)"),
        ("error, 95 %", f"{met.error_mm_s:.2g} mm/s, {verdict} the {met.allowed_mm_s:.2g} asked "
                        f"(bias, and 2 x {bars:.2g} of the runs)"),
    ]  # fmt: skip


def summary(
    engine: "Engine", scene: "Scene", found: "Summary", design: "Design", met: "Met | None"
) -> None:
    """Print the mean speed and everything measured beside it."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(box=box.SIMPLE, show_header=False, padding=(0, 1))
    drive = scene.drive
    bars = found.speed_se_mm_s
    speed = "none: no run ended well"
    if found.speed_mm_s is not None:
        error = "standard error unknown: too few data" if bars is None else f"± {bars:.2g}"
        speed = f"{found.speed_mm_s:.2f} {error} mm/s"
    correlation = found.correlation_time_s
    types = ", ".join(
        f"{name} {100 * share:.1f} %" for name, share in found.type_fractions.items() if share
    )
    powers = ", ".join(f"{name} {1e-6 * value:.3g}" for name, value in found.energies_per_s.items())
    rate = found.simulated_s / found.cpu_s if found.cpu_s else 0.0
    for name, value in (
        ("walker", f"{design.name}, {design.legs.kind} legs, tilt {design.legs.tilt_deg:g} deg"),
        ("plate", f"{drive.frequency:g} Hz, {drive.peak_gamma:g} g, {drive.peak_speed:.1f} mm/s"),
        ("model", f"{engine.model}, method {engine.method}, law {scene.contact.law}"),
        ("mean speed", speed),
        *(_met_rows(met, found) if met is not None else ()),
        ("runs", f"{found.runs}, {found.simulated_s:.1f} s simulated in all"),
        ("correlation time", "unknown" if correlation is None else f"{1e3 * correlation:.0f} ms"),
        ("impacts", f"{found.impacts_per_s:.1f} per second: {types or 'none'}"),
        ("in contact", f"{100 * found.contact_fraction:.1f} % of the time"),
        ("largest pitch", f"{found.max_pitch_deg:.2f} deg"),
        ("power, uW", f"{powers}; unaccounted {100 * found.energy_error:.2g} %"),
        ("outcomes", ", ".join(f"{count} x {name}" for name, count in found.outcomes.items())),
        ("time", f"{found.wall_s:.1f} s, {rate:.0f} simulated s per CPU s"),
    ):
        table.add_row(name, value)
    Console(highlight=False).print(table)


def study(found: "Study", folder: Path) -> None:
    """Print the ladders, what to run for which error, and where the tables and figures are."""
    from rich.console import Console

    from walkergen.report import ladders

    console = Console(highlight=False)
    for ladder in found.ladders:
        console.print(ladders.to_table(ladder))
        console.print(f"error: {ladder.error}\nreference: {ladder.reference}", markup=False)
        for note in ladder.notes:
            console.print(f"- {note}", markup=False)
        console.print()
    if found.answers:
        console.print("What to run for which error of the mean speed:")
        console.print(ladders.answers_table(found.answers))
    print(f"in {folder}/: a table (CSV, Markdown) and a figure (PNG) for each ladder"
          + (", accuracy.md, choice.png" if found.answers else ""))  # fmt: skip


def comparison_as_json(rows: "Sequence[Compared]", folder: Path) -> None:
    """Print every comparison with its verdict, and where the figures are."""
    listed = [row._asdict() | {"verdict": row.verdict._asdict()} for row in rows]
    as_json({"rows": listed, "folder": str(folder)})


def comparison(found: "Findings", rows: "Sequence[Compared]", folder: Path) -> None:
    """Print the paper's facts beside our numbers, and where the figures are."""
    from rich.console import Console

    from walkergen.report import comparison as tables

    Console(highlight=False).print(tables.to_console(rows, found.assumptions))
    print("± 2 standard errors; = agrees, ! differs, ? undecided: reproduce.md says by how much")
    print(f"in {folder}/: reproduce.md, reproduce.csv; figures 2, 3, 5 as PNG, PDF and CSV")


def effects(plan: "Plan", rows: "Sequence[Explained]", scene: "Scene", design: "Design") -> None:
    """Print which effects are on, why, how large they are and what they cost."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for heading in ("effect", "", "size", "cost", "why"):
        table.add_column(heading, justify="right" if heading in ("size", "cost") else "left")
    for row in rows:
        cost = "-" if row.cost is None else f"x {row.cost:.2f}"
        why = f"{row.reason} ({row.meaning})" + (f"; {row.switch}" if row.switch else "")
        table.add_row(row.effect, "on" if row.on else "off", f"{row.number:.3g}", cost, why)
    console = Console(highlight=False)
    console.print(f"{design.name}, tilt {design.legs.tilt_deg:g} deg, on {scene.name}:")
    console.print(f"model {plan.engine.model}, method {plan.engine.method}")
    console.print(table)
    console.print(
        "cost: CPU time over that of the scene without the effect, whose motion differs too"
    )


@contextmanager
def progress(title: str, wanted: bool) -> Iterator[Callable[[str, int, int], None]]:
    """A progress bar on the terminal's error stream; silent when not wanted or not a terminal."""
    try:
        if wanted and sys.stderr.isatty():
            with _bar(title) as update:
                yield update
        else:
            yield lambda what, done, total: None
    except KeyboardInterrupt:
        print("interrupted: finished files are whole; the same command completes", file=sys.stderr)
        raise


@contextmanager
def _bar(title: str) -> Iterator[Callable[[str, int, int], None]]:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title)

        def update(what: str, done: int, total: int) -> None:
            bar.update(task, description=f"{title}: {what}", completed=done, total=total)

        yield update
