"""Tables of a crowd, the same for films and for simulations."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from walkergen.core import Quantity, format_duration, format_number
from walkergen.files import quantity_format
from walkergen.files.report import Column, Table
from walkergen.guests.crowd.statistics.summary import NO_WALL, CrowdStatistics, few_runs_reason

NUMBER_COLUMNS = ("quantity", "value", "se", "low_95", "high_95", "by_chance", "refused")
"""Columns of crowd.csv: a quantity, its bounds, and its value of as many walkers placed and turned at random."""

CURVE_TABLES: Mapping[str, tuple[str, Mapping[str, str]]] = {
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
"""Tables of curves: the key of the abscissa, and the keys of the values by names in `CrowdStatistics.curves`."""


def make_tables(statistics: CrowdStatistics) -> list[Table]:
    """Return tables: numbers with errors (shown to people), their course in time, numbers of each run, and curves."""
    numbers, series, by_run = statistics.numbers, statistics.series, statistics.by_run
    rows = [_row(statistics, number) for number in numbers.values()]
    shown_rows = [row for row, number in zip(rows, numbers.values(), strict=True) if number.refused != NO_WALL]
    title = f"Crowd of {_describe_walkers(statistics)}"
    course = [
        (numbers[name].column, *_nan_to_none(point)) for name in series for point in zip(*series[name], strict=True)
    ]
    runs = [(run, *_nan_to_none(row)) for run, row in enumerate(zip(*by_run.values(), strict=True))]
    return [
        Table("crowd", rows, NUMBER_COLUMNS, _columns(statistics), title, statistics.notes, shown_rows),
        Table("crowd_series", course, ("quantity", "t_s", "value", "se")),
        Table("crowd_runs", runs, ("run", *(numbers[name].column for name in by_run))),
        *_curve_tables(statistics),
    ]


def facts(statistics: CrowdStatistics) -> dict[str, Any]:
    """Return the statistics of a crowd for JSON, without course and curves."""
    rows = [_row(statistics, number) for number in statistics.numbers.values()]
    return {
        "dish": statistics.dish.words,
        "walkers": statistics.walkers,
        "runs": statistics.runs,
        "frames": statistics.frames,
        "seconds": statistics.seconds,
        "numbers": {name: dict(zip(NUMBER_COLUMNS[1:], row, strict=True)) for name, *row in rows},
        "notes": list(statistics.notes),
    }


def summary_line(statistics: CrowdStatistics) -> str:
    """Describe the runs, their length, their walkers and their dish in a sentence."""
    runs = "one run" if statistics.runs == 1 else f"{statistics.runs} independent runs"
    return (
        f"{runs} of {format_duration(statistics.seconds)} each, {statistics.frames} frames, of "
        f"{_describe_walkers(statistics)}."
    )


def describe_answer(statistics: CrowdStatistics) -> str:
    """Describe the speed of the walkers and the order of their headings, as far as these are known."""
    parts = []
    if (speed := statistics.numbers["speed"]).value is not None:
        parts.append(f"{quantity_format.format_value(speed._replace(refused=''), 'mm/s')} on average")
        parts[0] += f" ({speed.refused})" if speed.refused else ""
    if (order := statistics.numbers["polar_order"]).value is not None:
        chance = format_number(statistics.by_chance["polar_order"], 2)
        parts.append(f"polar order {format_number(order.value, 2)} ({chance} at random, 1 if all point the same way)")
    return "; ".join(parts) or summary_line(statistics).rstrip(".")


def _describe_walkers(statistics: CrowdStatistics) -> str:
    """Describe the number of walkers and their dish."""
    return f"{statistics.walkers} walker{'s' * (statistics.walkers != 1)} in {statistics.dish.words}"


def _row(statistics: CrowdStatistics, number: Quantity) -> tuple[Any, ...]:
    """Return the row of a number in crowd.csv, with `NUMBER_COLUMNS`."""
    bounds = number.interval() or (None, None)
    chance = statistics.by_chance.get(number.key)
    return number.column, number.value, number.se, *bounds, chance, number.refused


def _columns(statistics: CrowdStatistics) -> tuple[Column, ...]:
    """Return the columns of the table shown to people. The first cell of a row names its quantity."""
    few = few_runs_reason(statistics.runs)  # said once, below the table
    numbers = {
        number.column: number._replace(refused="") if number.refused == few else number
        for number in statistics.numbers.values()
    }

    def format_chance(row: Sequence[Any]) -> str:
        number = numbers[row[0]]
        value = statistics.by_chance.get(number.key)
        return "" if value is None or number.value is None else format_number(value)

    return (*quantity_format.columns(lambda row: numbers[row[0]]), Column("at random", format_chance, right=True))


def _curve_tables(statistics: CrowdStatistics) -> Iterator[Table]:
    """Yield the tables of the curves that the crowd has, for CSV and Python alone."""
    for name, (position_key, keys) in CURVE_TABLES.items():
        curves = {key: statistics.curves[curve] for curve, key in keys.items() if curve in statistics.curves}
        if not curves:
            continue
        columns = [next(iter(curves.values())).at, *(part for curve in curves.values() for part in curve[1:])]
        header = [position_key, *(key for curve in curves for key in (curve, _error_key(curve)))]
        yield Table(name, [tuple(_nan_to_none(row)) for row in zip(*columns, strict=True)], header)


def _error_key(key: str) -> str:
    """Return the key of a curve's standard error: speed_mm_s gives speed_se_mm_s."""
    for unit in ("_mm_s", "_mm2"):
        if key.endswith(unit):
            return f"{key.removesuffix(unit)}_se{unit}"
    return f"{key}_se"


def _nan_to_none(values: Sequence[np.float64]) -> list[float | None]:
    """Convert a row of numbers to floats, NaN to None."""
    return [None if math.isnan(value) else float(value) for value in values]
