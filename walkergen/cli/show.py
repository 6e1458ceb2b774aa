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
    from walkergen.batch import Checked, Room
    from walkergen.calibration import Fitted
    from walkergen.design import Design
    from walkergen.experiment import Analysed
    from walkergen.hard_cases.selftest import Result
    from walkergen.plates import Place
    from walkergen.prediction import Prediction
    from walkergen.printing.checks import Finding
    from walkergen.printing.printers import Printer
    from walkergen.report.contents import Contents
    from walkergen.report.tables import Simulated, Weighing
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


def rows_as_json(rows: Sequence[Any], *more: Sequence[Any], files: Sequence[Path] = ()) -> None:
    """Print {"rows": [...]} of named tuples, side by side with `more`, and the files written."""
    listed = [row._asdict() for row in rows]
    for table in more:
        for row, extra in zip(listed, table, strict=False):
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
    rows: "Sequence[Prediction]",
    caption: str,
    title: str,
    simulated: "Sequence[Simulated]" = (),
    weighed: "Sequence[Weighing]" = (),
) -> None:
    """Print the table of predicted speeds, its notes and what it rests on."""
    from rich.console import Console

    from walkergen.report import tables

    console = Console(highlight=False)
    console.print(tables.to_table(rows, title, simulated))
    for number, note in enumerate(tables.notes_of(rows), start=1):
        console.print(f"[{number}] {note}", markup=False)
    console.print(caption, markup=False)
    if weighed:
        console.print(tables.weighed_table(rows, weighed))
        console.print(tables.WEIGHED, markup=False)


def placements(rows: "Sequence[Place]", paths: Sequence[Path], design: "Design") -> None:
    """Print how many copies of each part lie on each plate, the files, and how to read marks."""
    from collections import Counter

    from walkergen.report import tables

    counts = Counter((row.printer, row.plate, row.name, row.mark) for row in rows)
    for printer, number in dict.fromkeys((row.printer, row.plate) for row in rows):
        print(f"{printer}, plate {number}")
        for (machine, plate, name, mark), count in counts.items():
            if (machine, plate) == (printer, number):
                print(f"  {count:4d} x {name}" + (f"  {mark}" if mark else ""))
    print("\n".join(str(path) for path in paths))
    for printer in dict.fromkeys(row.printer for row in rows):
        own = [row.plate for row in rows if row.printer == printer]
        count = max(own)
        print(f"{printer}: {len(own)} parts on {count} plate{'s' if count > 1 else ''}")
    if legend := tables.legend_caption(design):
        print(legend)


def room(rows: "Sequence[Room]") -> None:
    """Print how many copies fit on one plate."""
    for row in rows:
        print(f"{row.printer:14s}  {row.fit:5d} x {row.name}")


def warnings(findings: "Sequence[Finding]", quiet: bool) -> None:
    """Print the warnings of the printability checks, a line each, on the error stream."""
    from walkergen.printing import checks

    for finding in checks.grouped(findings):
        if finding.level == "warning" and not quiet:
            print(f"warning: {checks.line(finding)}", file=sys.stderr)


def checked(found: "Checked", printer: "Printer") -> None:
    """Print how walls come out in lines, warnings and advice; errors follow as such."""
    from walkergen.printing import checks

    print(f"{'wall':8s}{'mm':>8s}{'lines':>8s}{'plastic':>10s}   (expected, against the mesh)")
    for wall in found.walls:
        percent = round(wall.plastic_percent)
        plastic = f"{percent:+d} %" if percent else "as drawn"
        print(f"{wall.wall:8s}{wall.thickness_mm:8.2f}{wall.lines:8.2f}{plastic:>10s}")
    findings = checks.grouped(found.findings)
    for finding in findings:
        if finding.level != "error":
            print(f"{finding.level}: {checks.line(finding)}")
    told = [
        _count(sum(finding.level == level for finding in findings), level)
        for level in ("error", "warning")
    ]
    parts, plates = _count(found.parts, "part"), _count(found.plates, "plate")
    print(f"{parts} on {plates} of {printer.name}: {', '.join(told)}")


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


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


