"""Tracks: objects found in frames, linked from frame to frame by trackpy."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.numerics import Array, Whole
from walkergen.guests.track.film.blobs import Blob, Blobs

MIN_AREA_RATIO, MAX_AREA_RATIO = 0.5, 1.6
"""Range of areas of a single walker, over the typical area; larger objects are several walkers."""

MAX_STEP_LENGTHS = 0.5
"""Largest distance moved from frame to frame, over a walker's length."""

MEMORY_S = 0.2
"""Longest time after which a lost walker is still recognised, s."""

MIN_TRACK_FRAMES, MIN_TRACK_SHARE = 5, 0.05
"""Smallest number of frames of a track, and smallest share of the film's frames."""


class Track(NamedTuple):
    """One walker in the frames that show it."""

    frames: Whole
    """Numbers of the frames, ascending, shape (n,)."""
    blobs: Blobs
    """The walker's blob in each of these frames."""


class Linked(NamedTuple):
    """All walkers of a film, and the frames left out."""

    walkers: Sequence[Track]
    """Walkers in order of appearance, from above where they appear together."""
    area: float
    """Area of a walker, pixels."""
    length: float
    """Length of a walker, pixels."""
    empty: int
    """Number of frames without an object."""
    merged: int
    """Number of frames with an object as large as several walkers. Such objects are left out."""
    short: int
    """Number of tracks that were left out because they are too short."""


def link(frames: Sequence[Sequence[Blob]], first: int, fps: float) -> Linked:
    """Return the walkers' tracks that link blobs in frames number `first`, `first` + 1 ... `fps`: frames per second.

    Raises InputError if no object is seen for long enough, or if objects are too close to distinguish.
    """
    blobs = [blob for frame in frames for blob in frame]
    if not blobs:
        raise InputError(f"no walker found in {len(frames)} frames. Try ‹threshold›, ‹width› or ‹region›")
    areas = np.array([blob.area for blob in blobs])
    area = typical_area(areas)
    lengths = np.array([blob.length for blob in blobs])
    length = float(np.median(lengths[np.abs(areas - area) < 0.3 * area]))
    fitting = [[blob for blob in frame if MIN_AREA_RATIO <= blob.area / area <= MAX_AREA_RATIO] for frame in frames]
    names = _link_numbers(fitting, MAX_STEP_LENGTHS * length, max(1, round(MEMORY_S * fps)))
    numbers = np.array([number for number, frame in enumerate(fitting, first) for _ in frame])
    columns = np.array([blob for frame in fitting for blob in frame]).T
    owner = np.array([name for frame in names for name in frame])
    least = max(MIN_TRACK_FRAMES, MIN_TRACK_SHARE * len(frames))
    groups = [Track(numbers[owner == name], Blobs(*columns[:, owner == name])) for name in np.unique(owner)]
    good = sorted(
        (walker for walker in groups if len(walker.frames) >= least),
        key=lambda walker: (walker.frames[0], walker.blobs.y[0]),
    )
    if not good:
        raise InputError(
            f"no walker found for {least:.3g} of {len(frames)} frames in a row: objects jump by more than "
            f"{MAX_STEP_LENGTHS * length:.3g} pixels a frame, or vanish. Film faster, or try ‹threshold›, ‹width› or "
            "‹region›"
        )
    return Linked(
        good,
        area,
        length,
        empty=sum(not frame for frame in frames),
        merged=sum(any(blob.area > MAX_AREA_RATIO * area for blob in frame) for frame in frames),
        short=len(groups) - len(good),
    )


def typical_area(areas: Array) -> float:
    """Return the area of a typical walker: objects of at least this area have half of the total area.

    Many small objects, or a few walkers that touch, hardly change it.
    """
    ordered = np.sort(areas)
    return float(ordered[np.searchsorted(np.cumsum(ordered), 0.5 * ordered.sum())])


def _link_numbers(frames: Sequence[Sequence[Blob]], radius: float, memory: int) -> list[list[int]]:
    """Return the number of the walker of each blob, a list for each frame. Raises InputError if there are too many.

    `radius`: largest step between frames, pixels. `memory`: frames for which a lost walker is remembered.
    """
    import trackpy

    trackpy.quiet()
    places = ((t, np.array([(blob.y, blob.x) for blob in frame]).reshape(-1, 2)) for t, frame in enumerate(frames))
    try:
        # Strategies compiled by numba would take longer to compile than any film takes to link.
        linked = trackpy.link_iter(places, radius, memory=memory, link_strategy="nonrecursive")
        return [list(names) for _, names in linked]
    except trackpy.SubnetOversizeException:
        raise InputError(
            f"walkers cannot be distinguished: too many lie within {radius:.3g} pixels, half a walker's length, of one "
            "another. Film faster, or fewer walkers"
        ) from None
