"""Columns of numbers from CSV files that people and programs write; bad rows are named, not hidden.

A million rows take about two seconds; pandas would take half of that and be the largest dependency.
"""

import csv
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.errors import InputError

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

MOST_ROWS = 20_000_000
CHUNK = 100_000
NAMED = 5
"""Bad rows named one by one; the others are counted."""


class Columns(NamedTuple):
    """The usable rows of a file."""

    values: dict[str, Array]
    """By name, each of shape (rows,); blank cells of optional columns are NaN."""
    lines: npt.NDArray[np.int64]
    """Line in the file of each row, shape (rows,)."""
    bad: dict[int, str]
    """What is wrong with each row left out, by its line."""

    def without(self, wrong: Mask, reason: str) -> "Columns":
        """The rows outside `wrong` (shape (rows,)); the others join the bad ones."""
        bad = self.bad | {int(line): reason for line in self.lines[wrong]}
        kept = {name: values[~wrong] for name, values in self.values.items()}
        return Columns(kept, self.lines[~wrong], bad)


def header(path: Path) -> list[str]:
    """Names in the first line; raises InputError when there is none."""
    with _rows(path) as rows:
        names = [name.strip() for name in next(rows, [])]
    if not any(names):
        raise InputError(f"{path}: is empty; give a CSV file whose first line names its columns")
    twice = sorted({name for name in names if name and names.count(name) > 1})
    if twice:
        raise InputError(f"{path}: column {twice[0]!r} occurs twice; keep one")
    return names


def read(path: Path, required: Sequence[str], optional: Sequence[str] = ()) -> Columns:
    """The named columns; rows without finite numbers in the required ones are left out and named.

    Other columns are not looked at (trackpy's `mass` is a brightness, not a mass). Raises
    InputError when a required column is missing, or no row is usable.
    """
    names = header(path)
    missing = [name for name in required if name not in names]
    if missing:
        seen = ", ".join(name for name in names if name)[:200]
        raise InputError(f"{path}: no column {missing[0]!r}; columns seen: {seen}")
    wanted = [name for name in (*required, *optional) if name in names]
    places = [names.index(name) for name in wanted]
    chunks: list[list[Array]] = []
    lines: list[npt.NDArray[np.int64]] = []
    bad: dict[int, str] = {}
    with _rows(path) as rows:
        next(rows)
        first = 2
        while chunk := list(islice(rows, CHUNK)):
            if first + len(chunk) > MOST_ROWS:
                raise InputError(f"{path}: more than {MOST_ROWS} rows; split the file")
            numbers = np.arange(first, first + len(chunk))
            values, wrong = _parse(chunk, numbers, wanted, places, len(required))
            usable = np.array([bool(row) and first + i not in wrong for i, row in enumerate(chunk)])
            chunks.append([column[usable] for column in values])
            lines.append(numbers[usable])
            bad |= wrong
            first += len(chunk)
    if not sum(len(part) for part in lines):
        told = summary(bad) or "no rows after the header"
        raise InputError(f"{path}: nothing to read: {told}")
    joined = [np.concatenate(parts) for parts in zip(*chunks, strict=True)]
    return Columns(dict(zip(wanted, joined, strict=True)), np.concatenate(lines), bad)


def summary(bad: dict[int, str]) -> str:
    """How many rows were left out, and why the first few; '' when none was."""
    if not bad:
        return ""
    told = "; ".join(f"line {line}: {bad[line]}" for line in sorted(bad)[:NAMED])
    more = f"; and {len(bad) - NAMED} more" if len(bad) > NAMED else ""
    return f"{len(bad)} bad row{'s' if len(bad) > 1 else ''} left out: {told}{more}"


@contextmanager
def _rows(path: Path) -> Iterator[Iterator[list[str]]]:
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            yield csv.reader(stream)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: not a CSV file in UTF-8: {error}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{str(path)[:80]!r}: cannot be read: {reason}") from None


def _parse(
    rows: list[list[str]],
    lines: npt.NDArray[np.int64],
    names: Sequence[str],
    places: Sequence[int],
    required: int,
) -> tuple[list[Array], dict[int, str]]:
    """Columns of a chunk, and what is wrong by line; the first `required` have to be finite."""
    values: list[Array] = []
    wrong: dict[int, str] = {}
    for number, (name, place) in enumerate(zip(names, places, strict=True)):
        try:  # nearly every chunk is sound, and this is ten times faster than cell by cell
            column = np.array([row[place] for row in rows], dtype=float)
        except (IndexError, ValueError):
            column = np.array([_number(row, place, number >= required) for row in rows])
        unusable = ~np.isfinite(column) if number < required else np.isinf(column)
        for index in np.flatnonzero(unusable):
            row = rows[index]
            if row:
                seen = f"{row[place].strip()[:30]!r}" if place < len(row) else "missing"
                wrong.setdefault(int(lines[index]), f"{name} is {seen}, not a number")
        values.append(column)
    return values, wrong


_UNREADABLE = -math.inf
"""Stands for text where an optional number may stand."""


def _number(row: list[str], place: int, optional: bool) -> float:
    text = row[place].strip() if place < len(row) else ""
    try:
        return float(text)
    except ValueError:
        return math.nan if optional and not text else _UNREADABLE
