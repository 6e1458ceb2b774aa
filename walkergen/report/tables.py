"""Tables of predictions: CSV with every digit, Markdown and console with those that matter."""

import csv
import io
from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.table import Table

from walkergen.prediction import Prediction

HEADINGS = ("tilt", "legs", "M", "J", "m", "j", "back", "front", "mean", "speed")
UNITS = ("deg", "", "g", "g mm²", "g", "g mm²", "v/w", "v/w", "v/w", "mm/s")


def to_csv(rows: Sequence[Prediction]) -> str:
    """One line a member; columns are the fields of `Prediction`, numbers with every digit."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(Prediction._fields)
    writer.writerows([["" if value is None else value for value in row] for row in rows])
    return text.getvalue()


def to_table(rows: Sequence[Prediction], title: str = "") -> Table:
    """The table for the console; rows with a note carry its number."""
    notes = notes_of(rows)
    table = Table(title=title or None, box=box.SIMPLE_HEAD, padding=(0, 0))
    for heading, unit in zip(HEADINGS, UNITS, strict=True):
        left = heading in ("legs", "speed")
        table.add_column(f"{heading}\n{unit}", justify="left" if left else "right", no_wrap=True)
    for row in rows:
        table.add_row(*_cells(row, notes))
    return table


def to_markdown(rows: Sequence[Prediction], title: str, caption: str) -> str:
    """A Markdown page with the table and its notes."""
    notes = notes_of(rows)
    table = Table(box=box.MARKDOWN)
    for heading, unit in zip(HEADINGS, UNITS, strict=True):
        name = f"{heading} ({unit})" if unit else heading
        table.add_column(name, justify="left" if heading == "legs" else "right", no_wrap=True)
    for row in rows:
        table.add_row(*_cells(row, notes))
    text = io.StringIO()
    Console(file=text, width=200, color_system=None).print(table)
    body = "\n".join(line.rstrip() for line in text.getvalue().strip().splitlines())
    listed = "\n".join(f"{number}. {note}" for number, note in enumerate(notes, start=1))
    return f"# {title}\n\n{caption}\n\n{body}\n\n{listed}\n".rstrip() + "\n"


def notes_of(rows: Sequence[Prediction]) -> list[str]:
    """The distinct notes of a table, in order; note k is marked [k] in it."""
    return list(dict.fromkeys(row.note for row in rows if row.note))


def _cells(row: Prediction, notes: list[str]) -> list[str]:
    mark = f" [{notes.index(row.note) + 1}]" if row.note else ""
    return [
        f"{row.tilt_deg:g}",
        row.legs,
        _short(row.M_g),
        _short(row.J_g_mm2),
        _short(row.m_g),
        _short(row.j_g_mm2),
        _fixed(row.factor_back, 3),
        _fixed(row.factor_front, 3),
        _fixed(row.factor_mean, 3),
        f"{_fixed(row.speed_mm_s, 1)} ± {_fixed(row.speed_sd_mm_s, 1)}{mark}",
    ]


def _fixed(value: float, digits: int) -> str:
    """Fixed decimals, without a minus on zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def _short(value: float | None) -> str:
    """Four significant digits, trailing zeros kept; a dash for what the row does not have."""
    return "-" if value is None else f"{value:#.4g}".rstrip(".")
