"""Figures of what a crowd did, the same for films and for simulations."""

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walkergen.analysis.motion import Curve
from walkergen.crowd.statistics.measuring import CrowdStatistics
from walkergen.files.figures import SERIES, SMALLEST, axes_of, logarithmic, panels_of, style

GREY = "0.6"
"""Colour of what walkers at random would do."""

MOST_MARKED = 40
"""Most points of a curve that have markers and bars; of longer ones the error is a band."""


def figures(statistics: CrowdStatistics, title: str) -> Mapping[str, Callable[[], Figure]]:
    """What draws each figure that the crowd has, by the stems of their files."""
    return {
        name: partial(draw, statistics, title)
        for name, (needs, draw) in FIGURES.items()
        if needs in statistics.series or _rises(statistics, needs)
    }


def _rises(statistics: CrowdStatistics, needs: str) -> bool:
    """Whether a curve has points above 0 enough to be drawn, on a logarithmic axis as well."""
    return needs in statistics.curves and int((statistics.curves[needs].value > 0).sum()) > 1


@style()
def course_figure(statistics: CrowdStatistics, title: str) -> Figure:
    """Draw order of headings and clusters against time."""
    groups = [
        ("order", ("polar_order", "nematic_order", "local_polar_order", "milling")),
        ("share of walkers", ("largest_cluster", "alone")),
        ("speed (mm/s)", ("speed", "wall_speed")),
    ]
    shown = [(label, [name for name in names if name in statistics.series]) for label, names in groups]
    shown = [(label, names) for label, names in shown if names]
    figure, panels = panels_of(title, [1.5] * len(shown))
    for axes, (label, names) in zip(panels, shown, strict=True):
        for number, name in enumerate(names):
            _draw(axes, statistics.series[name], number, name.replace("_", " "))
        axes.set_ylabel(label)
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
        axes.margins(x=0)
        axes.legend(ncols=2, loc="best")
    panels[-1].set_xlabel("time (s)")
    return figure


@style()
def pairs_figure(statistics: CrowdStatistics, title: str) -> Figure:
    """Draw the pair correlation and, below, how alike headings are, by distance."""
    alike = [name for name in ("polar_correlation", "nematic_correlation") if name in statistics.curves]
    figure, panels = panels_of(title, [2.0, 1.4][: 1 + bool(alike)])
    _draw(panels[0], statistics.curves["g"], 0, "")
    panels[0].axhline(1.0, color=GREY, lw=0.8, zorder=0)
    panels[0].set_ylabel("pair correlation g")
    panels[0].set_ylim(bottom=0)
    for number, name in enumerate(alike):
        _draw(panels[1], statistics.curves[name], number, name.split("_")[0])
    if alike:
        panels[1].axhline(0.0, color=GREY, lw=0.8, zorder=0)
        panels[1].set_ylabel("alignment of pairs")
        panels[1].legend()
    panels[-1].set_xlabel("distance of centres (mm)")
    panels[-1].set_xlim(left=0)
    return figure


@style()
def fluctuations_figure(statistics: CrowdStatistics, title: str) -> Figure:
    """Draw the standard deviation of the number of walkers in boxes against its mean."""
    figure, axes = axes_of(title)
    mean, variance, se = statistics.curves["fluctuations"]
    use = variance > 0
    deviation = np.sqrt(variance[use])
    error = np.nan_to_num(se[use]) / (2.0 * deviation)
    colour, _, marker = SERIES[0]
    axes.errorbar(mean[use], deviation, error, fmt=marker, color=colour, label="measured")
    fine = np.array([mean[use].min(), mean[use].max()])
    axes.plot(fine, np.sqrt(fine), "--", color=GREY, label="at random: mean$^{1/2}$", zorder=0)
    axes.set_xscale("log")
    axes.set_yscale("log")
    logarithmic(axes.xaxis)
    logarithmic(axes.yaxis)
    axes.set_xlabel("mean number of walkers in a box")
    axes.set_ylabel("standard deviation with time")
    axes.legend()
    return figure


