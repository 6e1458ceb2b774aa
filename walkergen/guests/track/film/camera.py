"""Shake of the camera, measured from objects at rest: edges of the plate, screws, letters, a table.

Points where the brightness is steep are followed from frame to frame (Lucas and Kanade 1981). A shift of the picture
and a flicker of the lamp are fitted to the change of brightness. If the ground shows nothing, the shake is unknown.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from walkergen.core.numerics import Array, Mask
from walkergen.guests.track.film.blobs import Blob
from walkergen.guests.track.film.films import Grey

BLUR_PX = 2.0
"""Standard deviation of the blur, pixels. Shifts up to about twice this distance are found."""

SLOPE_FACTOR, MIN_SLOPE = 5.0, 0.5
"""Smallest slope of the brightness at a point, over the noise of slopes, and in steps of 255 per pixel."""

MAX_POINTS, MIN_POINTS = 4000, 30
"""Largest and smallest number of points that are followed."""

WALKER_MARGIN = 0.75
"""Distance from a walker, over its length, within which no point counts as fixed."""

SHIFT_ROUNDS = 5
"""Number of iterations that refine a shift."""

MAX_SHIFT_ERROR_PX = 0.1
"""Largest standard error of a shift, pixels; with a larger one the shift is unknown."""


class FixedPoints(NamedTuple):
    """Points at rest in the reference picture, the median of the first frames."""

    places: Array
    """Positions: columns and rows, shape (2, n), pixels."""
    values: Array
    """Brightness, shape (n,)."""
    slopes: Array
    """Change of the brightness per pixel, to the right and down, shape (2, n)."""


class Shake(NamedTuple):
    """Apparent movement of objects at rest, pixels; NaN if unknown."""

    rms: float
    """Root mean square of the shifts along an axis."""
    largest: float
    """Largest distance of a shift from the mean shift."""


def find_fixed_points(samples: Sequence[Grey], walkers: Sequence[Blob]) -> FixedPoints | None:
    """Return the steepest points of the first frames, `samples`, away from `walkers`; None if there are too few."""
    blurred = ndimage.gaussian_filter(np.median(np.stack(samples), axis=0), BLUR_PX, output=float)
    first, last = (ndimage.gaussian_filter(samples[at], BLUR_PX, output=float) for at in (0, -1))
    noise = 1.4826 / math.sqrt(2.0) * float(np.median(np.abs(last - first)))
    slopes = np.stack(np.gradient(blurred)[::-1])
    steep = np.hypot(*slopes)
    steep[: int(2 * BLUR_PX)] = steep[-int(2 * BLUR_PX) :] = 0.0
    steep[:, : int(2 * BLUR_PX)] = steep[:, -int(2 * BLUR_PX) :] = 0.0
    # A blurred slope has the noise of a blurred pixel over the blur's width
    rows, columns = np.nonzero(steep > max(SLOPE_FACTOR * noise / BLUR_PX, MIN_SLOPE))
    is_clear = _is_clear(np.stack([columns, rows]), walkers)
    rows, columns = rows[is_clear], columns[is_clear]
    chosen = np.argsort(-steep[rows, columns], kind="stable")[:MAX_POINTS]
    rows, columns = rows[chosen], columns[chosen]
    if len(rows) < MIN_POINTS:
        return None
    places = np.stack([columns, rows]).astype(float)
    return FixedPoints(places, blurred[rows, columns], slopes[:, rows, columns])


def find_shift(points: FixedPoints, frame: Grey, walkers: Sequence[Blob]) -> Array:
    """Return the displacement (x to the right, y down, pixels) of still objects in a frame since the first frames.

    It is NaN if too few points are clear of walkers, or do not determine it.
    """
    is_clear = _is_clear(points.places, walkers)
    places, values, slopes = points.places[:, is_clear], points.values[is_clear], points.slopes[:, is_clear]
    unknown = np.full(2, np.nan)
    if len(values) < MIN_POINTS:
        return unknown
    blurred = ndimage.gaussian_filter(frame, BLUR_PX, output=float)
    terms = np.stack([*slopes, np.ones_like(values), values], axis=1)
    moved_by, steady = np.zeros(2), np.ones(len(values), dtype=bool)
    for _ in range(SHIFT_ROUNDS):
        moved = (places + moved_by[:, None])[::-1]
        change = ndimage.map_coordinates(blurred, moved, order=1, mode="nearest") - values
        fit, _, rank, _ = np.linalg.lstsq(terms[steady], change[steady])
        if rank < 4:
            return unknown
        residuals = change - terms @ fit
        scatter = 1.4826 * float(np.median(np.abs(residuals[steady])))
        steady = np.abs(residuals) <= 3.0 * scatter + 1e-9  # leaves out points that move or shine
        moved_by = moved_by - fit[:2]
    spread = scatter**2 * np.linalg.pinv(terms[steady].T @ terms[steady])
    return moved_by if np.sqrt(np.diag(spread)[:2]).max() < MAX_SHIFT_ERROR_PX else unknown


def measure_shake(shifts: Sequence[Array]) -> Shake:
    """Return the shake: size of the shifts of frames (pixels, shape (2,) each, NaN if unknown) about their mean."""
    known_shifts = np.array(shifts).reshape(-1, 2)
    known_shifts = known_shifts[~np.isnan(known_shifts).any(axis=1)]
    if len(known_shifts) < 2:
        return Shake(math.nan, math.nan)
    off = known_shifts - known_shifts.mean(axis=0)
    return Shake(float(np.sqrt(np.mean(off**2))), float(np.hypot(*off.T).max()))


def _is_clear(places: npt.NDArray[np.generic], walkers: Sequence[Blob]) -> Mask:
    """Return a mask, shape (n,), of the positions (columns and rows, shape (2, n)) that lie away from all walkers."""
    clear = np.ones(places.shape[1], dtype=bool)
    for walker in walkers:
        near = np.hypot(places[0] - walker.x, places[1] - walker.y) < WALKER_MARGIN * walker.length + 2.0 * BLUR_PX
        clear &= ~near
    return clear
