"""Figures: speed against tilt, as in the paper's figure 2."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walkergen.analysis.speeds import Measured
from walkergen.files.figures import COLUMN, STYLES, style, wrapped
from walkergen.jobs.make.family.chart_data import ChartData, ends
from walkergen.points.members import Simulated
from walkergen.theory.prediction import Curve, Prediction
from walkergen.walker.limbs import Kind

BOUNDS = "68 and 95 %"
THEORY = "eq. 15, dotted outside 95 %"

BAND, CORE = 0.16, 0.3
"""Shades of the bounds of 95 and 68 %."""

ALONE_DEG = 5.0
"""Tilts that are shown on either side of a single tilt that has no curve."""


class Shown(NamedTuple):
    """Place of a walker on the figure's axis, with what is known of it."""

    x: float
    row: Prediction
    simulated: Simulated | None


@style()
def speed_figure(
    rows: Sequence[Prediction],
    chart_data: ChartData,
    title: str,
    simulated: Sequence[Simulated] = (),
    named: bool = False,
) -> Figure:
    """Draw predicted speed against tilt, both kinds of legs, in bands of 68 and 95 %.

    Thin lines are the theory, dotted where it leaves the 95 % bounds. Kinds without a curve have
    their bounds as bars. Walkers whose legs follow no common tilt stand side by side, `named`.
    Simulated speeds, if there are any, are open symbols with their bounds of
    95 % as bars; measured speeds are crosses; an open star is the paper's one stated speed.
    """
    figure = Figure(figsize=(COLUMN, 3.3), layout="constrained")
    axes = figure.add_subplot()
    places = range(len(rows)) if named else [row.tilt_deg for row in rows]
    with_runs = [*simulated, *[None] * (len(rows) - len(simulated))]
    walkers = [Shown(*walker) for walker in zip(places, rows, with_runs, strict=True)]
    legend: dict[str, Any] = {}
    for kind, curve in chart_data.curves.items():
        legend |= _draw_curve(axes, kind, curve)
    for legs in dict.fromkeys(row.legs for row in rows):
        own = [walker for walker in walkers if walker.row.legs == legs]
        legend |= _draw_predicted(axes, own, legs, bars=legs not in chart_data.curves)
        legend |= _draw_simulated(axes, own, legs)
    if chart_data.stated is not None:
        tilt, speed = chart_data.stated
        legend[f"the paper: {speed:g} mm/s"] = axes.plot(
            tilt, speed, "*", color="black", markerfacecolor="white", markersize=11, zorder=2.5
        )[0]
    if chart_data.measured is not None:
        at = {walker.row.legs: float(walker.x) for walker in walkers} if named else {}
        legend |= _draw_measured(axes, chart_data.measured, at)
    _mark_sticking(axes, chart_data.curves)
    axes.axhline(0.0, color="0.6", linewidth=0.6, zorder=0)
    _label(axes, walkers, named, bool(simulated or chart_data.measured))
    figure.suptitle(wrapped(title, COLUMN - 0.1))
    figure.legend(legend.values(), legend.keys(), loc="outside lower center", ncols=2, columnspacing=1.2)
    return figure


def _label(axes: Axes, walkers: Sequence[Shown], named: bool, mixed: bool) -> None:
    """Name both axes; a single tilt without a curve gets an axis of some degrees."""
    axes.set_ylabel("speed (mm/s)" if mixed else "predicted speed (mm/s)")
    if named:
        axes.set_xticks([walker.x for walker in walkers], [walker.row.legs for walker in walkers])
        axes.set_xlim(-0.7, len(walkers) - 0.3)
        axes.set_xlabel("legs as designed")
        return
    axes.set_xlabel("tilt of the legs (deg)")
    low, high = axes.get_xlim()
    if len({walker.x for walker in walkers}) == 1 and high - low < 2.0 * ALONE_DEG:
        middle = walkers[0].x
        axes.set_xlim(middle - ALONE_DEG, middle + ALONE_DEG)


def _draw_curve(axes: Axes, kind: Kind, curve: Curve) -> dict[str, Any]:
    """Draw a kind's predicted speed between the members with its bounds, and the theory."""
    colour, line, _ = STYLES[kind]
    (middle,) = axes.plot(curve.tilt_deg, curve.speed, line, color=colour)
    bands = [
        axes.fill_between(curve.tilt_deg, curve.bounds[low], curve.bounds[high], color=colour, alpha=shade, linewidth=0)
        for low, high, shade in ((0, 3, BAND), (1, 2, CORE))
    ]
    return {f"{kind}, {BOUNDS}": (*bands, middle)} | _draw_theory(axes, curve)


