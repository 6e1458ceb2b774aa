"""Figure of the trade-off: what was surveyed and tried against every key that varies."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walkergen.files.figures import BLUE, COLUMN, INK, ORANGE, PAGE, Look, grid_of, legend_below, name, points, style
from walkergen.files.key_names import label
from walkergen.jobs.make.design.lab import Job, Trial
from walkergen.jobs.make.design.search import Search
from walkergen.jobs.make.design.verify import Verified
from walkergen.jobs.make.design.wish import UNITS, Wish
from walkergen.points.point import PREDICTION

ACROSS = 3
"""Largest number of panels side by side."""

BESIDE = ((8, 5), (-13, -13), (8, -13))
"""Places of the numbers of designs beside their marks, points: designs often share a value."""


@style()
def trade_off(title: str, job: Job, result: Search, designs: Sequence[Verified]) -> Figure:
    """Draw the wish's quantity against each key: surveyed, tried, and the designs, numbered."""
    spans, wish = job.box.spans, job.wish
    wide = min(len(spans), ACROSS)
    figure, panels = grid_of(title, len(spans), wide, 2.9, COLUMN if wide == 1 else PAGE, share_y=True)
    for place, (span, axes) in enumerate(zip(spans, panels, strict=True)):
        if wish.of == "speed":
            _trials(axes, span.key, result.survey.trials, "0.75", 3.0, "predicted")
        if job.model != PREDICTION or wish.of != "speed":
            _trials(axes, span.key, result.trials, INK, 5.0, f"tried, model {job.model}")
        _wish(axes, wish)
        for number, design in enumerate(designs, start=1):
            _design(axes, design, design.values[span.key], number, job.simulated)
        if wish.logarithmic:
            axes.set_yscale("log")
        name(axes, label(span.key), "" if place % wide else f"{wish.of} ({UNITS[wish.of]})")
    legend_below(figure, 2 if wide == 1 else 4)
    return figure


def _trials(axes: Axes, key: str, trials: Sequence[Trial], colour: str, size: float, label: str) -> None:
    """Draw the wish's quantity of trials against the value of a key."""
    pairs = [(trial.values[key], trial.seen.value) for trial in trials if trial.usable and trial.seen]
    axes.plot(*np.reshape(pairs, (-1, 2)).T, ".", color=colour, markersize=size, label=label, rasterized=True)


def _design(axes: Axes, design: Verified, at: float, number: int, simulated: bool) -> None:
    """Draw a design with its number, and its bounds of 95 % if it was simulated."""
    shown = design.verified or design.chosen
    bars = None
    if design.bounds is not None and simulated:
        bars = [[max(shown.value - design.bounds[0], 0.0)], [max(design.bounds[1] - shown.value, 0.0)]]
    look = Look(ORANGE, "", "s" if design.met else "X")
    drawn = points(axes, ([at], [shown.value], bars), look, "designs" if number == 1 else "")
    drawn.lines[0].set(markersize=7.0, markeredgecolor="black", zorder=5.0)
    place = (at, shown.value)
    axes.annotate(str(number), place, BESIDE[number - 1], textcoords="offset points", fontweight="bold", zorder=6)


def _wish(axes: Axes, wish: Wish) -> None:
    """Draw the value wished, and the error allowed as a band."""
    if wish.target is None:
        return
    low, high = wish.target - wish.allowed(0.0), wish.target + wish.allowed(0.0)
    axes.axhspan(low, high, color="#56B4E9", alpha=0.35, linewidth=0, zorder=0, label="wished, within the error")
    axes.axhline(wish.target, color=BLUE, linewidth=0.8, zorder=1)
