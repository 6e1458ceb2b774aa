"""Report of a job: its results as tables, lines and figures, as text and as files.

CSV, JSON and a pandas frame contain a row's values by keys, with units in the keys and with every
digit. Printed tables have columns instead. The text in a column is a function of the row.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from walkergen.core.errors import InputError, spell, spell_all, spell_for_python
from walkergen.core.files import formatting, tables

if TYPE_CHECKING:
    import numpy.typing as npt
    from matplotlib.figure import Figure
    from rich.table import Table as RichTable

    from walkergen.core.files.output import Folder

MAX_NOTEBOOK_ROWS = 20
"""Largest number of rows that a notebook shows. Further rows are only counted."""


class Column(NamedTuple):
    """Column of a printed table: its heading, with the unit, and a function that returns the text of a row's cell.

    If the heading has two lines, a terminal wraps no cell of the column.
    """

    heading: str
    cell: Callable[[Any], str]
    right: bool = False
    """True to align the cells at their right ends, as for numbers."""
    wide: bool = False
    """True for a column that is too wide for a terminal, and appears only in Markdown."""
    meaning: str = ""
    """Meaning of a short heading, shown with the heading below the table."""


def text_column(heading: str, key: str) -> Column:
    """Return a column of a field as text; `key` is the field's name."""
    return Column(heading, lambda row: str(getattr(row, key)))


def number_column(heading: str, key: str, digits: int = 4, wide: bool = False) -> Column:
    """Return a column of a field's numbers with this number of significant digits; None is blank."""
    return Column(
        heading, _format_if_known(key, lambda value: formatting.format_number(value, digits)), right=True, wide=wide
    )


def fixed_column(heading: str, key: str, digits: int, wide: bool = False) -> Column:
    """Return a column of a field's numbers with this number of decimals; None is blank."""
    return Column(
        heading, _format_if_known(key, lambda value: formatting.format_fixed(value, digits)), right=True, wide=wide
    )


def _format_if_known(key: str, format_number: Callable[[float], str]) -> Callable[[Any], str]:
    """Return a function that formats the value of a row's field, blank for None."""
    return lambda row: "" if (value := getattr(row, key)) is None else format_number(value)


def error_column(heading: str, key: str, se: str) -> Column:
    """Return a column of the field `key` with its standard error from the field `se`. Missing values are blank."""

    def format_cell(row: Any) -> str:
        value = getattr(row, key)
        return "" if value is None else formatting.format_with_error(value, getattr(row, se) or 0.0)

    return Column(heading, format_cell)


def interval_column(heading: str, low: str, high: str, digits: int = 4) -> Column:
    """Return a column of intervals, whose ends are the fields `low` and `high` of a row."""
    return Column(heading, lambda row: formatting.format_range(getattr(row, low), getattr(row, high), digits))


def key_columns(keys: Sequence[str], texts: Sequence[str] = ()) -> tuple[Column, ...]:
    """Return a column for each value of rows that are tuples, with its key as heading. `texts`: keys of text."""

    def make_column(index: int, key: str) -> Column:
        """Return the column of the values at an index of the rows."""
        return Column(key.replace("_", " "), lambda row: format_value(row[index]), key not in texts)

    return tuple(make_column(index, key) for index, key in enumerate(keys))


