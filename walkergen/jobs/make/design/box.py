"""Box of a search: the keys that vary, between their bounds, in steps that people write."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.errors import InputError
from walkergen.points import axes, request
from walkergen.points.axes import Axis, Sample, Space, Span
from walkergen.walker.design import Design

Array = npt.NDArray[np.float64]

FINEST = 200
"""Number of steps, at least, into which the range of a key is cut: tilts of 2 to 40 degrees in
tenths, lengths of 5 to 10 mm in hundredths, as files and printers have them."""

MOST_KEYS = 8
"""Largest number of keys that vary: more are not searched well with some dozens of simulations."""

TILTS, LENGTHS = (2.0, 40.0), (5.0, 10.0)
"""Tilts, deg, and lengths, mm, of legs that vary unless asked otherwise."""


class Box(NamedTuple):
    """Keys that vary, each with its bounds; points in it have coordinates 0..1."""

    spans: tuple[Span, ...]

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys that vary."""
        return tuple(span.key for span in self.spans)

    @property
    def diagonal(self) -> float:
        """Largest distance of two points in it, in coordinates."""
        return math.sqrt(len(self.spans))

    def digits(self, span: Span) -> int:
        """Decimals to which a key is rounded."""
        return -math.floor(math.log10((span.high - span.low) / FINEST) + 1e-9)

    def values(self, x: Sequence[float] | Array) -> dict[str, float]:
        """Values at coordinates, rounded to a step, never beyond the bounds."""
        rounded = {}
        for span, share in zip(self.spans, x, strict=True):
            value = round(span.low + float(share) * (span.high - span.low), self.digits(span))
            rounded[span.key] = min(max(value, span.low), span.high) + 0.0
        return rounded

    def place(self, values: Mapping[str, float]) -> Array:
        """Coordinates of values, shape (keys,)."""
        return np.array([(values[s.key] - s.low) / (s.high - s.low) for s in self.spans])

    def sample(self, count: int, seed: int) -> Space:
        """Points spread evenly over the box."""
        return Space((), Sample(self.spans, count, "sobol", seed))


def of_options(texts: Sequence[str], design: Design) -> Box:
    """Box of --vary KEY=LOW:HIGH, or of the legs' tilt and length. Raises InputError."""
    if not texts:
        return Box(_usual(design))
    parsed = [axes.parse(text, "--vary") for text in texts]
    spans = []
    for text, entry in zip(texts, parsed, strict=True):
        request.check(entry.key, f"--vary {entry.key}")
        request.check_alone(entry.key, f"--vary {entry.key}")
        if isinstance(entry, Axis):
            raise InputError(f"--vary {text[:60]!r}: write a range, {entry.key}=LOW:HIGH")
        spans.append(entry)
    keys = [span.key for span in spans]
    for key in keys:
        if keys.count(key) > 1:
            raise InputError(f"--vary {key}: given {keys.count(key)} times; write one range")
    if len(keys) > MOST_KEYS:
        raise InputError(f"--vary: {len(keys)} keys; at most {MOST_KEYS}: hold some with --set")
    return Box(tuple(spans))


def _usual(design: Design) -> tuple[Span, ...]:
    if design.pair:
        return Span("legs.tilt_deg", *TILTS), Span("legs.length_mm", *LENGTHS)
    if design.follows:
        return (Span("leg_tilt_deg", *TILTS),)
    raise InputError(
        f"{design.name}: no leg follows a common tilt, so say what may vary: "
        "--vary legs[1].tilt_deg=2:40, or --vary body.scale_mm=0.5:2"
    )
