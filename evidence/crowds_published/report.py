"""Report of our crowds compared with published ones: the statements, our numbers, a panel each, and the sources."""

from collections import Counter
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from evidence.crowds_published.compared import Compared
from evidence.crowds_published.published import FINDINGS, Source
from walkergen.core.files import formatting
from walkergen.core.numerics.quantity import Verdict
from walkergen.files import report
from walkergen.files.report import Column, Report, Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE = "Crowds and published experiments"

LEGEND = (
    "Errors are standard errors over independent runs. Only signs are compared, because the sources use other grains. "
    "A sign agrees if all of the 95 % bounds of the change have it."
)

KEYS = (
    *("finding", "source", "address", "read", "quote", "stated", "sign"),
    *("quantity", "setting", "ours", "verdict", "note"),
)
"""Columns of crowds_published.csv."""

POINT_KEYS = ("finding", "quantity", "setting", "at", "ours", "ours_se")
"""Columns of crowds.csv: a number behind a statement."""

PANELS_PER_ROW = 3
"""Panels side by side."""


def make_report(rows: Sequence[Compared], folder: Path, note: str) -> Report:
    """Report of what was compared, which lies in a folder; `note` says how it was simulated."""
    counts = Counter(row.verdict for row in rows)
    cells = [_csv_row(row) for row in rows]
    columns = (
        Column("published", lambda row: row.finding.key),
        Column("stated", lambda row: f"{row.finding.stated}: {row.finding.sign}"),
        report.text_column("ours", "quantity"),
        Column("along", lambda row: row.setting, wide=True),
        Column("numbers", _format_points),
        report.text_column("sign", "verdict"),
        Column("note", lambda row: row.note, wide=True),
    )
    points = [
        (row.finding.key, row.quantity, row.setting, at, value.value, value.se)
        for row in rows
        for at, value in row.points
    ]
    sources = dict.fromkeys(finding.source for finding in FINDINGS)
    return Report(
        name="crowds_published",
        title=TITLE,
        tables=[
            Table("crowds_published", cells, KEYS),
            Table("rows", rows, (), columns, notes=(LEGEND,)),
            Table("crowds", points, POINT_KEYS),
        ],
        facts={"rows": [dict(zip(KEYS, row, strict=True)) for row in cells]},
        lines=[
            ", ".join(f"{counts[verdict]} {verdict}" for verdict in Verdict if counts[verdict]),
            note,
            *map(_describe_source, sources),
        ],
        folder=folder,
        figures={"crowds": partial(draw_panels, rows)},
    )


def draw_panels(rows: Sequence[Compared]) -> "Figure":
    """Draw a panel a statement whose numbers were made: means and one standard error."""
    from walkergen.files import figures

    shown = [row for row in rows if len(row.points) > 1]
    with figures.style():
        figure, panels = figures.new_grid(f"{TITLE}: bars are one standard error", len(shown), PANELS_PER_ROW, 2.2)
        for axes, row in zip(panels, shown, strict=True):
            _draw_panel(axes, row)
    return figure


def _draw_panel(axes: "Axes", row: Compared) -> None:
    from walkergen.files import figures

    colour = {Verdict.AGREE: figures.BLUE, Verdict.DISAGREE: figures.ORANGE}.get(row.verdict, figures.GREY)
    at = [place for place, _ in row.points]
    values = [(value.value, value.se) for _, value in row.points]
    figures.draw_points(axes, (at, *zip(*values, strict=True)), figures.Look(colour), joined=True)
    figures.draw_level(axes)
    for value in row.finding.values:
        if at[0] <= value <= at[-1]:
            figures.draw_level(axes, value, upright=True)
    width, small = figures.PAGE_INCHES / PANELS_PER_ROW - 0.4, figures.MIN_FONT_PT
    axes.set_title(figures.wrap_text(f"{row.finding.key}: {row.verdict}", width, small), fontsize=small)
    figures.label_axes(axes, figures.wrap_text(row.setting, width, small), figures.wrap_text(row.quantity, 1.8, small))


def _csv_row(row: Compared) -> tuple[Any, ...]:
    """Row of the CSV, which holds every word."""
    finding = row.finding
    said = finding.key, *finding.source, finding.quote, finding.stated, finding.sign
    return *said, row.quantity, row.setting, _format_points(row), row.verdict.value, row.note


def _format_points(row: Compared) -> str:
    return "; ".join(
        f"{formatting.format_number(at)}: {formatting.format_with_error(value.value or 0.0, value.se or 0.0)}"
        for at, value in row.points
    )


def _describe_source(source: Source) -> str:
    quotes = "; ".join(f"{finding.key}: “{finding.quote}”" for finding in FINDINGS if finding.source == source)
    return f"{source.citation}. <{source.address}>. Read: {source.read}. {quotes}."
