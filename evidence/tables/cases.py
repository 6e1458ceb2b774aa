"""Walkers and scenes of the rows of a table, sampled evenly in ranges of numbers, group by group."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from walkergen.errors import GeometryError
from walkergen.scene import Effects, Scene
from walkergen.theory import uncertain
from walkergen.walker.design import Design

ALL = Effects()
"""Effects of a row: those that its numbers call for."""

Ranges = dict[str, tuple[float, float]]

Numbers = dict[str, float]
"""Numbers of a row by the names of their ranges."""


class Case(NamedTuple):
    """Walker and scene of one row of the table."""

    scene: Scene
    design: Design


class Group(NamedTuple):
    """Rows that are sampled together."""

    ranges: Ranges
    rows: int
    """Number of its rows in a whole table."""
    build: Callable[[Numbers], Case]
    """Walker and scene of a row. Raises GeometryError for one that cannot be built."""
    fixed: Mapping[str, float] = {}
    """Numbers that its rows have whatever was sampled."""


def whole(groups: Sequence[Group]) -> int:
    """Number of rows of a whole table, about."""
    return sum(group.rows for group in groups)


def cases(groups: Sequence[Group], rows: int, seed: int) -> Iterator[Case]:
    """Walkers and scenes of about so many rows; what cannot be built is left out.

    The groups take turns, so that a table of which a part is made is one of fewer rows.
    """
    ordered = []
    for number, group in enumerate(groups):
        count = math.ceil(rows * group.rows / whole(groups))
        low, high = np.array(list(group.ranges.values())).T
        sampled = low + (high - low) * uncertain.even(len(low), count, seed + number)
        ordered += [((place + 0.5) / count, number, place, row) for place, row in enumerate(sampled.tolist())]
    for _, number, _, row in sorted(ordered, key=lambda entry: entry[:3]):
        group = groups[number]
        try:
            yield group.build(dict(zip(group.ranges, row, strict=True)) | dict(group.fixed))
        except GeometryError:
            continue


def tilt_of(share: float) -> float:
    """Tilt, deg, from 0 to 45: half of them below 20, where speeds change most."""
    return float(45.0 * share ** (math.log(20.0 / 45.0) / math.log(0.5)))
