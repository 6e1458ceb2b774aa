"""Tables as text: CSV with every digit, Markdown."""

import csv
import io
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

MOST_WIDE = 10_000
"""Letters in a line, more than any table needs."""


def csv_text(header: Sequence[str], lines: Iterable[Sequence[Any]]) -> str:
    """Comma-separated values under a header: every digit of a number, nothing for None."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(lines)
    return text.getvalue()


def as_markdown(table: "Table") -> str:
    """A table made with box.MARKDOWN as text."""
    from rich.console import Console

    text = io.StringIO()
    Console(file=text, width=300, color_system=None).print(table)
    return "\n".join(line.rstrip() for line in text.getvalue().strip().splitlines())


def show(table: "Table", console: "Console") -> None:
    """Print a table; one too wide for the console in pieces below each other, each with the first.

    So that no number is cut at any width: columns of numbers must be no_wrap, and of these even the
    widest is printed whole.
    """
    for piece in _pieces(table, console):
        wide = _width(piece, console)
        console.print(piece, width=wide if wide > console.width else None, crop=False)


def _pieces(table: "Table", console: "Console") -> "list[Table]":
    """Tables of the first column with as many of the others as the console has room for."""
    if _width(table, console) <= console.width or len(table.columns) < 3:
        return [table]
    first, *others = range(len(table.columns))
    groups: list[list[int]] = [[first, others[0]]]
    for column in others[1:]:
        if _width(_of_columns(table, [*groups[-1], column]), console) <= console.width:
            groups[-1].append(column)
        else:
            groups.append([first, column])
    pieces = [_of_columns(table, group) for group in groups]
    pieces[0].title, pieces[0].title_justify = table.title, table.title_justify
    return pieces


def _of_columns(table: "Table", chosen: Sequence[int]) -> "Table":
    """A table's chosen columns as a table of its own, without its title."""
    from rich.table import Table

    found = Table(
        box=table.box, padding=table.padding, pad_edge=table.pad_edge,
        show_header=table.show_header,
    )  # fmt: skip
    columns = [table.columns[index] for index in chosen]
    for one in columns:
        found.add_column(one.header, justify=one.justify, no_wrap=one.no_wrap)
    for cells in zip(*(one.cells for one in columns), strict=True):
        found.add_row(*cells)
    return found


def _width(table: "Table", console: "Console") -> int:
    """Least number of letters in which no word of a table's is cut."""
    from rich.measure import Measurement

    wide = console.options.update(width=MOST_WIDE)
    return Measurement.get(console, wide, table).minimum
