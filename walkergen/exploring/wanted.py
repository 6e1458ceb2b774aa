"""Errors that a person can bear, as they are written: 5% or 3mm/s."""

import math
import re
from typing import NamedTuple

from walkergen.errors import InputError


class Wanted(NamedTuple):
    """Error that a person can bear, with 95 % confidence."""

    value: float
    relative: bool
    """True when the value is a share of the mean speed, False when it is in mm/s."""

    def __str__(self) -> str:
        return f"{100 * self.value:g} %" if self.relative else f"{self.value:g} mm/s"


def parse(text: str) -> Wanted:
    """Parse "5%" or "3mm/s". Raises InputError."""
    found = re.fullmatch(r"\s*([0-9.eE+-]+)\s*(%|mm/s)\s*", text)
    try:
        value = float(found[1]) if found else math.nan
    except ValueError:
        value = math.nan
    if found is None or not 0 < value < math.inf:
        raise InputError(f"--error {text[:30]!r}: write a positive share or speed, 5% or 3mm/s")
    relative = found[2] == "%"
    if relative and not value <= 100:
        raise InputError(f"--error {text[:30]!r}: at most 100 %")
    return Wanted(0.01 * value if relative else value, relative)
