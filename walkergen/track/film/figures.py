"""Picture to check a film's tracks by: what was found, where it went, when it was seen."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from walkergen.track.film.films import Grey
from walkergen.track.film.heading import LONG, Array
from walkergen.track.film.result import Tracked, Walker

WIDE, TALLEST = 8.0, 9.0
"""Width of the figure, and largest height of the film's frame in it, inches."""

COLOURS = ("#D55E00", "#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""Colours of Okabe and Ito; numbers, not colours, tell walkers apart."""

HALO = (withStroke(linewidth=2.5, foreground="white"),)
"""Rim around lines and letters, so that they are seen on any film."""

MOST_ROWS = 40
"""Largest number of walkers that have a row of their own in the lower panel."""


def check_figure(tracked: Tracked) -> Figure:
    """Draw the first frame with what was found in it, all tracks, and when each was seen."""
    figure, axes, lower = sheet(tracked.part, tracked.picture, len(tracked.walkers))
    for number, walker in enumerate(tracked.walkers):
        _draw(axes, tracked, walker, number)
    first = tracked.options.frames[0]
    axes.set_title(
        f"{tracked.film.path.name}, frame {first}: walkers there (solid), first seen later "
        "(dotted), last seen (dashed)",
        fontsize=10,
    )
    when(lower, [walker.seen.frames for walker in tracked.walkers], first, tracked.looked)
    return figure


def sheet(part: tuple[int, int, int, int], picture: Grey, count: int) -> tuple[Figure, Axes, Axes]:
    """Figure with a part (left, top, right, bottom; pixels) of a film's first frame and, below it,
    room for when each of so many walkers was seen.
    """
    left, top, right, bottom = part
    tall = min(WIDE * (bottom - top) / (right - left), TALLEST)
    low = 0.9 + 0.16 * min(count, MOST_ROWS)
    figure = Figure(figsize=(WIDE, tall + low + 0.5), layout="constrained")
    axes, lower = figure.subplots(2, 1, height_ratios=(tall, low))
    extent = (left, right, bottom, top)
    axes.imshow(picture, cmap="gray", vmin=0, vmax=255, extent=extent, alpha=0.75)
    axes.set_xlim(left, right)  # what is drawn later changes no limits
    axes.set_ylim(bottom, top)
    axes.set_xlabel("x (pixels)")
    axes.set_ylabel("y (pixels)")
    return figure, axes, lower


def _draw(axes: Axes, tracked: Tracked, walker: Walker, number: int) -> None:
    """Draw a walker's box where it was first and last seen, its track, number and heading."""
    colour = COLOURS[number % len(COLOURS)]
    blobs = walker.seen.blobs
    x, y = blobs.x + tracked.part[0] + 0.5, blobs.y + tracked.part[1] + 0.5
    gaps = np.flatnonzero(np.diff(walker.seen.frames) > 1) + 1
    axes.plot(np.insert(x, gaps, np.nan), np.insert(y, gaps, np.nan), color=colour, lw=1.2, path_effects=HALO)
    first = walker.seen.frames[0] == tracked.options.frames[0]
    is_round = bool(np.median(blobs.length / blobs.width) < LONG)
    for at, style in ((0, "-" if first else ":"), (-1, "--")):
        rim = np.add(_rim(blobs.axis[at], blobs.length[at], blobs.width[at], is_round), (x[at], y[at]))
        axes.plot(*rim.T, style, color=colour, lw=1.3, path_effects=HALO)
        theta, length = walker.headed.theta[at], blobs.length[at]
        if not np.isnan(theta):
            ahead = length * np.array([np.cos(theta), -np.sin(theta)])
            tip, tail = ((x[at], y[at]) + share * ahead for share in (0.85, 0.5))
            axes.annotate("", tip, tail, arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.2})
    axes.text(
        x[0], y[0], str(number), color="black", fontsize=9, weight="bold", ha="center", va="center", path_effects=HALO
    )


def _rim(axis: float, length: float, width: float, is_round: bool) -> Array:
    """Rim of a walker around its centre, a box or an ellipse, shape (n, 2), pixels, y downward."""
    turn = np.linspace(0.0, 2.0 * np.pi, 60)
    unit = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1), (1, 1)])
    if is_round:
        unit = np.column_stack([np.cos(turn), np.sin(turn)])
    c, s = np.cos(axis), np.sin(axis)
    return np.asarray((0.5 * unit * (length, width)) @ np.array([[c, -s], [s, c]]))


def when(
    axes: Axes, frames: Sequence[npt.NDArray[np.int64]], first: int, looked: int, numbers: Sequence[int] | None = None
) -> None:
    """Draw the frames in which each walker was seen, a row each, of `looked` from `first` on.

    Walkers are numbered from 0 unless they bear `numbers`.
    """
    called, shown = numbers or range(len(frames)), min(len(frames), MOST_ROWS)
    for row, seen in enumerate(frames[:shown]):
        cuts = np.flatnonzero(np.diff(seen) > 1) + 1
        parts = [(int(run[0]), int(run[-1] - run[0] + 1)) for run in np.split(seen, cuts)]
        axes.broken_barh(parts, (row - 0.35, 0.7), color=COLOURS[row % len(COLOURS)])
    axes.set_ylim(shown - 0.4, -0.6)
    axes.set_yticks(range(shown), [str(number) for number in called[:shown]], fontsize=8)
    axes.set_xlim(first, first + looked)
    axes.set_xlabel("frame")
    axes.set_ylabel("walker")
    more = f" (first {shown} of {len(frames)})" if shown < len(frames) else ""
    axes.set_title(f"frames in which each was seen{more}; gaps are lost", fontsize=9)
    axes.spines[["top", "right"]].set_visible(False)
