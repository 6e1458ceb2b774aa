"""Work-precision figures: error against CPU time, both on logarithmic axes."""

from collections.abc import Iterable, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walkergen.jobs.accuracy.ladder import Ladder, Rung
from walkergen.jobs.accuracy.setting import Measured
from walkergen.jobs.accuracy.speeds import Survey

# Okabe and Ito's colours, each with its own line and marker: readable in grey as well.
STYLES = (
    ("#0072B2", "-", "o"), ("#D55E00", "--", "s"), ("#009E73", "-.", "^"), ("#CC79A7", ":", "D"),
    ("#E69F00", "-", "v"), ("#56B4E9", "--", "P"), ("#000000", "-.", "X"), ("#999999", ":", "*"),
)  # fmt: skip

CROWDED = 6
"""Number of series beyond which only the ends of a series are named."""

SHARES = (0.2, 0.1, 0.05, 0.02, 0.01)
"""Relative errors that the figure of choices marks with a line."""


def ladder_figure(ladder: Ladder) -> Figure:
    """Draw a line per series; open symbols are errors that may be zero, drawn at |error| + 2 SE."""
    with matplotlib.rc_context({"font.size": 9, "axes.spines.top": False}):
        names = dict.fromkeys(rung.series for rung in ladder.rungs)
        width = 9.5 if len(names) > CROWDED else 7.0
        figure = Figure(figsize=(width, 4.6), layout="constrained")
        axes = figure.add_subplot()
        for place, (series, style) in enumerate(zip(names, STYLES, strict=False)):
            rungs = [r for r in ladder.rungs if r.series == series and r.error is not None]
            _draw(axes, rungs, style, below=place % 2 == 1, crowded=len(names) > CROWDED)
        if any(rung.error_sd for rung in ladder.rungs):
            axes.plot([], [], "o", color="0.5", markerfacecolor="white",
                      label="not told from zero: |error| + 2 SE")  # fmt: skip
        axes.margins(x=0.15)
        _logarithmic(axes, ladder.cost, ladder.error, ladder.title)
        if len(names) > CROWDED:
            figure.legend(frameon=False, fontsize=8, loc="outside right center")
        else:
            axes.legend(frameon=False, fontsize=8)
    return figure


def _logarithmic(axes: Axes, cost: str, error: str, title: str) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel(cost)
    axes.set_ylabel(error)
    axes.set_title(title, fontsize=9)
    axes.grid(visible=True, which="major", color="0.9")


def _draw(
    axes: Axes, rungs: Sequence[Rung], style: tuple[str, str, str], below: bool, crowded: bool
) -> None:
    colour, line, marker = style
    shown = [(rung, *_shown(rung)) for rung in rungs]
    shown = [one for one in shown if one[1] > 0]
    if not shown:
        return
    costs = [rung.cpu_s for rung, _, _ in shown]
    errors = [error for _, error, _ in shown]
    series = shown[0][0].series
    # A single point carries its name; only lines need the legend.
    label = series if len(shown) > 1 else None
    axes.plot(costs, errors, line, color=colour, linewidth=1, label=label)
    for rung, error, told in shown:
        face = colour if told else "white"
        axes.plot(rung.cpu_s, error, marker, color=colour, markerfacecolor=face, markersize=5)
    # Long series, and many, are named at their ends only.
    ends = len(shown) > 8 or (crowded and len(shown) > 1)
    for rung, error, _ in (shown[0], shown[-1]) if ends else shown:
        _name(
            axes,
            rung.setting.removeprefix(f"{series} ") if label else rung.setting,
            rung.cpu_s,
            error,
            colour,
            below,
        )


def _shown(rung: Rung) -> tuple[float, bool]:
    """Error to draw, and whether it is significantly different from zero."""
    assert rung.error is not None
    if rung.error_sd is None or rung.error > 2.0 * rung.error_sd:
        return rung.error, True
    return rung.error + 2.0 * rung.error_sd, False


def choice_figure(
    survey: Survey,
    found: Sequence[Measured],
    reference: Measured,
    formulas: Iterable[Rung],
    title: str,
) -> Figure:
    """Draw the total error with 95 % confidence against CPU time, a line for each setting.

    It falls as statistics improve, down to the bound of the setting's bias; formulas are points.
    """
    unit = survey.unit(reference)
    with matplotlib.rc_context({"font.size": 9, "axes.spines.top": False}):
        figure = Figure(figsize=(8.6, 5.0), layout="constrained")
        axes = figure.add_subplot()
        for place, rung in enumerate(formulas):
            assert rung.error is not None
            axes.plot(rung.cpu_s, rung.error, "k*", markersize=8)
            _name(axes, rung.series, rung.cpu_s, rung.error, "k", below=place % 2 == 1)
        for one, (colour, line) in zip(found, _lines(found), strict=True):
            bound = survey.bound(one, reference)
            if bound is None:
                continue
            time = np.geomspace(0.5, 1e5, 200)
            cost = one.cpu_per_s * (time + one.runs * one.discard_seconds)
            error = bound + 2.0 * np.sqrt(one.variance_time / time)
            axes.plot(cost, error / unit.size, line, color=colour, label=one.setting.label)
        _mark_shares(axes, unit.relative)
        error_name = f"error of the mean speed, 95 %, {unit.name}"
        _logarithmic(axes, "CPU time, s (one core)", error_name, title)
        figure.legend(frameon=False, fontsize=8, loc="outside right center")
    return figure


def _lines(found: Sequence[Measured]) -> list[tuple[Any, str]]:
    """Colours and lines: steps from light (coarse) to dark (fine), full; all else broken."""
    steps = sorted(one.setting.step_us for one in found if one.setting.step_us is not None)
    others = iter((("black", "--"), ("#D55E00", ":"), ("#CC79A7", "-.")))
    shades = matplotlib.colormaps["viridis"]
    return [
        next(others)
        if one.setting.step_us is None
        else (shades(0.9 * steps.index(one.setting.step_us) / max(len(steps) - 1, 1)), "-")
        for one in found
    ]


def _mark_shares(axes: Axes, relative: bool) -> None:
    if not relative:
        return
    for share in SHARES:
        axes.axhline(share, color="0.75", linewidth=0.7, zorder=0)
        axes.annotate(
            f"{100 * share:g} %", (0.005, share), xycoords=("axes fraction", "data"),
            va="bottom", fontsize=8, color="0.4",
        )  # fmt: skip


def _name(axes: Axes, text: str, x: float, y: float, colour: str, below: bool) -> None:
    offset = (4, -10) if below else (4, 4)  # neighbours may lie on top of each other
    axes.annotate(text, (x, y), xytext=offset, textcoords="offset points", fontsize=7, color=colour)
