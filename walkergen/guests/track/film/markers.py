"""Markers in a frame: their numbers from OpenCV, and their corners from their edges.

OpenCV's detector reads numbers and approximate corners, which are too far inward in blurred frames. Here each side of
the black square is a straight line. It is fitted to the positions where brightness steps from black to white: centroids
of the change across the side. A centroid is linear in the brightness, so neither noise nor a symmetric blur shifts it.
The lines meet in corners.
"""

from typing import Any, NamedTuple

import numpy as np
from scipy import ndimage

from walkergen.core.numerics import Array, Mask, Whole
from walkergen.core.walker.fittings import MARKER_CELLS
from walkergen.guests.track.film.films import Grey

MIN_SIDE_PX = 12.0
"""Smallest side of a marker that is read, pixels: two pixels per cell."""

CELL_PIXELS = 8
"""Pixels per cell of a marker turned upright for reading: in films at low bitrate 89 % of the markers are read so,
85 % by OpenCV's 4."""

EDGE_PLACES, END_SHARE = 24, 0.15
"""Number of positions along a side where its edge is searched, and share of the side left out at either end."""

WINDOW_CELLS = 0.45
"""Half width of the window across a side, cells: black frame inside, white rim outside."""
MIN_WINDOW_PX = 1.5
"""Smallest half width of that window, pixels."""
SAMPLES_PER_PIXEL = 4
"""Number of samples per pixel across a side."""
REFINE_ROUNDS = 2
"""Number of searches for edges: the second in windows about the edges from the first."""

MIN_STEP_RATIO = 0.5
"""Smallest step of brightness at a position on a side, over the side's median step. Covered parts have less."""


class Sighted(NamedTuple):
    """Markers in one frame."""

    numbers: Whole
    """Numbers of the markers, ascending, shape (n,)."""
    corners: Array
    """Corners from the upper left one clockwise as the marker is read, shape (n, 4, 2), pixels from
    the frame's upper left corner, x to the right, y down; the first two are at the front."""


class Reader:
    """Detector of markers in grey frames of one size, with OpenCV's settings."""

    def __init__(self, width: int, height: int) -> None:
        import cv2

        parameters = cv2.aruco.DetectorParameters()
        parameters.minMarkerPerimeterRate = 4.0 * MIN_SIDE_PX / max(width, height)
        parameters.perspectiveRemovePixelPerCell = CELL_PIXELS
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_100)
        self._detector: Any = cv2.aruco.ArucoDetector(dictionary, parameters)

    def find_markers(self, frame: Grey) -> Sighted:
        """Return the markers of a frame, ordered by number. Two markers may have the same number."""
        corners, numbers, _ = self._detector.detectMarkers(frame)
        if numbers is None or not len(numbers):
            return Sighted(np.zeros(0, np.int64), np.zeros((0, 4, 2)))
        places = np.asarray(corners, float).reshape(-1, 4, 2)
        order = np.argsort(np.ravel(numbers), kind="stable")
        whole = np.asarray(np.ravel(numbers)[order], np.int64)
        return Sighted(whole, refine_corners(frame, places[order]) + 0.5)


def refine_corners(frame: Grey, corners: Array) -> Array:
    """Return corners where markers' edges meet, near `corners`, (n, 4, 2). Pixels have whole numbers in the middle."""
    for _ in range(REFINE_ROUNDS):
        corners = _refine_once(frame, corners)
    return corners


def _refine_once(frame: Grey, squares: Array) -> Array:
    """Return the corners where the edges of markers meet, shape (n, 4, 2), searched near the corners `squares`.

    Markers without clear edges keep their corners. Sides follow each other around a marker.

    Axes of arrays: marker, side, place along it, sample across it.
    """
    sides = np.roll(squares, -1, axis=1) - squares
    length = np.linalg.norm(sides, axis=2)
    tangent = sides / length[..., None]
    outward = np.stack([tangent[..., 1], -tangent[..., 0]], axis=-1)
    half_window = np.maximum(WINDOW_CELLS * length.mean(axis=1) / MARKER_CELLS, MIN_WINDOW_PX)
    share = np.linspace(END_SHARE, 1.0 - END_SHARE, EDGE_PLACES)
    across = np.linspace(-1.0, 1.0, 2 * int(np.ceil(SAMPLES_PER_PIXEL * half_window.max())) + 1)
    offsets = half_window[:, None] * across
    places = squares[:, :, None] + share[:, None] * sides[:, :, None]
    points = places[:, :, :, None] + offsets[:, None, None, :, None] * outward[:, :, None, None]
    levels = ndimage.map_coordinates(frame, np.moveaxis(points, -1, 0)[::-1], output=float, order=1, mode="nearest")
    change = np.diff(levels, axis=-1)
    step = change.sum(axis=-1)
    good = step > np.maximum(MIN_STEP_RATIO * np.median(step, axis=-1, keepdims=True), 0.0)
    between = 0.5 * (offsets[:, 1:] + offsets[:, :-1])
    shift = np.einsum("nspk,nk->nsp", change, between) / np.where(good, step, 1.0)
    shift = np.clip(shift, -half_window[:, None, None], half_window[:, None, None])
    offset, slope = _fit_lines(share - 0.5, shift / length[..., None], good)
    normal = outward - slope[..., None] * tangent
    point = squares + 0.5 * sides + (offset * length)[..., None] * outward
    known = (good.sum(axis=-1) >= EDGE_PLACES // 3).all(axis=1)
    return np.where(known[:, None, None], _intersect_lines(normal, point), squares)


def _fit_lines(along: Array, shift: Array, good: Mask) -> tuple[Array, Array]:
    """Return offset in the middle, and slope, of lines fitted robustly to the edges of markers, shape (n, 4) each.

    `along`: positions along a side, shape (p,). `shift`: shifts of the edge across the side there, shape (n, 4, p).
    `good`: whether to use a shift. All lengths are over the length of the side.
    """
    weights = good.astype(float)
    for _ in range(3):
        total = np.maximum(weights.sum(axis=-1), 1e-9)
        middle = (weights * along).sum(axis=-1) / total
        mean = (weights * shift).sum(axis=-1) / total
        lever = along - middle[..., None]
        spread = np.maximum((weights * lever**2).sum(axis=-1), 1e-9)
        slope = (weights * lever * shift).sum(axis=-1) / spread
        off = np.abs(shift - mean[..., None] - slope[..., None] * lever)
        scatter = np.maximum(1.5 * np.median(off, axis=-1, keepdims=True), 1e-5)
        weights = good / (1.0 + (off / scatter) ** 2)
    return mean - slope * middle, slope


def _intersect_lines(normal: Array, point: Array) -> Array:
    """Return where the line of each side meets the line before, shape (n, 4, 2). `normal`, `point`: of the lines."""
    before = np.roll(normal, 1, axis=1)
    lines = np.stack([before, normal], axis=2)
    far = np.einsum("nsk,nsk->ns", normal, point)
    both = np.stack([np.roll(far, 1, axis=1), far], axis=-1)
    return np.asarray(np.linalg.solve(lines, both[..., None])[..., 0])
