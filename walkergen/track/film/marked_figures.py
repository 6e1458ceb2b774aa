"""Picture to check tracks by markers by: what was read, where it went, when it was seen."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walkergen.track.film.figures import COLOURS, HALO, sheet, when
from walkergen.track.film.marked import Marked, Walker


def check_figure(found: Marked) -> Figure:
    """Draw the first frame with all tracks, markers and fronts, and when each marker was read."""
    figure, axes, lower = sheet(found.part, found.picture, len(found.walkers))
    for at, walker in enumerate(found.walkers):
        _draw(axes, walker, COLOURS[at % len(COLOURS)])
    first = found.wish.frames[0]
    axes.set_title(
        f"{found.film.path.name}, frame {first}: markers where first (solid) and last read "
        "(dashed), arrows to the front",
        fontsize=10,
    )
    numbers = [walker.number for walker in found.walkers]
    when(lower, [walker.frames for walker in found.walkers], first, found.looked, numbers)
    return figure


def _draw(axes: Axes, walker: Walker, colour: str) -> None:
    """Draw a walker's track, its marker where it was first and last read, its number and front."""
    middles = walker.corners.mean(axis=1)
    gaps = np.flatnonzero(np.diff(walker.frames) > 1) + 1
    x, y = (np.insert(values, gaps, np.nan) for values in middles.T)
    axes.plot(x, y, color=colour, lw=1.2, path_effects=HALO)
    for at, style in ((0, "-"), (-1, "--")):
        square, middle = walker.corners[at], middles[at]
        axes.plot(*square[[0, 1, 2, 3, 0]].T, style, color=colour, lw=1.3, path_effects=HALO)
        ahead = 0.5 * (square[0] + square[1]) - middle
        axes.annotate(
            "", middle + 2.6 * ahead, middle + 1.4 * ahead, arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.2}
        )
    axes.text(
        middles[0, 0],
        middles[0, 1],
        str(walker.number),
        color="black",
        fontsize=9,
        weight="bold",
        ha="center",
        va="center",
        path_effects=HALO,
    )
