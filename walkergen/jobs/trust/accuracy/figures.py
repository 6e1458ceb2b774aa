"""Figure of what accuracy costs in time: the front of what is worth running, the rest in grey."""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from walkergen.files.figures import BLACK, BLUE, FAINT, GREY, SMALLEST, grid_of, legend_below, name, style, wrapped
from walkergen.jobs.trust.accuracy.ladder import Rung
from walkergen.jobs.trust.accuracy.setting import Measured, Unit
from walkergen.jobs.trust.accuracy.survey import Survey

Array = npt.NDArray[np.float64]

SHARES = (2.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001)
"""Relative errors that the axis names."""

FLAT = 0.1
"""Share of the statistical error in the bias at which the line of a known bias ends: more time
would change nothing."""

SHORT = 0.06
"""Decades, along cost and error together, below which a part of the front is as good as none."""

LINE = 9.5
"""Distance of two names above one another, points."""

ROOM, MARGIN = 15.0, 1.3
"""Largest cost of the axis over that of a line's end, where its name stands; and the factor
between the axis's ends and the least and the largest error."""

UNRESOLVED = "at most this: the budget did not tell the bias from 0"


class Line(NamedTuple):
    """Total error of a setting against its cost."""

    name: str
    cost: Array
    """CPU time, s, rising."""
    error: Array
    """Error with 95 % confidence, in the unit of the figure."""
    resolved: bool
    """True where the bias differs from zero: the line goes on as its bias. Else it ends where its
    statistical error falls below the bound that the survey could give."""
    worth: bool
    """True for settings of the complete model, of which `simulate --error` chooses."""


Part = tuple[Line, Array, Array]
"""Line, and the costs and errors at which it is the front."""


@style()
def choice_figure(
    survey: Survey, measurements: Sequence[Measured], reference: Measured, formulas: Iterable[Rung], title: str
) -> Figure:
    """Draw the total error with 95 % confidence against CPU time: of each setting, and the front.

    The front is the least error of the complete model's settings for a time.
    """
    unit = survey.unit(reference)
    lines = [line for measured in measurements if (line := _line(survey, measured, reference, unit)) is not None]
    rungs = sorted(formulas, key=lambda rung: rung.error or 0.0)
    figure, (axes,) = grid_of(f"What accuracy costs in time: {title}", 1, 1, 3.6)
    axes.set_xscale("log")
    axes.set_yscale("log")
    _limit(axes, lines, rungs)
    parts = [part for part in front([line for line in lines if line.worth]) if _length(part) > SHORT]
    _draw_front(axes, parts)
    named = {line.name for line, _, _ in parts}
    _draw_rest(axes, [line for line in lines if line.name not in named])
    for number, rung in enumerate(rungs):  # formulas have no line; the names of two stand below and above
        axes.plot([rung.cpu_s], [rung.error or np.nan], "*", color=BLACK, markersize=7, zorder=4)
        _say(axes, rung.series, (rung.cpu_s, rung.error), (6, LINE * (number - 0.5)), BLACK, "left")
    _label(axes, unit)
    axes.plot([], [], color=BLUE, linewidth=2.2, label="least error for the time")
    axes.plot([], [], color=FAINT, linewidth=0.9, label="another model, or more time than that")
    axes.plot([], [], "v", color=GREY, markerfacecolor="white", label=UNRESOLVED)
    legend_below(figure, 3)
    return figure


def _line(survey: Survey, measured: Measured, reference: Measured, unit: Unit) -> Line | None:
    """Line of a setting; None for one without a mean speed."""
    bias, bound = survey.bias(measured, reference), survey.bound(measured, reference)
    if bias is None or bound is None:
        return None
    time = np.geomspace(0.5, 1e6, 600)
    statistical = 2.0 * np.sqrt(measured.variance_time() / time)
    resolved = bias.certain > 0.0 or bound > bias.bound
    shown = statistical > (FLAT if resolved else 1.0) * bound
    shown[0] = True
    cost = measured.cpu_per_s * (time + measured.runs * measured.discard_seconds)
    error = (bound + statistical) / unit.size
    worth = measured.setting.model == survey.complete
    return Line(measured.setting.label, cost[shown], error[shown], resolved, worth)


