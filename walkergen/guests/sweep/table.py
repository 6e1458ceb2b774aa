"""Table of a sweep: a row for each point, in their order, written while it runs.

Every row ends with the key of its point in the store, and with a check sum of its other cells. The check sum shows
which rows a user has changed. A check sum is no signature, so results are never read back from a table.
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
"""Columns of a record that contain text."""


class Table:
    """CSV table to which rows are appended. A complete row is on the disk when `add` returns."""

    def __init__(self, path: Path, keys: Sequence[str], names: Sequence[str]) -> None:
        """Create the file with a header: the varied `keys`, the `names` of a record's values, point, check."""
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
        """Append a row: values of the varied keys, record, and the point's key in the store. Raises OutputError."""
        cells = [*values, *(record.get(name) for name in self.names), point]
        line = csv_text(cells, [])
        self._write(csv_text([*cells, row_checksum(line)], []))

    def _write(self, text: str) -> None:
        data = text.encode()
        try:
            if os.write(self._file, data) != len(data):
                raise OSError(28, os.strerror(28))  # a full disk stores only a part of the data
        except OSError as error:
            raise self._write_error(error) from None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        try:
            os.fsync(self._file)  # a full disk may report the error only now
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
    """Return whether a line ends with the right check sum. A last line that was cut short must only be printable."""
    text = line.removesuffix("\n")
    if text == line:
        return text.isprintable()
    before, _, check = text.rpartition(",")
    return check == row_checksum(before)


def to_parquet(path: Path, keys: Mapping[str, bool], names: Sequence[str]) -> bytes | None:
    """Return the CSV table at `path` converted to Parquet; None if pyarrow is not installed.

    `keys`: whether the values are numbers, by varied key. `names`: names of a record's values.
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
