"""Figure of a card: how a walker spreads, how long it remembers a push, how late it follows."""

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walkergen.analysis import delay, walks
from walkergen.analysis.motion import Array, Curve
from walkergen.analysis.relaxation import Relaxation
from walkergen.analysis.walks import Spread
from walkergen.crowd.cards.card import Card
from walkergen.crowd.cards.walker_motion import Measured
from walkergen.crowd.cards.walled import Walled
from walkergen.files.figures import COLUMN, logarithmic, panels_of, style, wrapped

BLUE, ORANGE, GREY = "#0072B2", "#D55E00", "0.45"

SHOWN = 5.0
"""Times of relaxation over which correlations are drawn."""

DELAYS = 60
"""Most points of the delay function that are drawn."""


@style()
def of_card(card: Card, measured: Measured) -> Figure:
    """Draw squared displacement with its parts, correlations of fluctuations, delay function."""
    figure = Figure(figsize=(COLUMN, 6.6), layout="constrained")
    spread, memory, late = figure.subplots(3, 1)
    title = ", ".join(filter(None, (f"Card of {card.name}", card.scene)))
    figure.suptitle(wrapped(title, COLUMN - 0.1))
    _spread(spread, card, measured)
    _memory(memory, measured)
    _delay(late, card, measured)
    return figure


def _spread(axes: Axes, card: Card, measured: Measured) -> None:
    """Squared displacement measured, and what run and diffusion of the card make of it."""
    at, value, se = measured.motion.msd
    axes.errorbar(at, value, np.nan_to_num(se), fmt="o", color=BLUE, markersize=2.5, elinewidth=0.8, label="measured")
    fine = np.geomspace(at[0], at[-1], 200)
    run = walks.squared(
        fine,
        Spread(card.speed_mm_s.number**2, card.rotational_diffusion_rad2_s.number, 0.0, 0.0, card.turning_rad_s.number),
    )
    pushed = 4.0 * card.translational_diffusion_mm2_s.number * _late(fine, card)
    axes.plot(fine, run + pushed, color=ORANGE, label="card: sum")
    axes.plot(fine, run, "--", color=GREY, label="run, turning")
    axes.plot(fine, pushed, ":", color=GREY, label="pushes")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(0.8 * at[0], 1.25 * at[-1])
    positive = value[value > 0]
    if len(positive):
        axes.set_ylim(0.3 * positive.min(), 3.0 * positive.max())
    logarithmic(axes.xaxis)
    logarithmic(axes.yaxis)
    axes.set_xlabel("lag (s)")
    axes.set_ylabel("squared displacement (mm²)")
    axes.legend(loc="upper left")


def _late(lag: Array, card: Card) -> Array:
    """Lags, shortened by the time in which pushes are remembered."""
    time = card.velocity_relaxation_s.number
    return walks.late(lag, time) if time > 0.0 else lag


def _memory(axes: Axes, measured: Measured) -> None:
    """Correlations of velocity and of turning, each over its first value, with exponentials."""
    longest = 0.0
    for relaxed, colour, marker, name in (
        (measured.velocity, BLUE, "o", "velocity"),
        (measured.turning, ORANGE, "s", "turning"),
    ):
        curve = relaxed.correlation
        if not len(curve.at) or not curve.value[0] > 0.0 or relaxed.time.value is None:
            continue
        shown = curve.at <= max(SHOWN * relaxed.time.value, 6.0 * measured.interval)
        longest = max(longest, float(curve.at[shown][-1]))
        _correlation(axes, relaxed, shown, (colour, marker, name))
    axes.axhline(0.0, color="0.8", linewidth=0.6, zorder=0)
    if longest:
        axes.set_xlim(-0.02 * longest, 1.02 * longest)
        axes.legend(loc="upper right")
    axes.set_xlabel("lag (s)")
    axes.set_ylabel("correlation")


def _correlation(axes: Axes, relaxed: Relaxation, shown: npt.NDArray[np.bool_], look: tuple[str, str, str]) -> None:
    curve, (colour, marker, name) = relaxed.correlation, look
    first = curve.value[0]
    axes.errorbar(
        curve.at[shown],
        curve.value[shown] / first,
        curve.se[shown] / first,
        fmt=marker,
        color=colour,
        markersize=2.5,
        elinewidth=0.8,
        label=f"of {name}",
    )
    time = relaxed.time.value
    if relaxed.resolved and time:
        fine = np.linspace(0.0, float(curve.at[shown][-1]), 200)
        height = relaxed.deviation**2 / first
        axes.plot(fine, height * np.exp(-fine / time), color=colour, linewidth=0.8, label=f"exp(-t / {time:.2g} s)")


def _delay(axes: Axes, card: Card, measured: Measured) -> None:
    """Delay function measured, and that of a particle with the card's numbers."""
    curve = _thinned(measured.delay.function)
    axes.axhline(0.0, color="0.8", linewidth=0.6, zorder=0)
    axes.set_xlabel("lag (s)")
    axes.set_ylabel("delay function (mm/s)")
    if not len(curve.at):
        return
    axes.errorbar(
        curve.at, curve.value, curve.se, fmt="o", color=BLUE, markersize=2.5, elinewidth=0.8, label="measured"
    )
    time = card.velocity_relaxation_s.number
    if time > 0.0:
        fine = np.linspace(0.0, float(curve.at[-1]), 300)
        rate, turn = card.rotational_diffusion_rad2_s.number, card.turning_rad_s.number
        expected = delay.expected(fine, card.propulsion_mm_s, rate, turn, time)
        axes.plot(fine, expected, color=ORANGE, label="card: inertia alone")
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.2 * (high - low))
    axes.legend(loc="upper right", ncols=2)


@style()
def of_walls(card: Card, walled: Walled) -> Figure:
    """Draw how often a walker stands to a wall at each angle, and how it turns there."""
    title = f"{card.name} by the wall of {walled.dish.words}"
    figure, (often, turns) = panels_of(title, (1.6, 1.9))
    by_wall = walled.by_wall
    angles = np.degrees(by_wall.angles)
    often.stairs(by_wall.density, np.linspace(-180.0, 180.0, len(angles) + 1), color=BLUE, fill=True, alpha=0.6)
    often.set_ylabel("density (1/rad)")
    seen = np.isfinite(by_wall.rates) & np.isfinite(by_wall.rates_se)
    turns.errorbar(
        angles[seen], by_wall.rates[seen], by_wall.rates_se[seen], fmt="o", color=BLUE, markersize=3.0, elinewidth=0.8
    )
    turns.axhline(0.0, color="0.8", linewidth=0.6, zorder=0)
    turns.set_ylabel("turning by it (rad/s)")
    turns.set_xlabel("heading from the way out (deg)")
    turns.set_xlim(-180.0, 180.0)
    turns.set_xticks(np.arange(-180, 181, 90))
    return figure


def _thinned(curve: Curve) -> Curve:
    """Curve with few enough points to see."""
    stride = max(len(curve.at) // DELAYS, 1)
    return Curve(*(part[::stride] for part in curve))
