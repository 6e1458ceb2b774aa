"""Rows of tracks as programs write them, brought into one form: a row for a walker in a frame.

A table whose columns name their contents is read directly, from any program. Other layouts, by program:
TrackMate (tables of spots, XML of spots or of tracks), DeepLabCut (three or four lines of names),
SLEAP's analysis table, idtracker.ai (columns x1, y1, x2, y2 and so on), MTrackJ (.mdf), Tracker of Open
Source Physics (a line with the tracks' names above the table), and files of arrays (`track_arrays`).
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain, islice
from pathlib import Path

import numpy as np

from walkergen.analysis import pose_tables, track_arrays, track_columns, track_xml, tracker_tables
from walkergen.analysis.track_columns import SCALE_COLUMNS, WALKERGEN_PROGRAM, NamedColumn, Source
from walkergen.core.errors import InputError
from walkergen.core.files import columns, file_reading, safe_text
from walkergen.core.files import formatting as words
from walkergen.core.numerics import Array

NO_TRACK_LABELS = ("none", "ø")
"""What TrackMate writes instead of a track's number for a spot without a track."""

TREX_COLUMNS = ("X#wcentroid (cm)", "X (cm)")
"""Columns of TRex's tables, of the body and of its head."""

CLUSTER_COLUMN = "CID"
"""Column of MTrackJ's clusters of tracks."""

MIRRORED_PROGRAMS = ("FastTrack",)
"""Programs whose headings count counterclockwise though their y goes down (FastTrack's tracking.cpp)."""


def read_source(path: Path, lane: bool) -> Source:
    """Read the rows of a file of tracks; those of a `lane` need no y. Raises InputError."""
    if (arrays := track_arrays.read_arrays(path, lane)) is not None:
        return arrays
    head = list(islice(_text_lines(path), 3))
    first = head[0].lstrip() if head else ""
    if first.startswith("<"):
        return track_xml.read_xml(path)
    if first.startswith("MTrackJ"):
        return track_xml.read_mtrackj(path)
    if first.lower().startswith("scorer,"):
        return pose_tables.read_deeplabcut(path)
    if above := tracker_tables.title_line_count(head):
        return tracker_tables.read_tracker(path, above)
    titled = len(head) > 1 and not track_columns.find_separator(head[0]) and bool(track_columns.find_separator(head[1]))
    names, _ = columns.first_two_rows(_table_lines(path, titled), str(path))
    if "frame_idx" in names:
        pose_tables.check_table_kind(path, names)
        if any(name.endswith(".x") for name in names):
            return pose_tables.read_sleap(path, names)
    return _from_columns(path, names, lane, titled)


def _text_lines(path: Path) -> Iterator[str]:
    """Return the lines of a table, whether its columns are text or arrays."""
    return track_arrays.npz_lines(path) or file_reading.read_lines(path, columns.FORMAT_NAME)


def _table_lines(path: Path, titled: bool, more: int = 0) -> Iterator[str]:
    """Yield a table's lines in the form of a CSV file, without a title above, and `more` blank below its header.

    What is left out is a blank line, so that lines keep their numbers. Raises InputError for commas in the
    cells of a table with another mark between them.
    """
    stream = _text_lines(path)
    if titled:
        next(stream)
    header = next(stream, "")
    if any(name in header for name in TREX_COLUMNS):
        names = header.split(",")  # which have the frame once more
        header = ",".join(name if name not in names[:at] else "" for at, name in enumerate(names))
        stream = map(track_arrays.blank_infinite, stream)
    mark = track_columns.find_separator(header)
    skipped = islice(stream, more) if more else ()
    blank = ["\n"] * (titled + len(list(skipped)))
    if mark in (",", ""):
        yield from chain([header], blank, stream)
        return
    for at, line in enumerate(chain([header], blank, stream), 1):
        if "," in line:
            raise InputError(
                f"{path}:{at}: a comma seen in {safe_text.shorten_line(line.strip())[:40]!r}: {columns.SEPARATOR_HINT}"
            )
        cells = line.split() if mark == " " else line.rstrip("\n").split(mark)
        if mark == " " and 0 < len(cells) < len(header.split()):
            words = f"{len(cells)} words, the header has {len(header.split())}"
            raise InputError(f"{path}:{at}: {words}: separate cells by commas where names hold spaces or cells nothing")
        yield ",".join(cells) + "\n"


