"""Figure of what accuracy costs in time: the least error for a time, and what it is made of."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from walkergen.files.figures import BLACK, BLUE, GREY, ORANGE, PALE, SMALLEST, grid_of, legend_below, name, style
from walkergen.files.figures import wrapped as lines_of
from walkergen.theory.surrogate import NORMAL_95

Array = npt.NDArray[np.float64]

SHARES = (1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001)
"""Errors that the axis names, in the unit of the figure."""

SHORTEST_S = 0.5
"""Measured time of all runs of a setting from which its curve is drawn, s."""

ROOM = 1.6
"""Factor between the ends of an axis and what is nearest to them."""


class Curve(NamedTuple):
    """Setting of which is chosen: its error (95 %) against its time. Errors are in the unit of the figure."""

    name: str
    bias: float
    """Bound of its bias."""
    variance_time: float
    """Squared standard error of the mean speed times measured time, (unit)^2 s."""
    cpu_per_s: float
    """CPU time of a simulated second, s."""
    discard_s: float
    """Starts of all runs that are not measured, s."""

    def scatter(self, cpu_s: Array) -> Array:
        """Error by the runs' scatter in a time; infinite where there is none to measure."""
        measured_s = cpu_s / self.cpu_per_s - self.discard_s
        with np.errstate(divide="ignore", invalid="ignore"):
            half = NORMAL_95 * np.sqrt(self.variance_time / measured_s)
        return np.where(measured_s >= SHORTEST_S, half, np.inf)


class Mark(NamedTuple):
    """What was measured of a setting at once: its bias against the reference, with its error."""

    name: str
    cpu_s: float
    bias: float
    se: float


class Point(NamedTuple):
    """Answer on the front: an error, the time that it takes, and words for both."""

    error: float
    cpu_s: float
    words: str


class Shown(NamedTuple):
    """All that the figure shows."""

    title: str
    unit: str
    """Name of the unit of errors: "%" for shares of the mean speed, else in words."""
    curves: Sequence[Curve]
    marks: Sequence[Mark]
    points: Sequence[Point]
    floor: float
    """Error (95 %) of the reference: nothing is drawn below it."""
    note: str = ""
    """What has no place on the axes, as formulas."""


class Front(NamedTuple):
    """Least error for a time, and its two parts, each of shape (n,)."""

    cpu_s: Array
    scatter: Array
    bias: Array
    total: Array


def front(curves: Sequence[Curve], longest_s: float) -> Front:
    """Least error of some curves up to a time, from where the first of them has one."""
    cheapest = min(curve.cpu_per_s * (curve.discard_s + SHORTEST_S) for curve in curves)
    cpu = np.geomspace(cheapest, max(longest_s, 3.0 * cheapest), 400)
    scatter = np.array([curve.scatter(cpu) for curve in curves])
    bias = np.array([curve.bias for curve in curves])[:, None] * np.ones_like(scatter)
    total = np.hypot(scatter, bias)
    least, at = total.argmin(axis=0), np.arange(len(cpu))
    return Front(cpu, scatter[least, at], bias[least, at], total[least, at])


@style()
def choice_figure(shown: Shown) -> Figure:
    """Draw the least error against CPU time with its parts, answers on it, and what was measured beside it."""
    figure, (axes,) = grid_of(f"What accuracy costs in time: {shown.title}", 1, 1, 3.6)
    axes.set_xscale("log")
    axes.set_yscale("log")
    longest = max([point.cpu_s for point in shown.points], default=0.0)
    marks = [mark for mark in shown.marks if mark.bias > shown.floor]
    times = [*(mark.cpu_s for mark in marks), *(point.cpu_s for point in shown.points)]
    errors = [*(mark.bias for mark in marks), *(point.error for point in shown.points)]
    if shown.curves:
        least = front(shown.curves, 2.0 * longest)
        seen = least.total >= shown.floor
        times, errors = [*times, *least.cpu_s[seen]], [*errors, *least.total[seen]]
        _draw_front(axes, least, shown.floor)
    _limit(axes, times, errors, shown.floor)
    _draw_marks(axes, marks, shown.floor)
    for point in shown.points:
        axes.plot(point.cpu_s, point.error, "o", color=BLUE, markersize=5, zorder=4)
        _say(axes, point.words, (point.cpu_s, point.error), (6, 6), BLUE)
    _draw_floor(axes, shown)
    _label(axes, shown.unit)
    legend_below(figure, 4)
    return figure


