"""Result of tracking a film: its walkers, and their scale."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core import Quantity
from walkergen.core.numerics import Array, Whole
from walkergen.guests.track.film import quality
from walkergen.guests.track.film.fields import TrackFields
from walkergen.guests.track.film.films import Box, Clock, Film, Grey
from walkergen.guests.track.film.lens import Lens


class Outline(NamedTuple):
    """Outline of a walker in one frame, and an arrow to its front, pixels of the whole frame, y downward."""

    rim: Array
    """Closed polygon around the walker, shape (k, 2)."""
    arrow: Array
    """Tail and tip of an arrow to its front, shape (2, 2); NaN where its heading is not known."""


class Walker(NamedTuple):
    """One tracked walker, in the frames that show it."""

    number: int
    """Number of its marker, or of the walker in order of appearance."""
    frames: Whole
    """Numbers of the frames, ascending, shape (n,)."""
    pixels: Array
    """Positions in the picture, shape (n, 2), pixels from the frame's upper left corner, y downward."""
    position: Array
    """Positions from the frame's lower left corner, shape (n, 2), mm, y up."""
    theta: Array
    """Headings, shape (n,), rad, from x (to the right) toward y (up); whole turns are counted; NaN
    where one is not known."""
    heading_by: str
    """Source of the headings, or the reason why there is none."""
    size_px: float
    """Median side of its marker in the picture, or median length of the walker, pixels."""
    outlines: tuple[Outline, Outline]
    """Outlines in the first and the last of these frames."""

    @property
    def lost(self) -> int:
        """Number of frames between the walker's first and last that do not show it."""
        return int(self.frames[-1] - self.frames[0] + 1 - len(self.frames))

    @property
    def net_mm(self) -> float:
        """Distance from the walker's first position to its last, mm; 0 after a full circle."""
        return math.dist(self.position[0], self.position[-1])

    @property
    def turned_deg(self) -> float | None:
        """Change of the walker's heading, deg, from the first known one to the last; None if none is known."""
        known = self.theta[~np.isnan(self.theta)]
        return math.degrees(float(known[-1] - known[0])) if len(known) else None


class Tracked(NamedTuple):
    """Walkers tracked in a film, with the film, the searched part, the times and the scale."""

    film: Film
    request: TrackFields
    lens: Lens | None
    """Lens whose distortion is corrected, as read from its file; None without one."""
    part: Box
    """Searched part of the frames."""
    picture: Grey
    """Searched part of the first frame."""
    clock: Clock
    looked: int
    """Number of searched frames."""
    walkers: Sequence[Walker]
    mm_per_px: Quantity
    """Scale, with markers the one in the middle of the picture. Its error applies to all lengths."""

    @property
    def jitter_mm(self) -> float:
        """Part of a position's error that changes from frame to frame, mm; NaN for too few frames."""
        return quality.jitter([self._full_track(walker) for walker in self.walkers])

    def path_mm(self, walker: Walker) -> float:
        """Return the length of a walker's path, mm, without the length that jitter would add."""
        return quality.path_length(walker.position, 0.0 if math.isnan(self.jitter_mm) else self.jitter_mm)

    def _full_track(self, walker: Walker) -> tuple[Array, Array]:
        """Return times (s, (n,)) and positions (mm, (n, 2)) of frames from a walker's first to last, NaN if lost."""
        first, last = walker.frames[[0, -1]]
        places = np.full((last - first + 1, 2), np.nan)
        places[walker.frames - first] = walker.position
        return self.clock.times[first : last + 1], places
