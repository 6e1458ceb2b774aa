"""Report of the study of accuracy: its ladders, and what to run for which error."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from walkergen.files import report, words
from walkergen.files.report import Column, Report, Table
from walkergen.jobs.trust.accuracy.ladder import Ladder, machine

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COMMON = ("series", "setting", "error", "error_sd", "cpu_s")
"""Columns of every ladder, before the details of its own."""

MOST_ROWS = 60
"""Rows of a ladder beyond which the console has its notes alone: its page has the rows."""


class Answer(NamedTuple):
    """Setting to run for an error that a person can bear."""

    error: str
    setting: str
    runs: int | None
    seconds: float | None
    expected_s: float | None
    """Expected time on all cores of the machine that measured, s."""
    why: str


ANSWER = (
    report.text("error (95 %)", "error"),
    report.text("setting", "setting"),
    Column("runs x seconds", lambda row: "-" if row.runs is None else f"{row.runs} x {row.seconds:g} s"),
    Column("takes", lambda row: "-" if row.expected_s is None else words.duration(row.expected_s)),
    report.text("why", "why"),
)


def of(
    ladders: Sequence[Ladder],
    answers: Report | None,
    simulated_s: float,
    least_s: float | None,
    title: str,
    folder: Path,
) -> Report:
    """Report of ladders and answers that lie in a folder.

    `simulated_s`: wall time of all simulations, s; `least_s`: least budget of these ladders, s,
    where it was taken in place of a smaller one.
    """
    tables, lines = [], []
    for table in map(table_of, ladders):
        short = len(table) <= MOST_ROWS
        tables.append(replace(table, columns=table.columns[: len(COMMON)] if short else ()))
        if not short:
            lines += [f"{table.title}: {len(table)} rows in {table.name}.md", *table.notes]
    figures = {ladder.name: partial(_draw, ladder) for ladder in ladders}
    return Report(
        name="accuracy",
        title=title,
        tables=[*tables, *(answers.tables if answers else ())],
        facts={
            "ladders": {ladder.name: [rung._asdict() for rung in ladder.rungs] for ladder in ladders},
            "answers": [row._asdict() for row in answers.table.rows] if answers else [],
            "simulated_s": simulated_s,
            "least_budget_s": least_s,
        },
        lines=[*lines, *(answers.lines if answers else ())],
        figures={**figures, **(answers.figures if answers else {})},
        folder=folder,
    )


def of_ladder(ladder: Ladder, title: str) -> Report:
    """Report of a ladder, for the walker and scene of a title."""
    return Report(
        name=ladder.name,
        title=title,
        tables=[table_of(ladder)],
        facts={},
        lines=[f"measured on: {machine()}"],
        figures={ladder.name: partial(_draw, ladder)},
    )


def of_answers(answers: Sequence[Answer], truth: str, title: str, draw: "Callable[[], Figure]") -> Report:
    """Report of what to run for which error, for the walker and scene of a title."""
    return Report(
        name="accuracy",
        title=title,
        tables=[Table("answers", answers, Answer._fields, ANSWER, "What to run for which error")],
        facts={},
        lines=[
            f"truth: {truth}",
            f"measured on: {machine()}",
            "in one command: walkergen simulate ... --error 5%, by the model's own step or a finer",
            "the error is that of the mean speed with 95 % confidence: the bound of the setting's "
            "bias and twice the standard error together; errors below what the truth is certified "
            "to rest on the order of the stepping (steps-short), not on a second method",
        ],
        figures={"choice": draw},
    )


def table_of(ladder: Ladder) -> Table:
    """Rungs of a ladder: COMMON columns, then the details."""
    details = ladder.rungs[0].details
    keys = (*COMMON, *details)
    texts = [*COMMON[:2], *(key for key, value in details.items() if isinstance(value, str))]
    columns = list(report.every(keys, texts))
    columns[4] = Column("CPU time", lambda row: words.duration(row[4]), right=True)
    rows = [(*rung[: len(COMMON)], *rung.details.values()) for rung in ladder.rungs]
    notes = [f"error: {ladder.error}", f"cost: {ladder.cost}", f"reference: {ladder.reference}"]
    return Table(ladder.name, rows, keys, columns, ladder.title, [*notes, *ladder.notes])


def _draw(ladder: Ladder) -> "Figure":
    from walkergen.jobs.trust.accuracy import figures

    return figures.ladder_figure(ladder)
