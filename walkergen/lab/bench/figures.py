"""Figures of the bench tests: curves from what the model needs to what is seen."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walkergen.files.figures import BLUE, COLUMN, GREEN, GREY, ORANGE, axes_of, name, style, wrapped
from walkergen.lab.bench.drop import Dropped
from walkergen.lab.bench.pluck import Plucked
from walkergen.lab.bench.slide import Incline
from walkergen.lab.inverse import Measured


@style()
def of_drop(dropped: Dropped, title: str, turn_deg: float, measured: Measured | None) -> Figure:
    """Draw the rebound against the feet's restitution, let go flat and from the hand."""
    figure, axes = axes_of(title)
    axes.plot((0, 1), (0, 1), ":", color=GREY, linewidth=0.9, label="a ball")
    flat, hand = dropped.curve(flat=True), dropped.curve(flat=False)
    if flat is not None:
        axes.plot(flat.at, flat.seen, "o-", color=BLUE, label="let go flat")
    if hand is not None and turn_deg > 0.0:
        words = f"from the hand, pitch and roll ± {turn_deg:g}°"
        axes.plot(hand.at, hand.seen, "s--", color=ORANGE, label=words)
        axes.fill_between(
            hand.at, hand.seen - hand.spread, hand.seen + hand.spread, color=ORANGE, alpha=0.2, linewidth=0
        )
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 1)
    _finish(axes, measured, "restitution of the feet (label)", "rebound of the whole walker")
    return figure


@style()
def of_slide(incline: Incline, title: str, measured: Measured | None) -> Figure:
    """Draw the slope at which a walker gives way against friction, by the way it faces."""
    figure, axes = axes_of(title)
    fine = np.linspace(0.0, max(incline.frictions), 200)
    axes.plot(fine, np.degrees(np.arctan(fine)), ":", color=GREY, label="a rigid block")
    looks = zip(incline.by_heading.items(), ((BLUE, "o"), (ORANGE, "s"), (GREEN, "^")), strict=True)
    for (facing, row), (colour, marker) in looks:
        for toppled, face in ((False, colour), (True, "none")):
            points = [
                (friction, outcome.angle)
                for friction, outcome in zip(incline.frictions, row, strict=True)
                if outcome.angle is not None and outcome.toppled == toppled
            ]
            label = "_" if toppled else f"facing {facing}"
            axes.plot(
                *np.array(points).reshape(-1, 2).T,
                marker,
                color=colour,
                markersize=5,
                markerfacecolor=face,
                label=label,
            )
    slips = [pair for pair in zip(incline.frictions, incline.slips, strict=True) if pair[1] is not None]
    if slips:
        axes.plot(*np.array(slips, float).T, "--", color=ORANGE, linewidth=0.9, label="upper foot slips (statics)")
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
    _finish(axes, measured, "friction; open: it falls over", "slope at which it gives way (deg)")
    return figure


@style()
def of_pluck(plucked: Plucked, title: str, measured: Measured | None, curve: Sequence[tuple[float, float]]) -> Figure:
    """Draw a leg of the model ringing, and the frequency heard against Young's modulus."""
    figure = Figure(figsize=(COLUMN, 4.2), layout="constrained")
    top, bottom = figure.subplots(2, 1)
    figure.suptitle(wrapped(title, COLUMN - 0.1))
    ringing = plucked.held
    top.plot(1e3 * ringing.times, 1e3 * ringing.angles, color=BLUE)
    name(top, "time (ms)", "the model's leg (mrad)")
    at, hertz = np.array(curve).T
    bottom.plot(at, hertz, "o-", color=BLUE, label="printed leg, first mode")
    hinge = hertz * plucked.held.frequency / plucked.cantilever
    bottom.plot(at, hinge, "--", color=ORANGE, linewidth=0.9, label="the model's hinge")
    _finish(bottom, measured, "Young's modulus (GPa)", "frequency (Hz)")
    return figure


def _finish(axes: Axes, measured: Measured | None, x: str, y: str) -> None:
    """Draw what was measured, with its error; name axes and curves."""
    if measured is not None:
        value, sd = measured.number.pair
        axes.axhspan(value - sd, value + sd, color=GREY, alpha=0.2, linewidth=0, label="measured")
        axes.axhline(value, color=GREY, linewidth=0.9)
    name(axes, x, y)
    axes.legend(loc="upper left", frameon=True, framealpha=0.9, edgecolor="none")
