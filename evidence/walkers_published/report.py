"""Report of published walkers compared with ours: numbers, predictions with bounds, inside or not, sources."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from evidence.walkers_published.predicted import Predicted
from evidence.walkers_published.published import Source
from walkergen.core.files import formatting
from walkergen.files import report
from walkergen.files.report import Column, Report, Table

TITLE = "Published walkers compared with ours"

LEGEND = (
    "predicted: median and bounds of 95 % of walkers drawn from ranges, ours, of all that is not stated "
    "(templates/published/sweeps); inside: yes where all of the published range lies in them"
)

KEYS = (
    *("source", "address", "read", "quantity", "unit", "published_low", "published_high", "where"),
    *("low_95", "median", "high_95", "low_se", "high_se", "draws", "ran", "inside", "note"),
)
"""Columns of walkers_published.csv."""


def make_report(rows: Sequence[Predicted], folder: Path, note: str) -> Report:
    """Report of what was put side by side, which lies in a folder; `note` says how it was simulated."""
    cells = [_csv_row(row) for row in rows]
    columns = (
        Column("set", lambda row: row.statement.source.key),
        Column("quantity", lambda row: row.statement.quantity),
        Column("published", lambda row: row.statement.stated),
        Column("predicted (95 %)", format_bounds),
        report.text_column("inside?", "inside"),
        Column("ran", lambda row: f"{row.ran} of {row.draws}" if row.draws else ""),
        Column("note", lambda row: row.note, wide=True),
    )
    counts = Counter(row.inside or "not predicted" for row in rows)
    sources = dict.fromkeys(row.statement.source for row in rows)
    return Report(
        name="walkers_published",
        title=TITLE,
        tables=[Table("walkers_published", cells, KEYS), Table("rows", rows, (), columns, notes=(LEGEND,))],
        facts={"rows": [dict(zip(KEYS, row, strict=True)) for row in cells]},
        lines=[
            "published numbers inside the bounds: "
            + ", ".join(f"{counts[word]} {word}" for word in ("yes", "in part", "no", "not predicted") if counts[word]),
            note,
            *map(_describe_source, sources),
        ],
        folder=folder,
    )


def format_bounds(row: Predicted) -> str:
    """Median and bounds in words; nothing where there are none."""
    if row.low is None or row.median is None or row.high is None:
        return ""
    low, median, high = (formatting.format_number(value, 3) for value in (row.low, row.median, row.high))
    return f"{median} [{low}, {high}]"


def _csv_row(row: Predicted) -> tuple[Any, ...]:
    """Row of the CSV, which holds every digit."""
    said = row.statement
    source = said.source.citation, said.source.address, said.source.read
    published = said.quantity, said.unit, said.low, said.high, said.where
    ours = row.low, row.median, row.high, row.low_se, row.high_se, row.draws, row.ran, row.inside, row.note
    return *source, *published, *ours


def _describe_source(source: Source) -> str:
    return f"{source.key}: {source.citation}. <{source.address}>. Read: {source.read}."
