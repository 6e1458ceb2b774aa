"""Picture of the true error of each engine against its time."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from evidence.work_precision.measure import DRAKE, MUJOCO, OURS, Row
from walkergen.core.theory.surrogate import NORMAL_95
from walkergen.files.figures import BLUE, GREY, MIN_FONT_PT, ORANGE, add_legend_below, label_axes, new_grid, style

LOOKS: dict[str, Any] = {
    OURS: {"color": BLUE, "marker": "o", "linestyle": "-"},
    MUJOCO: {"color": ORANGE, "marker": "s", "linestyle": "--"},
    DRAKE: {"color": GREY, "marker": "D", "linestyle": "-."},
}
"""Line of each engine."""

ERROR_TICKS = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
"""Errors on the axis, %."""

LOWEST_ERROR = 0.3
"""Lower end of the axis, %."""

LABEL_FACTOR = 1.15
"""Lower end of a label over the upper end of its bar."""


@style()
def draw_work_precision(rows: Sequence[Row]) -> Figure:
    """Draw the true error of every setting against its CPU time."""
    title = "What accuracy costs in three engines: walker of 10 deg on an open plate, legs without twist"
    figure, (axes,) = new_grid(title, count=1, across=1, height=3.6)
    axes.set_xscale("log")
    axes.set_yscale("log")
    for engine, look in LOOKS.items():
        _draw_engine(axes, [row for row in rows if row.engine == engine], look)
    axes.set_ylim(LOWEST_ERROR, 200.0)
    axes.set_xlim(2e-3, 40.0)
    label_axes(axes, "CPU time for a simulated second (s)", "true error of the mean speed (%)", log="xy")
    axes.yaxis.set_major_locator(FixedLocator(ERROR_TICKS))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_locator(NullLocator())
    add_legend_below(figure, 3)
    return figure


def true_error(row: Row, reference: Row) -> tuple[float, float]:
    """Return the error of the mean speed of a setting and half its 95 % interval, both in % of the reference."""
    scale = 100.0 / abs(reference.speed_mm_s)
    half = NORMAL_95 * float(np.hypot(row.se_mm_s, reference.se_mm_s))
    return scale * abs(row.speed_mm_s - reference.speed_mm_s), scale * half


def _draw_engine(axes: Axes, rows: Sequence[Row], look: dict[str, Any]) -> None:
    """Draw the settings of one engine: bars of 95 %, and an open triangle at the upper end of a bar that contains 0."""
    (reference,) = [row for row in rows if row.is_reference]
    colour, times, tops = look["color"], [], []
    for row in rows:
        if row.is_reference or row.diverged:
            continue
        error, half = true_error(row, reference)
        certain = error > half
        top = error if certain else error + half
        low = half if certain else top - LOWEST_ERROR
        bars = [[min(low, top - LOWEST_ERROR)], [half if certain else 0.0]]
        marker, fill = (look["marker"], colour) if certain else ("v", "white")
        axes.errorbar(row.cpu_s_per_s, top, bars, color=colour, capsize=2, elinewidth=0.6, zorder=2)
        axes.plot(row.cpu_s_per_s, top, marker, color=colour, markerfacecolor=fill, markersize=5, zorder=4)
        above = row.cpu_s_per_s, LABEL_FACTOR * (error + half)
        axes.text(*above, row.setting.replace("us", "µs"), rotation=60, ha="left", fontsize=MIN_FONT_PT, color=colour)
        times.append(row.cpu_s_per_s)
        tops.append(top)
    axes.plot(times, tops, color=colour, linestyle=look["linestyle"], linewidth=1.1, label=rows[0].engine, zorder=3)
