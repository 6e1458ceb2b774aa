"""Tables of what a crowd did, the same for films and for simulations."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from walkergen.analysis.estimates import Estimate
from walkergen.analysis.motion import Curve
from walkergen.crowd.statistics.measuring import NO_WALL, UNITS, CrowdStatistics
from walkergen.files import words
from walkergen.files.report import Column, Table

KEYS = {name: f"{name}_{unit}" if unit else name for name, unit in UNITS.items()}
"""Keys of the numbers, with their units."""

READ_UNITS = {"mm_s": " (mm/s)", "": ""}

CURVES: Mapping[str, tuple[str, Mapping[str, str]]] = {
    "crowd_pairs": (
        "distance_mm",
        {"g": "g", "polar_correlation": "polar_correlation", "nematic_correlation": "nematic_correlation"},
    ),
    "crowd_msd": ("lag_s", {"msd": "msd_mm2"}),
    "crowd_fluctuations": ("mean_walkers", {"fluctuations": "variance"}),
    "crowd_local_packing": ("local_packing", {"local_packing": "density"}),
    "crowd_clusters": ("walkers_from", {"cluster_shares": "share"}),
    "crowd_walls": (
        "wall_distance_mm",
        {"wall_density": "density", "wall_speed": "speed_mm_s", "wall_alignment": "alignment"},
    ),
}
"""Tables of curves: the key of their places, and the keys of the curves in them by their names."""


class CrowdNumber(NamedTuple):
    """Number of a crowd; the field names are the columns of crowd.csv."""

    quantity: str
    """Name with its unit."""
    value: float | None
    se: float | None
    low_95: float | None
    high_95: float | None
    by_chance: float | None
    """Value of as many walkers placed and turned at random, where it is known."""
    refused: str
    """Reason why the value, or its error, is not known."""


class _Course(NamedTuple):
    quantity: str
    t_s: float
    value: float | None
    se: float | None


def tables(statistics: CrowdStatistics) -> list[Table]:
    """Numbers with their errors, which people read; their course in time, each run, and curves."""
    rows = [_number(statistics, name) for name in UNITS]
    shown = [row for row in rows if row.refused != NO_WALL]
    title = f"Crowd of {statistics.walkers} walkers in {statistics.dish.words}"
    made = [Table("crowd", rows, CrowdNumber._fields, NUMBERS, title, statistics.notes, shown)]
    course = [_Course(KEYS[name], *point) for name, curve in statistics.series.items() for point in _points(curve)]
    made.append(Table("crowd_series", course, _Course._fields))
    by_run = [_known(np.array(row)) for row in zip(*statistics.by_run.values(), strict=True)]
    numbered = [(run, *row) for run, row in enumerate(by_run)]
    made.append(Table("crowd_runs", numbered, ("run", *(KEYS[n] for n in statistics.by_run))))
    return [*made, *_curves(statistics)]


def facts(statistics: CrowdStatistics) -> dict[str, Any]:
    """Numbers for JSON."""
    return {
        "dish": statistics.dish.words,
        "walkers": statistics.walkers,
        "runs": statistics.runs,
        "frames": statistics.frames,
        "seconds": statistics.seconds,
        "numbers": {
            row.quantity: {key: value for key, value in row._asdict().items() if key != "quantity"}
            for row in (_number(statistics, name) for name in UNITS)
        },
        "notes": list(statistics.notes),
    }


def _number(statistics: CrowdStatistics, name: str) -> CrowdNumber:
    estimate = statistics.numbers[name]
    low, high = _bounds(estimate)
    chance = statistics.by_chance.get(name)
    return CrowdNumber(KEYS[name], estimate.value, estimate.se, low, high, chance, estimate.reason)


def _bounds(estimate: Estimate) -> tuple[float | None, float | None]:
    return estimate.interval(0.95) or (None, None)


def _value(row: CrowdNumber) -> str:
    if row.value is None:
        return row.refused
    if row.se is None:
        return f"{words.number(row.value)} ± ?: {row.refused}"
    return words.with_error(row.value, row.se)


def _span(row: CrowdNumber) -> str:
    """Bounds of 95 % to two digits of the error; '' without any."""
    if row.low_95 is None or row.high_95 is None or not row.se:
        return ""
    return " to ".join(words.to_digits_of(row.se, (row.low_95, row.high_95)))


def _chance(row: CrowdNumber) -> str:
    return "" if row.by_chance is None or row.value is None else words.number(row.by_chance)


def _name(row: CrowdNumber) -> str:
    return in_words(next(name for name, key in KEYS.items() if key == row.quantity))


def in_words(name: str) -> str:
    """Name of a number in words, with its unit."""
    return name.replace("_", " ") + READ_UNITS[UNITS[name]]


NUMBERS = (
    Column("", _name),
    Column("value ± standard error", _value),
    Column("95 %", _span),
    Column("at random", _chance, right=True),
)


def _curves(statistics: CrowdStatistics) -> Iterator[Table]:
    """Tables of the curves that the crowd has, for CSV and Python alone."""
    for name, (at, keys) in CURVES.items():
        curves = {key: statistics.curves[curve] for curve, key in keys.items() if curve in statistics.curves}
        if not curves:
            continue
        columns = [next(iter(curves.values())).at]
        header = [at]
        for key, curve in curves.items():
            columns += [curve.value, curve.se]
            header += [key, _error_key(key)]
        yield Table(name, [_known(np.array(row)) for row in zip(*columns, strict=True)], header)


def _error_key(key: str) -> str:
    """Key of a curve's standard error: the unit stays last."""
    for unit in ("_mm_s", "_mm2"):
        if key.endswith(unit):
            return f"{key.removesuffix(unit)}_se{unit}"
    return f"{key}_se"


def _points(curve: Curve) -> Iterator[tuple[float, float | None, float | None]]:
    for at, value, se in zip(*curve, strict=True):
        yield (float(at), *_known(np.array([value, se])))  # type: ignore[misc]


def _known(values: Any) -> tuple[float | None, ...]:
    """Numbers of a row; None where one is not known."""
    return tuple(None if math.isnan(value) else float(value) for value in values)


def lines(statistics: CrowdStatistics) -> Sequence[str]:
    """What was measured, in a sentence."""
    runs = "one run" if statistics.runs == 1 else f"{statistics.runs} independent runs"
    return [
        f"{runs} of {words.duration(statistics.seconds)} each, {statistics.frames} frames, of "
        f"{statistics.walkers} walkers in {statistics.dish.words}."
    ]
