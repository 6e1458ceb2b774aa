"""Quality of tracks from any film: jitter of positions, length of paths, and films that break off."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from walkergen.core.numerics import Array
from walkergen.guests.track.film.films import Clock, Film

LEG_JITTERS = 10.0
"""Smallest length of the straight pieces of a path, over the jitter. Noise then lengthens a piece by about 1 %."""

MIN_READ_SHARE, READ_MARGIN_S = 0.95, 0.5
"""Share of a film's stated duration, less a margin (s) for its last frames, below which the film breaks off."""

MAX_LOST_SHARE = 0.05
"""Share of frames without a walker above which a warning is due."""


class Remarks(NamedTuple):
    """Remarks on a tracked film: facts, notes and warnings."""

    facts: dict[str, Any]
    """Facts for JSON and the manifest, with units in the names."""
    notes: list[str]
    """Notes on the search, and the scale with its error."""
    warnings: list[str]
    """Warnings, each with its size or its number of frames."""


def jitter(tracks: Sequence[tuple[Array, Array]]) -> float:
    """Return the part of a position's error (sd, along an axis) that changes from frame to frame; NaN if too short.

    `tracks`: times, shape (n,), and positions, shape (n, 2), of all frames, NaN where unknown. The error follows from
    each position's distance to the line between its neighbours. Uneven motion adds to it, slow errors do not.
    """
    squares = [np.zeros((0, 2))]
    for times, places in tracks:
        if len(times) < 3:
            continue
        share = ((times[1:-1] - times[:-2]) / (times[2:] - times[:-2]))[:, None]
        bend = places[1:-1] - (1.0 - share) * places[:-2] - share * places[2:]
        squares.append(bend**2 / (1.0 + (1.0 - share) ** 2 + share**2))
    joined = np.concatenate(squares)
    joined = joined[~np.isnan(joined)]
    return float(np.sqrt(np.mean(joined))) if len(joined) else math.nan


def path_length(places: Array, noise: float) -> float:
    """Return the length of a path through positions, shape (n, 2), with `noise` (sd) along each axis, in their unit.

    Each straight piece has at least LEG_JITTERS times the noise, since noise would lengthen a sum over all frames.
    """
    least, total, last = LEG_JITTERS * noise, 0.0, places[0]
    for place in places[1:]:
        leg = math.dist(place, last)
        if leg >= least:
            total, last = total + leg, place
    return total


def truncation_warnings(film: Film, clock: Clock, frames: tuple[int, int | None]) -> list[str]:
    """Return a warning if a film that was read to its end (`frames[1]` None) is shorter than stated; else []."""
    end, announced = clock.played_s, film.seconds
    if frames[1] is not None or end >= MIN_READ_SHARE * announced - READ_MARGIN_S:
        return []
    return [f"the film breaks off: {end:.3g} s of {announced:.3g} s could be read"]