@dataclass(frozen=True)
class Table:
    """Rows with the same fields: named tuples, or tuples with the values of `keys`.

    Iteration yields the rows as dictionaries. ``table["speed_mm_s"]`` is a column as an array.

    Examples
    --------
    >>> import walkergen as wg
    >>> table = wg.predict(tilt=[5, 10]).table
    >>> table["tilt_deg"]
    array([ 5., 10.])
    >>> [row["legs"] for row in table]
    ['flexible', 'flexible']
    """

    name: str
    """Stem of the table's CSV file."""
    rows: Sequence[Any]
    keys: Sequence[str]
    """Names of the values of a row, with units, in CSV, JSON and pandas frames. A table without
    keys is printed, but not written to a file."""
    columns: Sequence[Column] = ()
    """Columns of the printed table. A table without columns is written to files, but not printed."""
    title: str = ""
    notes: Sequence[str] = ()
    """Notes below the table, a sentence each."""
    read: Sequence[Any] | None = None
    """Rows of the printed table; None for all rows."""

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        """Yield the rows, each with its values by the keys."""
        for row in self.rows:
            yield dict(zip(self.keys, spell_all(tuple(row)), strict=True))

    def __getitem__(self, key: str) -> "npt.NDArray[Any]":
        """Return the values of a key, None as NaN among numbers. Raises KeyError that names the keys."""
        if key not in self.keys:
            raise KeyError(f"no column {key!r}; columns: {', '.join(self.keys)}")
        at = list(self.keys).index(key)
        return to_array([spell_all(row[at]) for row in self.rows])

    def __repr__(self) -> str:
        return f"<{self.title or 'table'}: {len(self)} rows of {', '.join(self.keys)}>"

    def csv(self) -> str:
        """Return the comma-separated values with every digit.

        Returns
        -------
        str
            Text of a CSV file, whose first line has the keys.
        """
        return tables.csv_text(self.keys, self.rows)

    def rich(self, markdown: bool = False) -> "RichTable":
        """Return the table in the form of the library rich, to print it or to convert it to Markdown.

        Parameters
        ----------
        markdown : bool, default: False
            Whether the table is for Markdown. It then has the columns that are too wide for a terminal.

        Returns
        -------
        rich.table.Table
            Table to print with rich.
        """
        from rich import box
        from rich.markup import escape as literally
        from rich.table import Table as RichTable

        columns = self._visible_columns(markdown)
        headed = any(column.heading for column in columns)
        rich_table = RichTable(
            title=None if markdown or not self.title else literally(self.title),
            box=box.MARKDOWN if markdown else box.SIMPLE_HEAD if headed else box.SIMPLE,
            padding=(0, 1, 0, 0) if headed else (0, 1),
            pad_edge=not headed,
            show_header=headed,
        )
        to_text = str if markdown else spell
        for column in columns:
            justify: Literal["left", "right"] = "right" if column.right else "left"
            rich_table.add_column(column.heading, justify=justify, no_wrap="\n" in column.heading)
        for row in self._visible_rows():
            rich_table.add_row(*(literally(to_text(column.cell(row))) for column in columns))
        return rich_table

    def footer_lines(self, markdown: bool = False) -> list[str]:
        """Return the lines below the table: the meanings of its visible columns, and its notes.

        Parameters
        ----------
        markdown : bool, default: False
            Whether the lines are for Markdown.

        Returns
        -------
        list of str
            Lines of text.
        """
        meanings = dict.fromkeys(column.meaning for column in self._visible_columns(markdown))
        legend = "; ".join(filter(None, meanings))
        return [line if markdown else spell(line) for line in filter(None, [legend, *self.notes])]

    def _visible_columns(self, markdown: bool) -> list[Column]:
        """Return the columns of a page, or those that fit a terminal."""
        return [column for column in self.columns if markdown or not column.wide]

    def summary_lines(self) -> list[str]:
        """Return a line for each row of a table without headings, or one line with the number of rows of another table.

        Returns
        -------
        list of str
            Lines of text.
        """
        if not self.columns or any(column.heading for column in self.columns):
            return [f"{self.name}: {len(self)} rows"]
        return [spell(": ".join(column.cell(row) for column in self.columns)) for row in self._visible_rows()]

    def _visible_rows(self) -> Sequence[Any]:
        """Return the rows of the printed table."""
        return self.rows if self.read is None else self.read

    def to_dataframe(self) -> Any:
        """Return a pandas frame with the same columns.

        Returns
        -------
        pandas.DataFrame
            A column for each key, with units in the keys.

        Raises
        ------
        InputError
            If pandas is missing.
        """
        try:
            import pandas
        except ModuleNotFoundError:
            raise InputError(
                "to_dataframe: pandas is not installed. Run pip install pandas, or use the columns "
                f"as NumPy arrays: table[{next(iter(self.keys), '')!r}]"
            ) from None
        return pandas.DataFrame({key: self[key] for key in self.keys})

    def _repr_html_(self) -> str:
        heads: Sequence[str] = self.keys or [column.heading for column in self.columns]
        shown = self.rows if self.keys else self._visible_rows()
        rows = [
            map(format_value, row) if self.keys else [column.cell(row) for column in self.columns]
            for row in shown[:MAX_NOTEBOOK_ROWS]
        ]
        head = "".join(f"<th>{escape(one)}</th>" for one in heads) if any(heads) else ""
        body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
        more = len(shown) - MAX_NOTEBOOK_ROWS
        notes = [*self.footer_lines(markdown=True), *([f"and {more} more rows"] if more > 0 else [])]
        title = f"<caption>{escape(self.title)}</caption>" if self.title else ""
        table = f"<table>{title}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
        return spell_for_python(table + "".join(f"<p>{escape(note)}</p>" for note in notes))


