"""Report of the study of accuracy: recommended settings for each error, and the ladders that support them.

A ladder lists settings from cheap to expensive, each with its error and its CPU time.
"""

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from walkergen.commands.accuracy.machine_speed import machine_description
from walkergen.core.files import formatting
from walkergen.core.tolerance import Tolerance
from walkergen.files import report
from walkergen.files.report import Column, Report, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Details = dict[str, float | str | None]
"""Further columns of a rung: the same keys for all rungs of a ladder."""


class Rung(NamedTuple):
    """Setting of a ladder, with its error and its cost."""

    series: str
    """Name of the series: settings that differ in one number."""
    setting: str
    error: float | None
    """Error as the ladder's `error` defines it; None if unknown."""
    error_sd: float | None
    """Standard error of the error; None when the error is deterministic."""
    cpu_s: float
    """Time as the ladder's `cost` defines it, s."""
    details: Details


class Ladder(NamedTuple):
    """Work-precision study: its rungs, and the reference for their errors."""

    name: str
    title: str
    error: str
    """Definition of `Rung.error`."""
    cost: str
    """Definition of `Rung.cpu_s`."""
    reference: str
    """Result that counts as true, and how it was certified."""
    rungs: Sequence[Rung]
    notes: Sequence[str] = ()


def format_order(values: Sequence[float], errors: Sequence[float]) -> str:
    """Return the order at which errors grow with `values`, such as steps, as text: "measured order 1.98 ± 0.05"."""
    slope, se = convergence_order(values, errors)
    return f"measured order {slope:.2f} ± {se:.2f}"


def convergence_order(values: Sequence[float], errors: Sequence[float]) -> tuple[float, float]:
    """Return the slope of log(error) over log(value) by least squares, and its standard error.

    The standard error is that of the scatter about the line: NaN for fewer than three points.
    """
    x, y = np.log(values), np.log(errors)
    slope, offset = np.polyfit(x, y, 1)
    if len(x) < 3:
        return float(slope), math.nan
    scatter = np.sum((y - slope * x - offset) ** 2) / (len(x) - 2)
    return float(slope), float(math.sqrt(scatter / np.sum((x - x.mean()) ** 2)))


COMMON_COLUMNS = ("series", "setting", "error", "error_sd", "cpu_s")
"""Columns of every ladder, before the details of its own."""

MAX_ROWS = 60
"""Rows of a ladder beyond which people read its notes alone: accuracy.csv has the rows."""

ONE_COMMAND_HINT = "To meet an error with one command: walkergen simulate ... --error 5%"


class Answer(NamedTuple):
    """Setting to run for an acceptable error."""

    error: Tolerance
    setting: str
    runs: int | None
    seconds: float | None
    expected_s: float | None
    """Expected time on all cores of this machine, s."""
    known: str
    """measured: for this walker, as shipped; scaled: from the shipped walker; law: extrapolated by the step's law; now:
    by this budget."""
    why: str
    accepted: bool = False
    """Whether it is the cheapest that the scene's `run.accepted_error` allows."""

    @property
    def plain(self) -> dict[str, Any]:
        """The same with its error in words, for files."""
        return self._asdict() | {"error": str(self.error)}


ANSWER_COLUMNS = (
    Column("error (95 %)", lambda row: f"{row.error}{', accepted' if row.accepted else ''}"),
    report.text_column("setting", "setting"),
    Column("runs x seconds", lambda row: "-" if row.runs is None else f"{row.runs} x {row.seconds:g} s"),
    Column("takes", lambda row: "-" if row.expected_s is None else formatting.format_duration(row.expected_s)),
    report.text_column("source", "known"),
    report.text_column("why", "why"),
)

RUNG_COLUMNS = (
    report.text_column("series", "series"),
    report.text_column("setting", "setting"),
    report.number_column("error", "error"),
    report.number_column("error sd", "error_sd"),
    Column("CPU time", lambda rung: formatting.format_duration(rung.cpu_s), right=True),
)


class Answers(NamedTuple):
    """Recommended settings for each error, and their justification."""

    rows: Sequence[Answer]
    lines: Sequence[str]
    """Reference result and its certification, and the source of numbers that were not measured now."""
    draw: "Callable[[], Figure]"


def mark_accepted(rows: Sequence[Answer], accepted: float | None) -> tuple[list[Answer], list[str]]:
    """Return answers, with the one of the largest error within `accepted` marked, and lines for the user if none is."""
    if accepted is None:
        return list(rows), []
    within = [row.error.value for row in rows if row.error.value <= accepted * (1.0 + 1e-9)]
    if not within:
        why = f"run.accepted_error = {accepted:g}: every error of the table is larger"
        return list(rows), [f"{why}. Run simulate ‹error=›{100.0 * accepted:g}%."]
    return [row._replace(accepted=row.error.value == max(within)) for row in rows], []


def make_report(
    ladders: Sequence[Ladder],
    answers: Answers | None,
    simulated_s: float,
    least_s: float | None,
    title: str,
    folder: Path,
) -> Report:
    """Return the report of ladders and answers in a folder.

    `simulated_s`: wall time of all simulations, s. `least_s`: smallest budget of these ladders, s,
    if it replaced a smaller requested one.
    """
    rows = answers.rows if answers else ()
    tables = [Table("answers", rows, (), ANSWER_COLUMNS, "Settings for each error")] if answers else []
    lines = [*answers.lines, ONE_COMMAND_HINT] if answers else []
    for ladder in ladders:
        notes = [f"error: {ladder.error}", f"cost: {ladder.cost}", f"reference: {ladder.reference}", *ladder.notes]
        if len(ladder.rungs) <= MAX_ROWS:
            tables.append(Table(ladder.name, ladder.rungs, (), RUNG_COLUMNS, ladder.title, notes))
        else:
            lines += [f"{ladder.title}: {len(ladder.rungs)} rows in accuracy.csv", *notes]
    return Report(
        name="accuracy",
        title=title,
        tables=[*tables, _rungs_table(ladders) if ladders else _answers_table(rows)],
        facts={
            "ladders": {ladder.name: [rung._asdict() for rung in ladder.rungs] for ladder in ladders},
            "answers": [row.plain for row in rows],
            "simulated_s": simulated_s,
            "least_budget_s": least_s,
        },
        lines=[*lines, f"measured on: {machine_description()}"],
        figures={"accuracy": answers.draw} if answers else {},
        folder=folder,
    )


def _rungs_table(ladders: Sequence[Ladder]) -> Table:
    """Return the table of all rungs: COMMON_COLUMNS columns, then details of every ladder, blank for other ladders."""
    rungs: list[tuple[str, Rung]] = [(ladder.name, rung) for ladder in ladders for rung in ladder.rungs]
    details = list(dict.fromkeys(key for _, rung in rungs for key in rung.details))
    rows = [(name, *rung[: len(COMMON_COLUMNS)], *map(rung.details.get, details)) for name, rung in rungs]
    return Table("accuracy", rows, ("ladder", *COMMON_COLUMNS, *details))


def _answers_table(answers: Sequence[Answer]) -> Table:
    """Return the table of the answers alone, if nothing was measured."""
    return Table("accuracy", [tuple(answer.plain.values()) for answer in answers], Answer._fields)
