"""Figures of what a crowd did, the same for films and for simulations."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walkergen.analysis.motion import Curve
from walkergen.files import figures as plots
from walkergen.files.figures import GREY, INK, SERIES, SMALLEST, Look, axes_of, panels_of, style
from walkergen.guests.crowd.statistics.measuring import CrowdStatistics

MOST_MARKED = 40
"""Most points of a curve that have markers and bars; of longer ones the error is a band."""


class Panel(NamedTuple):
    """Panel of a figure: curves of one kind."""

    label: str
    height: float
    """Inches."""
    names: tuple[str, ...]
    """Curves, those of which the crowd has are drawn."""
    chance: float | None = None
    """What walkers at random would have."""


COURSE = (
    Panel("order", 1.5, ("polar_order", "nematic_order", "local_polar_order", "milling")),
    Panel("share of walkers", 1.5, ("largest_cluster", "alone")),
    Panel("speed (mm/s)", 1.5, ("speed", "wall_speed")),
)
PAIRS = (
    Panel("pair correlation g", 2.0, ("g",), 1.0),
    Panel("alignment of pairs", 1.4, ("polar_correlation", "nematic_correlation"), 0.0),
)
WALLS = (
    Panel("density / mean", 1.3, ("wall_density",), 1.0),
    Panel("speed (mm/s)", 1.3, ("wall_speed",)),
    Panel("along the wall", 1.3, ("wall_alignment",), 0.0),
)


def figures(statistics: CrowdStatistics, title: str) -> Mapping[str, Callable[[], Figure]]:
    """Return functions that draw each figure that the crowd has, by the stems of their files."""
    curves = statistics.curves
    draws: dict[str, tuple[str, Callable[[], Figure]]] = {
        "crowd_pairs": ("g", partial(_stacked, curves, title, "distance of centres (mm)", PAIRS)),
        "crowd_fluctuations": ("fluctuations", partial(_fluctuations, curves, title)),
        "crowd_msd": ("msd", partial(_msd, curves, title)),
        "crowd_walls": (
            "wall_density",
            partial(_stacked, curves, title, "distance of the centre from the wall (mm)", WALLS),
        ),
        "crowd_clusters": ("cluster_shares", partial(_clusters, curves, title)),
        "crowd_packing": ("local_packing", partial(_packing, statistics, title)),
    }
    course = {"crowd_course": partial(_stacked, statistics.series, title, "time (s)", COURSE)}
    return course | {name: draw for name, (needs, draw) in draws.items() if needs in curves and _rises(curves[needs])}


def _rises(curve: Curve) -> bool:
    """Whether a curve has points above 0 enough to be drawn, on a logarithmic axis as well."""
    return int((curve.value > 0).sum()) > 1


@style()
def _stacked(curves: Mapping[str, Curve], title: str, at: str, panels: Sequence[Panel]) -> Figure:
    """Draw curves over one axis in panels, those that there are."""
    shown = [panel._replace(names=tuple(name for name in panel.names if name in curves)) for panel in panels]
    shown = [panel for panel in shown if panel.names]
    figure, grid = panels_of(title, [panel.height for panel in shown])
    for axes, panel in zip(grid, shown, strict=True):
        for look, name in zip(SERIES, panel.names, strict=False):
            _draw(axes, curves[name], look, name.replace("_", " ") if len(panel.names) > 1 else "")
        if panel.chance is not None:
            plots.level(axes, panel.chance)
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
        if len(panel.names) > 1:
            axes.legend(ncols=2, loc="best")
        plots.name(axes, y=panel.label)
    grid[-1].set_xlim(left=0)
    plots.name(grid[-1], at)
    return figure


@style()
def _fluctuations(curves: Mapping[str, Curve], title: str) -> Figure:
    """Draw the standard deviation of the number of walkers in boxes against its mean."""
    figure, axes = axes_of(title)
    mean, variance, se = (part[curves["fluctuations"].value > 0] for part in curves["fluctuations"])
    deviation = np.sqrt(variance)
    plots.points(axes, (mean, deviation, se / (2.0 * deviation)), label="measured")
    ends = np.array([mean.min(), mean.max()])
    axes.plot(ends, np.sqrt(ends), "--", color=GREY, label="at random: mean$^{1/2}$", zorder=0)
    axes.legend()
    plots.name(axes, "mean number of walkers in a box", "standard deviation with time", log="xy")
    return figure


@style()
def _msd(curves: Mapping[str, Curve], title: str) -> Figure:
    """Draw the mean squared displacement by lag."""
    figure, axes = axes_of(title)
    lag, squares, se = (part[curves["msd"].value > 0] for part in curves["msd"])
    plots.points(axes, (lag, squares, se))
    for power, at, line in ((2, 0, ":"), (1, -1, "--")):
        axes.plot(lag, squares[at] * (lag / lag[at]) ** power, line, color=GREY, label=f"slope {power}", zorder=0)
    axes.legend()
    plots.name(axes, "lag (s)", "mean squared displacement (mm²)", log="xy")
    return figure


@style()
def _clusters(curves: Mapping[str, Curve], title: str) -> Figure:
    """Draw the share of walkers in clusters of each octave of sizes."""
    figure, axes = axes_of(title)
    sizes, shares, se = curves["cluster_shares"]
    at = range(len(sizes))
    axes.bar(at, shares, color=SERIES[5].colour, yerr=np.nan_to_num(se), ecolor=INK, capsize=2)
    names = [f"{int(size)}" if size == 1 else f"{int(size)}–{2 * int(size) - 1}" for size in sizes]
    axes.set_xticks(at, names, fontsize=SMALLEST, rotation=45 if len(names) > 7 else 0)
    plots.name(axes, "walkers in a cluster", "share of the walkers")
    return figure


@style()
def _packing(statistics: CrowdStatistics, title: str) -> Figure:
    """Draw the probability density of the local packing."""
    figure, axes = axes_of(title)
    _draw(axes, statistics.curves["local_packing"], SERIES[0], "")
    if (packing := statistics.numbers["packing"].value) is not None:
        plots.level(axes, packing, upright=True)
        place = (packing, 0.95)
        axes.annotate(" of the dish", place, xycoords=("data", "axes fraction"), color=INK, fontsize=SMALLEST)
    axes.set(xlim=(0, None), ylim=(0, None))
    plots.name(axes, "packing in a box", "probability density")
    return figure


def _draw(axes: Axes, curve: Curve, look: Look, label: str) -> None:
    """Draw a curve with its errors, as bars or, of a long one, as a band."""
    if len(curve.at) <= MOST_MARKED:
        plots.points(axes, curve, look, label, joined=True)
    else:
        plots.curve(axes, curve, look, label)