def table_from_rows(name: str, rows: Sequence[Any], columns: Sequence[Column] = (), title: str = "") -> Table:
    """Return a table of one or more named tuples. Their fields are the keys."""
    return Table(name, rows, rows[0]._fields, columns, title)


def format_next_step(pictures: Sequence[Path], prints: Sequence[Path] = ()) -> str:
    """Return the sentence on what to open next: the first of the pictures, then files for a slicer."""
    more = f" and {len(prints) - 1} more" if len(prints) > 1 else ""
    steps = [*(f"look at {path}" for path in pictures[:1]), *(f"print {path}{more}" for path in prints[:1])]
    return f"next: {', then '.join(steps)}" if steps else ""


def format_value(value: Any) -> str:
    """Format a value for people: four digits of a number, blank for None."""
    if value is None:
        return ""
    if isinstance(value, float):
        return "" if math.isnan(value) else formatting.format_number(value, 4)
    return str(value)


def to_array(values: Sequence[Any]) -> "npt.NDArray[Any]":
    """Return values as an array of numbers, None as NaN; as an array of objects if one is no number."""
    import numpy as np

    if all(value is None or formatting.is_number(value) for value in values):
        whole = all(isinstance(value, int) for value in values)
        return np.array(
            [math.nan if value is None else value for value in values], dtype=np.int64 if whole else np.float64
        )
    return np.fromiter(values, dtype=object, count=len(values))  # lists stay lists


