"""Figure of filmed or simulated tracks: seen from above, or displacement against time."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from walkergen.analysis.tracks import Track, Tracks
from walkergen.files.figures import SERIES, new_axes, style

ARROW_COUNT = 8
"""Arrows along the longest track that show the heading."""

ARROW_LENGTH = 0.05
"""Length of an arrow over the width of the tracks."""

MAX_TRACKS = 24
"""Largest number of tracks drawn: more would hide one another."""

MAX_STRAIGHT_RATIO = 0.05
"""Width of all tracks over their length below which walkers do not turn, as in a lane: from above
their tracks are one line."""

MAX_POINTS = 4000
"""Largest number of points drawn of a track: more only make the PDF large."""


@style()
def draw_tracks(tracks: Tracks, title: str) -> Figure:
    """Draw tracks seen from above (fig. 6b), or displacement against time in a lane (fig. 5).

    Tracks along x that do not turn are drawn as those of a lane.
    """
    drawn = tracks.tracks[:MAX_TRACKS]
    if len(drawn) < len(tracks.tracks):
        title += f" (first {MAX_TRACKS} of {len(tracks.tracks)})"
    figure, axes = new_axes(title)
    everywhere = np.concatenate([track.position for track in drawn])
    extent = np.nanmax(everywhere, axis=0) - np.nanmin(everywhere, axis=0)
    size = float(np.max(extent))
    along = tracks.lane or extent[1] < MAX_STRAIGHT_RATIO * extent[0]
    for number, track in enumerate(drawn):
        colour, line, marker = SERIES[number % len(SERIES)]
        stride = len(track.position) // MAX_POINTS + 1
        places = track.position[~np.isnan(track.position).any(axis=1)]
        start = places[0]
        path = track.position[::stride]
        if along:
            time = np.arange(len(track.position))[::stride] * tracks.interval
            axes.plot(time, path[:, 0] - start[0], color=colour, ls=line, lw=0.8)
        else:
            axes.plot(*path.T, color=colour, ls=line, lw=0.8)
            axes.plot(*start, marker, color=colour, markersize=4)
            if track.heading is not None:
                _draw_headings(axes, track, size, colour)
    if along:
        axes.set_xlabel("time (s)")
        axes.set_ylabel(f"displacement along {'the lane' if tracks.lane else 'x'} (mm)")
    else:
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_xlabel("x (mm)" + ("; arrows: headings" if drawn[0].heading is not None else ""))
        axes.set_ylabel("y (mm)")
    return figure


def _draw_headings(axes: Axes, track: Track, size: float, colour: str) -> None:
    """Draw ARROW_COUNT arrows for the walker's heading along a track. `size`: largest extent of all tracks, mm."""
    assert track.heading is not None
    complete = np.isfinite(track.position).all(axis=1) & np.isfinite(track.heading)
    indices = np.flatnonzero(complete)
    count = min(ARROW_COUNT, len(indices))
    chosen = indices[np.linspace(0, len(indices) - 1, count).astype(int)] if len(indices) else indices
    heading = track.heading[chosen]
    axes.quiver(
        *track.position[chosen].T,
        np.cos(heading),
        np.sin(heading),
        color=colour,
        angles="xy",
        scale_units="xy",
        scale=1.0 / max(ARROW_LENGTH * size, 1e-9),
        width=0.006,
        headwidth=4.5,
        zorder=3,
    )
