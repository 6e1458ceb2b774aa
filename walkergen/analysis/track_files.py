"""Tracks of walkers from files: tables of places at times, in the units that they state or that are given.

Units are part of the names of columns (x_mm, "X (cm)", t_s, "time [ms]", theta_deg) or are given (--unit mm,deg; --fps,
--mm-per-px). A missing unit is an error. walkergen's own columns are t_s, x_mm and y_mm. With theta_rad, the heading
from x toward y_mm, the walker moves in space, seen from above. Without it y_mm is vertical, in a lane. All may have
`particle` and `plate_speed_mm_s`, the plate's peak speed while the particle ran.

`source` has a file's rows and the units that it states, `units` the options of the command line, `given` those of
--unit.
"""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from walkergen.analysis import lost_frames, sampling, track_columns, track_formats
from walkergen.analysis.track_columns import (
    ANGLE_UNITS_RAD,
    LENGTH_UNITS_MM,
    PIXEL,
    SCALE_COLUMNS,
    TIME_UNITS_S,
    WALKERGEN_PROGRAM,
    Source,
)
from walkergen.analysis.tracks import Track, Tracks
from walkergen.core.errors import InputError
from walkergen.core.files import formatting, safe_text
from walkergen.core.files.columns import Columns

MIN_UNIT, MAX_UNIT = 1e-6, 1e9
"""Limits of frames per second, and of millimetres in a pixel."""

MAX_RATE_ERROR = 1e-3
"""Relative difference of frame rates up to which files are of one recording."""

MAX_TURN_RAD = 2.0 * math.pi + 1e-3
"""Heading, rad, beyond which a column without a unit may hold degrees: one full turn."""


class Units(NamedTuple):
    """Units and axes of a file, as the command line gives them."""

    fps: float | None = None
    """Frames per second of a film."""
    mm_per_px: float | None = None
    y_down: bool = False
    """True when y grows downward in the file, as rows of an image do."""
    lane: bool = False
    """True when the walkers ran along a lane in x, so that y is ignored."""
    mm_per_px_se: float | None = None
    """Standard error of `mm_per_px`; None if unknown."""
    unit: str = ""
    """Units of places, times and headings that the file does not state, as "mm" or "cm,ms,deg"."""


class _Given(NamedTuple):
    """Units that --unit gives; None for each that is missing there."""

    length: str | None
    time: str | None
    angle: str | None


def read_tracks(path: Path, units: Units) -> Tracks:
    """Read the tracks of a file, with NaN for positions in lost and in repeated frames.

    Raises InputError when columns or units are missing or contradict each other, when no row is
    usable, or when times do not lie on a regular grid. Bad rows are left out and named in `note`,
    which also explains how columns were interpreted.
    """
    return lost_frames.drop(_read_with_lost_frames(path, units))


def read_recording(paths: Sequence[Path], units: Units) -> Tracks:
    """Read several files as tracks of one recording with one clock. Raises InputError as `read_tracks`."""
    films = [read_tracks(path, units) for path in paths]
    if len(films) == 1:
        return films[0]
    interval, origin = min(film.interval for film in films), min(film.first_s for film in films)
    unique = len({path.stem for path in paths}) == len(paths)
    tracks: list[Track] = []
    names = {}
    for path, film in zip(paths, films, strict=True):
        stride = round(film.interval / interval)
        if film.lane != films[0].lane or abs(film.interval / interval - stride) > MAX_RATE_ERROR * stride:
            raise InputError(
                f"{path}: has a sample every {1e3 * film.interval:.4g} ms, and another file every "
                f"{1e3 * interval:.4g} ms: files of one recording need one frame rate. Analyse them one by one."
            )
        late = round((film.first_s - origin) / interval)
        for track in film.tracks:
            name = safe_text.shorten_line(path.stem if unique else str(path))
            names[len(tracks)] = name if len(film.tracks) == 1 else f"{name} {track.particle}"
            spread = track.spread(stride * np.arange(len(track.position)))
            tracks.append(spread._replace(particle=len(tracks), start=track.start * stride + late))
    notes = [f"{len(films)} files are taken as one recording with the same clock", *(film.note for film in films)]
    errors = [film.scale_se for film in films]
    return Tracks(
        tuple(tracks),
        interval,
        sum(film.bad_rows for film in films),
        "; ".join(dict.fromkeys(note for note in notes if note)),
        None if None in errors else max(error or 0.0 for error in errors),
        origin,
        names,
    )


