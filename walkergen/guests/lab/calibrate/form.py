"""Form of measurements: measurements.csv, one row per reading, written empty and read when filled.

Columns: part; measured, the quantity with its unit; reading; error, the standard deviation of that reading, in its
unit; unloaded_mm, weight_g and at_mm, which some quantities also need. Rows of one part and quantity are tries; any
number is allowed. A column tracks may name the tracks.csv of a slide's film, in the form's folder; filmed_deg needs it.
"""

import math
import os
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from walkergen.core import Quantity
from walkergen.core.errors import InputError
from walkergen.core.files import columns, config, formatting, output
from walkergen.core.files import file_reading as reading
from walkergen.core.files.tables import csv_text

FORM_FILE = "measurements.csv"
CONDITION_COLUMNS = ("unloaded_mm", "weight_g", "at_mm")
HEADER = ("part", "measured", "reading", "error", *CONDITION_COLUMNS)
TRACKS_COLUMN = "tracks"
"""Optional column of a form: the name of a file of tracks in the form's folder."""
MAX_BYTES, MAX_ROWS = 1_000_000, 2000


class Kind(NamedTuple):
    """Kind of reading: what its row may contain."""

    error: float
    """Error of a reading with ordinary means, which the empty form proposes."""
    max_value: float
    """Largest value; a larger one suggests a wrong unit."""
    rows: int
    """Rows of the empty form."""
    required_columns: tuple[str, ...] = ()
    """Columns needed in addition to its reading."""
    optional_columns: tuple[str, ...] = ()
    """Columns that it may have."""
    min_value: float = 0.0
    """Value that it must exceed."""
    slip: str = ""
    """Question to the user if the value is out of range."""


SLIDE_KIND = Kind(1.0, 80.0, 6, min_value=2.0, slip=". Is it a friction? Write the angle: a friction of 0.25 is 14 deg")
"""Angle at which a part slides. Below 2 degrees is a friction of 0.035: no plastic on a solid."""

FILMED_ANGLE = "filmed_deg"
"""Angle of an incline on which a part was filmed as it slid; needs the film's tracks."""

AIR_SHARE = "air_percent"
"""Share of a strip's cross-section, in percent, that its lines leave open: round sides, and gaps between lines. The
empty form contains the printer's value. Air lowers the mass that rings."""

SLIDING_KINDS = {"slides_deg": SLIDE_KIND, FILMED_ANGLE: SLIDE_KIND._replace(rows=0)}
STRIP_KINDS = {
    "thickness_mm": Kind(0.02, 20.0, 3),
    "width_mm": Kind(0.05, 100.0, 2),
    "free_length_mm": Kind(0.5, 1000.0, 1),
    "deflection_mm": Kind(0.5, 1000.0, 6, ("unloaded_mm", "weight_g", "at_mm")),
    "swings_20_s": Kind(0.01, 1000.0, 3, (), ("weight_g",)),
    "ring_hz": Kind(0.2, 1e5, 1, (), ("weight_g",)),
    "swings_to_half": Kind(1.0, 1e4, 2, min_value=0.5),
    AIR_SHARE: Kind(2.0, 60.0, 1, min_value=-1.0),
}
BLOCK_KINDS = {
    "mass_g": Kind(0.01, 1e4, 2),
    **{name: Kind(0.05, 1000.0, 2) for name in ("length_mm", "width_mm", "height_mm")},
    **SLIDING_KINDS,
}
WALKER_KINDS = {**SLIDING_KINDS, "flight_s": Kind(0.002, 2.0, 6, ("at_mm",))}

MIN_ERROR = 1e-6
"""Smallest error of a reading, in its unit."""


class Reading(NamedTuple):
    """Mean of readings of one kind under one condition."""

    number: Quantity
    """Mean of the tries. Its standard error is the larger of the one from their scatter and the stated one."""
    stated: float
    """Standard error of the mean from the stated errors of the tries."""
    tries: int
    scatter: float | None
    """Standard deviation of the tries; None for a single try."""
    weight_g: float = 0.0
    at_mm: float = 0.0
    tracks: Path | None = None
    """File of the film's tracks; None without a film."""


