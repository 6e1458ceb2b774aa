"""Quantities as text: a value with its error, unit and bounds, or the reason why it is missing."""

from collections import Counter
from collections.abc import Callable, Iterable
from typing import Any

from walkergen.core.files import formatting
from walkergen.core.numerics.quantity import UNIT_SYMBOLS, Quantity
from walkergen.files.report import Column


def format_name(number: Quantity) -> str:
    """Return the name of a quantity as text."""
    return number.key.replace("_", " ")


def format_unit(number: Quantity) -> str:
    """Return the unit of a quantity as text."""
    return UNIT_SYMBOLS.get(number.unit, number.unit)


def format_value(number: Quantity, unit: str = "") -> str:
    """Format a value with its error and unit, or the reason why there is no error or no value."""
    if number.value is None:
        return number.refused
    if number.se is not None:
        return f"{formatting.format_with_error(number.value, number.se)} {unit}".rstrip()
    reason = f": {number.refused}" if number.refused else ""
    return f"{formatting.format_number(number.value)} ± ? {unit}".rstrip() + reason


def format_bounds(number: Quantity) -> str:
    """Format the bounds of 95 % to two digits of the error; "" without bounds."""
    bounds = number.interval()
    return " to ".join(formatting.format_to_error(number.se, bounds)) if bounds and number.se else ""


def columns(number_of: Callable[[Any], Quantity]) -> tuple[Column, Column, Column, Column]:
    """Return columns of a quantity's name, unit, value with error, and bounds. `number_of` returns a row's quantity."""
    return (
        Column("", lambda row: format_name(number_of(row))),
        Column("", lambda row: format_unit(number_of(row))),
        Column("value ± standard error", lambda row: format_value(number_of(row))),
        Column("95 %", lambda row: format_bounds(number_of(row))),
    )


def mark_reasons(numbers: Iterable[Quantity]) -> tuple[list[Quantity], dict[str, str]]:
    """Replace each reason for a missing value that several quantities share by a mark such as (a).

    Return the changed quantities, and the reasons by mark.
    """
    listed = list(numbers)
    shared = [reason for reason, count in Counter(number.refused for number in listed).items() if reason and count > 1]
    marks = {reason: f"({letter})" for reason, letter in zip(shared, "abcdefgh", strict=False)}
    marked = [number._replace(refused=marks.get(number.refused, number.refused)) for number in listed]
    return marked, {mark: reason for reason, mark in marks.items()}
