"""Report of a bench test: tables, answers and settings, for the screen, Markdown, CSV and JSON."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

from rich import box
from rich.table import Table

from walkergen.analysis.inverse import Inverse
from walkergen.files import words
from walkergen.files.tables import as_markdown, csv_text

Value = float | str | None


class Rows(NamedTuple):
    """Table of a bench test."""

    name: str
    """Stem of its CSV file."""
    title: str
    columns: Sequence[str]
    """Names with units."""
    rows: Sequence[Sequence[Value]]


class Answer(NamedTuple):
    """Answer to a number that was measured: under which condition, in words and in numbers."""

    condition: str
    told: str
    inverse: Inverse


class Report(NamedTuple):
    """What a bench test shows and says."""

    bench: str
    """Name of the test: drop, slide or pluck."""
    title: str
    caption: str
    """Walker, feet and plate."""
    tables: Sequence[Rows]
    answers: Sequence[Answer]
    notes: Sequence[str]
    settings: Mapping[str, float]
    """Keys of scene or design with the values that follow from the measured number."""


def to_table(rows: Rows, form: box.Box = box.SIMPLE_HEAD) -> Table:
    """Table of rich with numbers to three or four digits."""
    table = Table(title=rows.title, box=form, padding=(0, 1, 0, 0), pad_edge=False)
    for column, first in zip(rows.columns, rows.rows[0], strict=True):
        side: Literal["left", "right"] = "left" if isinstance(first, str) else "right"
        table.add_column(column.replace("_", " "), justify=side)
    for row in rows.rows:
        table.add_row(*(_shown(value) for value in row))
    return table


def _shown(value: Value) -> str:
    if value is None:
        return ""
    return value if isinstance(value, str) else words.number(value, 4)


def lines(report: Report) -> list[str]:
    """Answers, settings and notes, a line each."""
    told = [f"{one.condition}: {one.told}" if one.condition else one.told for one in report.answers]
    if report.settings:
        keys = ", ".join(
            f"{key} = {words.number(value, 4)}" for key, value in report.settings.items()
        )
        told.append(f"set {keys}")
    return [*told, *report.notes]


def to_markdown(report: Report) -> str:
    """Markdown page of all tables, answers and notes."""
    parts = [f"# {report.title}", f"{report.caption}."]
    parts += [f"- {line}" for line in lines(report)]
    for rows in report.tables:
        untitled = rows._replace(title="")
        parts += [f"## {rows.title}", as_markdown(to_table(untitled, box.MARKDOWN))]
    return "\n\n".join(parts).replace("\n\n- ", "\n- ").replace("\n- ", "\n\n- ", 1) + "\n"


def to_csv(rows: Rows) -> str:
    """CSV with every digit."""
    return csv_text(rows.columns, rows.rows)


def as_dict(report: Report) -> dict[str, Any]:
    """All of a report for JSON."""
    return {
        "bench": report.bench,
        "caption": report.caption,
        "tables": {
            table.name: [dict(zip(table.columns, row, strict=True)) for row in table.rows]
            for table in report.tables
        },
        "answers": [
            {
                "condition": one.condition,
                "told": one.told,
                "branches": [branch._asdict() for branch in one.inverse.branches],
                "everywhere": one.inverse.everywhere,
                "nearest": one.inverse.nearest,
                "misses": one.inverse.misses,
            }
            for one in report.answers
        ],
        "settings": dict(report.settings),
        "notes": list(report.notes),
    }
