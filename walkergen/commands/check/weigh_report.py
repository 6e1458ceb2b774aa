"""Report of a weighed mesh: mass properties of each object and of all together."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from walkergen.commands.check.weighing import ObjectMass, Weighing
from walkergen.core.numerics import Array
from walkergen.files import report
from walkergen.files.report import Column, Report, Table


@dataclass(frozen=True, kw_only=True, repr=False)
class WeighReport(Report):
    """Mass properties of a mesh file, in its own axes."""

    total: ObjectMass
    """All objects together, as one rigid body."""


class Line(NamedTuple):
    """Line of the printed mass properties: a label, up to three numbers, and their unit."""

    label: str
    numbers: tuple[str, ...]
    unit: str


def _number_column(index: int) -> Column:
    """Return the column of the first, second or third (index 0, 1, 2) number of each line."""
    return Column("", lambda line: line.numbers[index] if index < len(line.numbers) else "", right=True)


LINE_COLUMNS = (report.text_column("", "label"), *map(_number_column, range(3)), report.text_column("", "unit"))


def make_report(weighing: Weighing, path: Path, density_g_cm3: float, scale_mm: float) -> WeighReport:
    """Make the report of the weighed objects of a mesh file. `scale_mm`: length of the file's unit, mm."""
    several = [weighing.total] if len(weighing.parts) > 1 else []
    parts = [*weighing.parts, *several]
    pages = [
        Table(part.name, list(_lines(part)), Line._fields, LINE_COLUMNS, f"{part.name}, {part.triangles} triangles")
        for part in parts
    ]
    facts = {
        "density_g_cm3": density_g_cm3,
        "scale_mm": scale_mm,
        "sha256": weighing.sha256,
        "parts": [_facts(part) for part in weighing.parts],
        "total": _facts(weighing.total),
    }
    caption = f"{density_g_cm3:g} g/cm3, 1 unit = {scale_mm:g} mm, axes as in the file"
    return WeighReport(
        name="weigh",
        title=path.name,
        caption=f"{path.name}: {caption}",
        tables=[report.table_from_rows("objects", parts), *pages],
        facts=facts,
        lines=weighing.notes,
        total=weighing.total,
    )


def _facts(part: ObjectMass) -> dict[str, Any]:
    """Return the fields of an object for JSON: arrays as lists."""
    return {key: value.tolist() if isinstance(value, np.ndarray) else value for key, value in part._asdict().items()}


def _lines(part: ObjectMass) -> Iterator[Line]:
    """Yield the lines of an object's mass properties."""
    for label, values, unit in (
        ("volume", np.array([part.volume_mm3]), "mm3"),
        ("mass", np.array([part.mass_g]), "g"),
        ("centre of mass", part.centre_mm, "mm"),
        ("inertia tensor", part.tensor_g_mm2[0], "g mm2, about the centre"),
        ("", part.tensor_g_mm2[1], ""),
        ("", part.tensor_g_mm2[2], ""),
        ("principal moments", part.moments_g_mm2, "g mm2"),
        ("principal axes", part.axes[0], "of the first moment"),
        ("", part.axes[1], "of the second"),
        ("", part.axes[2], "of the third"),
    ):
        yield Line(label, tuple(f"{value:.6g}" for value in _zero_rounding(values)), unit)


def _zero_rounding(row: Array) -> Array:
    """Return the values of a row, with zero for values that are only rounding errors."""
    return np.where(np.abs(row) < 1e-12 * np.abs(row).max(), 0.0, row)
