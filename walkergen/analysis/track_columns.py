"""Columns of tables of tracks, recognized by the names that programs and people use, with the units in them."""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from datetime import date
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.files import columns, file_reading, safe_text
from walkergen.core.files.columns import Columns
from walkergen.core.numerics import Array

TRACKS_COLUMN = "tracks"
"""Column with a file of tracks instead of a speed, relative to the folder of the file of speeds."""

PIXEL = "px"
"""Unit of places in a picture. --mm-per-px gives its size."""

LENGTH_UNITS_MM: Mapping[str, float] = MappingProxyType({"um": 1e-3, "mm": 1.0, "cm": 10.0, "m": 1e3, "in": 25.4})
"""Units of places, mm."""

TIME_UNITS_S: Mapping[str, float] = MappingProxyType({"us": 1e-6, "ms": 1e-3, "s": 1.0, "min": 60.0})
"""Units of times, s."""

ANGLE_UNITS_RAD: Mapping[str, float] = MappingProxyType({"rad": 1.0, "deg": math.radians(1.0)})
"""Units of headings, rad."""

UNIT_SPELLINGS: Mapping[str, str] = MappingProxyType(
    dict.fromkeys(("µm", "μm", "micron", "microns"), "um")
    | dict.fromkeys(("pixel", "pixels"), PIXEL)
    | dict.fromkeys(("sec", "second", "seconds"), "s")
    | dict.fromkeys(("degree", "degrees", "°"), "deg")
    | {"inch": "in", "frames": "frame", "radians": "rad"}
)
"""Other spellings of units, as programs have them."""

PLACE_NAMES = (
    *("{}_wcentroid", "{}", "position_{}", "pos_{}", "{}_pos", "pos{}"),
    *("{}_position", "{}body", "centroid_{}", "{}_coord"),
)
"""Names of columns of places along an axis; TRex's of the body is before that of its head."""

COLUMN_NAMES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "frame": ("frame", "frames", "frame_idx", "frame_number", "frame_id", "imagenumber", "slice", "slice_n"),
        "time": ("time", "t", "seconds", "position_t"),
        # The last is idtracker.ai's, of one animal
        "x": (*(name.format("x") for name in PLACE_NAMES), "trajectories1"),
        "y": (*(name.format("y") for name in PLACE_NAMES), "trajectories2"),
        "theta": ("theta", "angle", "heading", "orientation", "tbody"),
        "particle": ("particle", "track_id", "trackid", "individual", "tid", "track", "track_n", "id", "object_id"),
    }
)
"""Names of columns by their contents, in small letters with _ between words; the first one found is used."""

UNITS_BY_COLUMN: Mapping[str, Sequence[str]] = MappingProxyType(
    {
        "time": (*TIME_UNITS_S, "frame"),
        "x": (*LENGTH_UNITS_MM, PIXEL),
        "y": (*LENGTH_UNITS_MM, PIXEL),
        "theta": tuple(ANGLE_UNITS_RAD),
    }
)
"""Units that a column of a kind may have."""

AXIS_FIRST_PATTERN, AXIS_LAST_PATTERN = r"(?P<axis>[xy])[ _]?(?P<label>\w+)", r"(?P<label>.+)[ _.](?P<axis>[xy])"
"""Names of columns of one walker among several: its axis, and its label."""

BOX_LABELS = ({"1", "2"}, {"min", "max"})
"""Labels of the corners of boxes around walkers, which have a column of their numbers."""

MAX_LABELS = 6
"""Maximum number of walkers whose labels are listed with their numbers."""

MAX_SHOWN_LETTERS = 80
"""Letters of a file's columns that a message shows."""

WALKERGEN_PROGRAM = "walkergen"
"""Program whose own columns are t_s and x_mm, in its own units."""

SCALE_COLUMNS = ("mm_per_px", "mm_per_px_se")
"""Columns of a film's scale and its standard error, the same in all rows of a film."""

CLOCK_PATTERN = re.compile(
    r"(?<![^,;\t\" ])(?:(\d{4}-\d\d-\d\d)[T ])?(?:(\d+):)?(\d{1,2}):(\d{1,2}(?:\.\d+)?)Z?(?=[,;\t\"\s]|$)"
)
"""Time of day in a cell, such as 00:00:01.040, with or without a date or hours."""


class NamedColumn(NamedTuple):
    """Column of a file."""

    name: str
    """Its name in the file."""
    unit: str
    """Unit that the name states; "" without one."""


class Source(NamedTuple):
    """Rows of a file, and its units and axes."""

    table: Columns
    """Columns frame, time, x, y, theta, particle, plate_speed_mm_s and SCALE_COLUMNS, if the file has them."""
    named: Mapping[str, NamedColumn]
    """Names of the columns in the file, and the units that they state."""
    program: str = ""
    """Program that wrote the file; "" if unknown."""
    y_down: bool = False
    """True if that program counts y downward, as rows of a picture."""
    mirrored: bool = False
    """True if the program counts headings counterclockwise on the picture, though y goes down."""
    notes: tuple[str, ...] = ()
    """Notes on how the file was read, as text."""


def read_text(path: Path) -> Iterator[str]:
    """Yield the lines of a table. Units such as µm may be in code page 1252."""
    return file_reading.read_lines(path, columns.FORMAT_NAME, errors=file_reading.CODE_PAGE)


def has_clock_time(line: str) -> bool:
    """Return whether a line has a time of day in a cell."""
    return bool(CLOCK_PATTERN.search(line))


def clock_to_seconds(line: str) -> str:
    """Replace times of day in a line by seconds."""
    return CLOCK_PATTERN.sub(_to_seconds, line) if ":" in line else line


