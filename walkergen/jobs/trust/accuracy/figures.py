"""Work-precision figures: error against CPU time, or both against the step; logarithmic axes."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walkergen.files.figures import PAGE, SERIES, logarithmic, style, wrapped
from walkergen.jobs.trust.accuracy.ladder import Ladder, Rung

YLABEL = 1.5
"""Length of the lines of a vertical axis's name, inches."""

UNSURE = "open: not told from 0; |error| + 2 SE"


@style()
def ladder_figure(ladder: Ladder) -> Figure:
    """Draw a line per series; open symbols are errors that may be zero, drawn at |error| + 2 SE.

    Ladders along a key, as the step, have error and cost against it in two panels: against one
    another their lines would run to and fro.
    """
    names = {"step_us": "step, us", "value": "step, us", "frame_us": "time between frames, us"}
    panels = 2 if ladder.along else 1
    figure = Figure(figsize=(PAGE, 3.2 if panels == 1 else 4.6), layout="constrained")
    grid = {"height_ratios": (1.7, 1.0)[:panels]}
    axes = figure.subplots(panels, 1, sharex=True, squeeze=False, gridspec_kw=grid)[:, 0]
    drawn = [rung for rung in ladder.rungs if rung.error is not None]
    at_zero = 0.6 * min((_at(rung, ladder.along) or math.inf for rung in drawn), default=1.0)
    names_of_series = dict.fromkeys(rung.series for rung in ladder.rungs)
    for look, series in zip(SERIES, names_of_series, strict=False):
        rungs = [rung for rung in drawn if rung.series == series]
        x = [_at(rung, ladder.along) for rung in rungs]
        points = [_shown(rung) for rung in rungs]
        label = series if len(rungs) > 1 else "".join(rung.setting for rung in rungs)
        _draw(axes[0], [(at, *point) for at, point in zip(x, points, strict=True)], at_zero, look, label)
        if ladder.along:
            costs = [(at, rung.cpu_s, True) for at, rung in zip(x, rungs, strict=True)]
            _draw(axes[1], costs, at_zero, look, "")
    if any(rung.error_sd for rung in ladder.rungs):
        axes[0].plot([], [], "o", color="0.5", markerfacecolor="white", label=UNSURE)
    _label(axes[0], names.get(ladder.along, ladder.cost), ladder.error)
    if ladder.along:
        _label(axes[1], names[ladder.along], ladder.cost)
        axes[0].set_xlabel("")
    figure.suptitle(wrapped(ladder.title, PAGE - 0.2))
    figure.legend(loc="outside right center")
    return figure


def _at(rung: Rung, along: str) -> float:
    """Place of a rung on the axis of its ladder, 0 of one without steps; its cost without a key."""
    return float(rung.details[along] or 0.0) if along else rung.cpu_s


def _draw(
    axes: Axes, points: Sequence[tuple[float, float, bool]], at_zero: float, look: tuple[str, Any, str], label: str
) -> None:
    """Draw points (x, y, sure) in the order of x, so that no line loops back; 0 stands apart.

    What is not sure is a bound: no line joins it.
    """
    colour, line, marker = look
    shown = sorted((at, y, sure) for at, y, sure in points if y > 0)
    joined = np.array([(at, y) for at, y, sure in shown if at > 0 and sure]).reshape(-1, 2).T
    axes.plot(*joined, color=colour, ls=line, linewidth=0.9)
    for at, y, sure in shown:
        axes.plot(at or at_zero, y, marker, color=colour, markerfacecolor=colour if sure else "white")
    if label and shown:
        joins = line if len(shown) > 1 else ""
        axes.plot([], [], color=colour, ls=joins, marker=marker, label=label)


def _label(axes: Axes, x: str, y: str) -> None:
    """Make both axes logarithmic and name them, in lines that fit."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.margins(x=0.08, y=0.1)
    axes.set_xlabel(x)
    axes.set_ylabel(wrapped(y, YLABEL))
    logarithmic(axes.xaxis)
    logarithmic(axes.yaxis)


def _shown(rung: Rung) -> tuple[float, bool]:
    """Error to draw, and whether it is significantly different from zero."""
    assert rung.error is not None
    if rung.error_sd is None or rung.error > 2.0 * rung.error_sd:
        return rung.error, True
    return rung.error + 2.0 * rung.error_sd, False
