"""Report of the checks of crowds in a plane: a row a number, with its verdict."""

from collections.abc import Sequence
from pathlib import Path

from evidence.crowd_checks.compared import Row
from walkergen.files import report
from walkergen.files.report import Column, Report, Table
from walkergen.jobs.trust.published import TIMES

NAME = "crowd_checks"

TITLE = "Walkers in a plane against walkers in space"

LEGEND = (
    "± one standard error: alone over runs, of pairs over pairs, of crowds over runs; the last "
    "number is plane less space in standard errors of that difference, in the single check of the "
    f"plane alone, whose input is the card of space; up to {TIMES:g} agree"
)


def table(rows: Sequence[Row]) -> Table:
    """Table to read, a row a number."""
    columns = (
        report.text("check", "check"),
        report.text("case", "case"),
        Column("number", _titled),
        report.with_error("space", "space", "space_se"),
        report.with_error("plane", "plane", "plane_se"),
        report.fixed("errors apart", "errors_apart", 1),
        report.text("verdict", "verdict"),
    )
    return Table(NAME, rows, Row._fields, columns, notes=(LEGEND,))


def of(rows: Sequence[Row], folder: Path, notes: Sequence[str]) -> Report:
    """Report of rows that lie in a folder; `notes` say how they were made."""
    reasons = dict[tuple[str, str], list[str]]()
    for row in rows:
        if row.why:
            reasons.setdefault((row.check, row.why), []).append(_named(row))
    counted = ", ".join(
        f"{check}: {sum(row.verdict == 'agrees' for row in rows if row.check == check)} of "
        f"{sum(row.check == check for row in rows)} agree"
        for check in dict.fromkeys(row.check for row in rows)
    )
    disagreeing = [
        f"{check}, {'; '.join(names)}: disagrees, perhaps because {why}" for (check, why), names in reasons.items()
    ]
    return Report(
        name=NAME,
        title=TITLE,
        tables=[table(rows)],
        facts={"rows": [row._asdict() for row in rows]},
        lines=[counted, *disagreeing, *notes],
        folder=folder,
    )


def _named(row: Row) -> str:
    return f"{row.case}, {row.quantity}" if row.check == "binary" else row.quantity


def _titled(row: Row) -> str:
    quantity = row.quantity.replace("_", " ") if row.check == "collective" else row.quantity
    return f"{quantity} ({row.unit})" if row.unit else quantity
