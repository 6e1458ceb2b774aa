"""Table of a sweep: a row for each point, in their order, written while it runs and read back.

Every row ends with the key of its point and a check sum of its other cells: a row that somebody
changed is told from one that we wrote, wherever the file has been.
"""

import os
import zlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Self

from walkergen.errors import InputError, OutputError
from walkergen.files import reading
from walkergen.files.columns import cells as cells_of
from walkergen.files.ledger import flags
from walkergen.files.tables import csv_text
from walkergen.points.point import PREDICTION, STATUS, Record, Value

NAME = "table.csv"
POINT, CHECK = "point", "check"
"""Names of the last two columns: the key of the point, and the check sum of the row."""

WORDS = ("model", "print_told", STATUS)
"""Columns of a record that hold words."""

SPEED = {
    False: ("speed_mm_s", "theory_mm_s", "model"),
    True: (
        "speed_mm_s", "se_mm_s", "low_95_mm_s", "high_95_mm_s", "step_error_mm_s",
        "predicted_mm_s", "theory_mm_s", "runs", "seconds", "model",
    ),
}  # fmt: skip
"""Columns of a predicted speed, and of a simulated one."""

MORE = {
    "spread": ("predicted_low_95_mm_s", "predicted_high_95_mm_s",
               "predicted_low_68_mm_s", "predicted_high_68_mm_s"),
    "persistence": (
        "persistence_time_s", "persistence_time_se_s", "persistence_length_mm",
        "persistence_length_se_mm", "rotational_diffusion_rad2_s",
        "rotational_diffusion_se_rad2_s", "turning_bias_rad_s", "turning_bias_se_rad_s",
    ),
    "impacts": ("impacts_per_s", "impacts_per_s_se", "contact_fraction", "contact_fraction_se"),
    "masses": ("total_g", "M_g", "J_g_mm2", "m_g", "j_g_mm2"),
    "printability": ("print_errors", "print_warnings", "print_told"),
}  # fmt: skip
"""Columns of the other groups of numbers."""


def columns(model: str, keep: Sequence[str]) -> tuple[str, ...]:
    """Columns of the records of a model that keep these groups, the status last."""
    more = [name for group in MORE if group in keep for name in MORE[group]]
    return (*SPEED[model != PREDICTION], *more, STATUS)


class Row(NamedTuple):
    """Row that was read back."""

    point: str
    """Key of the point; "" for one that was refused."""
    values: dict[str, str]
    """Cells by the names of their columns, without the point's key and the check sum."""


class Table:
    """Table that grows: rows are on the disk, whole, when `add` returns."""

    def __init__(self, path: Path, keys: Sequence[str], names: Sequence[str]) -> None:
        """Begin an empty table with columns of the keys that vary and of a record."""
        self.path, self.names = path, tuple(names)
        header = csv_text((*keys, *names, POINT, CHECK), [])
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            new = flags(os.O_WRONLY | os.O_CREAT | os.O_TRUNC)  # never through a link
            self._file = os.open(path, new, 0o666)
        except OSError as error:
            raise self._failure(error) from None
        self._write(header)

    def add(self, values: Sequence[Any], record: Record, point: str) -> None:
        """Append the row of a point. Raises OutputError."""
        cells = [*values, *(record.get(name) for name in self.names), point]
        line = csv_text(cells, [])
        self._write(csv_text([*cells, check_of(line)], []))

    def _write(self, text: str) -> None:
        data = text.encode()
        try:
            if os.write(self._file, data) != len(data):
                raise OSError(28, os.strerror(28))  # a disk that is full takes a part of it
        except OSError as error:
            raise self._failure(error) from None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        try:
            os.fsync(self._file)  # a full disk may only now say so
        except OSError as error:
            if kind is None:
                raise self._failure(error) from None
        finally:
            os.close(self._file)

    def _failure(self, error: OSError) -> OutputError:
        return OutputError(f"{str(self.path)!r}: cannot be written: {error.strerror}")


def check_of(line: str) -> str:
    """Check sum of a row's text without that sum, 8 hexadecimal digits."""
    return f"{zlib.crc32(line.rstrip().encode()):08x}"


def read(path: Path) -> Iterator[Row | int]:
    """Rows of a table, one after the other; the number of the line for a row that was changed.

    A last line that was cut short is left out. Raises InputError for a file that is no table of a
    sweep.
    """
    lines = reading.lines(path, "a table of `walkergen sweep`")
    header = cells_of(next(lines, ""), str(path), 1)
    if header[-2:] != [POINT, CHECK]:
        raise InputError(
            f"{path}: is no table of a sweep (its last columns are not point, check): "
            "move it away, or give another --out"
        )
    for number, line in enumerate(lines, start=2):
        if not line.endswith("\n"):
            return
        text = line.rstrip()
        sound = text.endswith(check_of(text.rpartition(",")[0]))
        cells = cells_of(line, str(path), number) if sound else []
        if len(cells) != len(header):
            yield number
            continue
        yield Row(cells[-2], dict(zip(header[:-2], cells[:-2], strict=True)))


def record_of(row: Row, names: Sequence[str]) -> Record | None:
    """Record of a row; None where the table has not all of these columns."""
    if not row.point or any(name not in row.values for name in names):
        return None
    return {name: _value(name, row.values[name]) for name in names if row.values[name]}


def _value(name: str, text: str) -> Value:
    if name in WORDS:
        return text
    return int(text) if text.lstrip("-").isdigit() else float(text)


def to_parquet(path: Path, keys: Mapping[str, bool], names: Sequence[str]) -> bytes | None:
    """The table at `path` as Parquet; None where pyarrow is not installed.

    `keys` are those that vary, True for numbers.
    """
    try:
        import pyarrow as arrow
        from pyarrow import csv as arrow_csv
        from pyarrow import parquet
    except ModuleNotFoundError:
        return None
    numbers = {key for key, numeric in keys.items() if numeric} | set(names) - set(WORDS)
    every = [*keys, *names, POINT, CHECK]
    types = {name: arrow.float64() if name in numbers else arrow.string() for name in every}
    buffer = arrow.BufferOutputStream()
    options = arrow_csv.ConvertOptions(column_types=types)
    with (
        arrow_csv.open_csv(path, convert_options=options) as blocks,
        parquet.ParquetWriter(buffer, blocks.schema) as writer,
    ):
        for block in blocks:
            writer.write_batch(block)
    return bytes(buffer.getvalue())
