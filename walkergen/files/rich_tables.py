"""Tables of Rich on a console of any width."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

MAX_TABLE_WIDTH = 10_000
"""Letters in a line, more than any table needs."""

EDGE_WIDTH = 2
"""Letters of a table's edges, at most."""


def print_table(table: "Table", console: "Console") -> None:
    """Print a table without cutting a word or a number, at any width of the console.

    Columns that may wrap become narrower first. A table that is still too wide is printed in pieces, one below
    the other, each with the columns that name the rows.
    """
    from rich.measure import Measurement

    sizes = [_column_sizes(table, index, console) for index in range(len(table.columns))]
    wide = console.options.update(width=MAX_TABLE_WIDTH)
    whole = Measurement.get(console, wide, table).maximum
    if whole <= console.width:
        console.print(table)
        return
    edge_width = -(-(whole - EDGE_WIDTH - sum(size.natural for size in sizes)) // len(sizes))
    title: Any = table.title
    for chosen in _split_columns(table, sizes, edge_width, console.width - EDGE_WIDTH):
        available = console.width - EDGE_WIDTH - edge_width * len(chosen)
        widths = _column_widths([sizes[index] for index in chosen], available)
        piece = _select_columns(table, chosen, widths)
        piece.title, title = title, None
        wide_enough = max(console.width, edge_width * len(chosen) + EDGE_WIDTH + sum(widths))
        with _temporary_width(console, wide_enough):
            console.print(piece)


@contextmanager
def _temporary_width(console: "Console", width: int) -> Iterator[None]:
    """Change the width of a console in this context. The terminal breaks lines that are longer than its own width."""
    before = console.width
    console.width = width
    try:
        yield
    finally:
        console.width = before


class Sizes(NamedTuple):
    """Smallest and natural width of a column, letters."""

    least: int
    """Length of its longest word or, if it must not wrap, of its longest line."""
    natural: int
    """Length of its longest line."""


def _column_sizes(table: "Table", index: int, console: "Console") -> Sizes:
    """Return the smallest and the natural width of the column of a table with this index, letters."""
    column = table.columns[index]
    cells = [column.header, *column.cells] if table.show_header else [*column.cells]
    texts = [console.render_str(cell).plain if isinstance(cell, str) else str(cell) for cell in cells]
    lines = [len(line) for text in texts for line in text.splitlines()]
    words = [len(word) for text in texts for word in text.split()]
    natural = max(lines, default=0)
    return Sizes(natural if column.no_wrap else max(words, default=0), natural)


def _split_columns(table: "Table", sizes: Sequence[Sizes], edges: int, width: int) -> Sequence[Sequence[int]]:
    """Return the columns (indices) of each piece: row names, and others that fit. `edges`: letters a column adds."""
    justify = [column.justify for column in table.columns[:2]]
    name_columns = [0, 1] if justify == ["right", "left"] else [0]
    pieces: list[list[int]] = []
    for column in range(len(name_columns), len(sizes)):
        piece = [*(pieces[-1] if pieces else name_columns), column]
        if not pieces or sum(sizes[index].least + edges for index in piece) > width:
            piece = [*name_columns, column]
            pieces.append(piece)
        else:
            pieces[-1] = piece
    return pieces or [name_columns]


def _column_widths(sizes: Sequence[Sizes], width: int) -> list[int]:
    """Return the widths of columns that share a total width: each gets its least, and more if its lines are longer."""
    widths = [size.least for size in sizes]
    remaining = width - sum(widths)
    order = sorted(range(len(sizes)), key=lambda index: sizes[index].natural - sizes[index].least)
    for done, index in enumerate(order):
        added = min(sizes[index].natural - sizes[index].least, remaining // (len(order) - done))
        widths[index] += max(added, 0)
        remaining -= max(added, 0)
    return widths


def _select_columns(table: "Table", chosen: Sequence[int], widths: Sequence[int]) -> "Table":
    """Copy chosen columns of a table, with given widths, into a table without its title."""
    from rich.table import Table

    piece = Table(
        box=table.box,
        padding=table.padding,
        pad_edge=table.pad_edge,
        show_header=table.show_header,
        title_justify=table.title_justify,
    )
    columns = [table.columns[index] for index in chosen]
    for column, width in zip(columns, widths, strict=True):
        piece.add_column(column.header, justify=column.justify, no_wrap=column.no_wrap, width=width)
    for cells in zip(*(column.cells for column in columns), strict=True):
        piece.add_row(*cells)
    return piece