def _from_columns(path: Path, names: list[str], lane: bool, titled: bool) -> Source:
    """Return the rows of a table whose columns name their contents."""
    try:
        named = track_columns.find_columns(names)
    except InputError as error:
        raise InputError(f"{path}: {error.text}") from None
    several = track_columns.coordinate_pairs(names)
    if several and "x" not in named:
        if {*several} in track_columns.BOX_LABELS[("particle" not in named) :]:
            corners = ", ".join(name for pair in several.values() for name in pair)
            raise InputError(
                f"{path}: {safe_text.shorten_line(corners)[:60]} are corners of boxes; give their middles as x and y"
            )
        return _from_pairs(path, named, several, titled)
    program, y_down = _detect_program(names, named, titled)
    # A walker in a plane that is upright has a pitch, and y is its height
    lane = lane or (program == WALKERGEN_PROGRAM and "theta_rad" not in names)
    for what in ("x",) if lane else ("x", "y"):
        if what not in named:
            raise track_columns.missing_column_error(path, names, what)
    clock = next((what for what in ("frame", "time") if what in named), None)
    if clock is None:
        raise track_columns.missing_column_error(path, names, "time")
    below = 0
    if program == "TrackMate":
        below, named = _read_units_below(path, names, named)
    if program == WALKERGEN_PROGRAM:
        clock = "time"
    if program == "Tracker" and "time" in named:
        named |= {"time": named["time"]._replace(unit=named["time"].unit or "s")}
    wanted = (clock, "x", *(() if lane else ("y",)))
    unread = (*wanted, "y", "theta") if lane else wanted
    optional = {what: each.name for what, each in named.items() if what not in unread}
    own = SCALE_COLUMNS if program == WALKERGEN_PROGRAM else (CLUSTER_COLUMN,) if program == "MTrackJ" else ()
    optional |= {name: name for name in ("plate_speed_mm_s", *own)}
    words_of: dict[str, list[str]] = {}
    label = optional.get("particle", "")
    if labels := _read_labels(path, titled, below, label):
        words_of = {optional.pop("particle"): labels}
    required = {what: named[what].name for what in wanted}
    lines = _table_lines(path, titled, below)
    table = columns.read_numbers(path, list(required.values()), list(optional.values()), words_of, lines)
    held = required | optional | dict.fromkeys(("particle",)[: len(words_of)], label)
    values = {what: table.values[name] for what, name in held.items() if name in table.values}
    said = (*_program_warnings(program), *track_columns.format_labels(labels))
    if (clusters := values.pop(CLUSTER_COLUMN, None)) is not None:
        said += (_renumber_clusters(values, clusters),)
    return Source(table._replace(values=values), named, program, y_down, program in MIRRORED_PROGRAMS, said)


def _renumber_clusters(values: dict[str, Array], clusters: Array) -> str:
    """Renumber walkers across all clusters of MTrackJ, which count their own tracks, and return a note."""
    pairs = np.stack([clusters, values["particle"]], axis=1)
    known = np.isfinite(pairs).all(axis=1)
    of_each, numbers = np.unique(pairs[known], axis=0, return_inverse=True)
    values["particle"] = np.full(len(clusters), np.nan)
    values["particle"][known] = numbers.ravel()
    named = ", ".join(f"{at} TID {track:g} of CID {cluster:g}" for at, (cluster, track) in enumerate(of_each[:6]))
    return f"walkers are numbered: {named}{', ...' if len(of_each) > 6 else ''}"


def _program_warnings(program: str) -> tuple[str, ...]:
    if program == "TRex":
        return ("TRex's cm are such only where its cm_per_pixel was set: else give ‹unit=›px and ‹mm_per_px›",)
    return ()


