"""Figures of measured motion, as in the paper's figures 5 and 6."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walkergen.analysis import persistent_walk
from walkergen.analysis.motion import Curve, Motion
from walkergen.core.files import formatting
from walkergen.files.figures import (
    FITTED,
    INK,
    MEASURED,
    MIN_FONT_PT,
    draw_level,
    draw_points,
    label_axes,
    new_axes,
    new_panels,
    style,
)
from walkergen.points.track_figure import MAX_TRACKS

MAX_EXPONENT_SE = 0.5
"""Largest standard error of a local exponent that is drawn. With larger errors 1 and 2 cannot be distinguished."""


@style()
def draw_msd(motion: Motion, title: str) -> Figure:
    """Draw the mean squared displacement with ballistic and diffusive limits (fig. 6a), above its local exponent."""
    figure, (axes, lower) = new_panels(title, (2.5, 1.2))
    lag, value = motion.msd.at, motion.msd.value
    draw_points(axes, motion.msd, label="measured")
    axes.set_xscale("log")
    axes.set_yscale("log")
    limits = axes.get_xlim(), axes.get_ylim()
    speed2 = diffusivity = None
    if motion.msd_fit is not None:
        spread = motion.msd_fit.spreads[0]
        speed2 = spread.mean_square
        fine = np.geomspace(lag[0], lag[-1], 200)
        axes.plot(
            fine, persistent_walk.squared_displacement(fine, spread), color=FITTED.colour, label="fit", zorder=2.5
        )
        diffusivity = motion.estimates["diffusivity"].value
    elif (speed := motion.estimates["lane_speed"].value) is not None:
        speed2 = speed**2
    if speed2 and speed2 > 0:
        label = f"slope 2: v²t², v = {math.sqrt(speed2):.3g} mm/s"
        axes.plot(lag, speed2 * lag**2, "--", color=INK, lw=0.8, label=label)
    if diffusivity:
        label = f"slope 1: 4Dt, D = {diffusivity:.3g} mm²/s"
        axes.plot(lag, 4 * diffusivity * lag, ":", color=INK, label=label)
    crossover = motion.estimates["crossover_time"].value
    if crossover is not None and limits[0][0] < crossover < limits[0][1]:
        draw_level(axes, crossover, upright=True)
        text = f"crossover {crossover:.2g} s "
        position, units = (crossover, 0.98), ("data", "axes fraction")
        axes.annotate(text, position, xycoords=units, ha="right", va="top", color=INK, fontsize=MIN_FONT_PT)
    axes.set_xlim(limits[0])
    axes.set_ylim(max(limits[1][0], 0.3 * value[value > 0].min(initial=np.inf)), limits[1][1])
    label_axes(axes, y="mean squared displacement (mm²)", log="xy")
    axes.legend(loc="lower right")
    _draw_exponents(lower, motion.exponent)
    return figure


def _draw_exponents(axes: Axes, exponent: Curve) -> None:
    """Draw local exponents against lag, with levels at 1 (diffusion) and 2 (a straight run)."""
    # Walkers begin straight and end diffusing: the labels are where no points are
    for value, limit, x, side in ((1.0, " diffusive: 1", 0.0, "left"), (2.0, "ballistic: 2", 1.0, "right")):
        draw_level(axes, value)
        units = ("axes fraction", "data")
        axes.annotate(limit, (x, value), xycoords=units, ha=side, va="bottom", color=INK, fontsize=MIN_FONT_PT)
    precise = exponent.se < MAX_EXPONENT_SE
    draw_points(axes, Curve(*(column[precise] for column in exponent)))
    axes.set_ylim(min(axes.get_ylim()[0], 0.75), max(axes.get_ylim()[1], 2.45))
    label_axes(axes, "lag t (s)", "local exponent")


@style()
def draw_density(motion: Motion, title: str) -> Figure:
    """Draw densities of the displacement along and across the body at one lag (fig. 6c)."""
    figure, axes = new_axes(title)
    for curve, label, look in ((motion.parallel, "along", MEASURED), (motion.orthogonal, "across", FITTED)):
        if len(curve.at):
            axes.plot(curve.at, curve.value, look.line, color=look.colour, drawstyle="steps-mid", label=label)
            axes.errorbar(*curve, fmt="none", ecolor=look.colour, alpha=0.6)
    axes.set_ylim(bottom=0)
    label_axes(axes, f"displacement within {1e3 * motion.lag_s:g} ms (mm)", "probability density (1/mm)")
    axes.legend()
    return figure


@style()
def draw_correlation(motion: Motion, title: str) -> Figure:
    """Draw the modulus of the autocorrelation of the direction against lag, with the fitted decay."""
    figure, axes = new_axes(title)
    draw_points(axes, motion.correlation, label="measured")
    rate = motion.estimates["persistence_rate"].value
    if rate is not None:
        lag = np.linspace(0.0, motion.correlation.at[-1], 200)
        at, first = motion.correlation.at[0], motion.correlation.value[0]
        # Subtracting the mean turning, measured within `detrend_time_s`, slows the decay
        bridge = lag * (1.0 - lag / motion.detrend_time_s) - at * (1.0 - at / motion.detrend_time_s)
        axes.plot(lag, first * np.exp(-rate * bridge), color=FITTED.colour, label="exponential")
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    headed = motion.estimates["motion_speed"].value is None
    label_axes(axes, "lag (s)", f"autocorrelation of {'headings' if headed else 'displacements (mm²)'}")
    axes.legend()
    return figure


@style()
def draw_walkers(motion: Motion, title: str) -> Figure:
    """Draw the speed of each walker with its error, and their mean with its bounds of 95 %."""
    figure, axes = new_axes(title)
    speeds = [(walker.particle, walker.mean("speed")) for walker in motion.walkers]
    rows = [(number, speed.value, speed.se) for number, speed in speeds if speed.value is not None]
    names, values, errors = zip(*rows, strict=True)
    x = range(1, len(names) + 1)
    draw_points(axes, (x, values, errors), label="each, ± standard error in its track")
    mean = motion.estimates["speed"]
    if (ends := mean.interval()) and mean.value is not None:
        axes.axhline(mean.value, color=FITTED.colour, label="mean, and where it lies with 95 %")
        limits = axes.get_ylim()
        axes.axhspan(*ends, color=FITTED.colour, alpha=0.15, lw=0)
        # The bounds from two walkers are many times as wide as the distance of the points
        low, high = limits
        axes.set_ylim(min(max(ends[0], 2 * low - high), low), max(min(ends[1], 2 * high - low), high))
    few = len(names) <= MAX_TRACKS
    if few:
        axes.set_xticks(x, [str(name) for name in names])
    label_axes(axes, "walker" if few else "walkers, in the order of their numbers", "speed (mm/s)")
    axes.legend()
    return figure


@style()
def draw_plate_speed(motion: Motion, title: str) -> Figure:
    """Draw speed against plate speed with the line through the origin (fig. 5, inset)."""
    figure, axes = new_axes(title)
    rows = [(plate, speed.value, speed.se) for plate, speed, _ in motion.by_plate_speed if speed.value is not None]
    measured = np.array(rows, dtype=float).reshape(-1, 3).T
    draw_points(axes, [*measured], label="measured")
    if motion.line is not None:
        ends = np.array([0.0, measured[0].max()])
        slope, se = motion.line.slope.pair
        label = f"through the origin, slope {formatting.format_with_error(slope, se)}"
        axes.plot(ends, slope * ends, color=FITTED.colour, label=label)
    axes.set_xlim(left=0)
    label_axes(axes, "plate speed (mm/s)", "speed (mm/s)")
    axes.legend()
    return figure


MOTION_FIGURES = {
    "plate_speed": draw_plate_speed,
    "walkers": draw_walkers,
    "msd": draw_msd,
    "density": draw_density,
    "correlation": draw_correlation,
}
"""Figures of a motion in addition to its tracks, by the stems of their files."""
