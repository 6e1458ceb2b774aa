"""Files of tracks in the formats of many programs, read into one form: a row for each walker in each frame.

A table whose columns name their contents is read directly, from any program. Other layouts, by program:
TrackMate (tables of spots, XML of spots or of tracks), DeepLabCut (three or four lines of names),
SLEAP's analysis table, idtracker.ai (columns x1, y1, x2, y2 and so on), MTrackJ (.mdf), Tracker of Open
Source Physics (a line with the tracks' names above the table), and files of arrays (`track_arrays`).

In a `lane` no y is needed. A `titled` table has a line above its header.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain, islice
from pathlib import Path

import numpy as np

from walkergen.analysis import pose_tables, track_arrays, track_columns, track_xml, tracker_tables
from walkergen.analysis.track_columns import SCALE_COLUMNS, WALKERGEN_PROGRAM, NamedColumn, Source
from walkergen.core.errors import InputError
from walkergen.core.files import columns, safe_text
from walkergen.core.files import formatting as words
from walkergen.core.numerics import Array

NO_TRACK_LABELS = ("none", "ø")
"""Texts that TrackMate writes instead of a track's number for a spot without a track."""

TREX_COLUMNS = ("X#wcentroid (cm)", "X (cm)")
"""Columns of TRex's tables, of the body and of its head."""

TREX_NOTE = "TRex's cm are such only where its cm_per_pixel was set: else give ‹unit=›px and ‹mm_per_px›"

CLUSTER_COLUMN = "CID"
"""Column of MTrackJ's clusters of tracks."""

MIRRORED_PROGRAMS = ("FastTrack",)
"""Programs whose headings count counterclockwise though their y goes down (FastTrack's tracking.cpp)."""


def read_source(path: Path, lane: bool) -> Source:
    """Read the rows of a file of tracks in any format. Raises InputError."""
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
    clocked = any(map(track_columns.has_clock_time, head[1:]))
    if "frame_idx" in names:
        pose_tables.check_table_kind(path, names)
        if any(name.endswith(".x") for name in names):
            return pose_tables.read_sleap(path, names)
    source = _from_columns(path, names, lane, titled)
    if not clocked or "time" not in source.named:
        return source
    return source._replace(named={**source.named, "time": source.named["time"]._replace(unit="s")})


def _text_lines(path: Path) -> Iterator[str]:
    """Return the lines of a table, whether its columns are text or arrays."""
    return track_arrays.npz_lines(path) or track_columns.read_text(path)


def _table_lines(path: Path, titled: bool, skip: int = 0) -> Iterator[str]:
    """Yield the lines of a table as those of a CSV file. Raises InputError for commas in other tables' cells.

    A title and the `skip` lines below the header become blank lines, so that lines keep their numbers.
    """
    stream: Iterator[str] = map(track_columns.clock_to_seconds, _text_lines(path))
    if titled:
        next(stream)
    header = next(stream, "")
    if any(name in header for name in TREX_COLUMNS):
        names = header.split(",")  # TRex writes the column frame twice
        header = ",".join(name if name not in names[:at] else "" for at, name in enumerate(names))
        stream = (track_arrays.INFINITE_PATTERN.sub("", line) for line in stream)
    separator = track_columns.find_separator(header)
    skipped = islice(stream, skip) if skip else ()
    blank = ["\n"] * (titled + len(list(skipped)))
    if separator in (",", ""):
        yield from chain([header], blank, stream)
        return
    for at, line in enumerate(chain([header], blank, stream), 1):
        if "," in line:
            raise InputError(
                f"{path}:{at}: {safe_text.shorten_line(line.strip())[:40]!r} has a decimal comma. "
                "Write a decimal point, as 0.04."
            )
        cells = line.split() if separator == " " else line.rstrip("\n").split(separator)
        if separator == " " and 0 < len(cells) < len(header.split()):
            words = f"{len(cells)} words, the header has {len(header.split())}"
            raise InputError(f"{path}:{at}: {words}. For names with spaces or empty cells, separate cells by commas.")
        yield ",".join(cells) + "\n"


def _from_columns(path: Path, names: list[str], lane: bool, titled: bool) -> Source:
    """Return the rows of a table whose column `names` state their contents. `titled`: a title is above the header."""
    try:
        named = track_columns.find_columns(names)
    except InputError as error:
        raise InputError(f"{path}: {error.text}") from None
    several = track_columns.coordinate_pairs(names)
    if several and "x" not in named:
        # Labels 1 and 2 are walkers unless a column `particle` numbers these.
        if {*several} in track_columns.BOX_LABELS[("particle" not in named) :]:
            corners = ", ".join(name for pair in several.values() for name in pair)
            raise InputError(
                f"{path}: {safe_text.shorten_line(corners)[:60]} are corners of boxes. Give their middles as x and y"
            )
        return _from_pairs(path, named, several, titled)
    program, y_down = _detect_program(names, named, titled)
    # A walker in a plane that is upright has a pitch, and y is its height
    lane = lane or (program == WALKERGEN_PROGRAM and "theta_rad" not in names)
    for kind in ("x",) if lane else ("x", "y"):
        if kind not in named:
            raise track_columns.missing_column_error(path, names, kind)
    clock = next((kind for kind in ("frame", "time") if kind in named), None)
    if clock is None:
        raise track_columns.missing_column_error(path, names, "time")
    unit_line_count = 0
    if program == "TrackMate":
        unit_line_count, named = _read_units_below(path, names, named)
    if program == WALKERGEN_PROGRAM:
        clock = "time"
    if program == "Tracker" and "time" in named:
        named |= {"time": named["time"]._replace(unit=named["time"].unit or "s")}
    wanted = (clock, "x", *(() if lane else ("y",)))
    unread = (*wanted, "y", "theta") if lane else wanted
    optional = {kind: column.name for kind, column in named.items() if kind not in unread}
    program_columns = (
        SCALE_COLUMNS if program == WALKERGEN_PROGRAM else (CLUSTER_COLUMN,) if program == "MTrackJ" else ()
    )
    optional |= {name: name for name in ("plate_speed_mm_s", *program_columns)}
    words_of: dict[str, list[str]] = {}
    label = optional.get("particle", "")
    if labels := _read_labels(path, titled, unit_line_count, label):
        words_of = {optional.pop("particle"): labels}
    required = {kind: named[kind].name for kind in wanted}
    lines = _table_lines(path, titled, unit_line_count)
    table = columns.read_numbers(path, list(required.values()), list(optional.values()), words_of, lines)
    names_by_kind = required | optional | dict.fromkeys(("particle",)[: len(words_of)], label)
    values = {kind: table.values[name] for kind, name in names_by_kind.items() if name in table.values}
    notes = (*((TREX_NOTE,) if program == "TRex" else ()), *track_columns.format_labels(labels))
    if (clusters := values.pop(CLUSTER_COLUMN, None)) is not None:
        notes += (_renumber_clusters(values, clusters),)
    return Source(table._replace(values=values), named, program, y_down, program in MIRRORED_PROGRAMS, notes)


