"""Figure of what accuracy costs in time: the least error for a time, and what it is made of."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from walkergen.commands.accuracy.choice import MIN_CURVE_S, RUN_COUNTS, Candidate
from walkergen.core.numerics import Array
from walkergen.core.numerics.quantity import Quantity
from walkergen.files.figures import (
    BLACK,
    BLUE,
    GREY,
    MIN_FONT_PT,
    ORANGE,
    PALE,
    add_legend_below,
    label_axes,
    new_grid,
    style,
)
from walkergen.files.figures import wrap_text as lines_of

ERROR_TICKS = (1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001)
"""Errors that the axis names."""

AXIS_MARGIN_FACTOR = 1.6
"""Factor between the ends of an axis and what is nearest to them."""


Mark = tuple[str, float, Quantity]
"""Name of a step that was measured, its CPU time, s, and its bias."""


class Point(NamedTuple):
    """Answer on the front: an error, the time that it takes, and words for both."""

    error: float
    cpu_s: float
    words: str


class FigureData(NamedTuple):
    """All that the figure shows."""

    title: str
    candidates: Sequence[Candidate]
    marks: Sequence[Mark]
    points: Sequence[Point]
    floor: float
    """Error (95 %) of the reference: nothing is drawn below it."""


class Front(NamedTuple):
    """Least error for a time, and its two parts, each of shape (n,)."""

    cpu_s: Array
    scatter: Array
    bias: Array
    total: Array


def compute_front(candidates: Sequence[Candidate], longest_s: float) -> Front:
    """Return the least error that any candidate reaches, against CPU time up to `longest_s` (s)."""
    cheapest = min(one.cpu_per_s * (RUN_COUNTS[0] * one.discard_s + MIN_CURVE_S) for one in candidates)
    cpu = np.geomspace(cheapest, max(longest_s, 3.0 * cheapest), 400)
    scatter = np.array([one.scatter_error(cpu) for one in candidates])
    bias = np.array([one.bias for one in candidates])[:, None] * np.ones_like(scatter)
    total = np.hypot(scatter, bias)
    best, columns = total.argmin(axis=0), np.arange(len(cpu))
    return Front(cpu, scatter[best, columns], bias[best, columns], total[best, columns])


@style()
def choice_figure(shown: FigureData) -> Figure:
    """Draw the least error against CPU time with its parts, answers on it, and measured biases."""
    figure, (axes,) = new_grid(f"What accuracy costs in time: {shown.title}", count=1, across=1, height=3.6)
    axes.set_xscale("log")
    axes.set_yscale("log")
    longest = max([point.cpu_s for point in shown.points], default=0.0)
    marks = [mark for mark in shown.marks if mark[2].number > shown.floor]
    times = [*(cpu_s for _, cpu_s, _ in marks), *(point.cpu_s for point in shown.points)]
    errors = [*(bias.number for *_, bias in marks), *(point.error for point in shown.points)]
    if shown.candidates:
        least = compute_front(shown.candidates, 2.0 * longest)
        seen = least.total >= shown.floor
        times, errors = [*times, *least.cpu_s[seen]], [*errors, *least.total[seen]]
        _draw_front(axes, least, shown.floor)
    _set_limits(axes, times, errors, shown.floor)
    _draw_marks(axes, marks, shown.floor)
    for point in shown.points:
        axes.plot(point.cpu_s, point.error, "o", color=BLUE, markersize=5, zorder=4)
        _annotate_point(axes, point.words, (point.cpu_s, point.error), (6, 6), BLUE)
    _draw_floor(axes, shown)
    _label_axes(axes)
    add_legend_below(figure, 4)
    return figure


def _draw_front(axes: Axes, least: Front, floor: float) -> None:
    """Draw the least error, thick, and its parts, thin; nothing below the floor."""
    for values, look, label in (
        (least.total, {"color": BLUE, "linewidth": 2.4, "zorder": 3}, "least error for the time"),
        (least.scatter, {"color": GREY, "linewidth": 1.0, "linestyle": "--"}, "part from the scatter of runs"),
        (least.bias, {"color": ORANGE, "linewidth": 1.0, "linestyle": "-."}, "part from the step, at most"),
    ):
        axes.plot(least.cpu_s, np.where(values >= floor, values, np.nan), label=label, **look)  # type: ignore[arg-type]


def _draw_marks(axes: Axes, marks: Sequence[Mark], floor: float) -> None:
    """Draw biases that were measured, with bars of 95 % that end at the floor."""
    for number, (words, cpu_s, bias) in enumerate(marks):
        below = min(bias.half_width(), bias.number - floor)
        label = "bias measured, ± 95 %" if number == 0 else None
        bars = [[below], [bias.half_width()]]
        axes.errorbar(
            cpu_s, bias.number, bars, fmt="s", color=BLACK, markersize=4, capsize=2, elinewidth=0.8, label=label
        )
        _annotate_point(axes, words, (cpu_s, bias.number), (5, -9), BLACK)


def _draw_floor(axes: Axes, shown: FigureData) -> None:
    """Shade the errors below the uncertainty of the reference."""
    axes.axhspan(axes.get_ylim()[0], shown.floor, color=PALE, linewidth=0, zorder=0)
    text = f"below the error of the reference, {100 * shown.floor:.2g} %"
    text_style = {"transform": axes.transAxes, "va": "bottom", "ha": "left", "fontsize": MIN_FONT_PT, "color": GREY}
    axes.text(0.01, 0.015, text, **text_style)  # type: ignore[arg-type]


def _set_limits(axes: Axes, times: Sequence[float], errors: Sequence[float], floor: float) -> None:
    """Set the limits of both axes from CPU times (s) and errors, with space for labels."""
    axes.set_xlim(min(times, default=0.1) / AXIS_MARGIN_FACTOR, 3.0 * AXIS_MARGIN_FACTOR * max(times, default=10.0))
    axes.set_ylim(0.5 * floor, min(AXIS_MARGIN_FACTOR * max(errors, default=1.0), AXIS_MARGIN_FACTOR * ERROR_TICKS[0]))


def _annotate_point(axes: Axes, text: str, at: tuple[float, float], offset: tuple[float, float], colour: str) -> None:
    """Write text next to the point `at`, shifted by `offset` in points."""
    halo: Any = {"path_effects": [withStroke(linewidth=2.5, foreground="white")], "fontsize": MIN_FONT_PT, "zorder": 5}
    axes.annotate(text, at, offset, textcoords="offset points", va="center", color=colour, **halo)


def _label_axes(axes: Axes) -> None:
    """Name both axes; errors in per cent."""
    label_axes(axes, "CPU time (s of one core)", lines_of("error of the mean speed, 95 % (%)", 2.9), log="xy")
    low, high = axes.get_ylim()
    axes.yaxis.set_major_locator(FixedLocator([share for share in ERROR_TICKS if low <= share <= high]))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda share, _: f"{100.0 * share:g}"))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.grid(axis="y", color="0.92", linewidth=0.6, zorder=0)
