"""Tables of predictions: CSV with every digit, Markdown and console with those that matter."""

import csv
import io
from collections.abc import Sequence
from typing import Literal, NamedTuple

from rich import box
from rich.console import Console
from rich.table import Table

from walkergen.prediction import Prediction

HEADINGS = ("tilt", "legs", "M", "J", "m", "j", "back", "front", "mean", "speed")
UNITS = ("deg", "", "g", "g mm²", "g", "g mm²", "v/w", "v/w", "v/w", "mm/s")
DETAILS = ("M", "J", "m", "j", "back", "front")
"""Columns that the console leaves out when it shows simulated speeds, to stay within 80."""


class Simulated(NamedTuple):
    """What a family's table tells of a member's ensemble; the field names are columns."""

    sim_speed_mm_s: float | None
    sim_se_mm_s: float | None
    """Standard error of the simulated speed; None when the data are too few."""
    sim_model: str
    sim_method: str
    sim_outcomes: str


def to_csv(rows: Sequence[Prediction], simulated: Sequence[Simulated] = ()) -> str:
    """One line a member; columns are the fields of the rows, numbers with every digit."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(Prediction._fields + (Simulated._fields if simulated else ()))
    for row, *more in zip(rows, *([simulated] if simulated else []), strict=True):
        values = (*row, *(more[0] if more else ()))
        writer.writerow(["" if value is None else value for value in values])
    return text.getvalue()


def to_table(
    rows: Sequence[Prediction], title: str = "", simulated: Sequence[Simulated] = ()
) -> Table:
    """The table for the console; rows with a note carry its number."""
    table = Table(title=title or None, box=box.SIMPLE_HEAD, padding=(0, 0))
    columns = _columns(rows, simulated)
    shown = [name for name in columns if not (simulated and name[0] in DETAILS)]
    for heading, unit in shown:
        left = heading in ("legs", "speed", "simulated", "outcomes")
        justify: Literal["left", "right"] = "left" if left else "right"
        table.add_column(f"{heading}\n{unit}", justify=justify, no_wrap=heading != "outcomes")
    for cells in zip(*(columns[name] for name in shown), strict=True):
        table.add_row(*cells)
    return table


def to_markdown(
    rows: Sequence[Prediction], title: str, caption: str, simulated: Sequence[Simulated] = ()
) -> str:
    """A Markdown page with the table and its notes."""
    table = Table(box=box.MARKDOWN)
    columns = _columns(rows, simulated)
    for heading, unit in columns:
        name = f"{heading} ({unit})" if unit else heading
        table.add_column(name, justify="left" if heading == "legs" else "right", no_wrap=True)
    for cells in zip(*columns.values(), strict=True):
        table.add_row(*cells)
    body = console_text(table)
    listed = "\n".join(f"{number}. {note}" for number, note in enumerate(notes_of(rows), start=1))
    return f"# {title}\n\n{caption}\n\n{body}\n\n{listed}\n".rstrip() + "\n"


def console_text(table: Table) -> str:
    """A table as plain text, as wide as it needs."""
    text = io.StringIO()
    Console(file=text, width=300, color_system=None).print(table)
    return "\n".join(line.rstrip() for line in text.getvalue().strip().splitlines())


def _columns(
    rows: Sequence[Prediction], simulated: Sequence[Simulated]
) -> dict[tuple[str, str], list[str]]:
    """Cells by (heading, unit)."""
    notes = notes_of(rows)
    cells = zip(*(_cells(row, notes) for row in rows), strict=True)
    columns = {
        key: list(column)
        for key, column in zip(zip(HEADINGS, UNITS, strict=True), cells, strict=True)
    }
    if simulated:
        columns["simulated", "mm/s"] = [_simulated(one) for one in simulated]
        columns["model", ""] = [one.sim_model for one in simulated]
        columns["outcomes", ""] = [one.sim_outcomes for one in simulated]
    return columns


def _simulated(one: Simulated) -> str:
    if one.sim_speed_mm_s is None:
        return "-"
    error = "?" if one.sim_se_mm_s is None else _fixed(one.sim_se_mm_s, 1)
    return f"{_fixed(one.sim_speed_mm_s, 1)} ± {error}"


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
