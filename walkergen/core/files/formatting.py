"""Numbers, spans and times as readable text, without exponents if possible."""

import math
import re
from collections.abc import Sequence

ZERO_BELOW = 1e-12
"""Size below which a number is zero to people: rounding, in every unit that is printed."""

MIN_WITHOUT_EXPONENT, MAX_WITHOUT_EXPONENT = 1e-6, 1e7
"""Sizes between which a number is written without an exponent."""

MAX_DECIMALS = 6
"""Largest number of decimals of a value with its error; beyond it has an exponent."""

NUMBER_PATTERN = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")


def is_number(value: object) -> bool:
    """Return whether a value is a number, and not a boolean."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def format_number(value: float, digits: int = 3) -> str:
    """Format a number with `digits` significant digits: 260, not 2.6e+02. Only far from 1 it has an exponent."""
    if abs(value) < ZERO_BELOW:
        return "0"
    text = f"{value:.{digits}g}"
    if "e" not in text or not MIN_WITHOUT_EXPONENT <= abs(value) < MAX_WITHOUT_EXPONENT:
        return text
    decimals = max(digits - 1 - math.floor(math.log10(abs(float(text)))), 0)
    return f"{float(text):.{decimals}f}"


def format_fixed(value: float, digits: int) -> str:
    """Format a number with `digits` decimals, without a minus on zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def format_count(number: int, one: str, many: str) -> str:
    """Format a count with its noun: `one` is the singular and `many` the plural."""
    return f"{number} {one if number == 1 else many}"


def parse_number(text: str) -> float | None:
    """Return the finite number that a text in plain digits contains, zero without a sign, or None otherwise.

    Python accepts more: 1_0, digits of other scripts, nan, surrounding line ends.
    """
    parsed = float(text) if NUMBER_PATTERN.fullmatch(text.strip(" \t")) else math.nan
    return parsed + 0.0 if math.isfinite(parsed) else None


def format_with_error(value: float, se: float) -> str:
    """Format a value with its standard error, both to two digits of the error. An error of 0 is left out."""
    return " ± ".join(format_to_error(se, (value, se) if se > 0 else (value,)))


def format_to_error(error: float, values: Sequence[float]) -> list[str]:
    """Format values with the decimals that show two digits of `error`. If it is 0 or NaN, with four digits each."""
    if not error > 0:
        return [format_number(value, 4) for value in values]
    digits = max(1 - math.floor(math.log10(error)), 0)
    if digits > MAX_DECIMALS:
        return [format_number(value, 3 if abs(value) > error else 2) for value in values]
    return [f"{value:.{digits}f}" for value in values]


def format_range(low: float | None, high: float | None, digits: int = 4) -> str:
    """Format an interval, such as "1 to 2", with significant digits. None is an unknown end: "above 1"."""
    if low is None and high is None:
        return "any value"
    if low is None or high is None:
        end = low if high is None else high
        assert end is not None
        return f"{'above' if high is None else 'below'} {format_number(end, digits)}"
    return f"{format_number(low, digits)} to {format_number(high, digits)}"


def format_duration(seconds: float, digits: int = 2) -> str:
    """Format a time in s in a suitable unit, from us to years, with `digits` significant digits."""
    units = ((3.15576e7, "years"), (86_400.0, "days"), (3600.0, "h"), (60.0, "min"))
    for size, unit in units:
        if seconds >= 2.0 * size:
            return f"{format_number(seconds / size, digits)} {unit}"
    for size, unit in ((1.0, "s"), (1e-3, "ms")):
        if seconds >= size:
            return f"{format_number(seconds / size, digits)} {unit}"
    return f"{format_number(seconds / 1e-6, digits)} us"


def format_budget(seconds: float) -> str:
    """Format a time in s as a value of the option --budget, rounded up: 45s, 12min, 3h."""
    for limit, size, unit in ((120.0, 1.0, "s"), (7200.0, 60.0, "min")):
        if seconds <= limit:
            return f"{math.ceil(seconds / size)}{unit}"
    return f"{math.ceil(seconds / 3600.0)}h"
