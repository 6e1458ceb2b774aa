"""Ladders of accuracy as tables: CSV with every digit, Markdown and console for reading."""

from collections.abc import Sequence
from typing import NamedTuple

from rich import box
from rich.table import Table

from walkergen.files import words
from walkergen.files.tables import as_markdown, csv_text
from walkergen.jobs.accuracy.ladder import Ladder, Rung

COMMON = ("series", "setting", "error", "error_sd", "cpu_s")


class Answer(NamedTuple):
    """Setting to run for an error that a person can bear."""

    error: str
    setting: str
    runs: int | None
    seconds: float | None
    expected_s: float | None
    """Expected time on all cores of the machine that measured, s."""
    why: str


def to_csv(ladder: Ladder) -> str:
    """Format as CSV, a line for each rung: COMMON columns, then the details."""
    lines = ((*rung[: len(COMMON)], *rung.details.values()) for rung in ladder.rungs)
    return csv_text([*COMMON, *ladder.rungs[0].details], lines)


def to_markdown(ladder: Ladder, measured_on: str) -> str:
    """Format as a Markdown page: what is measured, the reference, the table, the notes."""
    table = _filled(Table(box=box.MARKDOWN), ladder)
    notes = "\n".join(f"- {note}" for note in ladder.notes)
    return (
        f"# {ladder.title}\n\n"
        f"Error: {ladder.error}. Cost: {ladder.cost}.\n"
        f"Reference: {ladder.reference}.\n"
        f"Measured on: {measured_on}.\n\n"
        f"{as_markdown(table)}\n\n{notes}\n"
    )


def to_table(ladder: Ladder) -> Table:
    """Table for the console, without the details."""
    table = Table(
        title=ladder.title, box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), title_justify="left"
    )
    return _filled(table, ladder, details=False)


def answers_table(answers: Sequence[Answer], markdown: bool = False) -> Table:
    """Table of what to run for which error."""
    table = (
        Table(box=box.MARKDOWN) if markdown else Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    )
    for heading in ("error (95 %)", "setting", "runs x seconds", "takes", "why"):
        table.add_column(heading, no_wrap=markdown)
    for answer in answers:
        run = "-" if answer.runs is None else f"{answer.runs} x {answer.seconds:g} s"
        takes = "-" if answer.expected_s is None else words.duration(answer.expected_s)
        table.add_row(answer.error, answer.setting, run, takes, answer.why)
    return table


def _filled(table: Table, ladder: Ladder, details: bool = True) -> Table:
    names = list(ladder.rungs[0].details) if details else []
    for heading in ("series", "setting", "error", "±", "CPU time", *names):
        table.add_column(
            heading, justify="left" if heading in COMMON[:2] else "right", no_wrap=True
        )
    for rung in ladder.rungs:
        table.add_row(*_cells(rung), *(_short(rung.details[name]) for name in names))
    return table


def _cells(rung: Rung) -> tuple[str, ...]:
    return (
        rung.series,
        rung.setting,
        _short(rung.error),
        _short(rung.error_sd),
        words.duration(rung.cpu_s),
    )


def _short(value: float | str | None) -> str:
    if value is None:
        return "-"
    return value if isinstance(value, str) else f"{value:.3g}"
