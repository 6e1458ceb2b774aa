"""Plane of the caps in the camera's view: from pixels to millimetres, using the shape of squares.

A tilted camera maps a plane by a homography, which has eight numbers. Three of them (the origin and the direction of x)
are free to choose. The other five, scale, tilt and perspective, make all markers squares of their size (least squares
over corners, each marker turned and moved to its best fit). Source: Hartley and Zisserman, Multiple View Geometry, 2nd
ed., section 2.7, with squares in place of circular points. `lens` corrects lens distortion before; the remainder is in
`Plane.residual_px`.
"""

import math
from typing import NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.numerics import Array, Mask

UNIT_SQUARE = 0.5 * np.array([(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)])
"""Corners of a marker of side 1 with its front toward +x, y up, in the order of `markers.Sighted`, shape (4, 2)."""

MAX_SIGHTINGS = 3000
"""Largest number of sightings (a marker in a frame) in a fit."""

SMOOTH_PX = 0.5
"""Residual of a corner, pixels, above which its weight in the fit grows linearly instead of quadratically."""

RESIDUAL_FACTOR, MIN_RESIDUAL_PX = 5.0, 0.5
"""Residual of a marker, over the median residual and in pixels, above which it is misread or bent."""

PERSPECTIVE_PRIOR_PX = 0.1
"""Distance of one corner, pixels, that counts as much in the fit as a perspective term of 1. At 1 the scale has no
limit at the picture's edge. The prior keeps the perspective near 0 if one marker in one place does not determine it."""

CORRELATED_SIGHTINGS = 25.0
"""Approximate number of sightings with equal errors: those of one marker in neighbouring frames."""


class Plane(NamedTuple):
    """Map from pixels to the plane of the caps, mm, y up."""

    middle: Array
    """Middle of the frame, pixels."""
    half: float
    """Half of the frame's longer side, pixels."""
    terms: Array
    """Five terms: scale along x, of y into x, and along y (mm per `half`), and perspective along x and y."""
    residual_px: float
    """Root mean square distance of corners from those of squares, along an axis, pixels."""
    errors: Array
    """Standard errors of the terms."""

    def to_mm(self, pixels: Array) -> Array:
        """Map points of the picture, shape (..., 2), pixels, to the plane, mm.

        The origin is where the picture's lower left corner would be at the scale `mm_per_px` of its middle.
        """
        middle_mm = np.array([self.middle[0], self.middle[1]]) * self.mm_per_px
        return middle_mm + _map_points(self.terms, self._to_centred(pixels))

    @property
    def mm_per_px(self) -> float:
        """Scale in the middle of the picture, mm per pixel: the geometric mean over directions."""
        a, _, c = self.terms[:3]
        return math.sqrt(a * c) / self.half

    @property
    def tilt_deg(self) -> float:
        """Angle between the camera's axis and the plane's normal, from the foreshortening in the picture's middle."""
        a, b, c = self.terms[:3]
        large, small = np.linalg.svd(np.array([(a, b), (0.0, c)]), compute_uv=False)
        return math.degrees(math.acos(min(1.0, float(small / large))))

    def scales(self, pixels: Array) -> Array:
        """Return the millimetres per pixel at points of the picture, shape (n, 2), as the mean over directions."""
        near = 1.0 + self._to_centred(pixels) @ self.terms[3:]
        return np.asarray(self.mm_per_px / np.abs(near) ** 1.5)

    def _to_centred(self, pixels: Array) -> Array:
        """Return points of the picture, pixels, relative to the middle of the frame, divided by `half`, y up."""
        return np.asarray((pixels - self.middle) * (1.0, -1.0) / self.half)


class Pose(NamedTuple):
    """Positions and headings of n markers in the plane."""

    places: Array
    """Middles of the markers, shape (n, 2), mm."""
    headings: Array
    """Headings, shape (n,), rad, from x toward y."""
    off_px: Array
    """Root mean square distance of corners from those of squares, along an axis, shape (n,), pixels."""


