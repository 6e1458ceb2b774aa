"""Figure of our crowds: a panel for each statement with its numbers, marked by its verdict."""

import math
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from evidence.crowds_published.claims import Compared
from walkergen.files.figures import PAGE, SMALLEST, style, wrapped

COLUMNS = 3

MARKS = {"agrees": "#0072B2", "disagrees": "#D55E00", "undecided": "0.45", "not compared": "0.45"}
"""Colours by verdict, of Okabe and Ito."""


def draw(compared: Sequence[Compared]) -> Figure:
    """Draw a panel a statement whose numbers were made: means and one standard error."""
    shown = [one for one in compared if len(one.points) > 1]
    rows = max(1, math.ceil(len(shown) / COLUMNS))
    with style():
        figure = Figure(figsize=(PAGE, 2.2 * rows), layout="constrained")
        grid = figure.subplots(rows, COLUMNS, squeeze=False).ravel()
        for axes, one in zip(grid, shown, strict=False):
            _panel(axes, one)
        for axes in grid[len(shown) :]:
            axes.set_axis_off()
        figure.suptitle("Crowds beside published ones: bars are one standard error")
    return figure


def _panel(axes: Axes, one: Compared) -> None:
    at = [place for place, _ in one.points]
    means = [value.mean for _, value in one.points]
    errors = [value.se for _, value in one.points]
    axes.errorbar(at, means, errors, marker="o", color=MARKS[one.word], capsize=3, linewidth=0.9)
    axes.axhline(0.0, color="0.7", linewidth=0.6)
    width = PAGE / COLUMNS - 0.4
    axes.set_title(wrapped(f"{one.finding.key}: {one.word}", width, SMALLEST), fontsize=SMALLEST)
    axes.set_xlabel(wrapped(one.setting, width, SMALLEST), fontsize=SMALLEST)
    axes.set_ylabel(wrapped(one.quantity, 1.8, SMALLEST), fontsize=SMALLEST)
    for value in one.finding.values:
        if at[0] <= value <= at[-1]:
            axes.axvline(value, color="0.7", linestyle=":", linewidth=0.8)
