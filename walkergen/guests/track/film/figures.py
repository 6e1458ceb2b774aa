"""Picture for checking a film's tracks: walkers in the first frame, their paths, and their times."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from walkergen.guests.track.film.result import Tracked, Walker

WIDTH_INCHES, MAX_FRAME_INCHES = 8.0, 9.0
"""Width of the figure, and largest height of the film's frame in it, inches."""

COLOURS = ("#D55E00", "#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""Colours of Okabe and Ito. Numbers, not colours, distinguish walkers."""

HALO = (withStroke(linewidth=2.5, foreground="white"),)
"""White rim around lines and letters, which makes them visible on any film."""

MAX_ROWS = 40
"""Largest number of walkers that have a row of their own in the lower panel."""


def draw_check(tracked: Tracked) -> Figure:
    """Draw the first frame with its walkers, all tracks, and the frames that show each walker."""
    left, top, right, bottom = tracked.part
    tall = min(WIDTH_INCHES * (bottom - top) / (right - left), MAX_FRAME_INCHES)
    low = 0.9 + 0.16 * min(len(tracked.walkers), MAX_ROWS)
    figure = Figure(figsize=(WIDTH_INCHES, tall + low + 0.5), layout="constrained")
    axes, lower = figure.subplots(2, 1, height_ratios=(tall, low))
    axes.imshow(tracked.picture, cmap="gray", vmin=0, vmax=255, extent=(left, right, bottom, top), alpha=0.75)
    axes.set_xlim(left, right)  # fixes the limits for all that is drawn later
    axes.set_ylim(bottom, top)
    axes.set_xlabel("x (pixels)")
    axes.set_ylabel("y (pixels)")
    first = tracked.request.frames[0]
    for row, walker in enumerate(tracked.walkers):
        _draw_walker(axes, walker, first, COLOURS[row % len(COLOURS)])
    axes.set_title(
        f"{tracked.film.path.name}, frame {first}: walkers in it (solid), first seen later "
        "(dotted), last seen (dashed)",
        fontsize=10,
    )
    _draw_timeline(lower, tracked.walkers, first, tracked.looked)
    return figure


def _draw_walker(axes: Axes, walker: Walker, first: int, colour: str) -> None:
    """Draw a walker's track and number, and its outlines where first seen (solid if in frame `first`) and last seen."""
    gaps = np.flatnonzero(np.diff(walker.frames) > 1) + 1
    x, y = (np.insert(values, gaps, np.nan) for values in walker.pixels.T)
    axes.plot(x, y, color=colour, lw=1.2, path_effects=HALO)
    styles = "-" if walker.frames[0] == first else ":", "--"
    for (rim, arrow), style in zip(walker.outlines, styles, strict=True):
        axes.plot(*rim.T, style, color=colour, lw=1.3, path_effects=HALO)
        if not np.isnan(arrow).any():
            tail, tip = arrow
            axes.annotate("", tip, tail, arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.2})
    at_x, at_y = walker.pixels[0]
    number = str(walker.number)
    axes.text(at_x, at_y, number, fontsize=9, weight="bold", ha="center", va="center", path_effects=HALO)


def _draw_timeline(axes: Axes, walkers: Sequence[Walker], first: int, looked: int) -> None:
    """Draw the frames that show each walker, a row each, among the `looked` frames from number `first` on."""
    shown = walkers[:MAX_ROWS]
    for row, walker in enumerate(shown):
        cuts = np.flatnonzero(np.diff(walker.frames) > 1) + 1
        parts = [(int(run[0]), int(run[-1] - run[0] + 1)) for run in np.split(walker.frames, cuts)]
        axes.broken_barh(parts, (row - 0.35, 0.7), color=COLOURS[row % len(COLOURS)])
    axes.set_ylim(len(shown) - 0.4, -0.6)
    axes.set_yticks(range(len(shown)), [str(walker.number) for walker in shown], fontsize=8)
    axes.set_xlim(first, first + looked)
    axes.set_xlabel("frame")
    axes.set_ylabel("walker")
    more = f" (first {len(shown)} of {len(walkers)})" if len(shown) < len(walkers) else ""
    axes.set_title(f"frames that show each walker{more}; it is lost in gaps", fontsize=9)
    axes.spines[["top", "right"]].set_visible(False)