class _Condition(NamedTuple):
    """Part, quantity and conditions that tries to be averaged have in common."""

    part: str
    name: str
    weight_g: float
    at_mm: float
    tracks: str


Readings = Mapping[str, Mapping[str, Sequence[Reading]]]
"""Mean readings by part and kind, one for each condition."""


def reading_kinds(part: str) -> Mapping[str, Kind] | None:
    """Return the kinds of readings of a part by its name: strip_1, block, walker; None for other names."""
    stem, _, number = part.partition("_")
    if stem == "strip" and columns.parse_count(number, 99) is not None:
        return STRIP_KINDS
    return {"block": BLOCK_KINDS, "walker": WALKER_KINDS}.get(part)


def empty_form(air: Mapping[str, float]) -> str:
    """Return the text (CSV) of an empty form for strips, block and walker, with proposed errors.

    `air` maps each strip to its share of air in percent, filled in already.
    """
    lines: list[tuple[object, ...]] = []
    for part in (*air, "block", "walker"):
        for name, kind in (reading_kinds(part) or {}).items():
            reading = f"{air[part]:.1f}" if name == AIR_SHARE else ""
            lines += [(part, name, reading, kind.error, "", "", "")] * kind.rows
    return csv_text(HEADER, lines)


def is_filled(path: Path) -> bool:
    """Return whether a file exists that differs from every empty form, so that it must not be overwritten."""
    if not os.path.lexists(path):
        return False
    try:
        air = {row["part"]: float(row["reading"]) for _, row in _read_rows(path) if row["measured"] == AIR_SHARE}
        return reading.read_bytes(path, MAX_BYTES) != empty_form(air).encode()
    except (InputError, ValueError):
        return True  # a file with any other content was written by a person


def write_empty_form(path: Path, air: Mapping[str, float]) -> bool:
    """Write `empty_form(air)` unless a person filled one in, and return whether it was written. Raises OutputError."""
    if is_filled(path):
        return False
    output.write(path, empty_form(air).encode())
    return True


def read_form(path: Path) -> Readings:
    """Read a filled form; rows without a reading are left out.

    Tries under one condition are averaged: the error of their mean is the larger of the stated error and their scatter,
    over the root of their number. Raises InputError, a line for every mistake.
    """
    rows = _read_rows(path)
    if len(rows) > MAX_ROWS:
        raise InputError(f"{path}: {len(rows)} rows. At most {MAX_ROWS} are allowed")
    tries: dict[_Condition, list[tuple[float, float]]] = defaultdict(list)
    problems = []
    for line, row in rows:
        try:
            if triple := _parse_row(row):
                key, value, error = triple
                tries[key].append((value, error))
        except InputError as problem:
            problems.append(f"{path}:{line}: {problem}")
    if problems:
        raise config.mistakes_error(problems, path)
    if not any(condition.name != AIR_SHARE for condition in tries):
        raise InputError(f"{path}: no readings. Fill in the column reading of at least one row")
    readings: dict[str, dict[str, list[Reading]]] = defaultdict(lambda: defaultdict(list))
    for condition, pairs in tries.items():
        film = path.parent / condition.tracks if condition.tracks else None
        readings[condition.part][condition.name].append(_mean_reading(condition, pairs, film))
    return {part: dict(by_kind) for part, by_kind in readings.items()}


def _read_rows(path: Path) -> list[tuple[int, dict[str, str]]]:
    """Return the rows as line number and cells by column. Raises InputError for other columns."""
    table = columns.parse_records(reading.read_lines(path, columns.FORMAT_NAME, MAX_BYTES), str(path))
    remedy = ": start from the form that walkergen calibrate plate writes"
    columns.check_names(table.names, path, HEADER, (TRACKS_COLUMN,), remedy)
    return table.rows


