"""Film of a crowd, simulated or filmed: position and heading of every walker at every time, seen from above."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.analysis.tracks import Tracks
from walkergen.core import Array, Dish, Mask, Whole
from walkergen.readers.drawings import outlines as polygons

Outlines = Mapping[str, Sequence[Array]]
"""Outer contours by the name of a kind, seen from above, shape (corners, 2) each, mm. The heading is along +x, and the
tracked point is at the origin."""

NO_OUTLINES: Outlines = MappingProxyType({})


class CrowdFilm(NamedTuple):
    """One run of N walkers in F frames at a fixed rate, the transient already left out."""

    times: Array
    """Times of the frames, shape (F,), s."""
    x: Array
    """`x` and `y`: positions from the middle of the dish, shape (F, N), mm, not wrapped in a periodic square; NaN where
    a walker was not seen."""
    y: Array
    theta: Array
    """Headings, from x toward y, shape (F, N), rad, not wrapped; NaN where unknown."""
    areas: Array
    """Areas of the outlines, shape (N,), mm^2; NaN where no outline is known."""
    radii: Array
    """Distances of the outermost corners from the tracked points, shape (N,), mm; NaN where no outline is known."""
    kinds: tuple[str, ...]
    """Names of the walkers' designs, length N."""
    dish: Dish
    outlines: Outlines = NO_OUTLINES
    """Contours of each kind in `kinds`; empty if only tracks are known."""

    @property
    def interval(self) -> float:
        """Time between frames, s."""
        return float((self.times[-1] - self.times[0]) / (len(self.times) - 1))

    @property
    def mean_walkers(self) -> float:
        """Mean number of walkers seen in a frame. It is below N if tracks end or begin within the film."""
        return float(np.isfinite(self.x).sum(axis=1).mean())

    @property
    def has_sizes(self) -> bool:
        """Whether the sizes of all walkers are known."""
        return not bool(np.isnan(self.radii).any())

    @property
    def has_headings(self) -> bool:
        """Whether any heading is known."""
        return not bool(np.isnan(self.theta).all())

    def select_frames(self, frames: Whole) -> "CrowdFilm":
        """Return a film of the frames with these indices only."""
        kept = {key: getattr(self, key)[frames] for key in ("times", "x", "y", "theta")}
        return self._replace(**kept)


def from_positions(times: Array, places: Array, kinds: Sequence[str], outlines: Outlines, dish: Dish) -> CrowdFilm:
    """Make a film of `places` of shape (F, N, 3 or more): x, y (mm) and heading (rad) come first.

    `times`: s, shape (F,). `kinds`: design of each walker. `outlines`: contours of each design, or empty.
    """
    x, y, theta = (np.ascontiguousarray(places[..., axis]) for axis in range(3))
    size = {kind: _area_and_radius(contours) for kind, contours in outlines.items()}
    sizes = np.array([size.get(kind, (np.nan, np.nan)) for kind in kinds]).reshape(-1, 2)
    return CrowdFilm(times, x, y, theta, sizes[:, 0], sizes[:, 1], tuple(kinds), dish, outlines)


def from_tracks(tracks: Tracks, dish: Dish, contours: Sequence[Array] = ()) -> CrowdFilm:
    """Make a film of tracks on a plane. `contours` (mm) are the outline of every walker, if it is known.

    Headings are made continuous. Where a track has a gap, a full turn may be missed.
    """
    frames = max(track.start + len(track.position) for track in tracks.tracks)
    places = np.full((frames, len(tracks.tracks), 3), np.nan)
    for number, track in enumerate(tracks.tracks):
        span = slice(track.start, track.start + len(track.position))
        places[span, number, :2] = track.position
        if track.heading is not None:
            places[span, number, 2] = _unwrap_heading(track.heading)
    outlines = {"walker": contours} if contours else NO_OUTLINES
    times = tracks.interval * np.arange(frames, dtype=float)
    return from_positions(times, places, ["walker"] * len(tracks.tracks), outlines, dish)


def _area_and_radius(contours: Sequence[Array]) -> tuple[float, float]:
    """Return the area (mm^2) of contours and the distance (mm) of their outermost point from the origin."""
    area = sum(abs(float(polygons.area(contour))) for contour in contours)
    return area, max(float(np.hypot(*contour.T).max()) for contour in contours)


def _unwrap_heading(heading: Array) -> Array:
    """Make a heading (rad) continuous. Gaps stay NaN."""
    seen = np.isfinite(heading)
    heading = heading.copy()
    heading[seen] = np.unwrap(heading[seen])
    return heading


def mean_over_walkers(values: npt.NDArray[Any], chosen: Mask | None = None) -> npt.NDArray[Any]:
    """Average values (F, N) over walkers in each frame, shape (F,); NaN where none counts.

    Values that are NaN do not count, nor those of walkers outside the mask `chosen` (F, N).
    """
    known = ~np.isnan(values)
    if chosen is not None:
        known &= chosen
    count = known.sum(axis=1)
    return np.where(count > 0, np.where(known, values, 0).sum(axis=1) / np.maximum(count, 1), np.nan)
