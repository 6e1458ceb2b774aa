"""Acceptable errors in the form that a user writes: 5% or 3mm/s."""

from typing import NamedTuple

from walkergen.core.errors import InputError
from walkergen.core.files import formatting

UNITS = {"%": (1e-6, 100.0), "mm/s": (1e-6, 1e6)}
"""Units of errors, with the smallest and the largest accepted number."""


class Tolerance(NamedTuple):
    """Acceptable error: the largest half-width of a 95 % interval."""

    value: float
    relative: bool
    """True when the value is a share of the mean speed, False when it is in mm/s."""

    def __str__(self) -> str:
        return f"{100 * self.value:g} %" if self.relative else f"{self.value:g} mm/s"


def parse_tolerance(text: str) -> Tolerance:
    """Parse an error such as "5%" or "3mm/s". Raises InputError for other text, and for numbers outside `UNITS`."""
    unit = next((unit for unit in UNITS if text.rstrip(" ").endswith(unit)), "")
    value = formatting.parse_number(text.rstrip(" ").removesuffix(unit))
    if not unit or value is None or value <= 0.0:
        raise InputError(f"‹error=›{text[:30]!r}: write a share or a speed over 0, such as 5% or 3mm/s")
    relative = unit == "%"
    low, high = UNITS[unit]
    if not low <= value <= high:
        raise InputError(f"‹error=›{text[:30]!r}: must lie in {low:g}..{high:g} {unit}")
    return Tolerance(0.01 * value if relative else value, relative)
