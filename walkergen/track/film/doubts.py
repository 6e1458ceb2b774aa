"""Estimates of what is wrong with tracks that look right: jitter, shadows, sizes that differ."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.track.film.blobs import Blobs
from walkergen.track.film.linking import Seen

Array = npt.NDArray[np.float64]

LEGS = 10.0
"""Length of the straight legs of a path over the jitter: noise lengthens each by its square."""

INDEPENDENT = 10
"""Number of neighbouring frames, about, that err alike."""

SURE = 4.0
"""Standard errors by which a shadow, or a change of size, must differ from 0."""


def jitter(tracks: Sequence[tuple[Array, Array]]) -> float:
    """Error of a place that changes from frame to frame, along an axis.

    `tracks` are times, shape (n,), and places in neighbouring frames, shape (n, 2), NaN in others.
    It follows from how far a place lies off the line between those before and after: uneven motion
    adds to it, and what stays, or changes slowly, is not in it. NaN for too few frames.
    """
    squares = []
    for times, places in tracks:
        if len(times) < 3:
            continue
        share = ((times[1:-1] - times[:-2]) / (times[2:] - times[:-2]))[:, None]
        bend = places[1:-1] - (1.0 - share) * places[:-2] - share * places[2:]
        squares.append(bend**2 / (1.0 + (1.0 - share) ** 2 + share**2))
    known_squares = np.concatenate(squares) if squares else np.zeros(0)
    known_squares = known_squares[~np.isnan(known_squares)]
    return float(np.sqrt(np.mean(known_squares))) if len(known_squares) else math.nan


def path(places: Array, noise: float) -> float:
    """Length of a path through places, shape (n, 2), each off by `noise` along an axis.

    In legs of ten times the noise, or of a frame where that is longer: a sum over all frames would
    grow with their number even for a walker that stands.
    """
    least, total, last = LEGS * noise, 0.0, places[0]
    for place in places[1:]:
        leg = math.dist(place, last)
        if leg >= least:
            total, last = total + leg, place
    return total


def shadow(walkers: Sequence[Seen]) -> float:
    """Way by which shadows pull at the centres of walkers, pixels; 0 where none is resolved.

    A shadow lies on one side in the picture; what turns with walkers is their own shades. Of those
    that never turn the two cannot be told apart.
    """
    blobs = _together(walkers)
    c, s = np.cos(blobs.axis), np.sin(blobs.axis)
    ones, none = np.ones_like(c), np.zeros_like(c)
    right = np.column_stack([ones, none, c, s])  # of shadow (2 columns) and shades (2 columns)
    down = np.column_stack([none, ones, -s, c])
    terms, pulls = np.concatenate([right, down]), np.concatenate([blobs.pull_x, blobs.pull_y])
    fit, _, rank, _ = np.linalg.lstsq(terms, pulls)
    if rank < terms.shape[1]:
        return 0.0
    variance = float(np.mean((pulls - terms @ fit) ** 2)) * INDEPENDENT
    error = math.sqrt(variance * float(np.trace(np.linalg.inv(terms.T @ terms)[:2, :2])))
    pull = math.hypot(fit[0], fit[1])
    return pull if pull > SURE * error else 0.0


class Sizes(NamedTuple):
    """How much larger walkers look in one place than in another, as a share, and its error."""

    change: float
    error: float
    scatter: float
    """Standard deviation of the rest, as a share: from frame to frame, and as walkers turn."""


def sizes(walkers: Sequence[Seen]) -> Sizes:
    """Change of a walker's own size over the places that walkers reach: perspective, or a lens.

    Its logarithm is fitted with a plane and a bowl, each walker with a size of its own.
    """
    blobs = _together(walkers)
    owner = np.repeat(np.arange(len(walkers)), [len(walker.frames) for walker in walkers])
    place = np.column_stack([blobs.x, blobs.y])
    place -= place.mean(axis=0)
    place /= np.abs(place).max() or 1.0
    terms = np.column_stack([place, (place**2).sum(axis=1)])
    size = 0.5 * np.log(blobs.area)
    slopes = np.array([_centred(term, owner) for term in terms.T])
    changes = _centred(size, owner)
    fit, _, rank, _ = np.linalg.lstsq(slopes.T, changes)
    if rank < 3:
        return Sizes(0.0, math.inf, float(changes.std()))
    rest = changes - fit @ slopes
    fitted = terms @ fit
    ends = terms[[fitted.argmax(), fitted.argmin()]]
    span = ends[0] - ends[1]
    spread = np.linalg.pinv(slopes @ slopes.T) * float(np.mean(rest**2)) * INDEPENDENT
    return Sizes(math.expm1(float(span @ fit)), math.sqrt(float(span @ spread @ span)), float(rest.std()))


def _centred(values: Array, owner: npt.NDArray[np.int64]) -> Array:
    """Values without the mean of their walker's."""
    means = np.bincount(owner, values) / np.bincount(owner)
    return np.asarray(values - means[owner])


def _together(walkers: Sequence[Seen]) -> Blobs:
    """Blobs of all walkers, one walker after the other."""
    return Blobs(*np.hstack([np.array(walker.blobs) for walker in walkers]))


def at_once(walkers: Sequence[Seen]) -> int:
    """Largest number of walkers that are seen in one frame."""
    return int(np.bincount(np.concatenate([walker.frames for walker in walkers])).max())
