"""Axes of a sweep: the values of each key, from lists, ranges, or samples between bounds."""

import datetime
import itertools
import math
import re
from collections.abc import Iterator, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from walkergen.core import InputError
from walkergen.core.files import assignments
from walkergen.core.files.config import MAX_INTEGER, MIN_MAGNITUDE
from walkergen.field_values import suggest_range

MAX_VALUES = 1_000_000
"""Largest number of values of an axis, and of samples."""

Method = Literal["sobol", "latin"]

NUMBER_PATTERN = re.compile(r"\s*[+-]?([0-9]+\.?[0-9]*|\.[0-9]+|inf|nan)([eE][+-]?[0-9]+)?\s*", re.IGNORECASE)


class Axis(NamedTuple):
    """Key that varies in a sweep, with its values in order."""

    key: str
    values: tuple[Any, ...]


class Span(NamedTuple):
    """Bounds between which a key is sampled."""

    key: str
    low: float
    high: float


class Sample(NamedTuple):
    """Random points within the spans, from a scrambled Sobol sequence or a Latin hypercube."""

    spans: tuple[Span, ...]
    samples: int
    """Number of points."""
    method: Method
    seed: int


class Space(NamedTuple):
    """All combinations of the axes' values, each with every sample. The values of the last axis vary fastest."""

    axes: tuple[Axis, ...]
    sample: Sample | None = None

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys that vary, axes before spans."""
        spans = self.sample.spans if self.sample else ()
        return (*(axis.key for axis in self.axes), *(span.key for span in spans))

    @property
    def point_count(self) -> int:
        """Number of points: values of all axes multiplied, times samples."""
        samples = self.sample.samples if self.sample else 1
        return math.prod((len(axis.values) for axis in self.axes), start=samples)

    def rows(self) -> Iterator[tuple[Any, ...]]:
        """Yield a tuple with the values of `keys` for each point."""
        grid = itertools.product(*(axis.values for axis in self.axes))
        if self.sample is None:
            yield from grid
            return
        samples = [tuple(row) for row in _sample_points(self.sample).tolist()]
        for row in grid:
            for sample in samples:
                yield row + sample


def parse(text: str) -> Axis | Span:
    """Parse KEY=VALUE, KEY=1,2,3 or KEY=FIRST:LAST:STEP as an axis, KEY=LOW:HIGH as a span. Raises InputError."""
    key, value = assignments.split_key_value(text)
    return from_text(key, value, f"‹set› {text[:60]!r}")


def from_text(key: str, value: str, source: str) -> Axis | Span:
    """Parse the axis or span of a key from the text after "KEY=". Raises InputError, which begins with `source`."""
    values: list[Any] = []
    pieces = _split_list(value)
    for piece in pieces:
        numbers = piece.split(":")
        ranged = 2 <= len(numbers) <= 3 and all(NUMBER_PATTERN.fullmatch(number) for number in numbers)
        if ranged and len(numbers) == 3:
            values += _range_values(numbers, source)
        elif ranged and len(pieces) == 1:
            return make_span(key, float(numbers[0]), float(numbers[1]), source)
        elif ranged:
            raise InputError(f"{source}: bounds LOW:HIGH cannot be part of a list. Write FIRST:LAST:STEP.")
        elif (advice := suggest_range(piece)) and not key.endswith(".text"):
            raise InputError(f"{source}: {piece!r} is not a number. {advice}")
        elif not piece.strip():
            raise InputError(f"{source}: the list has an empty value. Remove a comma.")
        else:
            values.append(assignments.parse_value(piece.strip()))
        if len(values) > MAX_VALUES:
            break
    return make_axis(key, values, source)


def make_axis(key: str, values: Sequence[Any], source: str) -> Axis:
    """Return the axis of a key with these values, each once. Raises InputError, which begins with `source`."""
    if not values:
        raise InputError(f"{source}: has no values. Write at least one.")
    if len(values) > MAX_VALUES:
        raise InputError(f"{source}: more than {MAX_VALUES} values. Use a larger step.")
    for value in values:
        if isinstance(value, float) and not math.isfinite(value):
            raise InputError(f"{source}: {value} is not finite. Write finite numbers.")
        if isinstance(value, (datetime.date, datetime.time)):
            raise InputError(f"{source}: {value} is a date or a time. Write a number or a text.")
    if not all(isinstance(value, (str, int, float)) for value in values):
        return Axis(key, tuple(values))
    # True equals 1, but is another value.
    unique = dict.fromkeys((isinstance(value, bool), value) for value in values)
    return Axis(key, tuple(value for _, value in unique))


def make_span(key: str, low: float, high: float, source: str) -> Span:
    """Return the span of a key. Raises InputError, which begins with `source`, unless low < high, both finite."""
    for end in (low, high):
        _parse_end(str(end), source)
    if not low < high:
        raise InputError(f"{source}: must be LOW:HIGH with LOW below HIGH.")
    return Span(key, low, high)


def check_keys(axes: Sequence[Axis | Span]) -> None:
    """Raise InputError for a key that is given twice."""
    keys = [entry.key for entry in axes]
    for key in keys:
        if keys.count(key) > 1:
            raise InputError(f"‹set› {key}: given {keys.count(key)} times. Write its values once.")


def _split_list(text: str) -> list[str]:
    """Split a text at its commas, except within brackets, braces and quotes."""
    parts, depth, quote = [""], 0, ""
    for letter in text:
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "\"'":
            quote = letter
        else:
            depth += (letter in "[{") - (letter in "]}")
        if letter == "," and not depth and not quote:
            parts.append("")
        else:
            parts[-1] += letter
    return parts


def _range_values(words: Sequence[str], source: str) -> list[float]:
    """Return the values of a range from its three texts FIRST, LAST and STEP, as int if all three are whole numbers."""
    first, last, step = (_parse_end(word, source) for word in words)
    if step == 0 or (last - first) / step < 0:
        sign = "positive" if first <= last else "negative"
        raise InputError(f"{source}: step {step:g} does not lead from {first:g} to {last:g}. Write a {sign} step.")
    if (last - first) / step > MAX_VALUES:
        raise InputError(f"{source}: more than {MAX_VALUES} values. Use a larger step.")
    count = int((last - first) / step * (1 + 1e-12)) + 1  # 0.3 / 0.1 lies below 3
    if all(re.fullmatch(r"\s*[+-]?[0-9]+\s*", word) for word in words):
        return [int(first) + number * int(step) for number in range(count)]
    # Rounded to what people write, so that 0:1:0.1 gives 0.3 and not 0.30000000000000004.
    digits = 13 - math.floor(math.log10(max(abs(first), abs(last), abs(step))))
    return [round(first + number * step, digits) + 0.0 for number in range(count)]


def _parse_end(word: str, source: str) -> float:
    """Parse an end or a step of a range. Raises InputError, which begins with `source`, if out of range."""
    value = float(word)
    if not math.isfinite(value):
        raise InputError(f"{source}: {word.strip()} cannot be the end of a range. Write finite numbers.")
    if value != 0.0 and not MIN_MAGNITUDE <= abs(value) <= MAX_INTEGER:
        raise InputError(
            f"{source}: {word.strip()[:30]} cannot be the end of a range. Write 0, or numbers in "
            f"±({MIN_MAGNITUDE:g}..{MAX_INTEGER:.3g})."
        )
    return value + 0.0


def _sample_points(sample: Sample) -> Any:
    """Draw random values within the spans, shape (samples, spans), rounded to the 9 digits that a table shows."""
    from scipy.stats import qmc

    dimensions, rng = len(sample.spans), np.random.default_rng(sample.seed)
    if sample.method == "latin":
        cube = qmc.LatinHypercube(dimensions, rng=rng).random(sample.samples)
    else:
        sequence = qmc.Sobol(dimensions, rng=rng)
        cube = sequence.random_base2(math.ceil(math.log2(max(sample.samples, 1))))[: sample.samples]
    for span, column in zip(sample.spans, cube.T, strict=True):
        digits = 8 - math.floor(math.log10(max(abs(span.low), abs(span.high))))
        values = np.round(span.low + column * (span.high - span.low), min(digits, 300))
        column[:] = np.clip(values, span.low, span.high)
    return cube
