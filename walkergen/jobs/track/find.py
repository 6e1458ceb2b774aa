"""Walkers in a frame: where they are, how they lie, and where their mark is.

What is thinner than a share of a walker's width is rubbed out first (an opening with a disc), so
that trails, arrows, letters and walls are no walkers and do not pull at the centre of one.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from walkergen.jobs.track.film import Grey
from walkergen.jobs.track.look import EIGHT, Array, Look, Mask, pieces

RUBBED = 0.2
"""Radius of the disc that rubs out what is thin, over the walkers' width."""

HOLE = 0.8
"""Largest hole that is filled, a mark as bright as the ground, over the square of the width."""

DEEP = 0.12
"""Distance from the edge, over the width, at which a mark is looked for."""

MARKED, SPOT = 0.25, 0.3
"""Smallest contrast of a mark over that of the walkers; its largest share of a walker's area."""

OFF_CENTRE = 0.08
"""Smallest distance of a mark from the centre, over a walker's length."""


class Blob(NamedTuple):
    """One thing found in a frame; places in pixels from its upper left corner, y downward."""

    x: float
    y: float
    area: float
    axis: float
    """Angle of the long axis, counted counter-clockwise as one sees it, rad, in -pi/2..pi/2."""
    length: float
    """Extent along the long axis, pixels."""
    width: float
    """Extent across it, pixels."""
    mark: float
    """Direction from the centre to the mark, counted like `axis`; NaN without a mark."""


def find(frame: Grey, look: Look, marked: bool) -> list[Blob]:
    """Things at least as thick as walkers in a frame, from the upper one down; marks if wanted."""
    field = look.contrasts(frame)
    found = []
    for box, piece in pieces(field > look.threshold, 0.5 * look.width):
        whole = _filled(piece, look.width)
        left, top = box[1].start - 1, box[0].start - 1
        labels, count = ndimage.label(_opened(whole, RUBBED * look.width), EIGHT)
        for number in range(1, count + 1):
            own = labels == number
            blob = _blob(own, left, top)
            if marked:
                inside = np.pad(field[box], 1, mode="edge")
                blob = blob._replace(mark=_mark(own, inside, blob, left, top, look))
            found.append(blob)
    return found


def _filled(piece: Mask, width: float) -> Mask:
    """Piece without its small holes."""
    holes, count = ndimage.label(~piece)  # a piece is padded: its outside is the first of them
    if count < 2:
        return piece
    areas = np.bincount(holes.ravel())
    small = (areas <= HOLE * width * width) & (np.arange(count + 1) > 0)
    small[holes[0, 0]] = False
    return np.asarray(piece | small[holes])


def _opened(piece: Mask, radius: float) -> Mask:
    """Piece without what is thinner than a disc of that radius, pixels."""
    core: Mask = ndimage.distance_transform_edt(piece) > radius
    if not core.any():
        return core
    return np.asarray(ndimage.distance_transform_edt(~core) <= radius)


def _blob(own: Mask, left: int, top: int) -> Blob:
    """Centre, axis and extents of a set of pixels."""
    rows, cols = np.nonzero(own)
    x, y = cols - cols.mean(), rows.mean() - rows  # y upward
    axis = 0.5 * math.atan2(2.0 * (x @ y), x @ x - y @ y)
    c, s = math.cos(axis), math.sin(axis)
    along, across = np.ptp(c * x + s * y), np.ptp(c * y - s * x)
    # Extents of centres of pixels; at a slant a pixel reaches farther.
    reach = abs(c) + abs(s)
    return Blob(
        left + float(cols.mean()), top + float(rows.mean()), float(len(x)), axis,
        float(along) + reach, float(across) + reach, math.nan,
    )  # fmt: skip


def _mark(own: Mask, field: Array, blob: Blob, left: int, top: int, look: Look) -> float:
    """Direction to the spot that differs most from the rest of a walker; NaN without one."""
    deep = ndimage.distance_transform_edt(own) > max(1.5, DEEP * look.width)
    if not deep.any():
        return math.nan
    apart = np.where(deep, field - np.median(field[deep]), 0.0)
    strongest = apart.flat[np.abs(apart).argmax()]
    if abs(strongest) < MARKED * look.contrast:
        return math.nan
    spots, _ = ndimage.label(apart * np.sign(strongest) > 0.5 * abs(strongest), EIGHT)
    areas = np.bincount(spots.ravel())
    areas[0] = 0
    spot = spots == areas.argmax()
    if areas.max() > SPOT * blob.area:
        return math.nan
    row, col = ndimage.center_of_mass(np.abs(apart) * spot)
    x, y = left + col - blob.x, blob.y - top - row
    if math.hypot(x, y) < OFF_CENTRE * blob.length:
        return math.nan
    return math.atan2(y, x)
