"""Columns of numbers from CSV files that people and programs write; bad rows are named, not hidden.

A million sound rows take about a second, as with pandas, which would be the largest dependency.
"""

import csv
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from types import MappingProxyType
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
    with _lines(path) as lines:
        names = [name.strip() for name in next(csv.reader(lines), [])]
    if not any(names):
        raise InputError(f"{path}: is empty; give a CSV file whose first line names its columns")
    twice = sorted({name for name in names if name and names.count(name) > 1})
    if twice:
        raise InputError(f"{path}: column {twice[0]!r} occurs twice; keep one")
    return names


def read(
    path: Path,
    required: Sequence[str],
    optional: Sequence[str] = (),
    words: Mapping[str, Sequence[str]] = MappingProxyType({}),
) -> Columns:
    """The named columns; rows without finite numbers in the required ones are left out and named.

    Optional columns may have blank cells; those of `words` hold one of a few words, read as its
    place among them. Other columns are not looked at (trackpy's `mass` is a brightness, not a
    mass). Raises InputError when a required column is missing, or no row is usable.
    """
    names = header(path)
    missing = [name for name in required if name not in names]
    if missing:
        seen = ", ".join(name for name in names if name)[:200]
        raise InputError(f"{path}: no column {missing[0]!r}; columns seen: {seen}")
    wanted = [name for name in (*required, *optional, *words) if name in names]
    places = [names.index(name) for name in wanted]
    chunks: list[list[Array]] = []
    lines: list[npt.NDArray[np.int64]] = []
    bad: dict[int, str] = {}
    with _lines(path) as stream:
        next(stream)
        first = 2
        while chunk := list(islice(stream, CHUNK)):
            if first + len(chunk) > MOST_ROWS:
                raise InputError(f"{path}: more than {MOST_ROWS} rows; split the file")
            numbers = np.arange(first, first + len(chunk))
            values, wrong = _parse(chunk, numbers, wanted, places, len(required), words)
            usable = np.array([bool(line.strip()) for line in chunk])
            usable[[line - first for line in wrong]] = False
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
def _lines(path: Path) -> Iterator[Iterator[str]]:
    try:
        with path.open(encoding="utf-8-sig") as stream:
            yield stream
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: not a CSV file in UTF-8: {error}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{str(path)[:80]!r}: cannot be read: {reason}") from None


def _parse(
    chunk: list[str],
    numbers: npt.NDArray[np.int64],
    names: Sequence[str],
    places: Sequence[int],
    required: int,
    words: Mapping[str, Sequence[str]],
) -> tuple[list[Array], dict[int, str]]:
    """Columns of a chunk of lines, and what is wrong by line; the first `required` are finite."""
    rows: list[list[str]] = []
    try:  # nearly every chunk is sound, and this is ten times faster than cell by cell
        if not all(map(str.strip, chunk)):
            raise ValueError("blank lines, which loadtxt would drop")
        values = list(
            np.loadtxt(
                chunk, delimiter=",", usecols=places, comments=None, quotechar='"', ndmin=2
            ).T
        )
    except ValueError:
        rows = [next(csv.reader([line]), []) for line in chunk]
        cells = zip(names, places, strict=True)
        values = [
            np.array([_number(row, place, n >= required, words.get(name, ())) for row in rows])
            for n, (name, place) in enumerate(cells)
        ]
    wrong: dict[int, str] = {}
    for n, (name, place, column) in enumerate(zip(names, places, values, strict=True)):
        unusable = ~np.isfinite(column) if n < required else np.isinf(column)
        for index in np.flatnonzero(unusable):
            row = rows[index] if rows else next(csv.reader([chunk[index]]))
            if row:
                seen = f"{row[place].strip()[:30]!r}" if place < len(row) else "missing"
                expected = f"one of {', '.join(words[name])}" if name in words else "a number"
                wrong.setdefault(int(numbers[index]), f"{name} is {seen}, not {expected}")
    return values, wrong


_UNREADABLE = -math.inf
"""Stands for text where an optional number may stand."""


def _number(row: list[str], place: int, optional: bool, known: Sequence[str]) -> float:
    text = row[place].strip() if place < len(row) else ""
    try:
        return float(known.index(text) if known and text else text)
    except ValueError:
        return math.nan if optional and not text else _UNREADABLE
