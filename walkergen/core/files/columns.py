"""CSV files that people and programs write: whole columns of numbers, or records of text.

Every line is parsed alone, so that an open quote spoils no other. Bad rows of numbers are named, not hidden. A million
sound rows take about a second, as with pandas, which would be the largest dependency.
"""

import csv
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain, islice
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.core.errors import InputError
from walkergen.core.files import file_reading, formatting, safe_text
from walkergen.core.files.tables import unquote_formula

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]

FORMAT_NAME = "a CSV file"
MAX_ROWS, MAX_COLUMNS, MAX_BAD_ROWS = 20_000_000, 1000, 1_000_000
MAX_MAGNITUDE, MIN_MAGNITUDE = 1e12, 1e-12
"""Size above which a number is a typing error in any unit, and size below which it is 0."""
CHUNK_LINES = 100_000
"""Number of lines parsed together."""

MATCH_PLAIN_LINE = re.compile(r"""[^"'\r\n]{1,99999}\n?""").fullmatch
"""Lines whose cells are simply separated by commas; a line may exceed the csv module's limit for a cell."""

SEPARATOR_HINT = "separate cells by commas and write numbers with a decimal point"
"""Advice for tables from programs in other languages."""
MAX_NAMED_ROWS, MAX_NAMED_IF_ALL_BAD = 5, 2
"""Most bad rows named if some rows are good, and if all are bad; further rows are counted."""


class Columns(NamedTuple):
    """Usable rows of a file as numbers."""

    values: dict[str, Array]
    """Columns by name, each of shape (rows,); blank cells of optional columns are NaN."""
    lines: Whole
    """Line in the file of each row, shape (rows,)."""
    bad: dict[int, str]
    """Reason why each other row was left out, by its line in the file."""

    def reject_rows(self, wrong: Mask, reason: str) -> "Columns":
        """Return the columns without rows where `wrong`, shape (rows,), is True. These become bad, with this reason."""
        bad = self.bad | {int(line): reason for line in self.lines[wrong]}
        kept = {name: values[~wrong] for name, values in self.values.items()}
        return Columns(kept, self.lines[~wrong], bad)


class Records(NamedTuple):
    """Rows of a file as text."""

    names: list[str]
    """Names of the columns, in the order of the file."""
    rows: list[tuple[int, dict[str, str]]]
    """Line in the file of each row, and its cells by the names of their columns."""


def read_header(path: Path) -> list[str]:
    """Return the columns' names in the first line of a CSV file. Raises InputError for missing and for equal names."""
    return first_two_rows(file_reading.read_lines(path, FORMAT_NAME), str(path))[0]


def first_two_rows(lines: Iterable[str], source: str) -> tuple[list[str], list[str]]:
    """Return the names of a CSV file's columns, and the cells of its first row below, [] without rows.

    Errors begin with `source`.
    """
    names, stream = _read_names(iter(lines), source)
    rows = (split_cells(line, source, at) for at, line in enumerate(stream, 2) if line.strip())
    return names, next(rows, [])


def distinct_texts(lines: Iterable[str], source: str, name: str) -> list[str]:
    """Return the distinct texts of the column `name`, in file order, without blanks. Errors begin with `source`."""
    names, stream = _read_names(iter(lines), source)
    column = names.index(name)
    rows = (split_cells(line, source, at) for at, line in enumerate(stream, 2))
    found = dict.fromkeys(row[column].strip() for row in rows if column < len(row))
    return [text for text in found if text]


def parse_records(lines: Iterable[str], source: str) -> Records:
    """Parse the lines of a CSV file into rows. The first line names the columns, and blank rows are left out.

    Raises InputError, which begins with `source` and the line, when a name is missing or occurs
    twice, when a row has not as many cells as the header, and when a line is not valid CSV.
    """
    names, stream = _read_names(iter(lines), source)
    rows = []
    for at, line in enumerate(stream, start=2):
        row = split_cells(line, source, at)
        if not any(cell.strip() for cell in row):
            continue
        if len(row) != len(names):
            seen = "1 cell" if len(row) == 1 else f"{len(row)} cells"
            raise InputError(f"{source}:{at}: {seen}, the header has {len(names)}: {SEPARATOR_HINT}")
        rows.append((at, dict(zip(names, row, strict=True))))
    return Records(names, rows)


def check_names(seen: Sequence[str], path: Path, required: Sequence[str], optional: Sequence[str], note: str) -> None:
    """Raise InputError for a missing or unknown column. `seen` are the file's columns, and `note` ends the message."""
    missing = [name for name in required if name not in seen]
    unknown = [name for name in seen if name not in (*required, *optional)]
    if missing or unknown:
        what = f"no column {missing[0]!r}" if missing else f"unknown column {unknown[0][:60]!r}"
        raise InputError(f"{path}:1: {what}; columns are {', '.join(required)}{note}")


