"""Figures of measured motion, as in the paper's figures 5 and 6."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walkergen.analysis import walks
from walkergen.analysis.motion import Curve, Motion
from walkergen.files import words
from walkergen.files.figures import SMALLEST, axes_of, logarithmic, panels_of, style
from walkergen.points.track_figure import MOST_TRACKS

INK, WARM = "#0072B2", "#D55E00"
"""What was measured, and what was fitted to it."""

DRAWN = 0.5
"""Standard error of a local exponent beyond which it is not drawn: it tells 1 from 2 no more."""


@style()
def msd_figure(motion: Motion, title: str) -> Figure:
    """Draw the mean squared displacement, with its ballistic and diffusive limits (fig. 6a).

    Below it stands its local exponent.
    """
    figure, (axes, lower) = panels_of(title, (2.5, 1.2))
    lag, value = motion.msd.at, motion.msd.value
    _points(axes, motion.msd, "measured")
    axes.set_xscale("log")
    axes.set_yscale("log")
    limits = axes.get_xlim(), axes.get_ylim()
    speed2 = diffusivity = None
    if motion.msd_fit is not None:
        spread = motion.msd_fit.spreads[0]
        speed2 = spread.mean_square
        fine = np.geomspace(lag[0], lag[-1], 200)
        axes.plot(fine, walks.squared(fine, spread), color=WARM, label="fit", zorder=2.5)
        diffusivity = motion.estimates["diffusivity"].value
    elif (speed := motion.estimates["lane_speed"].value) is not None:
        speed2 = speed**2
    if speed2 and speed2 > 0:
        name = f"slope 2: v²t², v = {math.sqrt(speed2):.3g} mm/s"
        axes.plot(lag, speed2 * lag**2, "--", color="0.35", lw=0.8, label=name)
    if diffusivity:
        name = f"slope 1: 4Dt, D = {diffusivity:.3g} mm²/s"
        axes.plot(lag, 4 * diffusivity * lag, ":", color="0.35", lw=1.1, label=name)
    crossover = motion.estimates["crossover_time"].value
    if crossover is not None and limits[0][0] < crossover < limits[0][1]:
        axes.axvline(crossover, color="0.75", lw=0.8, zorder=0)
        axes.annotate(
            f"crossover {crossover:.2g} s ",
            (crossover, 0.98),
            ha="right",
            va="top",
            xycoords=("data", "axes fraction"),
            color="0.3",
            fontsize=SMALLEST,
        )
    axes.set_xlim(limits[0])
    axes.set_ylim(max(limits[1][0], 0.3 * value[value > 0].min(initial=np.inf)), limits[1][1])
    axes.set_ylabel("mean squared displacement (mm²)")
    logarithmic(axes.xaxis)
    logarithmic(axes.yaxis)
    axes.legend(loc="lower right")
    _exponents(lower, motion.exponent)
    return figure


def _exponents(axes: Axes, exponent: Curve) -> None:
    """Draw local exponents between those of diffusion and of a straight run."""
    # Walkers begin straight and end diffusing: words stand where the points are not.
    for value, limit, at, side in ((1.0, " diffusive: 1", 0.0, "left"), (2.0, "ballistic: 2", 1.0, "right")):
        axes.axhline(value, color="0.75", lw=0.8, zorder=0)
        axes.annotate(
            limit, (at, value), xycoords=("axes fraction", "data"), ha=side, va="bottom", fontsize=SMALLEST, color="0.3"
        )
    precise = exponent.se < DRAWN
    _points(axes, Curve(*(column[precise] for column in exponent)), "")
    axes.set_ylim(min(axes.get_ylim()[0], 0.75), max(axes.get_ylim()[1], 2.45))
    axes.set_xlabel("lag t (s)")
    axes.set_ylabel("local exponent")


@style()
def density_figure(motion: Motion, title: str) -> Figure:
    """Draw densities of the displacement along and across the body at one lag (fig. 6c)."""
    figure, axes = axes_of(title)
    for curve, name, colour, line in ((motion.parallel, "along", INK, "-"), (motion.orthogonal, "across", WARM, "--")):
        if len(curve.at):
            axes.plot(curve.at, curve.value, line, color=colour, drawstyle="steps-mid", label=name)
            axes.errorbar(curve.at, curve.value, curve.se, fmt="none", ecolor=colour, alpha=0.6)
    axes.set_ylim(bottom=0)
    axes.set_xlabel(f"displacement within {1e3 * motion.lag_s:g} ms (mm)")
    axes.set_ylabel("probability density (1/mm)")
    axes.legend()
    return figure


@style()
def correlation_figure(motion: Motion, title: str) -> Figure:
    """Draw how direction is lost: the modulus of its autocorrelation, with the fitted decay."""
    figure, axes = axes_of(title)
    _points(axes, motion.correlation, "measured")
    rate = motion.estimates["persistence_rate"].value
    if rate is not None:
        lag = np.linspace(0.0, motion.correlation.at[-1], 200)
        at, first = motion.correlation.at[0], motion.correlation.value[0]
        bridge = lag * (1.0 - lag / motion.own_s) - at * (1.0 - at / motion.own_s)
        axes.plot(lag, first * np.exp(-rate * bridge), color=WARM, label="exponential")
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    axes.set_xlabel("lag (s)")
    headed = motion.estimates["motion_speed"].value is None
    what = "headings" if headed else "displacements (mm²)"
    axes.set_ylabel(f"autocorrelation of {what}")
    axes.legend()
    return figure


@style()
def walkers_figure(motion: Motion, title: str) -> Figure:
    """Draw the speed of each walker with its error, and their mean with its bounds of 95 %."""
    figure, axes = axes_of(title)
    speeds = [(walker.particle, walker.of("speed")) for walker in motion.walkers]
    points = [(name, speed.value, speed.se) for name, speed in speeds if speed.value is not None]
    names, values, errors = zip(*points, strict=True)
    at = range(1, len(names) + 1)
    axes.errorbar(
        at,
        values,
        np.array(errors, dtype=float),
        fmt="o",
        color=INK,
        capsize=3,
        label="each, ± standard error in its track",
    )
    mean = motion.estimates["speed"]
    if (ends := mean.interval(0.95)) and mean.value is not None:
        axes.axhline(mean.value, color=WARM, label="mean, and where it lies with 95 %")
        limits = axes.get_ylim()
        axes.axhspan(*ends, color=WARM, alpha=0.15, lw=0)
        # Bounds over two walkers are many times as wide as the points lie apart.
        low, high = limits
        axes.set_ylim(min(max(ends[0], 2 * low - high), low), max(min(ends[1], 2 * high - low), high))
    if len(names) <= MOST_TRACKS:
        axes.set_xticks(at, [str(name) for name in names])
        axes.set_xlabel("walker")
    else:
        axes.set_xlabel("walkers, in the order of their numbers")
    axes.set_ylabel("speed (mm/s)")
    axes.legend()
    return figure


@style()
def plate_speed_figure(motion: Motion, title: str) -> Figure:
    """Draw speed against plate speed with the line through the origin (fig. 5, inset)."""
    figure, axes = axes_of(title)
    points = [(p, speed.value, speed.se) for p, speed in motion.by_plate_speed if speed.value is not None]
    plates, speeds, errors = np.array(points, dtype=float).reshape(-1, 3).T
    axes.errorbar(plates, speeds, errors, fmt="o", color=INK, capsize=3, label="measured")
    if motion.line is not None:
        ends = np.array([0.0, plates.max()])
        slope, se = motion.line.slope, motion.line.slope_se
        name = f"through the origin, slope {words.with_error(slope, se)}"
        axes.plot(ends, slope * ends, color=WARM, label=name)
    axes.set_xlim(left=0)
    axes.set_xlabel("plate speed (mm/s)")
    axes.set_ylabel("speed (mm/s)")
    axes.legend()
    return figure


OF_MOTION = {
    "plate_speed": plate_speed_figure,
    "walkers": walkers_figure,
    "msd": msd_figure,
    "density": density_figure,
    "correlation": correlation_figure,
}
"""Figures of a motion beside its tracks, by the stems of their files."""


def _points(axes: Axes, curve: Curve, label: str) -> None:
    errors = np.nan_to_num(curve.se)
    axes.errorbar(
        curve.at, curve.value, errors, fmt="o", color=INK, elinewidth=0.8, label=label, markersize=3.0, zorder=2
    )