def page(path: Path, found: "Contents", json: bool) -> None:
    """Print where the page is, and which of the family's files are not as they were written."""
    changed, missing = found.named("changed"), found.named("missing")
    if json:
        as_json({"file": str(path), "changed": changed, "missing": missing})
        return
    for name in changed:
        print(f"{name}: changed since the family was made")
    for name in missing:
        print(f"{name}: missing")
    print(f"{path}: {path.stat().st_size / 1e6:.1f} MB, opens in any browser, offline")


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


def hard_cases_as_json(results: "Sequence[Result]") -> None:
    """Print every check of every hard case; a value that is no number is null."""
    rows = []
    for result in results:
        checks = [
            check._asdict() | {"value": _number(check.value), "holds": check.holds}
            for check in result.checks
        ]
        rows.append(result._asdict() | {"checks": checks, "holds": result.holds})
    held = sum(result.holds for result in results)
    as_json({"rows": rows, "held": held, "failed": len(results) - held})


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def hard_cases(results: "Sequence[Result]") -> None:
    """Print the tightest check of each hard case, all checks that fail, and the counts."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for heading in ("", "case", "on", "checks", "tightest", "value", "limit", "margin"):
        right = heading in ("checks", "value", "limit", "margin")
        table.add_column(heading, justify="right" if right else "left")
    for result in results:
        tightest = sorted(result.checks, key=lambda check: _room(check.value, check.limit))[:1]
        name = (result.section, result.case, f"{result.model}, {result.method}")
        shown = [check for check in result.checks if not check.holds] or tightest
        for check in shown if not result.error else []:
            room = _room(check.value, check.limit)
            margin = (
                "FAILED" if not check.holds else "exact" if room == math.inf else f"x {room:.2g}"
            )
            values = (check.what, f"{check.value:.2g}", f"{check.limit:.2g}", margin)
            table.add_row(*name, str(len(result.checks)), *values)
        if result.error:
            table.add_row(*name, str(len(result.checks)), result.error, "", "", "FAILED")
    wide = None if sys.stdout.isatty() else 160  # a log has room
    Console(highlight=False, width=wide).print(table, markup=False)
    checks = sum(len(result.checks) for result in results)
    failed = sum(not result.holds for result in results)
    cases = len({result.case for result in results})
    print(
        f"{cases} hard cases in {len(results)} runs of a model and method, {checks} checks: "
        f"{len(results) - failed} runs hold, {failed} fail"
    )


def _room(value: float, limit: float) -> float:
    """Limit over value: how many times larger the value might be; 0 when it is no number."""
    if not math.isfinite(value):
        return 0.0
    return limit / value if value > 0.0 else math.inf


def motion_as_json(found: "Analysed") -> None:
    """Print everything measured, and what was noted while reading."""
    from walkergen.report import motion_tables

    data = motion_tables.as_dict(found.motion)
    data |= {"bad_rows": found.bad_rows, "notes": found.notes, "folder": str(found.folder)}
    as_json(data)


def motion(found: "Analysed", title: str) -> None:
    """Print the table of what was measured."""
    from rich.console import Console

    from walkergen.report import motion_tables

    console = Console(highlight=False)
    if found.motion.by_plate_speed:
        console.print(motion_tables.plate_table(found.motion))
        console.print(motion_tables.line_told(found.motion), markup=False)
    else:
        console.print(motion_tables.to_table(found.motion, title))
    for note in found.notes:
        console.print(note, markup=False)
    print(f"tables and figures in {found.folder}/")


def fit_as_json(found: "Fitted") -> None:
    """Print the fitted parameters and what was noted."""
    from walkergen.report import fit_tables

    data = fit_tables.as_dict(found.fit)
    as_json(data | {"notes": found.notes, "folder": str(found.folder)})


def fit(found: "Fitted", title: str) -> None:
    """Print the table of fitted parameters and what to make of them."""
    from rich.console import Console

    from walkergen.report import fit_tables

    console = Console(highlight=False)
    console.print(fit_tables.to_table(found.fit, title))
    told = (fit_tables.quality(found.fit), fit_tables.correlations(found.fit), *found.notes)
    for line in told:
        if line:
            console.print(line, markup=False)
    print(f"tables, figure and scene.toml in {found.folder}/")


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