def front(lines: Sequence[Line]) -> list[Part]:
    """Parts of lines that have the least error for their cost, in the order of cost.

    Beyond the end of a line its last error counts: nothing is gained, but it is not lost.
    """
    if not lines:
        return []
    cost = np.unique(np.concatenate([line.cost for line in lines]))
    errors = np.array([np.interp(cost, line.cost, line.error, left=np.inf) for line in lines])
    least = errors.argmin(axis=0)
    starts = [0, *(np.flatnonzero(np.diff(least)) + 1), len(cost)]
    parts = []
    for first, last in pairwise(starts):
        line = lines[least[first]]
        at = cost[first : last + 1]  # up to where the next one begins
        at = at[at <= line.cost[-1]]
        if len(at):
            parts.append((line, at, np.interp(at, line.cost, line.error)))
    return parts


def _length(part: Part) -> float:
    """Length of a part of the front, decades along cost and error together."""
    _, cost, error = part
    return float(np.log10(cost[-1] / cost[0]) + np.log10(error[0] / error[-1]))


def _limit(axes: Axes, lines: Sequence[Line], rungs: Sequence[Rung]) -> None:
    """Set the ends of the axes, with room for names on the right."""
    costs = [*(rung.cpu_s for rung in rungs), *(x for line in lines for x in line.cost[[0, -1]])]
    errors = [rung.error for rung in rungs if rung.error]
    errors += [y for line in lines for y in line.error[[0, -1]]]
    axes.set_xlim(0.5 * min(costs), ROOM * max(costs))
    axes.set_ylim(min(errors) / MARGIN**2, MARGIN * max(errors))


def _draw_front(axes: Axes, parts: Sequence[Part]) -> None:
    """Draw the front, thick, with the names of its parts on its left, where nothing can be."""
    last, named = np.inf, set[str]()
    for line, cost, error in parts:
        _thin(axes, line, BLUE)
        axes.plot(cost, error, color=BLUE, linewidth=2.2, zorder=3, solid_capstyle="round")
        # The geometric middle of the errors: a line falls first, and flattens then
        place = int(np.argmin(np.abs(np.log(error) - 0.5 * np.log(error[0] * error[-1]))))
        shift, last = _below(axes, (cost[place], error[place]), last)
        if line.name not in named:
            _say(axes, line.name, (cost[place], error[place]), (-7, shift - 3), BLUE, "right")
        named.add(line.name)


def _draw_rest(axes: Axes, lines: Sequence[Line]) -> None:
    """Draw what is not worth its time, thin and grey, with names at the ends, one below another."""
    last = np.inf
    for line in sorted(lines, key=lambda line: -line.error[-1]):
        _thin(axes, line, GREY)
        if line.resolved and len(line.cost) == 1:
            axes.plot(line.cost, line.error, ".", color=FAINT, zorder=1)
        end = line.cost[-1], line.error[-1]
        shift, last = _below(axes, end, last)
        _say(axes, line.name, end, (5, shift), GREY, "left")


def _thin(axes: Axes, line: Line, colour: str) -> None:
    """Draw a line, thin; where the survey did not resolve its bias its end is marked as a bound."""
    axes.plot(line.cost, line.error, color=FAINT, linewidth=0.9, zorder=1)
    if not line.resolved:
        axes.plot(line.cost[-1], line.error[-1], "v", color=colour, markerfacecolor="white", markersize=6, zorder=4)


def _below(axes: Axes, at: tuple[float, float], last: float) -> tuple[float, float]:
    """Shift (points) of a name at a place, so that it stands below the last one; its height, pixels."""
    height, scale = float(axes.transData.transform(at)[1]), 72.0 / axes.figure.dpi
    shift = min(0.0, scale * (last - height) - LINE)
    return shift, height + shift / scale


def _say(axes: Axes, text: str, at: Any, offset: tuple[float, float], colour: str, side: Any) -> None:
    """Write a name beside a point."""
    halo: Any = {"path_effects": [withStroke(linewidth=2.5, foreground="white")], "fontsize": SMALLEST, "zorder": 5}
    axes.annotate(text, at, offset, textcoords="offset points", ha=side, va="center", color=colour, **halo)


def _label(axes: Axes, unit: Unit) -> None:
    """Name both axes; errors that are shares in per cent."""
    errors = wrapped(f"error of the mean speed, 95 % confidence ({'%' if unit.relative else unit.name})", 2.9)
    name(axes, "CPU time (s of one core)", errors, log="xy")
    if unit.relative:
        low, high = axes.get_ylim()
        shares = [share for share in SHARES if low <= share <= high]
        for share in shares:
            axes.axhline(share, color="0.92", linewidth=0.6, zorder=0)
        axes.yaxis.set_major_locator(FixedLocator(shares))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda share, _: f"{100.0 * share:g}"))
        axes.yaxis.set_minor_locator(NullLocator())