def _read_with_lost_frames(path: Path, units: Units) -> Tracks:
    """Read the tracks of a file, lost and repeated frames included. Raises InputError as `read_tracks`."""
    given = _parse_units(units.unit)
    source = track_formats.read_source(path, units.lane)
    if source.program == WALKERGEN_PROGRAM:
        return _read_walkergen(path, source, units)
    _check_same_units(path, source, given)
    clock, has_times, notes = _choose_clock(path, source, units, given)
    length, lengths = _mm_per_unit(path, source, units, given)
    values = dict(source.table.values)
    y_sign = -1.0 if source.y_down or units.y_down else 1.0
    values["x"] = length * values["x"]
    if units.lane:
        values = {name: column for name, column in values.items() if name not in ("y", "theta")}
    else:
        values["y"] = y_sign * length * values["y"]
        notes += (_describe_y_axis(source, units),)
        if "theta" in values:
            angle, angles = _rad_per_unit(path, source, given)
            values["theta"] = (1.0 if source.mirrored else y_sign) * angle * values["theta"]
            notes += (angles,)
    table = source.table._replace(values=values)
    if has_times:
        values["time"] = clock * values["time"]
        table = table.reject_rows(np.isnan(values["time"]), "has no time")
        tracks = sampling.from_times(path, table, source.named["time"].name)
    else:
        values.setdefault("frame", values.get("time", np.zeros(0)))
        tracks = sampling.from_frames(path, table, clock)
    error = units.mm_per_px_se
    share = None if error is None or units.mm_per_px is None else error / units.mm_per_px
    program = (f"taken for a file of {source.program}",) if source.program else ()
    lines = [tracks.note, *program, *source.notes, lengths, *notes]
    return tracks._replace(scale_se=share if units.mm_per_px else 0.0, note="; ".join(line for line in lines if line))


def _parse_units(text: str) -> _Given:
    """Parse a text such as "cm,ms,deg". Raises InputError for an unknown unit, and for two of a kind."""
    units: dict[str, str] = {}
    for word in filter(None, (word.strip() for word in text.split(","))):
        unit = track_columns.canonical_unit(word)
        kinds = (("length", (*LENGTH_UNITS_MM, PIXEL)), ("time", (*TIME_UNITS_S, "frame")), ("angle", ANGLE_UNITS_RAD))
        kind = next((kind for kind, known in kinds if unit in known), "")
        if not kind or kind in units:
            raise InputError(
                f"‹unit=›{safe_text.shorten_line(text)[:40]}: must be a unit of positions "
                f"({', '.join((*LENGTH_UNITS_MM, PIXEL))}), of times "
                f"({', '.join((*TIME_UNITS_S, 'frame'))}), of headings ({', '.join(ANGLE_UNITS_RAD)}), or "
                "one of each, as cm,deg",
                "unit",
            )
        units[kind] = unit
    return _Given(units.get("length"), units.get("time"), units.get("angle"))


def _read_walkergen(path: Path, source: Source, units: Units) -> Tracks:
    """Read a file that walkergen wrote: of a walker seen from above, with a heading, or of one in a lane."""
    headed = "y" in source.table.values
    if units.y_down:
        y = "has y to the left of x" if headed else "is of a walker in a lane, and has no y"
        raise InputError(f"‹y_down›: {path} {y}. Leave out ‹y_down›")
    for field, value in (("fps", units.fps), ("mm_per_px", units.mm_per_px), ("unit", units.unit or None)):
        if value is not None:
            shown = value if isinstance(value, str) else f"{value:g}"
            raise InputError(f"‹{field}=›{shown}: {path} has its own t_s and x_mm. Leave out ‹{field}›")
    tracks = sampling.from_times(path, source.table, "t_s")
    return tracks._replace(scale_se=_scale_se(path, source.table))


def _check_same_units(path: Path, source: Source, given: _Given) -> None:
    """Raise InputError for given units that contradict those in the names of columns."""
    for kind, unit, known in (
        ("x", given.length, LENGTH_UNITS_MM),
        ("time", given.time, TIME_UNITS_S),
        ("theta", given.angle, ANGLE_UNITS_RAD),
    ):
        named = source.named.get(kind)
        if named and unit in known and named.unit in known and unit != named.unit:
            raise InputError(f"‹unit=›{unit}: {path} has its own {named.name} in {named.unit}. Leave out ‹unit›")


def _choose_clock(path: Path, source: Source, units: Units, given: _Given) -> tuple[float, bool, tuple[str, ...]]:
    """Choose times or frames. Return seconds per unit of time and True, or frames per second and False; and notes."""
    frames = "frame" in source.table.values
    named = source.named.get("time")
    unit = given.time or (named.unit if named else "")
    times = source.table.values.get("time")
    counted = times is not None and bool((times == np.rint(times))[np.isfinite(times)].all())
    if times is None or not np.isfinite(times).any() or unit == "frame":
        return _frame_rate(path, source, units), False, ()
    if frames and units.fps is not None:
        notes = () if named is None else (f"times are those of frames by ‹fps›, not of {named.name}",)
        return _frame_rate(path, source, units), False, notes
    assert named is not None
    if counted and not unit:
        if units.fps is None and not frames:  # frames are written twice if the rate is unknown
            raise InputError(
                f"{path}: {named.name} holds whole numbers without a unit. Give ‹unit=›s (or ms), or ‹fps› "
                "where it counts frames"
            )
        return _frame_rate(path, source, units), False, () if frames else (f"{named.name} is taken to count frames",)
    if units.fps is not None:
        raise InputError(f"‹fps=›{units.fps:g}: {path} has its own {named.name}. Leave out ‹fps›")
    return TIME_UNITS_S[unit or "s"], True, () if unit else (f"{named.name} is taken as seconds",)


