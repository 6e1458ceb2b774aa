"""Figures of a crowd, the same for films and for simulations."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walkergen.analysis.motion import Curve
from walkergen.files import figures as plots
from walkergen.files.figures import GREY, INK, MIN_FONT_PT, SERIES, Look, new_axes, new_panels, style
from walkergen.guests.crowd.statistics.summary import CrowdStatistics

MAX_MARKERS = 40
"""Most points of a curve that have markers and bars; of longer ones the error is a band."""


class Panel(NamedTuple):
    """Panel of a figure: curves of one kind."""

    label: str
    height: float
    """Inches."""
    names: tuple[str, ...]
    """Names of the curves; those that the crowd has are drawn."""
    chance: float | None = None
    """Value for walkers at random, drawn as a level; None without one."""


COURSE_PANELS = (
    Panel("order", 1.5, ("polar_order", "nematic_order", "local_polar_order", "milling")),
    Panel("share of walkers", 1.5, ("largest_cluster", "alone")),
    Panel("speed (mm/s)", 1.5, ("speed", "wall_speed")),
)
PAIR_PANELS = (
    Panel("pair correlation g", 2.0, ("g",), 1.0),
    Panel("alignment of pairs", 1.4, ("polar_correlation", "nematic_correlation"), 0.0),
)
WALL_PANELS = (
    Panel("density / mean", 1.3, ("wall_density",), 1.0),
    Panel("speed (mm/s)", 1.3, ("wall_speed",)),
    Panel("along the wall", 1.3, ("wall_alignment",), 0.0),
)


def figure_functions(statistics: CrowdStatistics, title: str) -> Mapping[str, Callable[[], Figure]]:
    """Return functions that draw the figures, by the names of their files. Figures without data are left out."""
    curves = statistics.curves
    # Curve that a figure needs, and the function that draws the figure
    draws: dict[str, tuple[str, Callable[[], Figure]]] = {
        "crowd_pairs": ("g", partial(_draw_panels, curves, title, "distance of centres (mm)", PAIR_PANELS)),
        "crowd_fluctuations": ("fluctuations", partial(_draw_fluctuations, curves, title)),
        "crowd_msd": ("msd", partial(_draw_msd, curves, title)),
        "crowd_walls": (
            "wall_density",
            partial(_draw_panels, curves, title, "distance of the centre from the wall (mm)", WALL_PANELS),
        ),
        "crowd_clusters": ("cluster_shares", partial(_draw_clusters, curves, title)),
        "crowd_packing": ("local_packing", partial(_draw_packing, statistics, title)),
    }
    course = {"crowd_course": partial(_draw_panels, statistics.series, title, "time (s)", COURSE_PANELS)}
    return course | {
        name: draw for name, (needs, draw) in draws.items() if needs in curves and _is_drawable(curves[needs])
    }


def _is_drawable(curve: Curve) -> bool:
    """Return whether a curve has enough points above 0 to be drawn, also on a logarithmic axis."""
    return int((curve.value > 0).sum()) > 1


@style()
def _draw_panels(curves: Mapping[str, Curve], title: str, x_label: str, panels: Sequence[Panel]) -> Figure:
    """Draw panels of curves over a shared x axis, labelled `x_label`. Missing curves are left out."""
    shown = [panel._replace(names=tuple(name for name in panel.names if name in curves)) for panel in panels]
    shown = [panel for panel in shown if panel.names]
    figure, grid = new_panels(title, [panel.height for panel in shown])
    for axes, panel in zip(grid, shown, strict=True):
        for look, name in zip(SERIES, panel.names, strict=False):
            _draw_curve(axes, curves[name], look, name.replace("_", " ") if len(panel.names) > 1 else "")
        if panel.chance is not None:
            plots.draw_level(axes, panel.chance)
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
        if len(panel.names) > 1:
            axes.legend(ncols=2, loc="best")
        plots.label_axes(axes, y=panel.label)
    grid[-1].set_xlim(left=0)
    plots.label_axes(grid[-1], x_label)
    return figure


@style()
def _draw_fluctuations(curves: Mapping[str, Curve], title: str) -> Figure:
    """Draw the standard deviation of the number of walkers in boxes against its mean."""
    figure, axes = new_axes(title)
    mean, variance, se = (part[curves["fluctuations"].value > 0] for part in curves["fluctuations"])
    deviation = np.sqrt(variance)
    plots.draw_points(axes, (mean, deviation, se / (2.0 * deviation)), label="measured")
    ends = np.array([mean.min(), mean.max()])
    axes.plot(ends, np.sqrt(ends), "--", color=GREY, label="at random: mean$^{1/2}$", zorder=0)
    axes.legend()
    plots.label_axes(axes, "mean number of walkers in a box", "standard deviation with time", log="xy")
    return figure


@style()
def _draw_msd(curves: Mapping[str, Curve], title: str) -> Figure:
    """Draw the mean squared displacement by lag."""
    figure, axes = new_axes(title)
    lag, msd, se = (part[curves["msd"].value > 0] for part in curves["msd"])
    plots.draw_points(axes, (lag, msd, se))
    # A straight run through the first point, diffusion through the last
    for power, point, line in ((2, 0, ":"), (1, -1, "--")):
        axes.plot(lag, msd[point] * (lag / lag[point]) ** power, line, color=GREY, label=f"slope {power}", zorder=0)
    axes.legend()
    plots.label_axes(axes, "lag (s)", "mean squared displacement (mm²)", log="xy")
    return figure


@style()
def _draw_clusters(curves: Mapping[str, Curve], title: str) -> Figure:
    """Draw a bar chart: the share of walkers in clusters of 1, 2 to 3, 4 to 7 and more walkers."""
    figure, axes = new_axes(title)
    sizes, shares, se = curves["cluster_shares"]
    at = range(len(sizes))
    axes.bar(at, shares, color=SERIES[5].colour, yerr=np.nan_to_num(se), ecolor=INK, capsize=2)
    names = [f"{int(size)}" if size == 1 else f"{int(size)}–{2 * int(size) - 1}" for size in sizes]
    axes.set_xticks(at, names, fontsize=MIN_FONT_PT, rotation=45 if len(names) > 7 else 0)
    plots.label_axes(axes, "walkers in a cluster", "share of the walkers")
    return figure


@style()
def _draw_packing(statistics: CrowdStatistics, title: str) -> Figure:
    """Draw the probability density of the packing in a box, and mark the packing of the whole dish."""
    figure, axes = new_axes(title)
    _draw_curve(axes, statistics.curves["local_packing"], SERIES[0], "")
    if (packing := statistics.numbers["packing"].value) is not None:
        plots.draw_level(axes, packing, upright=True)
        place = (packing, 0.95)
        axes.annotate(" of the dish", place, xycoords=("data", "axes fraction"), color=INK, fontsize=MIN_FONT_PT)
    axes.set(xlim=(0, None), ylim=(0, None))
    plots.label_axes(axes, "packing in a box", "probability density")
    return figure


def _draw_curve(axes: Axes, curve: Curve, look: Look, label: str) -> None:
    """Draw a curve with its errors: as bars, or as a band if it is long."""
    if len(curve.at) <= MAX_MARKERS:
        plots.draw_points(axes, curve, look, label, joined=True)
    else:
        plots.draw_curve(axes, curve, look, label)
