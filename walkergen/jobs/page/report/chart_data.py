"""What a family's chart shows beside its members, read back from speed.csv."""

from typing import NamedTuple

from walkergen.errors import InputError
from walkergen.files import words
from walkergen.jobs.page.report.contents import Contents

TABLE = "speed.csv"
WHATS = ("predicted", "measured", "paper")
BOUNDS = ("speed_low_68_mm_s", "speed_high_68_mm_s", "speed_low_95_mm_s", "speed_high_95_mm_s")
MOST_ROWS = 10_000
LARGEST = 1e9
"""Largest number that a chart has room for."""


class Speed(NamedTuple):
    """Speed at a tilt: predicted, measured, or the one that the paper states."""

    what: str
    legs: str
    tilt_deg: float
    speed_mm_s: float
    bounds: tuple[float, float, float, float] | None
    """Lower and upper bound of 68 %, then of 95 %, mm/s; None where they are unknown."""
    theory_mm_s: float | None
    """Speed by the theory; None but with a predicted one."""
    sticks: bool
    """True where a foot can stick, so that the paper's formula fails."""


def of(contents: Contents) -> list[Speed]:
    """Rows of speed.csv in its order; none where the folder has no such file.

    Raises InputError when a row is not as `family` writes it.
    """
    if TABLE not in contents.files:
        return []
    rows = contents.records(TABLE).rows
    if len(rows) > MOST_ROWS:
        raise InputError(f"{TABLE}: {len(rows)} rows; a page shows {MOST_ROWS} at most")
    return [_speed(row, line) for line, row in rows]


def _speed(row: dict[str, str], line: int) -> Speed:
    what, legs = row.get("what", ""), row.get("legs", "")
    if what not in WHATS:
        raise InputError(f"{TABLE}:{line}: what: must be {', '.join(WHATS)}, not {what[:40]!r}")
    if legs not in ("flexible", "braced"):
        raise InputError(f"{TABLE}:{line}: legs: must be flexible or braced, not {legs[:40]!r}")
    tilt, speed = (_number(row, name, line) for name in ("tilt_deg", "speed_mm_s"))
    if tilt is None or speed is None:
        raise InputError(f"{TABLE}:{line}: tilt_deg, speed_mm_s: a number is missing")
    low68, high68, low95, high95 = (_number(row, name, line) for name in BOUNDS)
    bounds = None
    if low68 is not None and high68 is not None and low95 is not None and high95 is not None:
        bounds = low68, high68, low95, high95
    return Speed(what, legs, tilt, speed, bounds, _number(row, "theory_mm_s", line), row.get("foot_can_stick") == "yes")


def _number(row: dict[str, str], column: str, line: int) -> float | None:
    """Number in a cell; None in a blank one. Raises InputError."""
    text = row.get(column, "")
    if not text:
        return None
    value = words.value(text)
    if value is None or abs(value) > LARGEST:
        raise InputError(f"{TABLE}:{line}: {column}: must be a number within ±{LARGEST:g}, not {text[:40]!r}")
    return value
