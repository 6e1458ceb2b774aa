"""Report of simulated prints with random uncertain inputs: a summary, all prints, shares of the variance, a figure."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from walkergen.commands.simulate.report import LINE_COLUMNS, Line
from walkergen.core.files import formatting
from walkergen.core.files.output import Folder
from walkergen.core.numerics import statistics
from walkergen.core.numerics.quantity import Quantity, column_values
from walkergen.core.walker.design import Design
from walkergen.files.report import Report, Table
from walkergen.points import step_errors
from walkergen.points.print_ensemble import PrintScatter
from walkergen.points.speed_table import SHARE_COLUMNS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

UNEXPLAINED = "which print it is"
"""Name of the part of the variance that no input explains: heights of corners, and the emulator's error."""


def make_report(spread: PrintScatter, design: Design, scene: str, folder: Path | None = None) -> Report:
    """Make the report of uncertain prints of a walker in a scene of this name, written to `folder` if given."""
    title = f"{design.name}, {design.tilt_deg:g} deg, {scene}"
    unexplained = spread.unexplained.pair
    lines = []
    if spread.shares:
        share = " ± ".join(formatting.format_fixed(100.0 * value, 0) for value in unexplained)
        lines += [f"{UNEXPLAINED}: {share} % (heights of its corners, and what the fit misses)"]
    if folder is not None:
        lines += [f"draws.csv, shares.csv, uncertain.png and .pdf in {folder}/"]
    inputs = [quantity.name.replace(" ", "_") for quantity in spread.inputs]
    shares = [*(column_values(share).values() for share in spread.shares), (UNEXPLAINED, *unexplained, None, None)]
    return Report(
        name="uncertain",
        title=title,
        facts=_facts(spread),
        lines=lines,
        tables=[
            Table("summary", [Line(*row) for row in summary_rows(spread)], (), LINE_COLUMNS, title),
            Table(
                "shares",
                shares,
                ("input", "first", "first_se", "total", "total_se"),
                SHARE_COLUMNS if spread.shares else (),
                "share of the variance between prints",
                read=spread.shares,
            ),
            Table("draws", np.column_stack([spread.values, spread.speeds]).tolist(), [*inputs, "speed_mm_s"]),
        ],
        figures={"uncertain": lambda: draw_speeds(spread, title)},
    )


def write(report: Report, folder: Path) -> None:
    """Write draws.csv (inputs and speed of every print), shares.csv, uncertain.png and .pdf."""
    with Folder(folder, "") as target:
        report.write_tables(target)
        report.write_figures(target)


def summary_rows(spread: PrintScatter) -> Iterator[tuple[str, str | Quantity]]:
    """Yield name and value of each row of the summary: mean, scatter between prints, and statistical error."""
    (low1, high1), (low2, high2) = (spread.speed.interval(level) or (None, None) for level in (0.68, 0.95))
    scatter, step = spread.between_prints_mm_s or None, step_errors.step_bias(spread.speed)
    yield "mean over prints", spread.speed
    yield (
        "a print",
        f"{formatting.format_range(low1, high1, 3)} mm/s (68 %), {formatting.format_range(low2, high2, 3)} (95 %)",
    )
    short = "not resolved by these short runs. Increase ‹seconds›."
    yield "deviation, print to print", Quantity("deviation", "mm_s", scatter, 0.0, refused="" if scatter else short)
    unknown = "unknown: run `simulate` without ‹uncertain›" if step is None else ""
    yield "error from the step", Quantity("step", "mm_s", step, 0.0, refused=unknown)
    yield "error of each short run", Quantity("statistical", "mm_s", spread.statistical_mm_s, 0.0)
    outcomes = ", ".join(f"{count} x {name}" for name, count in spread.outcomes.items())
    yield "runs", f"a run a draw: {outcomes}"
    for note in notes(spread):
        yield "note", note


def notes(spread: PrintScatter) -> Iterator[str]:
    """Yield notes on the uncertainties that the bounds include, and on those that were removed from them."""
    if spread.draws < statistics.MIN_VALUES_FOR_95:
        yield (
            f"95 % of prints: {spread.draws} draws do not reach its ends, which are extrapolated "
            "by Student's t; they hold 93 to 98 %, by the shape of the scatter; "
            f"{statistics.MIN_VALUES_FOR_95} draws need none"
        )
    if spread.statistical_mm_s > spread.between_prints_mm_s:
        yield (
            "Short runs scatter more than prints. Half of the variance is removed from the bounds, "
            "which remain too wide. Longer ‹seconds› narrows them."
        )
    else:
        yield "the statistical error of short runs is removed from the bounds"


def _facts(spread: PrintScatter) -> dict[str, Any]:
    """Return the results for JSON. Shares are shares of the variance between prints."""
    unexplained = {"share": spread.unexplained.value, "se": spread.unexplained.se}
    return {
        "draws": spread.draws,
        "outcomes": spread.outcomes,
        **spread.speed.row(68, 95),
        "between_prints_mm_s": spread.between_prints_mm_s,
        "statistical_mm_s": spread.statistical_mm_s,
        "by_step_mm_s": step_errors.step_bias(spread.speed),
        "shares": [column_values(share) for share in spread.shares],
        "unexplained": unexplained if spread.shares else None,
        "notes": list(notes(spread)),
    }


def draw_speeds(spread: PrintScatter, title: str) -> "Figure":
    """Draw the speeds of all prints with their bounds, and the shares of the variance."""
    from walkergen.files.figures import style

    with style():
        return _draw_panels(spread, title)


def _draw_panels(spread: PrintScatter, title: str) -> "Figure":
    """Draw a histogram of the speeds, and bars of the shares of the variance."""
    from matplotlib.figure import Figure

    from walkergen.files.figures import PAGE_INCHES, wrap_text

    figure = Figure(figsize=(PAGE_INCHES, 2.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.hist(spread.speeds, bins="auto", color="#0072B2", alpha=0.6)
    for level, shade, depth in ((95, "0.93", -2), (68, "0.86", -1)):
        left.axvspan(
            *(spread.speed.interval(level / 100) or ()), color=shade, zorder=depth, label=f"{level} % of prints"
        )
    left.axvline(spread.speed.number, color="black", linewidth=1.2, label="mean")
    left.set_xlabel("speed (mm/s)")
    left.set_ylabel("prints")
    figure.suptitle(wrap_text(title, PAGE_INCHES - 0.2))
    left.legend(frameon=True, framealpha=0.9, edgecolor="none", loc="upper left")
    names = [*(share.name for share in spread.shares), UNEXPLAINED]
    positions = np.arange(len(names))[::-1]
    error = {"ecolor": "0.3", "capsize": 2, "elinewidth": 0.8}
    first, first_se = np.array([*(share.first.pair for share in spread.shares), spread.unexplained.pair]).T
    total, total_se = np.reshape([share.total.pair for share in spread.shares], (-1, 2)).T
    right.barh(positions + 0.2, first, 0.36, xerr=first_se, error_kw=error, color="#0072B2", label="alone")
    right.barh(
        positions[:-1] - 0.2,
        total,
        0.36,
        xerr=total_se,
        error_kw=error,
        color="#D55E00",
        hatch="////",
        edgecolor="white",
        linewidth=0.0,
        label="with all others",
    )
    right.set_yticks(positions, names)
    right.set_xlim(left=0.0)
    right.set_xlabel("share of the variance between prints")
    right.legend()
    return figure