@dataclass(frozen=True, kw_only=True)
class Report:
    """Results of a job: tables, facts, lines and figures.

    ``report["name"]`` is the table of this name. Jobs whose results other jobs use add fields.

    Examples
    --------
    >>> import walkergen as wg
    >>> report = wg.predict(tilt=10)
    >>> round(report.facts["rows"][0]["speed_mm_s"])
    51
    """

    name: str
    """Stem of the report's Markdown file."""
    title: str
    tables: Sequence[Table]
    facts: Mapping[str, Any]
    """Results for JSON."""
    headline: str = ""
    """Sentence that answers the request, above everything else, without a full stop."""
    caption: str = ""
    """Description of the request, without a full stop."""
    lines: Sequence[str] = ()
    """Answers, settings and notes, a sentence each."""
    warnings: Sequence[str] = ()
    """Problems, and results that may mislead; on the error stream of a command."""
    figures: "Mapping[str, Callable[[], Figure]]" = field(default_factory=dict)
    """Functions that draw the figures, by the stems of their files."""
    files: Sequence[Path] = ()
    """Files that the report lists, a line each."""
    folder: Path | None = None
    """Folder that it was written to."""
    next_step: str = ""
    """Sentence on what to open next, below everything else, without a full stop."""
    errors: Sequence[str] = ()
    """Reasons why the command fails after it prints the report, a line each."""
    code: int = 0
    """Exit code of the command: 130 if it was interrupted."""

    @property
    def table(self) -> Table:
        """First of the tables."""
        return self.tables[0]

    def __getitem__(self, name: str) -> Table:
        """Return the table by its name. Raises KeyError that names the tables."""
        for each in self.tables:
            if each.name == name:
                return each
        raise KeyError(f"no table {name!r}; tables: {', '.join(one.name for one in self.tables)}")

    def visible_tables(self) -> Iterator[Table]:
        """Return the tables to print: those with columns, except those for which `read` is empty.

        Returns
        -------
        iterator of Table
            Tables in the order of the page.
        """
        return (each for each in self.tables if each.columns and each.read != [])

    def markdown(self) -> str:
        """Return the text of the report in Markdown: all lines and all printed tables.

        Returns
        -------
        str
            Text in Markdown.
        """
        parts = [f"# {self.title}", *(f"{text}." for text in (self.headline, self.caption) if text)]
        for each in self.visible_tables():
            parts += [f"## {each.title}" if each.title else ""]
            parts += [_to_markdown(each.rich(markdown=True))]
            parts += ["\n".join(f"- {line}" for line in each.footer_lines(markdown=True))]
        parts += ["\n".join(f"- {line}" for line in self.lines)]
        return spell_for_python("\n\n".join(part for part in parts if part) + "\n")

    def write(self, folder: "Folder", pictures: bool) -> None:
        """Write a CSV file for each table, the report in Markdown, and the figures as PNG and PDF.

        Parameters
        ----------
        folder : Folder
            Open folder to write to.
        pictures : bool
            Whether figures are written.
        """
        self.write_tables(folder)
        folder.write(f"{self.name}.md", self.markdown().encode())
        if pictures:
            self.write_figures(folder)

    def write_tables(self, folder: "Folder") -> None:
        """Write a CSV file for each table that has keys.

        Parameters
        ----------
        folder : Folder
            Open folder to write to.
        """
        for each in self.tables:
            if each.keys:
                folder.write(f"{each.name}.csv", each.csv().encode())

    def write_figures(self, folder: "Folder") -> None:
        """Write the figures as PNG and PDF.

        Parameters
        ----------
        folder : Folder
            Open folder to write to.
        """
        for name, draw in self.figures.items():
            from walkergen.files import figures  # brings matplotlib

            figure = draw()
            folder.write(f"{name}.png", figures.png(figure))
            folder.write(f"{name}.pdf", figures.pdf(figure))

    def plot(self, name: str | None = None) -> "Figure":
        """Draw one of the figures.

        Parameters
        ----------
        name : str, optional
            Name of the figure, a key of `figures`; the first by default.

        Returns
        -------
        matplotlib.figure.Figure
            The figure, which a notebook shows.

        Raises
        ------
        InputError
            If there is no such figure. The message lists the names.
        """
        from walkergen.files import figures

        chosen = next(iter(self.figures), "") if name is None else name
        if chosen not in self.figures:
            named = ", ".join(map(repr, self.figures)) or "none: the report has no figure"
            raise InputError(f"plot {name!r}: must be one of {named}")
        return figures.show_in_notebook(self.figures[chosen]())

    def to_dataframe(self) -> Any:
        """Return a pandas frame of the first table.

        Returns
        -------
        pandas.DataFrame
            A column for each key, with units in the keys.

        Raises
        ------
        InputError
            If pandas is missing.
        """
        return self.table.to_dataframe()

    def __repr__(self) -> str:
        lines = [
            self.headline or self.title,
            *(line for one in self.tables for line in one.summary_lines()),
            *self._message_lines(),
        ]
        return spell_for_python("\n".join(lines))

    def _repr_html_(self) -> str:
        parts = [f"<p>{escape(text)}</p>" for text in (self.headline or self.title, self.caption)]
        parts += [each._repr_html_() for each in self.visible_tables()]
        return spell_for_python("".join([*parts, *(f"<p>{escape(line)}</p>" for line in self._message_lines())]))

    def _message_lines(self) -> Iterator[str]:
        """Yield the report's lines, then its warnings."""
        yield from map(spell, self.lines)
        yield from (f"warning: {spell(warning)}" for warning in self.warnings)


def _to_markdown(table: "RichTable") -> str:
    """Format a table as Markdown with aligned columns, after its title if it has one.

    As Rich prints it with box.MARKDOWN, which takes ten times as long and breaks lines of 300.
    """
    from rich.cells import cell_len

    columns = []
    for column in table.columns:
        cells = [_strip_markup(column.header), *map(_strip_markup, column.cells)]
        wide, right = max(map(cell_len, cells)), column.justify == "right"
        spaces = [" " * (wide - cell_len(cell)) for cell in cells]
        columns.append([space + cell if right else cell + space for cell, space in zip(cells, spaces, strict=True)])
    header, *rows = [f"| {' | '.join(line)} |" for line in zip(*columns, strict=True)]
    rule = "".join(f"|{'-' * (cell_len(column[0]) + 2)}" for column in columns) + "|"
    title = [_strip_markup(table.title)] if table.title else []
    return "\n".join([*title, header, rule, *rows])


def _strip_markup(cell: Any) -> str:
    """Return the text of a cell or heading without Rich's markup."""
    from rich.text import Text

    text = Text.from_markup(cell) if isinstance(cell, str) and "[" in cell else cell
    return " ".join(str(text).split("\n"))