def _draw_theory(axes: Axes, curve: Curve) -> dict[str, Any]:
    """Draw the theory as a thin line, dotted where it leaves the bounds of 95 %."""
    inside = (curve.bounds[0] <= curve.theory) & (curve.theory <= curve.bounds[3])
    thin: Any = {"color": "0.25", "linewidth": 0.7}
    axes.plot(curve.tilt_deg, curve.theory, ":", **thin)
    (solid,) = axes.plot(curve.tilt_deg, np.where(inside, curve.theory, np.nan), "-", **thin)
    return {THEORY: solid}


def _draw_predicted(axes: Axes, walkers: Sequence[Shown], kind: str, bars: bool) -> dict[str, Any]:
    """Draw the members' speeds, with bounds as bars where no band shows them."""
    colour, _, marker = STYLES[kind]
    x, speeds = [walker.x for walker in walkers], [walker.row.speed_mm_s for walker in walkers]
    (points,) = axes.plot(x, speeds, marker, color=colour, markersize=4, zorder=3)
    if not bars:
        return {}
    for low, high, width, shade in (("low_95", "high_95", 1.2, 0.5), ("low_68", "high_68", 5.0, CORE)):
        bottoms, tops = ([getattr(walker.row, f"speed_{end}_mm_s") for walker in walkers] for end in (low, high))
        axes.vlines(x, bottoms, tops, color=colour, linewidth=width, alpha=shade)
    return {f"{kind}, {BOUNDS}": points}


def _draw_simulated(axes: Axes, walkers: Sequence[Shown], kind: str) -> dict[str, Any]:
    """Draw the members' simulated speeds, as far as there are any."""
    colour, _, marker = STYLES[kind]
    points = [
        (walker.x, walker.simulated.sim_speed_mm_s, *_lengths(walker.simulated))
        for walker in walkers
        if walker.simulated is not None and walker.simulated.sim_speed_mm_s is not None
    ]
    if not points:
        return {}
    x, speeds, *bars = zip(*points, strict=True)
    drawn = axes.errorbar(
        x, speeds, bars, fmt=marker, color=colour, markerfacecolor="white", markersize=5, capsize=2, zorder=3.2
    )
    return {f"{kind}, simulated, 95 %": drawn}


def _lengths(runs: Simulated) -> tuple[float, float]:
    """Lengths of a bar below and above a simulated speed, mm/s; none where bounds are unknown."""
    speed, low, high = runs.sim_speed_mm_s, runs.sim_low_95_mm_s, runs.sim_high_95_mm_s
    if speed is None or low is None or high is None:
        return 0.0, 0.0
    return speed - low, high - speed


def _draw_measured(axes: Axes, measured: Measured, at: Mapping[str, float]) -> dict[str, Any]:
    """Draw measured speeds, with bars of 95 % where their errors are known.

    They stand at their tilts, or at the places of walkers with such legs where these are given.
    """
    legend: dict[str, Any] = {}
    for kind, mark in (("flexible", "x"), ("braced", "+")):
        chosen = np.array([legs == kind for legs in measured.legs])
        if not chosen.any() or (at and kind not in at):
            continue
        x = np.full(chosen.sum(), at[kind]) if at else measured.tilt[chosen]
        speed = measured.speed[chosen]
        bars = None if measured.se is None else speed - ends(speed, measured.se[chosen])[0]
        label = f"{kind}, measured" + ("" if bars is None else ", 95 %")
        legend[label] = axes.errorbar(
            x,
            speed,
            bars,
            fmt=mark,
            color="black",
            markersize=5,
            markeredgewidth=1.2,
            elinewidth=0.9,
            capsize=2,
            zorder=3.4,
        )
    return legend


def _mark_sticking(axes: Axes, curves: Mapping[Kind, Curve]) -> None:
    """Shade the tilts at which a flexible foot can stick, where the paper's formula fails."""
    curve = curves.get("flexible")
    if curve is None or not curve.can_stick.any():
        return
    tilts = curve.tilt_deg[curve.can_stick]
    axes.axvspan(tilts.min(), tilts.max(), color="0.92", linewidth=0, zorder=-1)
    axes.annotate(
        "feet can stick",
        (0.5 * (tilts.min() + tilts.max()), 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(0, 2),
        textcoords="offset points",
        ha="center",
        va="bottom",
        color="0.35",
        fontsize=7,
    )
