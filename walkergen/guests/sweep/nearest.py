"""Points of a sweep that are nearest to a desired speed."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from walkergen.core import InputError, format_range
from walkergen.files.report import Column, Table, format_value

MAX_SHOWN = 5
"""Number of points shown to people."""

SPEED_COLUMN = "speed_mm_s"
BOUND_COLUMNS = ("low_95_mm_s", "high_95_mm_s"), ("predicted_low_95_mm_s", "predicted_high_95_mm_s")
"""Columns of the bounds of 95 %, of a simulated speed and of a predicted one."""


def check_speed(names: Sequence[str]) -> None:
    """Refuse a desired speed where the table has no speeds. Raises InputError."""
    if SPEED_COLUMN not in names:
        raise InputError("‹wish›: the points have no speed. Add speed to ‹keep›.", "wish")


def sort_by_distance(table: Table, keys: Sequence[str], wish: float) -> Table:
    """Return a table with the points nearest to a desired speed first, a part of it for people.

    Points whose checks found print errors come after the others, points without a speed last.
    """
    speed = table.keys.index(SPEED_COLUMN)
    errors = table.keys.index("print_errors") if "print_errors" in table.keys else None

    def distance(row: Sequence[Any]) -> tuple[bool, bool, float]:
        value = row[speed]
        return value is None, errors is not None and bool(row[errors]), abs((value or 0.0) - wish)

    rows = sorted(table.rows, key=distance)
    usable = [row for row in rows if not any(distance(row)[:2])]
    return replace(table, rows=rows, columns=_columns(table.keys, keys), read=usable[:MAX_SHOWN])


def _columns(names: Sequence[str], keys: Sequence[str]) -> list[Column]:
    """Return the displayed columns: the varied keys, the speed and its bounds."""
    columns = [_column(key, (names.index(key),), format_value) for key in keys]
    columns.append(_column("speed\n(mm/s)", (names.index(SPEED_COLUMN),), format_value))
    for low, high in BOUND_COLUMNS:
        if low in names:
            columns.append(_column("95 %\n(mm/s)", (names.index(low), names.index(high)), _format_span))
            break
    return columns


def _column(heading: str, places: Sequence[int], text: Callable[..., str]) -> Column:
    """Make a column with the text of the values at these places of a row."""
    return Column(heading, lambda row: text(*(row[place] for place in places)), right=True)


def _format_span(low: float | None, high: float | None) -> str:
    """Format bounds as text, empty where they are unknown."""
    return "" if low is None or high is None else format_range(low, high)
