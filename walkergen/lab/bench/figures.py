"""Figures of the bench tests: curves from what the model needs to what is seen."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walkergen.analysis.inverse import Measured
from walkergen.files.figures import COLUMN, STYLES, axes_of, style, wrapped
from walkergen.lab.bench.drop import Dropped
from walkergen.lab.bench.pluck import Plucked
from walkergen.lab.bench.slide import Incline

Points = Sequence[tuple[float, float]]

BLUE, ORANGE = STYLES["flexible"][0], STYLES["braced"][0]
GREEN, GREY = "#009E73", "0.45"


@style()
def of_drop(dropped: Dropped, title: str, turn_deg: float, measured: Measured | None) -> Figure:
    """Draw the rebound against the feet's restitution, let go flat and from the hand."""
    figure, axes = axes_of(title)
    axes.plot((0, 1), (0, 1), ":", color=GREY, linewidth=0.9, label="a ball")
    flat, hand = dropped.curve(flat=True), dropped.curve(flat=False)
    if flat is not None:
        axes.plot(flat.at, flat.seen, "o-", color=BLUE, markersize=4, label="let go flat")
    if hand is not None and turn_deg > 0.0:
        axes.plot(
            hand.at,
            hand.seen,
            "s--",
            color=ORANGE,
            markersize=4,
            label=f"from the hand, pitch and roll ± {turn_deg:g}°",
        )
        band = hand.seen - hand.spread, hand.seen + hand.spread
        axes.fill_between(hand.at, *band, color=ORANGE, alpha=0.2, linewidth=0)
    _draw_measured(axes, measured)
    axes.set_xlabel("restitution of the feet (label)")
    axes.set_ylabel("rebound of the whole walker")
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 1)
    axes.legend(loc="upper left", frameon=True, framealpha=0.9, edgecolor="none")
    return figure


@style()
def of_slide(incline: Incline, title: str, measured: Measured | None) -> Figure:
    """Draw the slope at which a walker gives way against friction, by the way it faces."""
    figure, axes = axes_of(title)
    fine = np.linspace(0.0, max(incline.frictions), 200)
    axes.plot(fine, np.degrees(np.arctan(fine)), ":", color=GREY, label="a rigid block")
    looks = zip(incline.by_heading.items(), ((BLUE, "o"), (ORANGE, "s"), (GREEN, "^")), strict=True)
    for (facing, row), (colour, marker) in looks:
        points = [
            (friction, outcome.angle, outcome.toppled)
            for friction, outcome in zip(incline.frictions, row, strict=True)
            if outcome.angle is not None
        ]
        slid = [(friction, angle) for friction, angle, toppled in points if not toppled]
        fell = [(friction, angle) for friction, angle, toppled in points if toppled]
        axes.plot(*np.array(slid).reshape(-1, 2).T, marker, color=colour, markersize=5, label=f"facing {facing}")
        axes.plot(*np.array(fell).reshape(-1, 2).T, marker, color=colour, markersize=5, markerfacecolor="none")
    slips = [pair for pair in zip(incline.frictions, incline.slips, strict=True) if pair[1] is not None]
    if slips:
        axes.plot(*np.array(slips, float).T, "--", color=ORANGE, linewidth=0.9, label="upper foot slips (statics)")
    _draw_measured(axes, measured)
    axes.set_xlabel("friction; open: it falls over")
    axes.set_ylabel("slope at which it gives way (deg)")
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
    axes.legend(loc="upper left", frameon=True, framealpha=0.9, edgecolor="none")
    return figure


@style()
def of_pluck(plucked: Plucked, title: str, measured: Measured | None, curve: Points) -> Figure:
    """Draw a leg of the model ringing, and the frequency heard against Young's modulus."""
    figure = Figure(figsize=(COLUMN, 4.2), layout="constrained")
    top, bottom = figure.subplots(2, 1)
    figure.suptitle(wrapped(title, COLUMN - 0.1))
    ringing = plucked.held
    top.plot(1e3 * ringing.times, 1e3 * ringing.angles, color=BLUE)
    top.set_xlabel("time (ms)")
    top.set_ylabel("the model's leg (mrad)")
    at, hertz = np.array(curve).T
    bottom.plot(at, hertz, "o-", color=BLUE, markersize=4, label="printed leg, first mode")
    hinge = hertz * plucked.held.frequency / plucked.cantilever
    bottom.plot(at, hinge, "--", color=ORANGE, linewidth=0.9, label="the model's hinge")
    _draw_measured(bottom, measured)
    bottom.set_xlabel("Young's modulus (GPa)")
    bottom.set_ylabel("frequency (Hz)")
    bottom.legend(loc="upper left", frameon=True, framealpha=0.9, edgecolor="none")
    return figure


def _draw_measured(axes: Axes, measured: Measured | None) -> None:
    if measured is None:
        return
    low, high = measured.value - measured.sd, measured.value + measured.sd
    axes.axhspan(low, high, color=GREY, alpha=0.2, linewidth=0, label="measured")
    axes.axhline(measured.value, color=GREY, linewidth=0.9)
