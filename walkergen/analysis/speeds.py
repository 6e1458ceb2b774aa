"""Measured speeds of walkers against tilt, from a CSV file, or from the tracks that it names."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from walkergen.analysis.track_columns import TRACKS_COLUMN
from walkergen.core.errors import InputError
from walkergen.core.files import columns
from walkergen.core.numerics import Array
from walkergen.core.walker.limbs import KINDS, Kind

MAX_SPEEDS = 2000

MIN_VALUE_MM_S = 1e-6
"""Least error, and least speed of a plate, mm/s."""

MAX_VALUES = {"tilt_deg": 90.0, "speed_mm_s": 1e5, "speed_se_mm_s": 1e5, "plate_speed_mm_s": 1e6}
"""Largest absolute values that are accepted as measurements, by column."""

MIN_SPEED_RATIO, MAX_SPEED_RATIO = 0.005, 50.0
"""Limits of a file's largest speed over the plate's; beyond them its unit is another. Walkers have 0.05 to 3."""

PLATE_SPEED_TOLERANCE = 0.05
"""Relative difference within which plate speeds are equal: amplitudes are read to a few percent."""


class Measured(NamedTuple):
    """Measured speeds of walkers; arrays of shape (n,)."""

    tilt: Array
    """Tilts of the legs, deg."""
    legs: list[Kind]
    speed: Array
    """Measured speeds, mm/s."""
    se: Array | None
    """Standard errors of the speeds, mm/s; None when the file has none."""
    plate_speed: Array
    """Peak speed of the plate, mm/s."""
    bad: str
    """Rows that were left out, and why; "" when all are used."""
    of_films: tuple[str, ...] = ()
    """Notes on tracks that rows name."""

    @property
    def notes(self) -> list[str]:
        """Notes on the file: rows that were left out, then films."""
        return [note for note in (self.bad, *self.of_films) if note]


def read_speeds(path: Path, kind: Kind, plate_speed: float) -> Measured:
    """Read measured speeds from columns tilt_deg, speed_mm_s; optionally speed_se_mm_s, legs, plate_speed_mm_s.

    A row may name a file of tracks instead of a speed. `kind` of the legs and `plate_speed` (mm/s) are used
    where the file has none. Raises InputError.
    """
    optional = ("speed_se_mm_s", "plate_speed_mm_s")
    of_films: tuple[str, ...] = ()
    if TRACKS_COLUMN in columns.read_header(path):
        from walkergen.analysis import track_speeds

        more = (track_speeds.SPEED_COLUMN, track_speeds.PARTICLE_COLUMN)
        table = columns.read_numbers(path, ("tilt_deg",), (*optional, *more), {"legs": KINDS})
        table, of_films = track_speeds.add_track_speeds(path, table)
    else:
        table = columns.read_numbers(path, ("tilt_deg", "speed_mm_s"), optional, {"legs": KINDS})
    if len(table.lines) > MAX_SPEEDS:
        raise InputError(f"{path}: {len(table.lines)} speeds. At most {MAX_SPEEDS}: is it a film?")
    for name in optional:
        _check_positive(path, table, name)
    for name, most in MAX_VALUES.items():
        if name in table.values:
            beyond = np.abs(table.values[name]) > most
            table = table.reject_rows(beyond, f"{name} must lie within ±{most:g}")
    if "speed_se_mm_s" in table.values:
        blank = np.isnan(table.values["speed_se_mm_s"])
        if not blank.all():
            table = table.reject_rows(blank, "speed_se_mm_s is blank, unlike in other rows")
    if not len(table.lines):
        raise InputError(f"{path}: nothing to read: {columns.describe_bad_rows(table.bad)}")
    unknown = np.full(len(table.lines), np.nan)
    plate = table.values.get("plate_speed_mm_s", unknown)
    se = table.values.get("speed_se_mm_s")
    return Measured(
        table.values["tilt_deg"],
        [kind if np.isnan(code) else KINDS[int(code)] for code in table.values.get("legs", unknown)],
        table.values["speed_mm_s"],
        None if se is None or np.isnan(se).any() else se,
        np.where(np.isnan(plate), plate_speed, plate),
        columns.describe_bad_rows(table.bad),
        of_films,
    )


def _check_positive(path: Path, table: columns.Columns, name: str) -> None:
    """Raise InputError for the first number of a column below MIN_VALUE_MM_S, such as 0; NaN is allowed."""
    if name in table.values and (too_small := table.values[name] < MIN_VALUE_MM_S).any():
        first = int(np.argmax(too_small))
        raise InputError(
            f"{path}:{table.lines[first]}: {name} = {table.values[name][first]:g}: must be >= "
            f"{MIN_VALUE_MM_S:g}: write it in mm/s, or leave the column blank where it is not known"
        )


def check_units(path: Path, measured: Measured) -> None:
    """Raise InputError if speeds of walkers on flexible legs seem to have another unit or the wrong sign."""
    leaning = np.array([kind == "flexible" for kind in measured.legs]) & (measured.tilt != 0.0)
    if not leaning.any():
        return
    forward_speed = (np.sign(measured.tilt) * measured.speed)[leaning]
    error = np.zeros_like(forward_speed) if measured.se is None else measured.se[leaning]
    if (forward_speed < -2.0 * error).any() and not (forward_speed > 2.0 * error).any():
        raise InputError(
            f"{path}: speed_mm_s is never clearly above 0, but walkers run the way their "
            "legs lean. Is the film mirrored, or does x count the other way? Change the sign."
        )
    ratio = float(np.max(np.abs(forward_speed) / measured.plate_speed[leaning]))
    if not MIN_SPEED_RATIO <= ratio <= MAX_SPEED_RATIO:
        unit = "m/s" if ratio < MIN_SPEED_RATIO else "µm/s or pixels"
        raise InputError(
            f"{path}: speed_mm_s is at most {np.abs(forward_speed).max():.3g}, or {ratio:.2g} times the "
            f"plate's peak speed. It must be {MIN_SPEED_RATIO:g} to {MAX_SPEED_RATIO:g} times. Is it in {unit} "
            "instead of mm/s?"
        )


def select_plate_speed(measured: Measured, plate_speed: float) -> Measured:
    """Select the speeds measured on a plate with this peak speed (mm/s), within PLATE_SPEED_TOLERANCE."""
    same = np.abs(measured.plate_speed / plate_speed - 1.0) <= PLATE_SPEED_TOLERANCE
    away = int(np.count_nonzero(~same))
    left_out = f"{away} speeds at other plate speeds than {plate_speed:.3g} mm/s left out"
    notes = [measured.bad, left_out if away else ""]
    return measured._replace(
        tilt=measured.tilt[same],
        legs=[kind for kind, chosen in zip(measured.legs, same, strict=True) if chosen],
        speed=measured.speed[same],
        se=None if measured.se is None else measured.se[same],
        plate_speed=measured.plate_speed[same],
        bad="; ".join(note for note in notes if note),
    )
