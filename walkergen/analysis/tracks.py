"""Tracks of walkers: places and headings at regular times, filmed or simulated."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from walkergen.core.numerics import Array, Mask, Whole


class Track(NamedTuple):
    """Positions of one walker at regular times; NaN if it was not seen."""

    particle: int
    position: Array
    """Shape (times, dimensions), mm: x in a lane; x and y on a plane, with y to the left of x."""
    heading: Array | None
    """Heading, shape (times,), rad, from x toward y; None when the file has none."""
    plate_speed: float | None = None
    """Peak speed of the plate, mm/s; None if the file does not state it."""
    start: int = 0
    """Sample, of all tracks together, at which this one begins."""
    reach: Whole | None = None
    """Samples after each one within which no wall can be reached, shape (times,); None without walls."""

    def free_samples(self, span: int) -> Mask | None:
        """Return whether no wall is in reach during the next `span` samples, shape (times,); None without walls."""
        return None if self.reach is None else self.reach >= span

    def spread(self, samples: Whole) -> "Track":
        """Return the track with its places at these samples, from 0 on, and none between them."""
        position = np.full((int(samples[-1]) + 1, self.position.shape[1]), np.nan)
        heading = None if self.heading is None else np.full(len(position), np.nan)
        position[samples] = self.position
        if heading is not None:
            heading[samples] = self.heading
        return self._replace(position=position, heading=heading)


class Tracks(NamedTuple):
    """All tracks of a file."""

    tracks: tuple[Track, ...]
    interval: float
    """Time between neighbouring samples of a track, s."""
    bad_rows: int
    note: str
    """Changes to the rows, such as those left out for a reason; '' without any."""
    scale_se: float | None = 0.0
    """Standard error of the scale, as a share of it. It changes all lengths together. None if
    unknown; the largest one of a file with several."""
    first_s: float = 0.0
    """Time of the first sample on the file's clock, s."""
    names: Mapping[int, str] = MappingProxyType({})
    """Names of the walkers by their numbers, if each comes from a file of its own."""

    @property
    def lane(self) -> bool:
        """True when positions lie along a lane, not on a plane."""
        return bool(self.tracks[0].position.shape[1] == 1)


def from_positions(places: Sequence[Array], interval: float, lane: bool) -> Tracks:
    """Build tracks of simulated walkers, numbered from 0, `interval` s between samples.

    Each of `places` has rows of x, y (mm, to the left of x) and heading (rad). In a `lane` only x counts.
    """
    tracks = (
        Track(number, rows[:, :1] if lane else rows[:, :2], None if lane else rows[:, 2])
        for number, rows in enumerate(places)
    )
    return Tracks(tuple(tracks), interval, 0, "")
