"""Figure of what accuracy costs in time: the front of what is worth running, the rest in grey."""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter, NullLocator

from walkergen.files.figures import PAGE, SMALLEST, logarithmic, style, wrapped
from walkergen.jobs.trust.accuracy.ladder import Rung
from walkergen.jobs.trust.accuracy.setting import Measured, Unit
from walkergen.jobs.trust.accuracy.speeds import Survey

Array = npt.NDArray[np.float64]

FRONT, REST, FAINT = "#0072B2", "0.45", "0.75"
"""Colours of the front, of the names and of the lines of the rest."""

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


@style()
def choice_figure(
    survey: Survey, measurements: Sequence[Measured], reference: Measured, formulas: Iterable[Rung], title: str
) -> Figure:
    """Draw the total error with 95 % confidence against CPU time: of each setting, and the front.

    The front is the least error of the complete model's settings for a time.
    """
    unit = survey.unit(reference)
    lines = [_line(survey, measured, reference, unit) for measured in measurements]
    drawn = [line for line in lines if line is not None]
    rungs = sorted(formulas, key=lambda rung: rung.error or 0.0)
    figure = Figure(figsize=(PAGE, 3.6), layout="constrained")
    axes = figure.add_subplot()
    axes.set_xscale("log")
    axes.set_yscale("log")
    _limit(axes, drawn, rungs)
    parts = [part for part in front([line for line in drawn if line.worth]) if _length(part) > SHORT]
    named = {line.name for line, _, _ in parts}
    _draw_rest(axes, [line for line in drawn if line.name not in named])
    _draw_front(axes, parts)
    _draw_formulas(axes, rungs)
    _label(axes, unit)
    axes.plot([], [], color=FRONT, linewidth=2.2, label="least error for the time")
    axes.plot([], [], color=FAINT, linewidth=0.9, label="another model, or more time than that")
    axes.plot([], [], "v", color=REST, markerfacecolor="white", label=UNRESOLVED)
    axes.legend(loc="lower left")
    figure.suptitle(wrapped(f"What accuracy costs in time: {title}", PAGE - 0.2))
    return figure


def _line(survey: Survey, measured: Measured, reference: Measured, unit: Unit) -> Line | None:
    """Line of a setting; None for one without a mean speed."""
    bias, bound = survey.bias(measured, reference), survey.bound(measured, reference)
    if bias is None or bound is None:
        return None
    time = np.geomspace(0.5, 1e6, 600)
    statistical = 2.0 * np.sqrt(measured.variance_time / time)
    resolved = bias.certain > 0.0 or bound > bias.bound
    shown = statistical > (FLAT if resolved else 1.0) * bound
    shown[0] = True
    cost = measured.cpu_per_s * (time + measured.runs * measured.discard_seconds)
    error = (bound + statistical) / unit.size
    worth = measured.setting.model == survey.complete
    return Line(measured.setting.label, cost[shown], error[shown], resolved, worth)


Part = tuple[Line, Array, Array]
"""Line, and the costs and errors at which it is the front."""


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
        span = slice(first, last + 1)  # up to where the next one begins
        inside = cost[span] <= line.cost[-1]
        at = cost[span][inside]
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
    last = np.inf
    for line, cost, error in parts:
        axes.plot(line.cost, line.error, color=FAINT, linewidth=0.9, zorder=1)
        axes.plot(cost, error, color=FRONT, linewidth=2.2, zorder=3, solid_capstyle="round")
        _end(axes, line, FRONT)
        # The geometric middle of the errors: a line falls first, and flattens then
        place = int(np.argmin(np.abs(np.log(error) - 0.5 * np.log(error[0] * error[-1]))))
        at = axes.transData.transform((cost[place], error[place]))
        scale = 72.0 / axes.figure.dpi
        shift = min(0.0, scale * (last - at[1]) - LINE)
        last = at[1] + shift / scale
        if line.name not in {text.get_text() for text in axes.texts}:
            _say(axes, line.name, (cost[place], error[place]), (-7, shift - 3), FRONT, "right")


def _draw_rest(axes: Axes, lines: Sequence[Line]) -> None:
    """Draw what is not worth its time, thin and grey, with names at the ends, one below another."""
    ends = sorted(lines, key=lambda line: -line.error[-1])
    last = np.inf
    for line in ends:
        axes.plot(line.cost, line.error, color=FAINT, linewidth=0.9, zorder=1)
        if line.resolved and len(line.cost) == 1:
            axes.plot(line.cost, line.error, ".", color=FAINT, zorder=1)
        _end(axes, line, REST)
        at = axes.transData.transform((line.cost[-1], line.error[-1]))[1]
        scale = 72.0 / axes.figure.dpi
        shift = min(0.0, scale * (last - at) - LINE)
        last = at + shift / scale
        _say(axes, line.name, (line.cost[-1], line.error[-1]), (5, shift), REST, "left")


def _end(axes: Axes, line: Line, colour: str) -> None:
    """Mark the end of a line whose bias the survey did not resolve as a bound."""
    if not line.resolved:
        axes.plot(line.cost[-1], line.error[-1], "v", color=colour, markerfacecolor="white", markersize=6, zorder=4)


def _draw_formulas(axes: Axes, rungs: Sequence[Rung]) -> None:
    """Draw formulas, which have no line, as stars; the names of two stand below and above."""
    for number, rung in enumerate(rungs):
        assert rung.error is not None
        axes.plot(rung.cpu_s, rung.error, "*", color="black", markersize=7, zorder=4)
        _say(axes, rung.series, (rung.cpu_s, rung.error), (6, LINE * (number - 0.5)), "black", "left")


def _say(axes: Axes, text: str, at: Any, offset: tuple[float, float], colour: str, ha: str) -> None:
    """Write a name beside a point."""
    axes.annotate(
        text,
        at,
        offset,
        textcoords="offset points",
        ha=ha,
        va="center",
        color=colour,
        fontsize=SMALLEST,
        zorder=5,
        path_effects=[withStroke(linewidth=2.5, foreground="white")],
    )


def _label(axes: Axes, unit: Unit) -> None:
    """Name both axes; errors that are shares in per cent."""
    axes.set_xlabel("CPU time (s of one core)")
    logarithmic(axes.xaxis)
    name = "%" if unit.relative else unit.name
    axes.set_ylabel(wrapped(f"error of the mean speed, 95 % confidence ({name})", 2.9))
    if not unit.relative:
        logarithmic(axes.yaxis)
        return
    low, high = axes.get_ylim()
    shares = [share for share in SHARES if low <= share <= high]
    for share in shares:
        axes.axhline(share, color="0.92", linewidth=0.6, zorder=0)
    axes.yaxis.set_major_locator(FixedLocator(shares))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda share, _: f"{100.0 * share:g}"))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_minor_formatter(NullFormatter())
