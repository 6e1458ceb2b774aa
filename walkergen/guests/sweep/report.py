"""Report of a sweep: number of points, their problems, their rows, and their figure."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from walkergen.files.report import Report, Table
from walkergen.guests.sweep import nearest
from walkergen.guests.sweep.evaluation import Done
from walkergen.guests.sweep.sweep_points import SweepPoints
from walkergen.points.model_kinds import Picture
from walkergen.points.point import STATUS_KEY, WENT_KEY, PointStatus

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass
class Points:
    """Evaluated points of a sweep, counted by outcome."""

    names: Sequence[str]
    """Names of the numbers of a row, beyond those of the keys."""
    kept: bool
    """True for rows that are kept in memory, for a figure or for the caller."""
    count: int = 0
    stored: int = 0
    """Number of those that an earlier run, or another sweep, had evaluated."""
    bad: dict[str, int] = field(default_factory=dict)
    """Number of points by status, for all but "ok"."""
    rows: list[tuple[Any, ...]] = field(default_factory=list)

    def add(self, values: Sequence[Any], done: Done) -> None:
        """Count a point, and store its row if `kept`. `values`: of the varied keys."""
        self.count += 1
        self.stored += done.stored
        if (status := str(done.record[WENT_KEY])) != PointStatus.OK:
            self.bad[status] = self.bad.get(status, 0) + 1
        if self.kept:
            self.rows.append((*values, *map(done.record.get, self.names)))


@dataclass(frozen=True, kw_only=True, repr=False)
class SweepReport(Report):
    """Points of a sweep, one row each: the keys that vary, then numbers with their bounds."""

    keys: tuple[str, ...]
    """Keys that vary."""

    def _repr_html_(self) -> str:
        return self.table._repr_html_()


def make_report(
    sweep: SweepPoints, points: Points, warnings: Sequence[str] = (), wish: float | None = None
) -> SweepReport:
    """Return the report of evaluated points. If `points` kept no rows, its table is empty and there is no figure.

    `warnings`: about an earlier table in the folder. `wish`: desired speed, mm/s: the nearest points come first.
    """
    keys, title = sweep.space.keys, sweep.title
    rows = Table("table", points.rows, (*keys, *points.names), title=title)
    facts: dict[str, Any] = {"points": points.count, "known": points.stored, "bad": points.bad, "files": []}
    shown = rows
    if wish is not None:
        shown = nearest.sort_by_distance(rows, keys, wish)
        facts["nearest"] = [dict(zip(rows.keys, row, strict=True)) for row in shown.read or ()]
    return SweepReport(
        name="sweep",
        title=title,
        tables=[shown],
        lines=_count_lines(points),
        facts=facts,
        figures=_figure_functions(rows, keys, sweep.kind.pictures(sweep.keep)),
        keys=keys,
        warnings=warnings,
    )


def add_files(report: SweepReport, folder: Path, names: Sequence[str]) -> SweepReport:
    """Return the report with the `names` of files that were written to a folder."""
    facts = {**report.facts, "files": [str(folder / name) for name in names]}
    return replace(report, facts=facts, lines=[*report.lines, f"in {folder}: {', '.join(names)}"])


def _count_lines(points: Points) -> list[str]:
    """Return the lines on the number of points: all, those stored before, and those with problems."""
    before = f", {points.stored} of them stored before" if points.stored else ""
    counted = f"{points.count} points{before}"
    if points.stored == points.count:
        counted = f"all {points.count} points were stored before"
    bad = points.bad.items()
    return [counted, *(f"{count} of them: {name} (see the column status)" for name, count in bad)]


def _figure_functions(
    rows: Table, keys: Sequence[str], pictures: Sequence[Picture]
) -> "Mapping[str, Callable[[], Figure]]":
    """Return functions that draw the figures, by file name: one for each number in `pictures`.

    Numbers that no point has are left out. There are no figures if no key has two values.
    """
    columns = dict(zip(rows.keys, zip(*rows.rows, strict=True), strict=False))
    if not any(len(set(map(str, columns.get(key, ())))) > 1 for key in keys):
        return {}
    return {
        picture.name: partial(_draw_picture, rows, keys, picture)
        for picture in pictures
        if any(value is not None for value in columns[picture.value])
    }


def _draw_picture(rows: Table, keys: Sequence[str], picture: Picture) -> "Figure":
    """Draw one number of the points in `rows`, with its bounds if known, against the varied `keys`."""
    from walkergen.guests.sweep import figures
    from walkergen.guests.sweep.panels import Columns

    columns = dict(zip(rows.keys, zip(*rows.rows, strict=True), strict=True))
    unknown = np.full(len(rows), np.nan)
    low, high = (rows[end] if end in columns else unknown for end in (picture.low, picture.high))
    values = {key: columns[key] for key in keys}
    drawn = Columns(values, rows[picture.value], low, high, columns[STATUS_KEY], picture.label)
    return figures.draw_figure(drawn, keys, rows.title)
