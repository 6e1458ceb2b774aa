"""Figures: speed against tilt, as in the paper's figure 2. Functions that draw return their entries of the legend."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walkergen.analysis.speeds import Measured
from walkergen.commands.family.chart_data import NORMAL_95, ChartData
from walkergen.core.theory.prediction import Curve, Prediction
from walkergen.core.walker.limbs import Kind
from walkergen.files.figures import (
    BLACK,
    COLUMN_INCHES,
    INK,
    LEG_STYLES,
    MIN_FONT_PT,
    Look,
    draw_level,
    draw_points,
    label_axes,
    new_grid,
    style,
    wrap_text,
)
from walkergen.points.members import Simulated

BOUNDS_LABEL = "68 and 95 %"
THEORY_LABEL = "theory (eq. 15): all landings alike"

BAND_95_ALPHA, BAND_68_ALPHA = 0.16, 0.3
"""Opacities of the bounds of 95 and 68 %."""

MEASURED_LOOKS = {"flexible": Look(BLACK, "", "x"), "braced": Look(BLACK, "", "+")}
"""Looks of measured speeds by the kind of legs."""

SINGLE_TILT_MARGIN_DEG = 5.0
"""Margin of the axis on either side of a single tilt without a curve, deg."""


class PlottedWalker(NamedTuple):
    """Walker on the figure's axis, with its position and speeds."""

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
    note: str = "",
) -> Figure:
    """Draw predicted speed against tilt, both kinds of legs, in bands of 68 and 95 %.

    One dashed line is the theory, of flexible legs if there are any. Kinds without a curve have
    bars as bounds, as walkers that require runs have. Walkers whose legs follow no common tilt
    are drawn side by side, `named`. Simulated speeds are open symbols with their bounds of
    95 % as bars; measured speeds are crosses; an open star is the paper's one stated speed. The
    legend has the `note` as its title.
    """
    figure, (axes,) = new_grid(title, count=1, across=1, height=3.3, width=COLUMN_INCHES)
    positions = range(len(rows)) if named else [row.tilt_deg for row in rows]
    with_runs = [*simulated, *[None] * (len(rows) - len(simulated))]
    walkers = [PlottedWalker(*walker) for walker in zip(positions, rows, with_runs, strict=True)]
    legend: dict[str, Any] = {}
    for kind, curve in chart_data.curves.items():
        legend |= _draw_curve(axes, kind, curve)
    legend |= _draw_theory(axes, chart_data.curves)
    for legs in dict.fromkeys(row.legs for row in rows):
        same_kind = [walker for walker in walkers if walker.row.legs == legs]
        kind_curve = next((curve for kind, curve in chart_data.curves.items() if kind == legs), None)
        legend |= _draw_predicted(axes, same_kind, legs, kind_curve)
        legend |= _draw_simulated(axes, same_kind, legs)
    if chart_data.stated is not None:
        look: Any = {"color": BLACK, "markerfacecolor": "white", "markersize": 11, "zorder": 2.5}
        legend[f"the paper: {chart_data.stated[1]:g} mm/s"] = axes.plot(*chart_data.stated, "*", **look)[0]
    if chart_data.measured is not None:
        positions_by_kind = {walker.row.legs: float(walker.x) for walker in walkers} if named else {}
        legend |= _draw_measured(axes, chart_data.measured, positions_by_kind)
    _mark_sticking(axes, chart_data.curves)
    draw_level(axes)
    mixed = simulated or chart_data.measured
    label_axes(
        axes, "legs as designed" if named else "tilt of the legs (deg)", f"{'' if mixed else 'predicted '}speed (mm/s)"
    )
    _set_limits(axes, walkers, named)
    looks: Any = {"columnspacing": 0.8, "handlelength": 1.6, "title": wrap_text(note, COLUMN_INCHES - 0.1) or None}
    figure.legend(legend.values(), legend.keys(), loc="outside lower center", ncols=2, **looks)
    return figure


def _set_limits(axes: Axes, walkers: Sequence[PlottedWalker], named: bool) -> None:
    """Set the limits of the axis of tilts. A single tilt without a curve gets a margin on either side."""
    if named:
        axes.set_xticks([walker.x for walker in walkers], [walker.row.legs for walker in walkers])
        axes.set_xlim(-0.7, len(walkers) - 0.3)
        return
    low, high = axes.get_xlim()
    if len({walker.x for walker in walkers}) == 1 and high - low < 2.0 * SINGLE_TILT_MARGIN_DEG:
        axes.set_xlim(walkers[0].x - SINGLE_TILT_MARGIN_DEG, walkers[0].x + SINGLE_TILT_MARGIN_DEG)


