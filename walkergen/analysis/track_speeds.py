"""Rows of a file of speeds that name tracks instead of a speed, and the speeds of these tracks.

A row represents one walker of the tracks, by its number in the column `particle`, or each of them, with speed and
standard error from `analyse`. If tracks are too short for errors, a row for all is their mean.
"""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from walkergen.analysis import motion, track_files, track_warnings, walls
from walkergen.analysis.track_columns import TRACKS_COLUMN
from walkergen.core.errors import InputError
from walkergen.core.files import columns, file_reading, safe_text
from walkergen.core.files.columns import Columns
from walkergen.core.numerics import Array
from walkergen.core.numerics.quantity import Quantity

PARTICLE_COLUMN = "particle"
"""Column of a walker in a file of tracks."""

SPEED_COLUMN, ERROR_COLUMN, PLATE_COLUMN = "speed_mm_s", "speed_se_mm_s", "plate_speed_mm_s"

MAX_FILES = 200
"""Largest number of files of tracks."""


class _Film(NamedTuple):
    """Walkers of a file of tracks."""

    path: Path
    speeds: dict[int, Quantity]
    """Speed of each single walker, mm/s, by its number."""
    mean: Quantity
    """Mean speed of all, mm/s."""
    plates: dict[int, float]
    """Peak speed of the plate by walker, mm/s; NaN if the file does not state it."""
    scale_se: float | None
    """Standard error of the scale as a share of it; None if unknown."""
    notes: list[str]
    """Doubts about its tracks, and what was done to its rows."""

    @property
    def name(self) -> str:
        """Name of the file, safe to show."""
        return safe_text.shorten_line(self.path.name)


class _Walker(NamedTuple):
    """Walker, or the mean of several, that a row of the file of speeds represents."""

    at: int
    """Index of that row in the table of usable rows."""
    film: _Film
    particles: tuple[int, ...]
    estimate: Quantity
    """Speed, mm/s."""

    @property
    def speed(self) -> float | None:
        """Speed, mm/s; None if the speed or its error is unknown."""
        return None if self.estimate.se is None else self.estimate.value

    @property
    def reason(self) -> str:
        """Reason why it has no speed, or no error of it."""
        return self.estimate.refused

    def error(self, row_count: int) -> float:
        """Return the standard error of the speed, mm/s, with the scale's error that this number of rows shares."""
        value, se = self.estimate.value, self.estimate.se
        assert value is not None
        assert se is not None
        return math.hypot(se, math.sqrt(row_count) * (self.film.scale_se or 0.0) * value)


def add_track_speeds(path: Path, table: Columns) -> tuple[Columns, tuple[str, ...]]:
    """Replace each row that names tracks by one row per walker, with its speed and standard error (mm/s).

    The second result has notes. The n walkers of a film share the error of its scale: each standard error includes it
    times sqrt(n), so that the error of their mean includes it once. Raises InputError for tracks that cannot be read,
    for rows that have a speed as well, and for a walker in two rows.
    """
    names = _track_names(path)
    has_tracks = np.array([int(line) in names for line in table.lines], bool)
    both = has_tracks & ~np.isnan(_column_or_nan(table, SPEED_COLUMN))
    if both.any():
        raise InputError(f"{path}:{table.lines[both][0]}: both {SPEED_COLUMN} and {TRACKS_COLUMN}: leave one blank")
    films: dict[str, _Film] = {}
    walkers: list[_Walker] = []
    for row in map(int, np.flatnonzero(has_tracks)):
        name = names[int(table.lines[row])]
        if name not in films:
            if len(films) == MAX_FILES:
                raise InputError(f"{path}: more than {MAX_FILES} files of tracks: split the file")
            films[name] = _read_film(path.parent / name)
        walkers += _row_walkers(films[name], row, _column_or_nan(table, PARTICLE_COLUMN)[row], path, table)
    _check_duplicates(path, walkers)
    known = [walker for walker in walkers if walker.speed is not None]
    joined = _join_rows(table.reject_rows(has_tracks, ""), table, known)
    bad = table.bad | _missing_speed_reasons(table, walkers, known)
    notes = [note for film in films.values() for note in _film_notes(film, walkers)]
    joined = joined._replace(bad=bad)
    return joined.reject_rows(
        np.isnan(joined.values[SPEED_COLUMN]), f"neither {SPEED_COLUMN} nor {TRACKS_COLUMN}"
    ), tuple(notes)


def _track_names(path: Path) -> dict[int, str]:
    """Return the names of files of tracks by the line that names them."""
    records = columns.parse_records(file_reading.read_lines(path, columns.FORMAT_NAME), str(path))
    cells = ((line, row[TRACKS_COLUMN].strip()) for line, row in records.rows)
    return {line: cell for line, cell in cells if cell}


def _column_or_nan(table: Columns, name: str) -> Array:
    """Return a column of a table; an array of NaN if the table does not have it."""
    return table.values.get(name, np.full(len(table.lines), np.nan))


