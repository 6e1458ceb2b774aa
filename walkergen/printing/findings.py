"""Findings of the printability checks: what deviates from the drawing, its limit, a remedy."""

from typing import Literal, NamedTuple

Level = Literal["error", "warning", "advice"]

NOISE_MM = 1e-6
"""Largest error, mm, that sums of floats and rounding to micrometres may leave."""


class Finding(NamedTuple):
    """A deviation of the print from the drawing, with its limit and a remedy."""

    level: Level
    where: str
    """Name of the part, plate or printer."""
    what: str
    seen: float
    limit: float
    unit: str
    change: str


def new(level: Level, what: str, seen: float, limit: float, unit: str, change: str) -> Finding:
    """Finding whose place is not known yet."""
    return Finding(level, "", what, float(seen), float(limit), unit, change)
