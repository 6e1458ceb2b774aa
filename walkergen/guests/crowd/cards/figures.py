"""Figures of a card: a walker's squared displacement, its correlations in time, and the delay of its velocity."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walkergen.analysis import persistent_walk
from walkergen.analysis.persistent_walk import Spread
from walkergen.files import figures as plots
from walkergen.files.figures import COLUMN_INCHES, FITTED, GREY, SERIES, Look, new_grid, style
from walkergen.guests.crowd.cards import delay
from walkergen.guests.crowd.cards.card import Card
from walkergen.guests.crowd.cards.relaxation import Relaxation
from walkergen.guests.crowd.cards.walker_motion import Measured

CORRELATION_SPAN = 5.0
"""Longest lag at which correlations are drawn, in relaxation times."""

MAX_DELAY_POINTS = 60
"""Most points of the delay function that are drawn."""


@style()
def draw_card(card: Card, measured: Measured) -> Figure:
    """Draw three panels: squared displacement with its parts, correlations of fluctuations, and delay function."""
    title = ", ".join(filter(None, (f"Card of {card.name}", card.scene)))
    figure, (spread, memory, late) = new_grid(title, 3, 1, 2.2, COLUMN_INCHES)
    _draw_spread(spread, card, measured)
    _draw_correlations(memory, measured)
    _draw_delay(late, card, measured)
    return figure


def _draw_spread(axes: Axes, card: Card, measured: Measured) -> None:
    """Draw the squared displacement by lag: measured, and from the card by its run, by its noise, and by both."""
    at, value, _ = measured.motion.msd
    speed, turning = card.speed_mm_s.number, card.turning_rad_s.number
    time, rotation = card.velocity_relaxation_s.number, card.rotational_diffusion_rad2_s.number
    fine = np.geomspace(at[0], at[-1], 200)
    run = persistent_walk.squared_displacement(fine, Spread(speed**2, rotation, 0.0, 0.0, turning))
    delayed = persistent_walk.delayed_lag(fine, time) if time > 0.0 else fine  # less the relaxation time of pushes
    pushed = 4.0 * card.translational_diffusion_mm2_s.number * delayed
    plots.draw_points(axes, measured.motion.msd, label="measured")
    axes.plot(fine, run + pushed, color=FITTED.colour, label="card: sum")
    axes.plot(fine, run, "--", color=GREY, label="run, turning")
    axes.plot(fine, pushed, ":", color=GREY, label="pushes")
    axes.set_xlim(0.8 * at[0], 1.25 * at[-1])
    positive = value[value > 0]
    if len(positive):
        axes.set_ylim(0.3 * positive.min(), 3.0 * positive.max())
    axes.legend(loc="upper left")
    plots.label_axes(axes, "lag (s)", "squared displacement (mm²)", log="xy")


def _draw_correlations(axes: Axes, measured: Measured) -> None:
    """Draw the correlations of velocity and of turning, each divided by its first value, with fitted exponentials."""
    longest = 0.0
    for relaxed, look, name in ((measured.velocity, SERIES[0], "velocity"), (measured.turning, SERIES[1], "turning")):
        curve = relaxed.correlation
        if not len(curve.at) or not curve.value[0] > 0.0 or relaxed.time.value is None:
            continue
        shown = curve.at <= max(CORRELATION_SPAN * relaxed.time.value, 6.0 * measured.interval)
        longest = max(longest, float(curve.at[shown][-1]))
        _draw_correlation(axes, relaxed, int(shown.sum()), look, name)
    plots.draw_level(axes)
    if longest:
        axes.set_xlim(-0.02 * longest, 1.02 * longest)
        axes.legend(loc="upper right")
    plots.label_axes(axes, "lag (s)", "correlation")


def _draw_correlation(axes: Axes, relaxed: Relaxation, shown: int, look: Look, name: str) -> None:
    """Draw the first `shown` points of a correlation, divided by its first value, and its fitted exponential."""
    at, value, se = (part[:shown] for part in relaxed.correlation)
    first, time = value[0], relaxed.time.value
    plots.draw_points(axes, (at, value / first, se / first), look, f"of {name}")
    if relaxed.resolved and time:
        fine = np.linspace(0.0, float(at[-1]), 200)
        height = relaxed.deviation**2 / first
        axes.plot(fine, height * np.exp(-fine / time), color=look.colour, lw=0.8, label=f"exp(-t / {time:.2g} s)")


def _draw_delay(axes: Axes, card: Card, measured: Measured) -> None:
    """Draw the measured delay function, and that of a particle with inertia and the card's numbers, by lag."""
    function = measured.delay.function
    stride = max(len(function.at) // MAX_DELAY_POINTS, 1)
    at, value, se = (part[::stride] for part in function)
    plots.draw_level(axes)
    plots.label_axes(axes, "lag (s)", "delay function (mm/s)")
    if not len(at):
        return
    plots.draw_points(axes, (at, value, se), label="measured")
    time = card.velocity_relaxation_s.number
    if time > 0.0:
        fine = np.linspace(0.0, float(at[-1]), 300)
        rate, turn = card.rotational_diffusion_rad2_s.number, card.turning_rad_s.number
        expected = delay.inertial_delay_function(fine, card.propulsion_mm_s, rate, turn, time)
        axes.plot(fine, expected, color=FITTED.colour, label="card: inertia alone")
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.2 * (high - low))
    axes.legend(loc="upper right", ncols=2)