def _read_film(path: Path) -> _Film:
    """Analyse a file of tracks. Return the speeds of its walkers, and notes on the tracks."""
    read = track_files.read_tracks(path, track_files.Units())
    measured = motion.analyse(read, found_walls=walls.find_walls(read))
    plates = {track.particle: math.nan if track.plate_speed is None else track.plate_speed for track in read.tracks}
    speeds = {walker.particle: walker.mean("speed") for walker in measured.walkers}
    mean = measured.estimates["speed"]
    notes = [
        *track_warnings.find_all(read),
        *measured.doubts,
        track_warnings.describe_scale_error(read.scale_se),
        read.note,
    ]
    return _Film(path, speeds, mean, plates, read.scale_se, [note for note in notes if note])


def _row_walkers(film: _Film, at: int, number: float, path: Path, table: Columns) -> Iterator[_Walker]:
    """Yield the walkers that row `at` of the table represents: the one with this `number`, or all if it is NaN."""
    single_walkers = [_Walker(at, film, (particle,), speed) for particle, speed in film.speeds.items()]
    if math.isnan(number):
        unknown = all(walker.speed is None for walker in single_walkers)
        if unknown and len(single_walkers) > 1 and film.mean.se is not None:
            yield _Walker(at, film, tuple(film.speeds), film.mean)
        else:
            yield from single_walkers
    elif number in film.speeds:
        yield _Walker(at, film, (int(number),), film.speeds[int(number)])
    else:
        seen = ", ".join(map(str, list(film.speeds)[:10]))
        more = " ..." if len(film.speeds) > 10 else ""
        raise InputError(
            f"{path}:{table.lines[at]}: {PARTICLE_COLUMN} = {number:g}: must be a walker of {film.name}: {seen}{more}"
        )


def _check_duplicates(path: Path, walkers: Sequence[_Walker]) -> None:
    """Raise InputError for the first walker that is listed in two rows."""
    seen: set[tuple[Path, int]] = set()
    for walker in walkers:
        for key in ((walker.film.path, particle) for particle in walker.particles):
            if key in seen:
                raise InputError(
                    f"{path}: walker {key[1]} of {walker.film.name} is in two rows: give each "
                    f"walker once, by the column {PARTICLE_COLUMN}"
                )
            seen.add(key)


def _join_rows(other_rows: Columns, table: Columns, walkers: Sequence[_Walker]) -> Columns:
    """Return the other rows, then a row for each of the walkers with the remaining cells of its row in the table."""
    at = np.array([walker.at for walker in walkers], np.int64)
    row_counts = [sum(other.film is walker.film for other in walkers) for walker in walkers]
    film_plates = np.array([walker.film.plates[walker.particles[0]] for walker in walkers])
    plate = _column_or_nan(table, PLATE_COLUMN)[at]
    new_columns = {
        SPEED_COLUMN: np.array([walker.speed for walker in walkers], float),
        ERROR_COLUMN: np.array([walker.error(count) for walker, count in zip(walkers, row_counts, strict=True)], float),
        PLATE_COLUMN: np.where(np.isnan(plate), film_plates, plate),
    }
    names = dict.fromkeys((*table.values, *new_columns))
    values = {
        name: np.append(_column_or_nan(other_rows, name), new_columns.get(name, _column_or_nan(table, name)[at]))
        for name in names
    }
    return Columns(values, np.append(other_rows.lines, table.lines[at]), {})


def _missing_speed_reasons(table: Columns, walkers: Sequence[_Walker], usable: Sequence[_Walker]) -> dict[int, str]:
    """Return by line why a row has no walker with a speed; `usable` walkers have one."""
    with_speed = {walker.at for walker in usable}
    without_speed = {walker.at: walker for walker in reversed(walkers) if walker.at not in with_speed}
    return {
        int(table.lines[at]): f"{walker.film.name}: no walker has a speed: {walker.reason}"
        for at, walker in without_speed.items()
    }


def _film_notes(film: _Film, walkers: Sequence[_Walker]) -> Iterator[str]:
    """Yield the notes on a film: its speeds, walkers left out, doubts, and the error of its scale."""
    film_walkers = [walker for walker in walkers if walker.film is film]
    refused = [walker for walker in film_walkers if walker.speed is None]
    means = [walker for walker in film_walkers if len(walker.particles) > 1]
    if means:
        reason = next(iter(film.speeds.values())).refused
        yield (
            f"{film.name}: the mean speed of {len(film.speeds)} walkers, one row: no walker's own "
            f"has an error: {reason}"
        )
    elif len(refused) < len(film_walkers):
        count = len(film_walkers) - len(refused)
        yield f"{film.name}: speeds of {count} walker{'' if count == 1 else 's'}, a row each"
    if 0 < len(refused) < len(film_walkers):
        which = ", ".join(str(walker.particles[0]) for walker in refused[:10])
        yield f"{film.name}: left out: walker {which}: {refused[0].reason}"
    yield from (f"{film.name}: {note}" for note in film.notes)