def _to_seconds(clock: re.Match[str]) -> str:
    """Return the seconds of a time of day, matched by CLOCK_PATTERN, as text; with a date, from the year 1 on."""
    days = date.fromisoformat(clock[1]).toordinal() if clock[1] else 0
    return f"{((24 * days + int(clock[2] or 0)) * 60 + int(clock[3])) * 60 + float(clock[4]):.9f}"


def find_columns(names: Sequence[str]) -> dict[str, NamedColumn]:
    """Find the columns of a file by their names; return them by kind (frame, time, x, ...).

    Raises InputError for two columns of headings with different units.
    """
    candidates: dict[str, list[tuple[int, NamedColumn]]] = {}
    for name in names:
        for kind, rank, unit in _possible_kinds(name):
            candidates.setdefault(kind, []).append((rank, NamedColumn(name, unit)))
    if len(candidates.get("theta", [])) > 1 and {"theta", "theta_deg"} <= set(names):
        raise InputError("both theta (rad) and theta_deg. Keep one")
    # Of names of equal rank take the one that states a unit other than pixels
    return {
        kind: min(found, key=lambda ranked: (ranked[0], ranked[1].unit in ("", PIXEL)))[1]
        for kind, found in candidates.items()
    }


def _possible_kinds(name: str) -> list[tuple[str, int, str]]:
    """List what a column may hold by its name: kind, rank of the name among those of the kind, and unit."""
    text = name.strip().lower()
    with_unit = re.fullmatch(r"(.*?)\s*[(\[]([^)\]]*)[)\]]", text)
    word, unit = with_unit.groups() if with_unit else (text, "")
    word = re.sub(r"[^a-z0-9]+", "_", word).strip("_")
    if not with_unit and "_" in word and canonical_unit(word.rpartition("_")[2]):
        word, _, unit = word.rpartition("_")
    unit = "s" if word == "seconds" else canonical_unit(unit)
    return [
        (kind, known.index(word), unit)
        for kind, known in COLUMN_NAMES.items()
        if word in known and (not unit or unit in UNITS_BY_COLUMN.get(kind, ()))
    ]


def canonical_unit(text: str) -> str:
    """Return the short name of a unit, such as mm; "" for a text that is no unit."""
    unit = UNIT_SPELLINGS.get(text.strip().lower(), text.strip().lower())
    return unit if unit in (*LENGTH_UNITS_MM, *TIME_UNITS_S, *ANGLE_UNITS_RAD, PIXEL, "frame") else ""


def find_separator(line: str) -> str:
    """Return the mark between the cells of a line; "" if there is one cell."""
    return next((mark for mark in ",\t; " if mark in line.strip()), "")


def coordinate_pairs(names: Sequence[str]) -> dict[str, tuple[str, str]]:
    """Return the names of the x and y column of each walker by its label, for rows with all walkers of a frame.

    Such columns are called x1 and y1, X_left and Y_left, or left_x and left_y.
    """
    found: dict[str, dict[str, str]] = {}
    for name in names:
        match = re.fullmatch(AXIS_FIRST_PATTERN, name, re.IGNORECASE) or re.fullmatch(
            AXIS_LAST_PATTERN, name, re.IGNORECASE
        )
        if match and not find_columns([name]):
            found.setdefault(match["label"], {})[match["axis"].lower()] = name
    return {label: (axes["x"], axes["y"]) for label, axes in found.items() if len(axes) == 2}


def missing_column_error(path: object, names: Sequence[str], kind: str) -> InputError:
    """Return the error for a file without a column of a kind (x, y or time); `names` are its columns."""
    rename = {"x": "x_mm, x_cm or x_px", "y": "y_mm, y_cm or y_px", "time": "t_s, or frame where it counts frames"}
    seen = safe_text.shorten_line(", ".join(name for name in names if name))
    dots = "" if len(seen) < MAX_SHOWN_LETTERS else " ..."
    return InputError(
        f"{path}: no column {kind!r}. Rename the one that holds it to {rename[kind]} (seen: "
        f"{seen[:MAX_SHOWN_LETTERS]}{dots}); "
        "walkergen analyse --help lists the formats"
    )


def format_labels(labels: Sequence[str]) -> tuple[str, ...]:
    """Return the note on the numbers that walkers with labels get; () without labels."""
    if not labels:
        return ()
    some = ", ".join(
        f"{number} {safe_text.shorten_line(label)[:30]}" for number, label in enumerate(labels[:MAX_LABELS])
    )
    return (f"walkers are numbered: {some}{', ...' if len(labels) > MAX_LABELS else ''}",)


def to_long_table(
    table: Columns, clock: str, times: Array, walkers: Sequence[tuple[Array, ...]], numbers: Sequence[float]
) -> Columns:
    """Return a table with a row for each walker in each frame, from arrays by frame.

    `walkers`: x, y and, for all or none, theta of each; `numbers`: their numbers. `clock` ("frame" or "time") is the
    column for `times`. `table` has a row for each frame, and gives the lines and the bad rows.
    """
    parts: dict[str, list[Array]] = {clock: [], "particle": [], "x": [], "y": [], "theta": []}
    lines = []
    for number, (x, y, *theta) in zip(numbers, walkers, strict=True):
        seen = np.isfinite(x) & np.isfinite(y)
        for name, column in ((clock, times), ("x", x), ("y", y), ("particle", np.full(len(x), float(number)))):
            parts[name].append(column[seen])
        parts["theta"] += [angles[seen] for angles in theta]
        lines.append(table.lines[seen])
    values = {name: np.concatenate(arrays) for name, arrays in parts.items() if arrays}
    return Columns(values, np.concatenate(lines), table.bad)