def _frame_rate(path: Path, source: Source, units: Units) -> float:
    """Return the given frames per second of a file that counts frames. Raises InputError without them."""
    if units.fps is None:
        pixels = units.mm_per_px is None and source.named["x"].unit in ("", PIXEL) and not units.unit
        more = " and pixels. Give ‹fps› and ‹mm_per_px› (or ‹unit=›mm if these are mm)" if pixels else ". Give ‹fps›"
        raise InputError(f"{path}: counts frames{more}")
    return _check_range("fps", units.fps)


def _check_range(field: str, value: float) -> float:
    """Return the value of a field if it is within the limits. Raises InputError."""
    if not MIN_UNIT <= value <= MAX_UNIT:
        raise InputError(f"‹{field}=›{value:g}: must be a number in {MIN_UNIT:g}..{MAX_UNIT:g}")
    return value


def _mm_per_unit(path: Path, source: Source, units: Units, given: _Given) -> tuple[float, str]:
    """Return the millimetres of a unit of the positions, and a note on the unit. Raises InputError if it is unknown."""
    named, across = source.named["x"], source.named.get("y")
    if across is not None and {named.unit, across.unit} - {""} and named.unit != across.unit and not units.lane:
        raise InputError(f"{path}: {named.name} and {across.name} are of different units. Give both one")
    unit = given.length or named.unit
    by_frame = "time" not in source.table.values
    if unit in LENGTH_UNITS_MM:
        if units.mm_per_px is not None:
            raise InputError(
                f"‹mm_per_px=›{units.mm_per_px:g}: {path} has its own {named.name} in {unit}. Leave out ‹mm_per_px›"
            )
        origin = "by ‹unit›" if given.length else f"as {named.name} says"
        return LENGTH_UNITS_MM[unit], f"places are in {unit}, {origin}"
    if units.mm_per_px is not None:
        return _check_range("mm_per_px", units.mm_per_px), ""
    if unit == PIXEL or (by_frame and not unit):
        raise InputError(
            f"{path}: counts pixels. Give ‹mm_per_px›, the millimetres per pixel (or ‹unit=›mm if x and y are in mm)"
        )
    raise InputError(
        f"{path}: {named.name} has no unit. Give ‹unit=›mm (or cm, m, in), or ‹mm_per_px› for pixels"
        + ("; Pogotrack's files are in cm and degrees: ‹unit=›cm,deg" if "theta" in source.table.values else "")
    )


def _rad_per_unit(path: Path, source: Source, given: _Given) -> tuple[float, str]:
    """Return the radians of a unit of the headings, and a note on the unit. Raises InputError if it is unknown."""
    named = source.named.get("theta")
    unit = given.angle or (named.unit if named else "rad")
    if unit:
        return ANGLE_UNITS_RAD[unit], ""
    assert named is not None
    largest = float(np.nanmax(np.abs(source.table.values["theta"]), initial=0.0))
    if largest > MAX_TURN_RAD and _is_not_radians(source.table):
        raise InputError(
            f"{path}: {named.name} has no unit and reaches {formatting.format_number(largest, 4)}, more than a "
            "turn in radians. "
            "Give ‹unit=›deg or ‹unit=›rad (with that of positions: ‹unit=›mm,deg), or call it theta_deg or theta_rad"
        )
    return 1.0, f"{named.name} is taken as radians{', whole turns counted' if largest > MAX_TURN_RAD else ''}"


def _is_not_radians(table: Columns) -> bool:
    """Return whether headings cannot be radians, which start within a turn, in steps of at most half a turn."""
    particle = table.values.get("particle", np.zeros(len(table.lines)))
    order = np.lexsort((table.values.get("frame", table.values.get("time", table.lines)), particle))
    order = order[~np.isnan(table.values["theta"][order])]
    theta, same = table.values["theta"][order], np.diff(particle[order]) == 0
    first = theta[np.append(True, ~same)]
    return bool((np.abs(first) > MAX_TURN_RAD).any() or (np.abs(np.diff(theta))[same] > 0.5 * MAX_TURN_RAD).any())


def _describe_y_axis(source: Source, units: Units) -> str:
    """Describe the direction that was taken for y."""
    if source.y_down:
        return f"y counts rows downward, as {source.program} does: turned over"
    if units.y_down:
        return "y counts rows downward, by ‹y_down›: turned over"
    if source.program:
        return f"y grows upward, as in {source.program}"
    return "y is taken to grow upward: for rows of a picture give ‹y_down›, which reverses the sign of turning"


def _scale_se(path: Path, table: Columns) -> float | None:
    """Return the largest relative error of a file's scale; 0 for a simulation, None if a row does not give it."""
    if not set(SCALE_COLUMNS) <= set(table.values):
        return 0.0
    scale, error = (table.values[name] for name in SCALE_COLUMNS)
    if (scale <= 0).any() or (error < 0).any():
        raise InputError(f"{path}: mm_per_px must be > 0 and mm_per_px_se >= 0, or blank")
    share = float(np.max(error / scale))
    return None if math.isnan(share) else share
