"""Points of a sweep sorted by their distance from a desired speed."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from walkergen.core import InputError, format_range
from walkergen.files.report import Column, Table, format_value

MAX_SHOWN = 5
"""Number of nearest points that are printed."""

SPEED_COLUMN = "speed_mm_s"
BOUND_COLUMNS = "low_95_mm_s", "high_95_mm_s"
"""Columns with the 95 % bounds of the speed."""


def check_speed(names: Sequence[str]) -> None:
    """Raise InputError if a table has no speed to compare with a desired one. `names`: names of its columns."""
    if SPEED_COLUMN not in names:
        raise InputError("‹wish›: needs speeds, but the points have none. Add speed to ‹keep›.", "wish")


def sort_by_distance(table: Table, keys: Sequence[str], wish: float) -> Table:
    """Return the table sorted by distance from a desired speed, mm/s. `keys`: columns of the varied keys.

    Points with errors of printing come after the others, points without a speed last. MAX_SHOWN points are printed.
    """
    speed = table.keys.index(SPEED_COLUMN)
    errors = table.keys.index("print_errors") if "print_errors" in table.keys else None

    def sort_key(row: Sequence[Any]) -> tuple[bool, bool, float]:
        """Return whether the speed is missing, whether there are print errors, and the distance."""
        value = row[speed]
        return value is None, errors is not None and bool(row[errors]), abs((value or 0.0) - wish)

    rows = sorted(table.rows, key=sort_key)
    usable = [row for row in rows if not any(sort_key(row)[:2])]
    return replace(table, rows=rows, columns=_printed_columns(table.keys, keys), read=usable[:MAX_SHOWN])


def _printed_columns(names: Sequence[str], keys: Sequence[str]) -> list[Column]:
    """Return the printed columns: the varied `keys`, the speed and its bounds. `names`: names of the rows' values."""
    columns = [_make_column(key, (names.index(key),), format_value) for key in keys]
    columns.append(_make_column("speed\n(mm/s)", (names.index(SPEED_COLUMN),), format_value))
    if BOUND_COLUMNS[0] in names:
        columns.append(_make_column("95 %\n(mm/s)", [names.index(end) for end in BOUND_COLUMNS], _format_span))
    return columns


def _make_column(heading: str, indices: Sequence[int], format_values: Callable[..., str]) -> Column:
    """Return a column that formats the values at these indices of a row as one text."""
    return Column(heading, lambda row: format_values(*(row[index] for index in indices)), right=True)


def _format_span(low: float | None, high: float | None) -> str:
    """Format two bounds as text; "" if one is unknown."""
    return "" if low is None or high is None else format_range(low, high)