def _detect_program(names: Sequence[str], named: Mapping[str, NamedColumn], titled: bool) -> tuple[str, bool]:
    """Return the program that writes such columns, and whether its y counts downward."""
    held = set(names)
    if {"t_s", "x_mm"} <= held and "y" not in named:
        return WALKERGEN_PROGRAM, False
    for program, own in (
        (WALKERGEN_PROGRAM, {"t_s", "x_mm", "theta_rad"}),
        (WALKERGEN_PROGRAM, {"t_s", "x_mm", "pitch_rad"}),
        ("TrackMate", {"POSITION_X", "TRACK_ID"}),
        ("TRex", {"X#wcentroid (cm)"}),
        ("TRex", {"X (cm)", "missing"}),
        ("FastTrack", {"xBody", "imageNumber"}),
        ("MTrackJ", {"TID", "PID"}),
        ("idtracker.ai", {"frame", "time", "individual", "probability"}),
        ("idtracker.ai", {"trajectories1", "trajectories2"}),
    ):
        if own <= held:
            return program, program != WALKERGEN_PROGRAM
    return ("Tracker", False) if titled else ("", False)


def _read_labels(path: Path, titled: bool, below: int, name: str) -> list[str]:
    """Return the labels of walkers in the column of this name, if they are no numbers."""
    if not name:
        return []
    labels = columns.distinct_texts(_table_lines(path, titled, below), str(path), name)
    return labels if any(map(_is_word, labels)) else []


def _is_word(label: str) -> bool:
    try:
        float(label)
    except ValueError:
        return label.lower() not in NO_TRACK_LABELS
    return False


def _read_units_below(
    path: Path, names: list[str], named: dict[str, NamedColumn]
) -> tuple[int, dict[str, NamedColumn]]:
    """Return TrackMate's lines below the header that are no rows, and its columns with the units of the last one."""
    lines = islice(file_reading.read_lines(path, columns.FORMAT_NAME), 1, 4)
    rows = [columns.split_cells(line, str(path), at) for at, line in enumerate(lines, 2)]
    place = names.index("POSITION_X")
    count = next((at for at, row in enumerate(rows) if place < len(row) and _is_number(row[place])), len(rows))
    if not count:
        return 0, named
    unit_row = rows[count - 1]
    units = {
        what: track_columns.canonical_unit(unit_row[names.index(each.name)].strip("() "))
        for what, each in named.items()
        if names.index(each.name) < len(unit_row)
    }
    known = {what: unit for what, unit in units.items() if unit in track_columns.UNITS_BY_COLUMN.get(what, ())}
    return count, {what: each._replace(unit=known.get(what, "")) for what, each in named.items()}


def _is_number(text: str) -> bool:
    return words.parse_number(text.strip()) is not None


def _from_pairs(
    path: Path, named: Mapping[str, NamedColumn], several: Mapping[str, tuple[str, str]], titled: bool
) -> Source:
    """Convert a table with one row a frame, and columns of x and y for every walker."""
    clock = next((what for what in ("frame", "time") if what in named), "")
    wide = [name for pair in several.values() for name in pair]
    table = columns.read_numbers(path, [named[clock].name] if clock else (), wide, lines=_table_lines(path, titled))
    times = table.values[named[clock].name] if clock else (table.lines - table.lines.min()).astype(float)
    by_program = all(label.isdigit() for label in several)
    said = track_columns.format_labels(()) if by_program else track_columns.format_labels(tuple(several))
    if not clock:
        said += ("rows are taken for frames, one after the other",)
    walkers = [(table.values[x], table.values[y]) for x, y in several.values()]
    numbers = [float(label) for label in several] if by_program else [float(n) for n in range(len(several))]
    long = track_columns.to_long_table(table, clock or "frame", times, walkers, numbers)
    unit = track_columns.PIXEL if by_program else ""
    own = {"x": NamedColumn(wide[0], unit), "y": NamedColumn(wide[1], unit)}
    own[clock or "frame"] = named[clock] if clock else NamedColumn("row", "")
    return Source(long, own, "idtracker.ai" if by_program else "", by_program, said=said)
