"""Figures: speed against tilt, as in the paper's figure 2."""

from collections.abc import Mapping, Sequence

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from walkergen.analysis.speeds import Measured
from walkergen.files.figures import STYLES
from walkergen.jobs.family.tables import Simulated
from walkergen.prediction import Curve, Prediction
from walkergen.walker.limbs import Kind

BOUNDS = "bounds of 68 and 95 %"


def speed_figure(
    rows: Sequence[Prediction],
    curves: Mapping[Kind, Curve],
    impact_speed: float,
    title: str,
    simulated: Sequence[Simulated] = (),
    measured: Measured | None = None,
    stated: tuple[float, float] | None = None,
    named: bool = False,
) -> Figure:
    """Draw predicted speed against tilt, both kinds of legs, in bands of 68 and 95 %.

    Kinds without a curve have their bounds as bars. Walkers whose legs follow no common tilt stand
    side by side, `named`. Simulated speeds, if there are any, are open symbols with their bounds of
    95 % as bars; measured speeds are crosses; a star is the paper's one stated speed, (tilt, mm/s).
    """
    with matplotlib.rc_context({"font.size": 10, "axes.spines.top": False}):
        figure = Figure(figsize=(7.0, 4.4), layout="constrained")
        axes = figure.add_subplot()
        for kind, curve in curves.items():
            colour, line, _ = STYLES[kind]
            axes.plot(curve.tilt_deg, curve.speed, line, color=colour, label=f"{kind} legs")
            for (bottom, top), shade in (((0, 3), 0.12), ((1, 2), 0.2)):
                band = curve.bounds[bottom], curve.bounds[top]
                known = bottom and not np.isnan(curve.bounds).all()
                told = f"{kind} legs, {BOUNDS}" if known else None
                axes.fill_between(
                    curve.tilt_deg, *band, color=colour, alpha=shade, linewidth=0, label=told
                )
        for legs in dict.fromkeys(row.legs for row in rows):
            colour, _, marker = STYLES[legs]
            points = [(row.tilt_deg, row.speed_mm_s) for row in rows if row.legs == legs]
            told = None if legs in curves else f"{legs} legs"
            axes.plot(*zip(*points, strict=True), marker, color=colour, markersize=5, label=told)
            if legs not in curves:
                _draw_bars(axes, [row for row in rows if row.legs == legs], colour)
        _draw_simulated(axes, rows, simulated)
        if measured is not None:
            _draw_measured(axes, measured)
        if stated is not None:
            axes.plot(*stated, "*", color="black", markersize=11, label="the paper's walker")
        _mark_sticking(axes, curves)
        axes.axhline(0.0, color="0.6", linewidth=0.8, zorder=0)
        if not curves:
            axes.margins(x=0.5, y=0.15)
        axes.set_xlabel("legs as designed" if named else "tilt of the legs (deg)")
        if named:
            axes.set_xticks([])
        axes.set_ylabel("speed (mm/s)" if simulated or measured else "predicted speed (mm/s)")
        axes.set_title(title, fontsize=10)
        axes.legend(frameon=False)
        low, high = axes.get_ylim()
        axes.set_ylim(low, high)
        ratio = axes.twinx()
        ratio.set_ylim(low / impact_speed, high / impact_speed)
        ratio.set_ylabel("speed / impact speed")
    return figure


def _draw_bars(axes: matplotlib.axes.Axes, rows: Sequence[Prediction], colour: str) -> None:
    """Draw the bounds of 68 and 95 % of single points, where they are known."""
    known = [row for row in rows if row.speed_low_95_mm_s is not None]
    if not known:
        return
    tilts = [row.tilt_deg for row in known]
    for low, high, width, told in (
        ("low_95", "high_95", 1.2, f"{known[0].legs} legs, {BOUNDS}"),
        ("low_68", "high_68", 4.0, ""),
    ):
        bottoms, tops = (
            [getattr(row, f"speed_{end}_mm_s") for row in known] for end in (low, high)
        )
        axes.vlines(tilts, bottoms, tops, color=colour, linewidth=width, alpha=0.4, label=told)


def _draw_simulated(
    axes: matplotlib.axes.Axes, rows: Sequence[Prediction], simulated: Sequence[Simulated]
) -> None:
    for legs in dict.fromkeys(row.legs for row in rows):
        colour, _, marker = STYLES[legs]
        points = [
            (row.tilt_deg, one.sim_speed_mm_s, *_ends(one))
            for row, one in zip(rows, simulated, strict=False)
            if row.legs == legs and one.sim_speed_mm_s is not None
        ]
        if points:
            tilts, speeds, *bars = zip(*points, strict=True)
            axes.errorbar(
                tilts, speeds, bars, fmt=marker, color=colour, markerfacecolor="white",
                markersize=6, capsize=3, label=f"{legs}, simulated, 95 %",
            )  # fmt: skip


def _ends(one: Simulated) -> tuple[float, float]:
    """Lengths of a bar below and above a simulated speed, mm/s; none where bounds are unknown."""
    speed, low, high = one.sim_speed_mm_s, one.sim_low_95_mm_s, one.sim_high_95_mm_s
    if speed is None or low is None or high is None:
        return 0.0, 0.0
    return speed - low, high - speed


def _draw_measured(axes: matplotlib.axes.Axes, measured: Measured) -> None:
    for legs, mark in (("flexible", "x"), ("braced", "+")):
        chosen = np.array([one == legs for one in measured.legs])
        if chosen.any():
            bars = None if measured.se is None else measured.se[chosen]
            axes.errorbar(
                measured.tilt[chosen], measured.speed[chosen], bars, fmt=mark, color="black",
                markersize=7, markeredgewidth=1.5, capsize=3, label=f"{legs}, measured",
            )  # fmt: skip


def _mark_sticking(axes: matplotlib.axes.Axes, curves: Mapping[Kind, Curve]) -> None:
    """Shade the tilts at which a flexible foot can stick, where the paper's formula fails."""
    curve = curves.get("flexible")
    if curve is None or not curve.can_stick.any():
        return
    tilts = curve.tilt_deg[curve.can_stick]
    axes.axvspan(tilts.min(), tilts.max(), color="0.92", linewidth=0, zorder=-1)
    axes.annotate(
        "feet can stick", (0.5 * (tilts.min() + tilts.max()), 0.97),
        xycoords=("data", "axes fraction"), ha="center", va="top", color="0.45", fontsize=8,
    )  # fmt: skip
