"""Tables as notebooks show them: columns of numpy, a small page of HTML, a frame of pandas."""

import math
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from typing import Any

import numpy as np
import numpy.typing as npt

from walkergen.errors import InputError
from walkergen.files.tables import as_html

Column = npt.NDArray[Any]

MOST_SHOWN = 20
"""Rows that a notebook shows; the others are counted."""


class Table:
    """Columns by name, with units in the names, and a row for each walker, sample or point."""

    def __init__(
        self, columns: Mapping[str, Sequence[Any] | Column], title: str = "",
        notes: Sequence[str] = (),
    ) -> None:  # fmt: skip
        """Make a table of columns of equal length; None is NaN in a column of numbers."""
        self.columns: dict[str, Column] = {name: column_of(one) for name, one in columns.items()}
        self.title = title
        self.notes = tuple(notes)

    def __getitem__(self, name: str) -> Column:
        """Find a column by its name. Raises KeyError that names the columns."""
        if name not in self.columns:
            raise KeyError(f"no column {name!r}; columns: {', '.join(self.columns)}")
        return self.columns[name]

    def __len__(self) -> int:
        return max((len(column) for column in self.columns.values()), default=0)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        """Rows, each with its values by the names of their columns."""
        for values in zip(*self.columns.values(), strict=True):
            yield dict(zip(self.columns, values, strict=True))

    def __repr__(self) -> str:
        return f"<{self.title or 'table'}: {len(self)} rows of {', '.join(self.columns)}>"

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{escape(name)}</th>" for name in self.columns)
        rows = [
            "<tr>" + "".join(f"<td>{escape(cell(one[at]))}</td>" for one in self.columns.values())
            + "</tr>"
            for at in range(min(len(self), MOST_SHOWN))
        ]  # fmt: skip
        more = len(self) - MOST_SHOWN
        notes = [*self.notes, *([f"and {more} more rows"] if more > 0 else [])]
        title = f"<caption>{escape(self.title)}</caption>" if self.title else ""
        table = (
            f"<table>{title}<thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"
        )
        return table + "".join(f"<p>{escape(note)}</p>" for note in notes)

    def to_dataframe(self) -> Any:
        """Frame of pandas with the same columns. Raises InputError where pandas is missing."""
        try:
            import pandas
        except ModuleNotFoundError:
            raise InputError(
                "to_dataframe: pandas is not installed: pip install pandas, or take the columns "
                f"as they are, arrays of numpy: table[{next(iter(self.columns), '')!r}]"
            ) from None
        return pandas.DataFrame(self.columns)


class Result:
    """Result that a notebook shows as a small table of names and values."""

    @property
    def table(self) -> Table:
        """Numbers of the result, with units in the names of the columns."""
        raise NotImplementedError

    def rows(self) -> Iterator[tuple[str, str]]:
        """Names and values in words, as a notebook shows them."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return "\n".join(f"{name}: {value}" for name, value in self.rows())

    def _repr_html_(self) -> str:
        return as_html(self.rows())

    def to_dataframe(self) -> Any:
        """Frame of pandas of `table`. Raises InputError where pandas is missing."""
        return self.table.to_dataframe()


def table_of(rows: Sequence[Any], title: str = "", notes: Sequence[str] = ()) -> Table:
    """Table of named tuples of one kind, whose fields are the columns."""
    fields = rows[0]._fields if rows else ()
    columns = {name: [getattr(row, name) for row in rows] for name in fields}
    return Table(columns, title, notes)


def column_of(values: Sequence[Any] | Column) -> Column:
    """Values as an array: of numbers, None as NaN, or of objects where one is no number."""
    if isinstance(values, np.ndarray):
        return values
    if all(one is None or _is_number(one) for one in values):
        whole = all(isinstance(one, int) for one in values)
        return np.array([math.nan if one is None else one for one in values],
                        dtype=np.int64 if whole else np.float64)  # fmt: skip
    found = np.empty(len(values), dtype=object)
    found[:] = values
    return found


def cell(value: Any) -> str:
    """Value of a cell for people: four digits of a number, nothing where there is none."""
    if value is None:
        return ""
    if isinstance(value, (float, np.floating)):
        return "" if math.isnan(value) else f"{value:.4g}"
    return str(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)
