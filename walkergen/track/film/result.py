"""What was found in a film: its walkers, and what their places rest on."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.track.film import doubts
from walkergen.track.film.appearance import Appearance
from walkergen.track.film.camera import Shake
from walkergen.track.film.films import Clock, Film, Grey
from walkergen.track.film.heading import Headed
from walkergen.track.film.lens import Lens
from walkergen.track.film.linking import Linked, Seen

Array = npt.NDArray[np.float64]


class Options(NamedTuple):
    """Wishes of a person; None is what the film tells."""

    mm_per_px: float | None = None
    mm_per_px_se: float | None = None
    """Standard error of `mm_per_px`; None when it is not known."""
    length_mm: float | None = None
    """Length of a walker; either this or `mm_per_px` is given."""
    length_se_mm: float | None = None
    """Standard error of `length_mm`, beside that of its image."""
    fps: float | None = None
    """Frames per second at which the film was taken."""
    frames: tuple[int, int | None] = (0, None)
    """First frame, and the one after the last."""
    region: tuple[int, int, int, int] | None = None
    """Left and upper edge, width and height of the part that is looked at, pixels."""
    walkers: str | None = None
    """One of `SIDES`."""
    threshold: float | None = None
    """Contrast beyond which a pixel is a walker's, steps of 255."""
    width_px: float | None = None
    """Width of a walker, the shorter side."""
    heading: str = "motion"
    """One of `heading.BY`."""
    lens: Lens | None = None
    """Lens that bends, which is undone; None for one that does not."""


class Walker(NamedTuple):
    """One tracked walker."""

    seen: Seen
    straight: Seen
    """The same by a lens that does not bend."""
    position: Array
    """Places from the frame's lower left corner, shape (n, 2), mm, y up."""
    headed: Headed

    @property
    def net_mm(self) -> float:
        """Distance from its first place to its last, mm; a full circle has none."""
        return math.dist(self.position[0], self.position[-1])


class Tracked(NamedTuple):
    """What was found in a film."""

    film: Film
    options: Options
    look: Appearance
    linked: Linked
    walkers: Sequence[Walker]
    looked: int
    """Frames looked at."""
    still: int
    """Frames in which nothing has moved since the one before."""
    clock: Clock
    mm_per_px: float
    mm_per_px_se: float | None
    """Standard error of `mm_per_px`; None where it was given without."""
    shake: Shake
    picture: Grey
    """Part of the first frame that was looked at."""
    part: tuple[int, int, int, int]
    """Left, top, right and bottom of it in the frame, pixels."""

    @property
    def jitter_mm(self) -> float:
        """Error of a place that changes from frame to frame, mm; NaN for too few frames."""
        return doubts.jitter([self._unbroken(walker) for walker in self.walkers])

    def path_mm(self, walker: Walker) -> float:
        """Length of a walker's path, mm, its jitter left out."""
        return doubts.path(walker.position, 0.0 if math.isnan(self.jitter_mm) else self.jitter_mm)

    def _unbroken(self, walker: Walker) -> tuple[Array, Array]:
        """Times and places of all frames from a walker's first to its last; NaN where lost."""
        first, last = walker.seen.frames[[0, -1]]
        places = np.full((last - first + 1, 2), np.nan)
        places[walker.seen.frames - first] = walker.position
        return self.clock.times[first : last + 1], places