def read_numbers(
    path: Path,
    required: Sequence[str],
    optional: Sequence[str] = (),
    words: Mapping[str, Sequence[str]] = MappingProxyType({}),
    lines: Iterable[str] | None = None,
) -> Columns:
    """Read columns of numbers by name, leaving out rows without finite numbers in the required columns.

    `lines` replace the lines of the file, for a file that another program writes in a format of its own.

    Optional columns may have blank cells. `words` has the texts that a column may hold, by its name: each text is read
    as its index in the list. Other columns are not looked at (trackpy's `mass` is a brightness, not a mass). Raises
    InputError when the file cannot be read, when a required column is missing, and when no row is usable.
    """
    names, stream = _read_names(iter(file_reading.read_lines(path, FORMAT_NAME) if lines is None else lines), str(path))
    missing = [name for name in required if name not in names]
    if missing:
        seen = safe_text.shorten_line(", ".join(name for name in names if name))
        raise InputError(f"{path}: no column {missing[0]!r}; columns seen: {seen}")
    all_names = (*required, *optional, *words)
    columns = {name: names.index(name) for name in all_names if name in names}
    chunks: list[list[Array]] = []
    kept: list[Whole] = []
    bad: dict[int, str] = {}
    long_rows: dict[int, str] = {}
    first = 2
    while chunk := list(islice(stream, CHUNK_LINES)):
        if first + len(chunk) > MAX_ROWS:
            raise InputError(f"{path}: more than {MAX_ROWS} rows. Split the file")
        numbers = np.arange(first, first + len(chunk))
        values, wrong = _parse_chunk(chunk, numbers, str(path), columns, len(required), words)
        long_rows_of_chunk = _find_long_rows(chunk, first, str(path), len(names))
        long_rows |= long_rows_of_chunk
        wrong |= long_rows_of_chunk
        usable = np.array([bool(line.strip()) for line in chunk])
        usable[[line - first for line in wrong]] = False
        chunks.append([column[usable] for column in values])
        kept.append(numbers[usable])
        bad |= wrong
        if len(bad) > MAX_BAD_ROWS:
            raise InputError(f"{path}: more than {describe_bad_rows(bad)}: is it the right file?")
        first += len(chunk)
    if len(long_rows) > sum(map(len, kept)):
        line = min(long_rows)
        raise InputError(f"{path}:{line}: {long_rows[line]}: {SEPARATOR_HINT}")
    if not any(map(len, kept)):
        reason = describe_bad_rows(bad, MAX_NAMED_IF_ALL_BAD) or "no rows after the header"
        raise InputError(f"{path}: nothing to read: {reason}")
    joined = map(np.concatenate, zip(*chunks, strict=True))
    return Columns(dict(zip(columns, joined, strict=True)), np.concatenate(kept), bad)


def parse_count(text: str, most: int) -> int | None:
    """Return the whole number that a text in plain digits contains, or None if it is outside 1..most or no number."""
    value = int(text) if re.fullmatch(r"\s*[0-9]{1,9}\s*", text) else 0
    return value if 1 <= value <= most else None


def describe_bad_rows(bad: dict[int, str], most: int = MAX_NAMED_ROWS) -> str:
    """Describe the number of bad rows, and the reasons for the first `most`. `bad`: reasons by line; '' without any."""
    if not bad:
        return ""
    named = "; ".join(f"line {line}: {bad[line]}" for line in sorted(bad)[:most])
    more = f"; and {len(bad) - most} more" if len(bad) > most else ""
    return f"{len(bad)} bad row{'s' if len(bad) > 1 else ''} left out: {named}{more}"


