"""Result of tracking a film: the settings, and its walkers."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core.numerics import Array, Whole
from walkergen.core.numerics.quantity import Quantity
from walkergen.guests.track.film import quality
from walkergen.guests.track.film.films import Box, Clock, Film, Grey
from walkergen.guests.track.film.lens import Lens


class Options(NamedTuple):
    """A user's settings; None, or no value, is read from the film."""

    mm_per_px: Quantity = Quantity("mm_per_px", "", None)
    length: Quantity = Quantity("length", "mm", None)
    """Length of a walker; either this or `mm_per_px` is given. The error of its image is separate."""
    fps: float | None = None
    """Frames per second at which the film was taken."""
    frames: tuple[int, int | None] = (0, None)
    """First frame, and the one after the last."""
    region: tuple[int, int, int, int] | None = None
    """Left and upper edge, width and height of the searched part, pixels."""
    walkers: str | None = None
    """One of `make.CONTRAST_SIDES`."""
    threshold: float | None = None
    """Contrast beyond which a pixel is a walker's, steps of 255."""
    width_px: float | None = None
    """Width of a walker, the shorter side."""
    heading: str = "motion"
    """One of `heading.HEADING_SOURCES`."""
    lens: Lens | None = None
    """Lens whose distortion is corrected; None without distortion."""
    markers: str | None = None
    """Markers on the walkers, one of `make.MARKER_KINDS`, for scale, walkers and headings; None without markers."""
    marker: Quantity = Quantity("marker", "mm", None)
    """Side of the markers, their black frame included; without a value as `plate --caps` prints them."""


class Outline(NamedTuple):
    """Walker in one frame as the picture shows it, pixels of the whole frame, y downward."""

    rim: Array
    """Closed, shape (k, 2)."""
    arrow: Array
    """Tail and tip of an arrow to its front, shape (2, 2); NaN where its heading is not known."""


class Walker(NamedTuple):
    """One tracked walker, in the frames that show it."""

    number: int
    """Number of its marker, or of the walker in order of appearance."""
    frames: Whole
    """Ascending, shape (n,)."""
    pixels: Array
    """Places in the picture, shape (n, 2), pixels from the frame's upper left corner, y downward."""
    position: Array
    """Places from the frame's lower left corner, shape (n, 2), mm, y up."""
    theta: Array
    """Headings, shape (n,), rad, from x (to the right) toward y (up); whole turns are counted; NaN
    where one is not known."""
    heading_by: str
    """Source of the headings, or the reason why there is none."""
    size_px: float
    """Median side of its marker in the picture, or length of the walker."""
    outlines: tuple[Outline, Outline]
    """As it was first and last seen."""

    @property
    def lost(self) -> int:
        """Number of frames between its first and its last that do not show it."""
        return int(self.frames[-1] - self.frames[0] + 1 - len(self.frames))

    @property
    def net_mm(self) -> float:
        """Distance from its first place to its last, mm; a full circle has none."""
        return math.dist(self.position[0], self.position[-1])

    @property
    def turned_deg(self) -> float | None:
        """Change of its heading from the first that is known to the last; None for fewer than one."""
        known = self.theta[~np.isnan(self.theta)]
        return math.degrees(float(known[-1] - known[0])) if len(known) else None


class Tracked(NamedTuple):
    """Findings in a film."""

    film: Film
    options: Options
    part: Box
    """Searched part."""
    picture: Grey
    """That part of the first frame."""
    clock: Clock
    looked: int
    """Number of searched frames."""
    walkers: Sequence[Walker]
    mm_per_px: Quantity
    """Scale; with markers that in the middle of the picture. Its error applies to all lengths."""

    @property
    def jitter_mm(self) -> float:
        """Error of a place that changes from frame to frame, mm; NaN for too few frames."""
        return quality.jitter([self._full_track(walker) for walker in self.walkers])

    def path_mm(self, walker: Walker) -> float:
        """Length of a walker's path, mm, without its jitter."""
        return quality.path_length(walker.position, 0.0 if math.isnan(self.jitter_mm) else self.jitter_mm)

    def _full_track(self, walker: Walker) -> tuple[Array, Array]:
        """Return times and positions of all frames from a walker's first to its last; NaN where lost."""
        first, last = walker.frames[[0, -1]]
        places = np.full((last - first + 1, 2), np.nan)
        places[walker.frames - first] = walker.position
        return self.clock.times[first : last + 1], places