def _draw_curve(axes: Axes, kind: Kind, curve: Curve) -> dict[str, Any]:
    """Draw a kind's predicted speed between the members, with its bounds."""
    look = LEG_STYLES[kind]
    (middle,) = axes.plot(curve.tilt_deg, curve.speed, look.line, color=look.colour)
    bands = [
        axes.fill_between(
            curve.tilt_deg, curve.bounds[low], curve.bounds[high], color=look.colour, alpha=a, linewidth=0
        )
        for low, high, a in ((0, 3, BAND_95_ALPHA), (1, 2, BAND_68_ALPHA))  # rows of QUANTILES
    ]
    return {f"{kind}, {BOUNDS_LABEL}": (*bands, middle)}


def _draw_theory(axes: Axes, curves: Mapping[Kind, Curve]) -> dict[str, Any]:
    """Draw the theory as one dashed line: of flexible legs if there are any, since braced walkers do not run."""
    curve = curves.get("flexible", next(iter(curves.values()), None))
    if curve is None:
        return {}
    return {THEORY_LABEL: axes.plot(curve.tilt_deg, curve.theory, "--", color=INK, linewidth=0.9)[0]}


def _draw_predicted(axes: Axes, walkers: Sequence[PlottedWalker], kind: str, curve: Curve | None) -> dict[str, Any]:
    """Draw the members' speeds, with bars as bounds if no band of a curve shows them."""
    colour, _, marker = LEG_STYLES[kind]
    x, speeds = [walker.x for walker in walkers], np.array([walker.row.speed.value for walker in walkers], float)
    (marks,) = axes.plot(x, speeds, marker, color=colour, markersize=4, zorder=3)
    if curve is not None:
        walkers = [walker for walker in walkers if np.isnan(np.interp(walker.x, curve.tilt_deg, curve.speed))]
        x = [walker.x for walker in walkers]
    if not walkers:
        return {}
    for level, width, shade in ((0.95, 1.2, 0.5), (0.68, 5.0, BAND_68_ALPHA)):
        low, high = np.array([one.row.speed.interval(level) or (np.nan, np.nan) for one in walkers]).T
        axes.vlines(x, low, high, color=colour, linewidth=width, alpha=shade)
    return {f"{kind}, {BOUNDS_LABEL}": marks}


def _draw_simulated(axes: Axes, walkers: Sequence[PlottedWalker], kind: str) -> dict[str, Any]:
    """Draw the members' simulated speeds, if any, with bars of 95 % if known."""
    runs = [(one.x, one.simulated) for one in walkers if one.simulated and one.simulated.speed.value is not None]
    if not runs:
        return {}
    speeds = np.array([run.speed.value for _, run in runs], dtype=float)
    low, high = np.array([run.speed.interval() or (np.nan, np.nan) for _, run in runs]).T
    drawn = draw_points(
        axes, ([x for x, _ in runs], speeds, [speeds - low, high - speeds]), LEG_STYLES[kind], hollow=True
    )
    return {f"{kind}, simulated, 95 %": drawn}


def _draw_measured(axes: Axes, measured: Measured, at: Mapping[str, float]) -> dict[str, Any]:
    """Draw measured speeds, with bars of 95 % if their errors are known.

    Speeds are drawn at their tilts or, if given, at the position `at` of the walker with this kind of legs.
    """
    legend: dict[str, Any] = {}
    for kind, look in MEASURED_LOOKS.items():
        chosen = np.array([legs == kind for legs in measured.legs])
        if not chosen.any() or (at and kind not in at):
            continue
        x = np.full(chosen.sum(), at[kind]) if at else measured.tilt[chosen]
        bars = None if measured.se is None else NORMAL_95 * measured.se[chosen]
        drawn = draw_points(axes, (x, measured.speed[chosen], bars), look)
        drawn.lines[0].set(markersize=5.0, markeredgewidth=1.2, zorder=3.4)
        legend[f"{kind}, measured" + ("" if bars is None else ", 95 %")] = drawn
    return legend


def _mark_sticking(axes: Axes, curves: Mapping[Kind, Curve]) -> None:
    """Shade the tilts at which a flexible foot can stick, where the paper's formula fails."""
    curve = curves.get("flexible")
    if curve is None or not curve.can_stick.any():
        return
    low, high = curve.tilt_deg[curve.can_stick].min(), curve.tilt_deg[curve.can_stick].max()
    axes.axvspan(low, high, color="0.92", linewidth=0, zorder=-1)
    above: Any = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points", "ha": "center", "va": "bottom"}
    axes.annotate("feet can stick", (0.5 * (low + high), 1.0), (0, 2), color=INK, fontsize=MIN_FONT_PT, **above)