def fit_plane(corners: Array, side: float, width: int, height: int) -> Plane:
    """Fit the plane in which markers are squares of `side` (mm), from corners of shape (n, 4, 2), pixels.

    `width` and `height`: of the frame, pixels. Raises InputError if no plane makes the markers squares.
    """
    from scipy.optimize import least_squares

    middle, half = 0.5 * np.array([width, height]), 0.5 * max(width, height)
    chosen = corners[np.unique(np.linspace(0, len(corners) - 1, MAX_SIGHTINGS).round().astype(int))]
    points = (chosen - middle) * (1.0, -1.0) / half
    sides = np.hypot(*np.moveaxis(points - np.roll(points, 1, axis=1), -1, 0))
    start = side / float(np.median(sides))

    def residuals(terms: Array) -> Array:
        """Return the offsets of all corners from squares, pixels, then the weighted perspective terms."""
        off, sizes = _square_offsets(_map_points(terms, points), points, side)
        return np.append((half * off / sizes[:, None, None]).ravel(), PERSPECTIVE_PRIOR_PX * terms[3:])

    found = least_squares(
        residuals,
        [start, 0.0, start, 0.0, 0.0],
        loss="soft_l1",
        f_scale=SMOOTH_PX,
        x_scale=[start, start, start, 1.0, 1.0],
    )
    terms = np.asarray(found.x)
    size = float(np.sqrt(np.mean(residuals(terms)[:-2] ** 2)))
    spread = np.linalg.pinv(found.jac.T @ found.jac) * size**2 * min(CORRELATED_SIGHTINGS, len(chosen))
    plane = Plane(middle, half, terms, size, np.sqrt(np.diag(spread)))
    if terms[0] <= 0.0 or terms[2] <= 0.0 or (1.0 + points @ terms[3:]).min() <= 0.05:
        raise InputError(
            "markers are squares in no plane: caps that are not flat, or a camera that looks along "
            "the plate: film it from above"
        )
    return plane


def find_poses(plane: Plane, corners: Array, side: float) -> Pose:
    """Return the poses of markers of `side` (mm) in the plane, from corners of shape (n, 4, 2), pixels."""
    mapped = plane.to_mm(corners)
    off, sizes = _square_offsets(mapped, corners, side)
    centred = mapped - mapped.mean(axis=1, keepdims=True)
    residual = np.sqrt((off**2).mean(axis=(1, 2))) / sizes
    return Pose(mapped.mean(axis=1), _turn_angles(centred), residual)


def is_square(off_px: Array) -> Mask:
    """Return a mask of the markers that are squares in the plane, from `Pose.off_px`, shape (n,). Others lean."""
    return np.asarray(off_px <= max(RESIDUAL_FACTOR * float(np.median(off_px)), MIN_RESIDUAL_PX))


def _map_points(terms: Array, points: Array) -> Array:
    """Map centred points of the picture, shape (..., 2), to the plane, mm, with the five terms of a `Plane`."""
    a, b, c, right, up = terms
    near = 1.0 + points[..., 0] * right + points[..., 1] * up
    x = (a * points[..., 0] + b * points[..., 1]) / near
    return np.stack([x, c * points[..., 1] / near], axis=-1)


def _square_offsets(mapped: Array, points: Array, side: float) -> tuple[Array, Array]:
    """Return the offsets of corners from the best-fitting squares of `side`, and the scales, plane over picture.

    `mapped`, `points`: corners in the plane and in the picture, shape (n, 4, 2), in the order of UNIT_SQUARE. Shapes of
    results: (n, 4, 2) in the unit of `mapped`, and (n,).
    """
    centred = mapped - mapped.mean(axis=1, keepdims=True)
    turn = _turn_angles(centred)
    c, s = np.cos(turn)[:, None], np.sin(turn)[:, None]
    x, y = side * UNIT_SQUARE.T
    square = np.stack([c * x - s * y, s * x + c * y], axis=-1)
    scales = np.sqrt(np.abs(_signed_areas(mapped) / _signed_areas(points)))
    return centred - square, scales


def _turn_angles(centred: Array) -> Array:
    """Return the rotation angles (rad), shape (n,), of squares about the origin, from corners of shape (n, 4, 2)."""
    cross = centred[..., 1] @ UNIT_SQUARE[:, 0] - centred[..., 0] @ UNIT_SQUARE[:, 1]
    along = centred[..., 0] @ UNIT_SQUARE[:, 0] + centred[..., 1] @ UNIT_SQUARE[:, 1]
    return np.asarray(np.arctan2(cross, along))


def _signed_areas(corners: Array) -> Array:
    """Return the signed areas, shape (n,), of quadrilaterals, shape (n, 4, 2)."""
    first, second = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    return np.asarray(0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]))