def _read_names(stream: Iterator[str], source: str) -> tuple[list[str], Iterator[str]]:
    """Read the names in the first line of a stream, and return them with all lines after it. Raises InputError.

    R's write.table gives no name to the column of row names: it is the first, and its name is then "".
    """
    names = [name.strip() for name in split_cells(next(stream, ""), source, 1)]
    if not any(names):
        raise InputError(f"{source}: is empty. Give {FORMAT_NAME} whose first line names its columns")
    if len(names) == 1 and (other := next((mark for mark in ";\t|" if mark in names[0]), "")):
        raise InputError(f"{source}:1: no comma, but {other!r} seen: {SEPARATOR_HINT}")
    if len(names) > MAX_COLUMNS:
        raise InputError(f"{source}:1: {len(names)} columns. At most {MAX_COLUMNS} are allowed")
    twice = sorted({name for name in names if name and names.count(name) > 1})
    if twice:
        raise InputError(f"{source}:1: column {twice[0]!r} occurs twice. Keep one")
    first = next(stream, None)
    if first is None:
        return names, stream
    row = split_cells(first, source, 2)
    if len(row) == len(names) + 1 and row[-1].strip() and len(names) < MAX_COLUMNS:
        # Commas within numbers would make as many cells: R quotes row names, and has decimal points
        if not (first.lstrip().startswith('"') or any("." in cell for cell in row[1:])):
            problem = f"{len(row)} cells, the header has {len(names)}: do rows begin with names, as R writes them? "
            raise InputError(f"{source}:2: {problem}Then name that column in the header. Else {SEPARATOR_HINT}")
        names = ["", *names]
    return names, chain([first], stream)


def _find_long_rows(chunk: Sequence[str], first: int, source: str, count: int) -> dict[int, str]:
    """Return a message on each line with more than `count` cells, by line number. The chunk begins at line `first`."""
    problems = {}
    for at, line in enumerate(chunk, first):
        if line.count(",") >= count:
            row = split_cells(line, source, at)
            if any(cell.strip() for cell in row[count:]):
                problems[at] = f"{len(row)} cells, the header has {count}"
    return problems


def split_cells(line: str, source: str, at: int) -> list[str]:
    """Split a line into its cells; an empty line has none. Raises InputError, with `source` and line number `at`."""
    if MATCH_PLAIN_LINE(line):  # as below, in a third of the time
        return line.removesuffix("\n").split(",")
    try:
        return [unquote_formula(cell) for cell in next(csv.reader([line]), [])]
    except csv.Error as error:
        raise InputError(f"{source}:{at}: not valid CSV: {error}") from None


def _parse_chunk(
    chunk: list[str],
    numbers: Whole,
    source: str,
    columns: Mapping[str, int],
    required_count: int,
    words: Mapping[str, Sequence[str]],
) -> tuple[list[Array], dict[int, str]]:
    """Parse lines into columns, each of shape (lines,), and return them with the reason for each bad line.

    `numbers` are the lines' numbers in the file, and `columns` the indices of the cells by name. In the first
    `required_count` columns every line that is not bad has a finite number. `words` has the texts that other columns
    may hold.
    """
    rows: list[list[str]] = []
    try:  # nearly every chunk is sound, and this is ten times faster than cell by cell
        if words or not all(map(str.strip, chunk)):
            raise ValueError("words, or blank lines, which loadtxt would drop")
        table = np.loadtxt(chunk, delimiter=",", usecols=[*columns.values()], comments=None, quotechar='"', ndmin=2)
        if len(table) != len(chunk):
            raise ValueError("an open quote, which joined lines")
        values = list(table.T)
    except ValueError:
        rows = [split_cells(line, source, at) for line, at in zip(chunk, numbers, strict=True)]
        values = [
            np.array(
                [_parse_cell(row, column, optional=n >= required_count, words=words.get(name, ())) for row in rows]
            )
            for n, (name, column) in enumerate(columns.items())
        ]
    wrong: dict[int, str] = {}
    for n, ((name, position), column) in enumerate(zip(columns.items(), values, strict=True)):
        column[np.abs(column) < MIN_MAGNITUDE] = 0.0
        unusable = np.abs(column) > MAX_MAGNITUDE
        if n < required_count:
            unusable |= np.isnan(column)
        for index in np.flatnonzero(unusable):
            row = rows[index] if rows else split_cells(chunk[index], source, numbers[index])
            if row:
                seen = f"{row[position].strip()[:30]!r}" if position < len(row) else "missing"
                within = f" within ±{MAX_MAGNITUDE:g}" if abs(column[index]) < math.inf else ""
                expected = f"one of {', '.join(words[name])}" if name in words else "a number"
                expected += within
                wrong.setdefault(int(numbers[index]), f"{name} is {seen}, not {expected}")
    return values, wrong


_UNREADABLE = -math.inf
"""Value of a cell that holds neither a number nor, where it may, nothing."""


def _parse_cell(row: list[str], column: int, optional: bool, words: Sequence[str]) -> float:
    """Return a cell's number, or the index of its text in `words`, or NaN if blank and optional, else _UNREADABLE."""
    text = row[column].strip() if column < len(row) else ""
    if words and text:
        return float(words.index(text)) if text in words else _UNREADABLE
    value = formatting.parse_number(text)
    if value is not None:
        return value
    return math.nan if optional and text.lower() in ("", "nan") else _UNREADABLE