@style()
def msd_figure(statistics: CrowdStatistics, title: str) -> Figure:
    """Draw the mean squared displacement by lag."""
    figure, axes = axes_of(title)
    lag, squares, se = statistics.curves["msd"]
    use = squares > 0
    colour, _, marker = SERIES[0]
    axes.errorbar(lag[use], squares[use], np.nan_to_num(se[use]), fmt=marker, color=colour)
    for power, at, words in ((2, 0, "slope 2"), (1, -1, "slope 1")):
        line = squares[use][at] * (lag[use] / lag[use][at]) ** power
        axes.plot(lag[use], line, (":", "--")[power - 1], color=GREY, label=words, zorder=0)
    axes.set_xscale("log")
    axes.set_yscale("log")
    logarithmic(axes.xaxis)
    logarithmic(axes.yaxis)
    axes.set_xlabel("lag (s)")
    axes.set_ylabel("mean squared displacement (mm²)")
    axes.legend()
    return figure


@style()
def walls_figure(statistics: CrowdStatistics, title: str) -> Figure:
    """Draw density, speed and alignment against the distance from the wall."""
    shown = [
        (name, label, chance)
        for name, label, chance in (
            ("wall_density", "density / mean", 1.0),
            ("wall_speed", "speed (mm/s)", None),
            ("wall_alignment", "along the wall", 0.0),
        )
        if name in statistics.curves
    ]
    figure, panels = panels_of(title, [1.3] * len(shown))
    for axes, (name, label, chance) in zip(panels, shown, strict=True):
        _draw(axes, statistics.curves[name], 0, "")
        if chance is not None:
            axes.axhline(chance, color=GREY, lw=0.8, zorder=0)
        axes.set_ylabel(label)
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    panels[-1].set_xlim(left=0)
    panels[-1].set_xlabel("distance of the centre from the wall (mm)")
    return figure


@style()
def clusters_figure(statistics: CrowdStatistics, title: str) -> Figure:
    """Draw the share of walkers in clusters of each octave of sizes."""
    figure, axes = axes_of(title)
    sizes, shares, se = statistics.curves["cluster_shares"]
    at = range(len(sizes))
    axes.bar(at, shares, color=SERIES[5][0], yerr=np.nan_to_num(se), ecolor="0.3", capsize=2)
    names = [f"{int(size)}" if size == 1 else f"{int(size)}–{2 * int(size) - 1}" for size in sizes]
    axes.set_xticks(at, names, fontsize=SMALLEST, rotation=45 if len(names) > 7 else 0)
    axes.set_xlabel("walkers in a cluster")
    axes.set_ylabel("share of the walkers")
    return figure


@style()
def packing_figure(statistics: CrowdStatistics, title: str) -> Figure:
    """Draw the probability density of the local packing."""
    figure, axes = axes_of(title)
    _draw(axes, statistics.curves["local_packing"], 0, "")
    packing = statistics.numbers["packing"].value
    if packing is not None:
        axes.axvline(packing, color=GREY, lw=0.8, zorder=0)
        axes.annotate(
            " of the dish", (packing, 0.95), xycoords=("data", "axes fraction"), color="0.3", fontsize=SMALLEST
        )
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    axes.set_xlabel("packing in a box")
    axes.set_ylabel("probability density")
    return figure


FIGURES: Mapping[str, tuple[str, Callable[[CrowdStatistics, str], Figure]]] = {
    "crowd_course": ("speed", course_figure),
    "crowd_pairs": ("g", pairs_figure),
    "crowd_fluctuations": ("fluctuations", fluctuations_figure),
    "crowd_msd": ("msd", msd_figure),
    "crowd_walls": ("wall_density", walls_figure),
    "crowd_clusters": ("cluster_shares", clusters_figure),
    "crowd_packing": ("local_packing", packing_figure),
}
"""Figures by the stems of their files, with the series or curve that each needs."""


def _draw(axes: Axes, curve: Curve, number: int, label: str) -> None:
    """Draw a curve with its errors, as bars or, of a long one, as a band."""
    colour, line, marker = SERIES[number]
    if len(curve.at) <= MOST_MARKED:
        errors = np.nan_to_num(curve.se)
        axes.errorbar(
            curve.at,
            curve.value,
            errors,
            fmt=marker,
            ls=line,
            color=colour,
            markersize=3.0,
            elinewidth=0.8,
            label=label or None,
        )
        return
    axes.plot(curve.at, curve.value, ls=line, color=colour, lw=0.9, label=label or None)
    low, high = curve.value - curve.se, curve.value + curve.se
    axes.fill_between(curve.at, low, high, color=colour, alpha=0.25, lw=0)
