"""Walkers in a frame: their positions, orientations and marks.

Things thinner than a share of a walker's width are erased first (an opening with a disc). So trails, arrows, letters
and walls are no walkers and do not shift the centre of one.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from walkergen.core.numerics import Array, Mask
from walkergen.guests.track.film.appearance import EIGHT_NEIGHBOURS, Appearance, Floats, connected_pieces
from walkergen.guests.track.film.films import Grey

OPENING_RADIUS = 0.3
"""Radius of the disc that erases thin things, over the walkers' width."""

MIN_HALF_WIDTH = 0.38
"""Smallest distance from the edge to the middle of a walker, over the walkers' width: letters have less."""

CHESSBOARD_RATIO = 1.415
"""Largest ratio of the Euclidean to the chessboard distance, rounded up from the root of 2."""

MAX_HOLE_AREA = 0.8
"""Largest hole that is filled, a mark as bright as the ground, over the square of the width."""

MARK_DEPTH = 0.12
"""Distance from the edge, over the width, at which the search for a mark starts."""

MIN_MARK_CONTRAST, MAX_MARK_SHARE = 0.25, 0.3
"""Smallest contrast of a mark over that of the walkers; its largest share of a walker's area."""

MIN_MARK_OFFSET = 0.08
"""Smallest distance of a mark from the centre, over a walker's length."""

MIN_CORE_CONTRAST, CORE_QUANTILE = 0.8, 0.7
"""Smallest contrast inside a walker, over the CORE_QUANTILE of the contrasts of all its pixels. A shadow has less
contrast."""


class Blob(NamedTuple):
    """Object found in a frame: centre x, y (pixels from the upper left corner, y down), area (pixels) and shape."""

    x: float
    y: float
    area: float
    axis: float
    """Angle of the long axis, counter-clockwise in the picture, rad, in -pi/2..pi/2."""
    length: float
    """Extent along the long axis, pixels."""
    width: float
    """Extent across the long axis, pixels."""
    mark: float
    """Direction from the centre to the mark, rad, counted like `axis`; NaN without a mark."""
    pull_x: float = 0.0
    """`pull_x`, `pull_y`: shift of the centre by a shadow, pixels: x, y less the centre of the core without shadow."""
    pull_y: float = 0.0


class Blobs(NamedTuple):
    """Blobs of one walker in several frames: the fields of `Blob`, arrays of shape (n,)."""

    x: Array
    y: Array
    area: Array
    axis: Array
    length: Array
    width: Array
    mark: Array
    pull_x: Array
    pull_y: Array


def find_blobs(frame: Grey, look: Appearance, marked: bool) -> list[Blob]:
    """Return the objects at least as thick as walkers in a frame, from top to bottom. `marked`: also search marks."""
    field = look.contrasts(frame)
    blobs = []
    for box, piece in connected_pieces(field > look.threshold, 0.5 * look.width):
        whole = _fill_holes(piece, look.width)
        if CHESSBOARD_RATIO * ndimage.distance_transform_cdt(whole).max() < MIN_HALF_WIDTH * look.width:
            continue  # a letter, or a line around the plate; computing Euclidean distances would take long
        left, top = box[1].start - 1, box[0].start - 1  # a piece is padded, within the frame
        inside = field[top : box[0].stop + 1, left : box[1].stop + 1]
        labels, count = ndimage.label(_open_mask(whole, OPENING_RADIUS * look.width), EIGHT_NEIGHBOURS)
        for number in range(1, count + 1):
            mask = labels == number
            if ndimage.distance_transform_edt(mask).max() < MIN_HALF_WIDTH * look.width:
                continue
            blob = _measure_blob(_coverage(mask, inside), left, top)
            pull_x, pull_y = _shadow_pull(mask, inside)
            blob = blob._replace(pull_x=pull_x, pull_y=pull_y)
            if marked:
                blob = blob._replace(mark=_mark_direction(mask, inside, blob, left, top, look))
            blobs.append(blob)
    return blobs


def _coverage(mask: Mask, field: Floats) -> Floats:
    """Return the share of each pixel that a walker covers: 1 inside its mask, from contrasts `field` at its edge."""
    near = ndimage.binary_dilation(mask, EIGHT_NEIGHBOURS)
    deep = ndimage.binary_erosion(mask, EIGHT_NEIGHBOURS, iterations=2)
    level = np.median(field[deep if deep.any() else mask])  # contrast inside this walker, as light is uneven
    share = np.where(near, (field / level).clip(0.0, 1.0), 0.0)
    share[deep] = 1.0
    return share


