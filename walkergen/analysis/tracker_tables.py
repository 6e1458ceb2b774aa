"""Tables of Tracker (Open Source Physics): a line with names of tracks above the line with names of columns.

An exported table has the names over the first column of each track, a blank cell over the time and, for several
tracks, `#multi:` above all. A copied table has one name. Frames without a mark have blank cells.
"""

from collections.abc import Iterator, Sequence
from itertools import chain, islice
from pathlib import Path

from walkergen.analysis import track_columns
from walkergen.analysis.track_columns import NamedColumn, Source
from walkergen.core.errors import InputError
from walkergen.core.files import columns

MULTI_TRACK_HEADER, TIME_COLUMN = "#multi:", "t"
"""First line of a file of several tracks, and the first column of every table."""


def title_line_count(head: Sequence[str]) -> int:
    """Count the lines above the names of columns, from a file's first three lines; 0 if it is not Tracker's."""
    count = 2 if head and head[0].strip() == MULTI_TRACK_HEADER else 1
    if len(head) <= count:
        return 0
    mark = track_columns.find_separator(head[count])
    title = head[count - 1].rstrip("\n")
    named = title.startswith(mark) if mark and len(_split_cells(title, mark)) > 1 else bool(mark and title.strip())
    return count if named and _split_cells(head[count], mark)[0] == TIME_COLUMN else 0


def _split_cells(line: str, separator: str) -> list[str]:
    return [cell.strip() for cell in line.rstrip("\n").split(separator)]


def read_tracker(path: Path, count: int) -> Source:
    """Read Tracker's table, with `count` lines above the names of its columns. Raises InputError."""
    head = list(islice(track_columns.read_text(path), count + 1))
    mark = track_columns.find_separator(head[count])
    names = _split_cells(head[count], mark)
    wide = {axis: [at for at, name in enumerate(names) if name == axis] for axis in ("x", "y")}
    for axis in ("x", "y"):
        if not wide[axis]:
            raise track_columns.missing_column_error(path, [name for name in names if name], axis)
    if len(wide["x"]) != len(wide["y"]):
        raise InputError(
            f"{path}: {len(wide['x'])} columns x and {len(wide['y'])} columns y: export x and y of each track"
        )
    keys = [f"{axis} of track {n}" for n in range(len(wide["x"])) for axis in ("x", "y")]
    xy_columns = [at for pair in zip(wide["x"], wide["y"], strict=True) for at in pair]
    table = columns.read_numbers(
        path, [TIME_COLUMN], keys, lines=_csv_lines(path, count, mark, [TIME_COLUMN, *keys], [0, *xy_columns])
    )
    walkers = [(table.values[x], table.values[y]) for x, y in zip(keys[::2], keys[1::2], strict=True)]
    long = track_columns.to_long_table(table, "time", table.values[TIME_COLUMN], walkers, range(len(walkers)))
    if not len(long.lines):
        raise InputError(f"{path}: nothing to read: no frame has both x and y. Export both.")
    titles = _split_cells(head[count - 1], mark)
    # With blanks between cells, one title of two words looks like two titles
    called = [titles[at] for at in range(1, len(titles)) if titles[at]] if mark != " " else []
    notes = track_columns.format_labels(called) if len(called) == len(walkers) > 1 else ()
    named = {"time": NamedColumn(TIME_COLUMN, "s"), "x": NamedColumn("x", ""), "y": NamedColumn("y", "")}
    return Source(long, named, "Tracker", notes=notes)


def _csv_lines(
    path: Path, header_index: int, separator: str, names: Sequence[str], indices: Sequence[int]
) -> Iterator[str]:
    """Yield a CSV file's lines: new names, then the columns at these indices, below line `header_index` (from 0)."""
    yield ",".join(names) + "\n"
    stream = track_columns.read_text(path)
    for at, line in enumerate(chain(["\n"] * header_index, islice(stream, header_index + 1, None)), 2):
        if separator != "," and "," in line:
            raise InputError(f"{path}:{at}: {line.strip()[:40]!r} has a decimal comma. Write a decimal point, as 0.04.")
        cells = _split_cells(line, separator)
        yield ",".join(cells[index] if index < len(cells) else "" for index in indices if line.strip()) + "\n"