def _renumber_clusters(values: dict[str, Array], clusters: Array) -> str:
    """Replace `values["particle"]` in place by numbers unique in all of MTrackJ's `clusters`. Return a note."""
    pairs = np.stack([clusters, values["particle"]], axis=1)
    known = np.isfinite(pairs).all(axis=1)
    tracks, numbers = np.unique(pairs[known], axis=0, return_inverse=True)
    values["particle"] = np.full(len(clusters), np.nan)
    values["particle"][known] = numbers.ravel()
    shown = ", ".join(f"{at} TID {track:g} of CID {cluster:g}" for at, (cluster, track) in enumerate(tracks[:6]))
    return f"walkers are numbered: {shown}{', ...' if len(tracks) > 6 else ''}"


def _detect_program(names: Sequence[str], by_kind: Mapping[str, NamedColumn], titled: bool) -> tuple[str, bool]:
    """Return the program that writes columns of these names, and whether its y counts downward."""
    present = set(names)
    if {"t_s", "x_mm"} <= present and "y" not in by_kind:
        return WALKERGEN_PROGRAM, False
    for program, its_columns in (
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
        if its_columns <= present:
            return program, program != WALKERGEN_PROGRAM
    return ("Tracker", False) if titled else ("", False)


def _read_labels(path: Path, titled: bool, skip: int, name: str) -> list[str]:
    """Return the labels of walkers in the column `name`; [] if they are numbers. `skip`: lines below the header."""
    if not name:
        return []
    labels = columns.distinct_texts(_table_lines(path, titled, skip), str(path), name)
    return labels if any(map(_is_word, labels)) else []


def _is_word(label: str) -> bool:
    """Return whether a label is a word: neither a number nor in NO_TRACK_LABELS."""
    try:
        float(label)
    except ValueError:
        return label.lower() not in NO_TRACK_LABELS
    return False


def _read_units_below(
    path: Path, names: list[str], by_kind: dict[str, NamedColumn]
) -> tuple[int, dict[str, NamedColumn]]:
    """Return the number of TrackMate's lines between header and rows, and its columns with the units stated there."""
    lines = islice(track_columns.read_text(path), 1, 4)
    rows = [columns.split_cells(line, str(path), at) for at, line in enumerate(lines, 2)]
    index = names.index("POSITION_X")
    count = next((at for at, row in enumerate(rows) if index < len(row) and _is_number(row[index])), len(rows))
    if not count:
        return 0, by_kind
    unit_row = rows[count - 1]
    units = {
        kind: track_columns.canonical_unit(unit_row[names.index(column.name)].strip("() "))
        for kind, column in by_kind.items()
        if names.index(column.name) < len(unit_row)
    }
    known = {kind: unit for kind, unit in units.items() if unit in track_columns.UNITS_BY_COLUMN.get(kind, ())}
    return count, {kind: column._replace(unit=known.get(kind, "")) for kind, column in by_kind.items()}


def _is_number(text: str) -> bool:
    return words.parse_number(text.strip()) is not None


def _from_pairs(
    path: Path, by_kind: Mapping[str, NamedColumn], pairs: Mapping[str, tuple[str, str]], titled: bool
) -> Source:
    """Read a table with one row a frame, and `pairs` of columns x and y by the label of each walker."""
    clock = next((kind for kind in ("frame", "time") if kind in by_kind), "")
    names = [name for pair in pairs.values() for name in pair]
    table = columns.read_numbers(path, [by_kind[clock].name] if clock else (), names, lines=_table_lines(path, titled))
    times = table.values[by_kind[clock].name] if clock else (table.lines - table.lines.min()).astype(float)
    has_numbers = all(label.isdigit() for label in pairs)
    notes = track_columns.format_labels(()) if has_numbers else track_columns.format_labels(tuple(pairs))
    if not clock:
        notes += ("rows are taken for frames, one after the other",)
    walkers = [(table.values[x], table.values[y]) for x, y in pairs.values()]
    numbers = [float(label) for label in pairs] if has_numbers else [float(n) for n in range(len(pairs))]
    long = track_columns.to_long_table(table, clock or "frame", times, walkers, numbers)
    unit = track_columns.PIXEL if has_numbers else ""
    named = {"x": NamedColumn(names[0], unit), "y": NamedColumn(names[1], unit)}
    named[clock or "frame"] = by_kind[clock] if clock else NamedColumn("row", "")
    return Source(long, named, "idtracker.ai" if has_numbers else "", has_numbers, notes=notes)