def _shadow_pull(piece: Mask, field: Floats) -> tuple[float, float]:
    """Return the offset (x, y, pixels) of a blob from its core, where the contrast `field` is high, due to a shadow."""
    core = ndimage.binary_fill_holes(piece & (field > MIN_CORE_CONTRAST * np.quantile(field[piece], CORE_QUANTILE)))
    (row, col), (core_row, core_col) = (ndimage.center_of_mass(mask) for mask in (piece, core))
    return float(col - core_col), float(row - core_row)


def _fill_holes(piece: Mask, width: float) -> Mask:
    """Return a piece whose holes are filled, if they are small for a walker of this `width` (pixels)."""
    holes, count = ndimage.label(~piece)  # the outside counts as one, and is label 1
    if count < 2:
        return piece
    areas = np.bincount(holes.ravel())
    small = (areas <= MAX_HOLE_AREA * width * width) & (np.arange(count + 1) > 0)
    small[holes[0, 0]] = False
    return np.asarray(piece | small[holes])


def _open_mask(piece: Mask, radius: float) -> Mask:
    """Return the piece without parts thinner than a disc of that radius, pixels."""
    core: Mask = ndimage.distance_transform_edt(piece) > radius
    if not core.any():
        return core
    return np.asarray(ndimage.distance_transform_edt(~core) <= radius)


def _measure_blob(covered: Floats, left: int, top: int) -> Blob:
    """Measure centre, axis and extents of a blob. `covered`: share of each pixel that it covers, shape (rows, columns).

    The first pixel of `covered` is in column `left` and row `top` of the frame.
    """
    rows, cols = np.nonzero(covered)
    weight = covered[rows, cols].astype(float)
    area = float(weight.sum())
    middle_x, middle_y = (float((weight * place).sum()) / area for place in (cols, rows))
    x, y = cols - middle_x, middle_y - rows  # y upward
    # No dot product: its threads would cost more time than they save, and change the order of sums
    xx, xy, yy = (float((weight * a * b).sum()) for a, b in ((x, x), (x, y), (y, y)))
    axis = 0.5 * math.atan2(2.0 * xy, xx - yy)
    c, s = math.cos(axis), math.sin(axis)
    along, across = c * x + s * y, c * y - s * x
    length, width = (_extent(weight, other, 0.15 * float(np.ptp(other))) for other in (across, along))
    return Blob(left + middle_x, top + middle_y, area, axis, length, width, math.nan)


def _extent(weight: Floats, off: Floats, half: float) -> float:
    """Return the extent (pixels) of a blob along a line, from the pixels within about `half` pixels of the line.

    `weight`, `off`: covered shares of pixels, and their distances to the line. The band ends softly, over a pixel, so
    that its width is the same wherever the line runs.
    """
    half = max(half, 0.5)
    return float((weight * (half + 0.5 - np.abs(off)).clip(0.0, 1.0)).sum()) / (2.0 * half)


def _mark_direction(mask: Mask, field: Floats, blob: Blob, left: int, top: int, look: Appearance) -> float:
    """Return the direction (rad) from a walker's centre to its mark, its most different spot, or NaN without one.

    `mask`, `field`: its pixels, and contrasts, in a box that begins at column `left` and row `top` of the frame.
    """
    interior = ndimage.distance_transform_edt(mask) > max(1.5, MARK_DEPTH * look.width)
    if not interior.any():
        return math.nan
    contrast = np.where(interior, field - np.median(field[interior]), 0.0)
    strongest = contrast.flat[np.abs(contrast).argmax()]
    if abs(strongest) < MIN_MARK_CONTRAST * look.contrast:
        return math.nan
    spots, _ = ndimage.label(contrast * np.sign(strongest) > 0.5 * abs(strongest), EIGHT_NEIGHBOURS)
    areas = np.bincount(spots.ravel())
    areas[0] = 0
    spot = spots == areas.argmax()
    if areas.max() > MAX_MARK_SHARE * blob.area:
        return math.nan
    row, col = ndimage.center_of_mass(np.abs(contrast) * spot)
    x, y = left + col - blob.x, blob.y - top - row
    if math.hypot(x, y) < MIN_MARK_OFFSET * blob.length:
        return math.nan
    return math.atan2(y, x)
