"""Doubts about tracks of any film: jitter of places, films that break off, walkers that are lost."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from walkergen.core.numerics import Array
from walkergen.guests.track.film.films import Clock, Film

LEG_JITTERS = 10.0
"""Length of the straight legs of a path over the jitter: noise lengthens each by its square."""

MIN_READ_SHARE, READ_MARGIN_S = 0.95, 0.5
"""Share of its duration, less this time (s) for its last frames, below which a film breaks off."""

MAX_LOST_SHARE = 0.05
"""Share of frames without a walker above which a warning is due."""


class Remarks(NamedTuple):
    """Remarks on a tracked film: facts, notes and warnings."""

    facts: dict[str, Any]
    """For JSON and the manifest, with units in the names."""
    notes: list[str]
    """Notes on the search, and the scale with its error."""
    warnings: list[str]
    """Warnings, each with its size or its number of frames."""


def jitter(tracks: Sequence[tuple[Array, Array]]) -> float:
    """Compute the part of a position's error that changes from frame to frame, along an axis.

    `tracks`: times, shape (n,), and places, shape (n, 2), of all frames, NaN where unknown. The error follows from each
    place's distance to the line between its neighbours: uneven motion adds to it, slow errors do not. NaN if too short.
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
    """Measure the length of a path through positions, shape (n, 2), with a `noise` along each axis.

    Each leg is at least ten times the noise, since noise alone would lengthen a sum over all frames.
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