def _parse_row(row: Mapping[str, str]) -> tuple[_Condition, float, float] | None:
    """Return condition, value and error of a row; None without a reading. Raises InputError."""
    part, name = row["part"].strip(), row["measured"].strip()
    measurable = reading_kinds(part)
    if measurable is None:
        raise InputError(f"part {part[:40]!r}: must be strip_1, strip_2 ..., block or walker")
    if name not in measurable:
        raise InputError(f"measured {name[:40]!r}: must be one of {', '.join(measurable)} for {part}")
    if not row["reading"].strip():
        return None
    kind = measurable[name]
    conditions = {column: _parse_condition(row[column].strip(), column, name, kind) for column in CONDITION_COLUMNS}
    film = row.get(TRACKS_COLUMN, "").strip()
    if film and name != FILMED_ANGLE:
        raise InputError(f"{name} does not use the column {TRACKS_COLUMN}. Leave it blank.")
    if name == FILMED_ANGLE and not film:
        raise InputError(f"{name} needs the column {TRACKS_COLUMN}: the tracks.csv of the slide's film")
    value, what = _parse_number("reading", row["reading"], 1e5, allow_zero=True), "reading"
    is_difference = "unloaded_mm" in kind.required_columns
    if is_difference:
        value, what = abs(value - conditions["unloaded_mm"]), "reading less unloaded_mm"  # a ruler stands either way up
    if not kind.min_value < value <= kind.max_value:
        raise InputError(
            f"{name}: {what} = {value:g}: must be > {kind.min_value:g} and <= {kind.max_value:g}{kind.slip}"
        )
    for column in kind.required_columns:
        if column != "unloaded_mm" and conditions[column] <= 0.0:
            raise InputError(f"{column} = {conditions[column]:g}: must be > 0")
    if not row["error"].strip():
        raise InputError(f"{name}: error is blank. Write the standard deviation of a reading, such as {kind.error:g}")
    error = _parse_number("error", row["error"], 1e5)
    error *= math.sqrt(2.0) if is_difference else 1.0  # both readings have this error
    return _Condition(part, name, conditions["weight_g"], conditions["at_mm"], film), value, error


def _parse_condition(cell: str, column: str, name: str, kind: Kind) -> float:
    """Parse the cell of a column in the row of the reading `name`, or return 0 if it is blank. Raises InputError."""
    if cell and column not in kind.required_columns + kind.optional_columns:
        raise InputError(f"{column} = {cell[:30]!r}: {name} does not use this column. Leave it blank.")
    if not cell and column in kind.required_columns:
        raise InputError(f"{column} is blank. Fill it in: {name} needs it.")
    return _parse_number(column, cell, 1e5, allow_zero=True) if cell else 0.0


def _parse_number(name: str, cell: str, largest: float, allow_zero: bool = False) -> float:
    """Parse a number of MIN_ERROR (or 0, if `allow_zero`) up to `largest`, called `name` in messages."""
    value = formatting.parse_number(cell)
    smallest = 0.0 if allow_zero else MIN_ERROR
    if value is None or not smallest <= value <= largest:
        raise InputError(f"{name} = {cell.strip()[:30]!r}: must be a number >= {smallest:g} and <= {largest:g}")
    return value


def _mean_reading(condition: _Condition, pairs: Sequence[tuple[float, float]], film: Path | None) -> Reading:
    """Return the mean of tries (value, error), weighted by their errors. `film`: tracks of the slide, None without."""
    values, errors = np.array(pairs).T
    weights = errors**-2 / (errors**-2).sum()
    stated = float((errors**-2).sum() ** -0.5)
    scatter = float(values.std(ddof=1)) if len(values) > 1 else None
    error = stated if scatter is None else max(stated, scatter / math.sqrt(len(values)))
    number = Quantity(condition.name, "", float(weights @ values), error)
    return Reading(number, stated, len(values), scatter, condition.weight_g, condition.at_mm, film)
