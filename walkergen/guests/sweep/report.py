"""Report of a sweep: a sentence with the result, the table of its points, and figures."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from walkergen.core import format_number, format_range
from walkergen.files.report import Report, Table, format_value
from walkergen.guests.sweep import nearest
from walkergen.guests.sweep.evaluation import Done
from walkergen.guests.sweep.sweep_points import SweepPoints
from walkergen.points.model_kinds import Picture
from walkergen.points.point import STATUS_KEY, WENT_KEY, PointStatus

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MAX_REASONS = 3
"""Maximum number of reasons for missing values in the sentence with the result."""


@dataclass
class Points:
    """Evaluated points of a sweep, counted by outcome."""

    keys: Sequence[str]
    """Keys that vary."""
    names: Sequence[str]
    """Names of the other values of a row: quantities and status."""
    main: Picture | None
    """Main quantity: the speed or, for crowds, the first of the requested quantities; None without any."""
    keeps_rows: bool
    """True if rows stay in memory, for a figure or for the caller."""
    count: int = 0
    stored: int = 0
    """Number of points that an earlier run, or another sweep, had evaluated."""
    bad: dict[str, int] = field(default_factory=dict)
    """Number of points by status, for every status except "ok"."""
    missing: dict[str, int] = field(default_factory=dict)
    """Number of points without the main quantity, by reason."""
    best: dict[str, Any] = field(default_factory=dict)
    """Keys and all other values of the point with the largest main quantity."""
    rows: list[tuple[Any, ...]] = field(default_factory=list)

    def add(self, values: Sequence[Any], done: Done) -> None:
        """Count a point, and store its row if `keeps_rows`. `values`: values of the varied keys."""
        self.count += 1
        self.stored += done.stored
        if (status := str(done.record[WENT_KEY])) != PointStatus.OK:
            self.bad[status] = self.bad.get(status, 0) + 1
        if self.main is not None:
            value = done.record.get(self.main.value)
            if value is None:
                reason = str(done.record[STATUS_KEY]).removeprefix(f"{status}: ").partition(". ")[0]
                self.missing[reason] = self.missing.get(reason, 0) + 1
            elif not self.best or value > self.best[self.main.value]:
                self.best = {**dict(zip(self.keys, values, strict=True)), **done.record}
        if self.keeps_rows:
            self.rows.append((*values, *map(done.record.get, self.names)))


@dataclass(frozen=True, kw_only=True, repr=False)
class SweepReport(Report):
    """Points of a sweep, one row each: the keys that vary, then quantities with their bounds."""

    keys: tuple[str, ...]
    """Keys that vary."""

    def _repr_html_(self) -> str:
        return self.table._repr_html_()


def make_report(
    sweep: SweepPoints, points: Points, warnings: Sequence[str] = (), wish: float | None = None
) -> SweepReport:
    """Return the report of evaluated points. If `points` has no rows, the table is empty and there is no figure.

    Parameters
    ----------
    sweep : SweepPoints
        Sweep of the points.
    points : Points
        Evaluated points.
    warnings : sequence of str
        Warnings about an earlier table in the folder.
    wish : float, optional
        Desired speed, mm/s. The points nearest to it come first.
    """
    keys, title = sweep.space.keys, sweep.title
    rows = Table("table", points.rows, (*keys, *points.names), title=title)
    facts: dict[str, Any] = {"points": points.count, "known": points.stored, "bad": points.bad, "files": []}
    facts |= {"missing": points.missing, "best": points.best}
    shown = rows
    if wish is not None:
        shown = nearest.sort_by_distance(rows, keys, wish)
        facts["nearest"] = [dict(zip(rows.keys, row, strict=True)) for row in shown.read or ()]
    return SweepReport(
        name="sweep",
        title=title,
        tables=[shown],
        caption=format_answer(points),
        lines=_format_counts(points),
        facts=facts,
        figures=_figure_functions(rows, keys, sweep.kind.pictures(sweep.keep)),
        keys=keys,
        warnings=warnings,
    )


def add_files(report: SweepReport, folder: Path, names: Sequence[str]) -> SweepReport:
    """Return the report with a line for the files that were written to a folder. `names`: their names."""
    facts = {**report.facts, "files": [str(folder / name) for name in names]}
    pictures = [f"picture: {folder / name}" for name in names if name.endswith(".png")]
    lines = [*pictures, *report.lines, f"written into {folder}: {', '.join(names)}"]
    return replace(report, facts=facts, lines=lines)


def format_answer(points: Points) -> str:
    """Return the sentence with the result: how many points lack the main quantity, and which point has the largest."""
    answer = "1 point" if points.count == 1 else f"{points.count} points"
    if points.main is None:
        return answer
    name, unit = points.main.name_and_unit
    if points.missing:
        reasons = sorted(points.missing.items(), key=lambda pair: -pair[1])
        listed = "; ".join(f"{reason} ({count})" for reason, count in reasons[:MAX_REASONS])
        more = " (all: column status of the table)" if reasons[MAX_REASONS:] else ""
        answer = f"{sum(points.missing.values())} of {answer} have no {name}: {listed}{more}"
    if not points.best:
        return answer
    low, high = (points.best.get(key) for key in (points.main.low, points.main.high))
    number = f"{format_number(points.best[points.main.value], 3)} {unit}".rstrip()
    if low is not None and high is not None:
        number += f" (95 %: {format_range(low, high, 3)})"
    if not points.keys:
        return f"{answer}: {number}"
    values = ", ".join(f"{key} = {format_value(points.best[key])}" for key in points.keys)
    return f"{answer}. {'Fastest' if name == 'speed' else f'Largest {name}'}: {number} at {values}"


def _format_counts(points: Points) -> list[str]:
    """Return lines of text with the numbers of points in doubt, and of points that were stored before."""
    doubts = [
        f"{count} of {points.count} points: {name} (column status of the table)"
        for name, count in points.bad.items()
        if name not in (PointStatus.NO_SPEED, PointStatus.REFUSED)
    ]
    stored = "all" if points.stored == points.count else f"{points.stored} of the"
    return [*doubts, *([f"{stored} points were stored before"] if points.stored else [])]


def _figure_functions(
    rows: Table, keys: Sequence[str], pictures: Sequence[Picture]
) -> "Mapping[str, Callable[[], Figure]]":
    """Return functions that draw the figures, by the stem of their file: one for each quantity in `pictures`.

    Quantities that no point has are left out. There are no figures if no key has two values.
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
    """Draw one quantity of the points in `rows`, with its bounds if known, against the varied `keys`."""
    from walkergen.guests.sweep import figures, scales
    from walkergen.guests.sweep.panels import Columns

    columns = dict(zip(rows.keys, zip(*rows.rows, strict=True), strict=True))
    unknown = np.full(len(rows), np.nan)
    low, high = (rows[end] if end in columns else unknown for end in (picture.low, picture.high))
    values = {key: columns[key] for key in keys}
    shown = Columns(values, rows[picture.value], low, high, columns[STATUS_KEY], picture.label)
    best, (name, unit) = int(np.nanargmax(shown.value)), picture.name_and_unit
    varied = [scale for scale in (scales.make_scale(key, values[key]) for key in keys) if len(scale.values) > 1]
    found = [scales.format_value(scale, int(scale.indices[best]), scale.unit == "") for scale in varied]
    at = ", ".join(map(_keep_together, found))
    most = f"{format_number(shown.value[best], 3)} {unit}".rstrip()
    title = f"{name[:1].upper()}{name[1:]} of {rows.title}: highest, {_keep_together(most)}, at {at}"
    return figures.draw_figure(shown, keys, title)


def _keep_together(text: str) -> str:
    """Return the text with spaces at which no line is broken."""
    return text.replace(" ", "\N{NO-BREAK SPACE}")
