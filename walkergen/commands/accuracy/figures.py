"""Figure of what accuracy costs: the least error for the seconds that a user waits, and the recommended settings."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from walkergen.commands.accuracy.choice import MIN_CURVE_S, RUN_COUNTS, Candidate, wall_time_s
from walkergen.core.numerics import Array
from walkergen.files.figures import BLUE, GREY, MIN_FONT_PT, PALE, add_legend_below, label_axes, new_grid, style
from walkergen.files.figures import wrap_text as lines_of

ERROR_TICKS = (1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001)
"""Errors that the axis names."""

AXIS_MARGIN_FACTOR = 1.6
"""Factor between the ends of an axis and what is nearest to them."""


class Point(NamedTuple):
    """Setting of the table: the error that it meets, the seconds that a user waits, and words for both."""

    error: float
    wait_s: float
    words: str


class FigureData(NamedTuple):
    """All that the figure shows."""

    title: str
    candidates: Sequence[Candidate]
    points: Sequence[Point]
    absent: Sequence[str]
    """Errors of the table without a point, each with the reason."""
    floor: float
    """Error (95 %) of the reference: nothing is drawn below it."""
    cores: int
    """Number of cores of this machine."""


class Front(NamedTuple):
    """Least error for a CPU time, arrays of shape (n,)."""

    cpu_s: Array
    total: Array


def compute_front(candidates: Sequence[Candidate], longest_s: float) -> Front:
    """Return the least error that any candidate reaches, against CPU time up to `longest_s` (s)."""
    cheapest = min(one.cpu_per_s * (RUN_COUNTS[0] * one.discard_s + MIN_CURVE_S) for one in candidates)
    cpu = np.geomspace(cheapest, max(longest_s, 3.0 * cheapest), 400)
    return Front(cpu, np.min([np.hypot(one.scatter_error(cpu), one.bias) for one in candidates], axis=0))


@style()
def choice_figure(shown: FigureData) -> Figure:
    """Draw the least error against the seconds that a user waits, and the settings of the table."""
    figure, (axes,) = new_grid(shown.title, count=1, across=1, height=3.6)
    axes.set_xscale("log")
    axes.set_yscale("log")
    times, errors = [point.wait_s for point in shown.points], [point.error for point in shown.points]
    if shown.candidates:
        longest_s = 2.0 * max(times, default=10.0) * min(shown.cores, RUN_COUNTS[0])
        least = compute_front(shown.candidates, longest_s)
        waits = wall_time_s(least.cpu_s, RUN_COUNTS[0], shown.cores)
        seen = least.total >= shown.floor
        times, errors = [*times, *waits[seen]], [*errors, *least.total[seen]]
        axes.plot(waits[seen], least.total[seen], color=BLUE, linewidth=2.0, label="least error for the time")
    axes.set_xlim(min(times, default=1.0) / AXIS_MARGIN_FACTOR, AXIS_MARGIN_FACTOR * max(times, default=10.0))
    highest = AXIS_MARGIN_FACTOR * min(max(errors, default=1.0), ERROR_TICKS[0])
    axes.set_ylim(0.5 * shown.floor, highest)
    for number, point in enumerate(shown.points):
        label = "settings of the table" if number == 0 else None
        axes.plot(point.wait_s, point.error, "o", color=BLUE, markersize=5, zorder=4, label=label)
        halo: Any = {"path_effects": [withStroke(linewidth=2.5, foreground="white")], "fontsize": MIN_FONT_PT}
        axes.annotate(point.words, point[1::-1], (6, 6), textcoords="offset points", va="center", zorder=5, **halo)
    _draw_floor(axes, shown)
    _label_axes(axes, shown.cores)
    add_legend_below(figure, 2)
    return figure


def _draw_floor(axes: Axes, shown: FigureData) -> None:
    """Shade the errors below the uncertainty of the reference, and list the errors without a point."""
    axes.axhspan(axes.get_ylim()[0], shown.floor, color=PALE, linewidth=0, zorder=0)
    text = f"below the error of the reference, {100 * shown.floor:.2g} %"
    text += f"; no dot for {' and '.join(shown.absent)}" if shown.absent else ""
    text_style = {"transform": axes.transAxes, "va": "bottom", "ha": "left", "fontsize": MIN_FONT_PT, "color": GREY}
    axes.text(0.01, 0.015, text, **text_style)  # type: ignore[arg-type]


def _label_axes(axes: Axes, cores: int) -> None:
    """Name both axes; errors in per cent."""
    seconds = f"seconds that you wait on this machine (cores: {cores})"
    label_axes(axes, seconds, lines_of("error of the mean speed, 95 % (%)", 2.9), log="xy")
    low, high = axes.get_ylim()
    axes.yaxis.set_major_locator(FixedLocator([share for share in ERROR_TICKS if low <= share <= high]))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda share, _: f"{100.0 * share:g}"))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.grid(axis="y", color="0.92", linewidth=0.6, zorder=0)