def _draw_front(axes: Axes, least: Front, floor: float) -> None:
    """Draw the least error, thick, and its parts, thin; nothing below the floor."""
    for values, look, label in (
        (least.total, {"color": BLUE, "linewidth": 2.4, "zorder": 3}, "least error for the time"),
        (least.scatter, {"color": GREY, "linewidth": 1.0, "linestyle": "--"}, "by the runs' scatter"),
        (least.bias, {"color": ORANGE, "linewidth": 1.0, "linestyle": "-."}, "by model and step, at most"),
    ):
        axes.plot(least.cpu_s, np.where(values >= floor, values, np.nan), label=label, **look)  # type: ignore[arg-type]


def _draw_marks(axes: Axes, marks: Sequence[Mark], floor: float) -> None:
    """Draw biases that were measured, with bars of two errors that end at the floor."""
    for number, mark in enumerate(marks):
        below = min(2.0 * mark.se, mark.bias - floor)
        label = "bias measured, ± 95 %" if number == 0 else None
        bars = [[below], [2.0 * mark.se]]
        axes.errorbar(
            mark.cpu_s, mark.bias, bars, fmt="s", color=BLACK, markersize=4, capsize=2, elinewidth=0.8, label=label
        )
        _say(axes, mark.name, (mark.cpu_s, mark.bias), (5, -9), BLACK)


def _draw_floor(axes: Axes, shown: Shown) -> None:
    """Shade what the reference does not know, and write the note there."""
    low = axes.get_ylim()[0]
    axes.axhspan(low, shown.floor, color=PALE, linewidth=0, zorder=0)
    told = f"{100 * shown.floor:.2g} %" if shown.unit == "%" else f"{shown.floor:.2g}"
    text = f"below {told} the reference itself is not known" + (f"\n{shown.note}" if shown.note else "")
    place = {"transform": axes.transAxes, "va": "bottom", "ha": "left", "fontsize": SMALLEST, "color": GREY}
    axes.text(0.01, 0.015, text, **place)  # type: ignore[arg-type]


def _limit(axes: Axes, times: Sequence[float], errors: Sequence[float], floor: float) -> None:
    """Set the ends of the axes: where simulations are, with room for names on the right and words below."""
    axes.set_xlim(min(times, default=0.1) / ROOM, 3.0 * ROOM * max(times, default=10.0))
    axes.set_ylim(0.5 * floor, min(ROOM * max(errors, default=1.0), ROOM * SHARES[0]))


def _say(axes: Axes, text: str, at: tuple[float, float], offset: tuple[float, float], colour: str) -> None:
    """Write words beside a point."""
    halo: Any = {"path_effects": [withStroke(linewidth=2.5, foreground="white")], "fontsize": SMALLEST, "zorder": 5}
    axes.annotate(text, at, offset, textcoords="offset points", va="center", color=colour, **halo)


def _label(axes: Axes, unit: str) -> None:
    """Name both axes; errors that are shares in per cent."""
    shares = unit == "%"
    name(axes, "CPU time (s of one core)", lines_of(f"error of the mean speed, 95 % ({unit})", 2.9), log="xy")
    if shares:
        low, high = axes.get_ylim()
        named = [share for share in SHARES if low <= share <= high]
        axes.yaxis.set_major_locator(FixedLocator(named))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda share, _: f"{100.0 * share:g}"))
        axes.yaxis.set_minor_locator(NullLocator())
        axes.grid(axis="y", color="0.92", linewidth=0.6, zorder=0)
