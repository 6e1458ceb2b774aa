"""Table of a sweep: a row for each point, in their order, written while it runs.

Every row ends with the key of its point and a check sum of its other cells. It distinguishes rows that a user changed
from our own. No number is read back: a sum is no signature.
"""

import os
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Self

from walkergen.core import InputError, OutputError, csv_text
from walkergen.core.files import file_reading
from walkergen.core.files.columns import split_cells as cells_of
from walkergen.core.files.ledger import open_flags
from walkergen.points.point import STATUS_KEY, Record

TABLE_FILE = "table.csv"
POINT_COLUMN, CHECK_COLUMN = "point", "check"
"""Names of the last two columns: the key of the point, and the check sum of the row."""

TEXT_COLUMNS = ("model", "print_told", STATUS_KEY)
"""Columns of a record that hold words."""


class Table:
    """Table that grows: rows are on the disk, whole, when `add` returns."""

    def __init__(self, path: Path, keys: Sequence[str], names: Sequence[str]) -> None:
        """Create the file with a header. `keys`: columns of the varied keys. `names`: columns of a record."""
        self.path, self.names = path, tuple(names)
        header = csv_text((*keys, *names, POINT_COLUMN, CHECK_COLUMN), [])
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            new = open_flags(os.O_WRONLY | os.O_CREAT | os.O_TRUNC)  # never through a link
            self._file = os.open(path, new, 0o666)
        except OSError as error:
            raise self._write_error(error) from None
        self._write(header)

    def add(self, values: Sequence[Any], record: Record, point: str) -> None:
        """Append the row of a point: values of the keys, record and key of the point. Raises OutputError."""
        cells = [*values, *(record.get(name) for name in self.names), point]
        line = csv_text(cells, [])
        self._write(csv_text([*cells, row_checksum(line)], []))

    def _write(self, text: str) -> None:
        data = text.encode()
        try:
            if os.write(self._file, data) != len(data):
                raise OSError(28, os.strerror(28))  # a disk that is full takes a part of it
        except OSError as error:
            raise self._write_error(error) from None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        try:
            os.fsync(self._file)  # a full disk may only now say so
        except OSError as error:
            if kind is None:
                raise self._write_error(error) from None
        finally:
            os.close(self._file)

    def _write_error(self, error: OSError) -> OutputError:
        return OutputError(f"{str(self.path)!r}: cannot be written: {error.strerror}")


def row_checksum(line: str) -> str:
    """Return the check sum, 8 hexadecimal digits, of a row's text before the column of the check sum."""
    return f"{zlib.crc32(line.rstrip().encode()):08x}"


def find_changed_lines(path: Path) -> list[int]:
    """Return the numbers of lines whose check sum is wrong: they were changed after a sweep wrote them.

    A last line that was cut short does not count. Raises InputError for a file that is no table of a sweep.
    """
    lines = file_reading.read_lines(path, "a table of `walkergen sweep`", newline="")
    header = next(lines, "")
    if header.endswith("\n") and cells_of(header, str(path), 1)[-2:] != [POINT_COLUMN, CHECK_COLUMN]:
        raise InputError(
            f"{path}: is not a table of a sweep (its last columns are not point, check). "
            "Move it, or give another ‹out›."
        )
    return [number for number, line in enumerate(lines, start=2) if not _has_valid_checksum(line)]


def _has_valid_checksum(line: str) -> bool:
    """Return whether a line ends with the right check sum. A line that was cut short must be printable only."""
    text = line.removesuffix("\n")
    if text == line:
        return text.isprintable()
    before, _, check = text.rpartition(",")
    return check == row_checksum(before)


def to_parquet(path: Path, keys: Mapping[str, bool], names: Sequence[str]) -> bytes | None:
    """Convert the CSV table at `path` to Parquet; None if pyarrow is not installed.

    `keys`: varied keys, True for those with numbers, False for text. `names`: columns of a record.
    """
    try:
        import pyarrow as arrow
        from pyarrow import csv as arrow_csv
        from pyarrow import parquet
    except ModuleNotFoundError:
        return None
    numbers = {key for key, numeric in keys.items() if numeric} | set(names) - set(TEXT_COLUMNS)
    columns = [*keys, *names, POINT_COLUMN, CHECK_COLUMN]
    types = {name: arrow.float64() if name in numbers else arrow.string() for name in columns}
    buffer = arrow.BufferOutputStream()
    options = arrow_csv.ConvertOptions(column_types=types)
    with (
        arrow_csv.open_csv(path, convert_options=options) as blocks,
        parquet.ParquetWriter(buffer, blocks.schema) as writer,
    ):
        for block in blocks:
            writer.write_batch(block)
    return bytes(buffer.getvalue())
