"""Lens distortion from an OpenCV calibration, and its correction.

The file is JSON: image_width, image_height, camera_matrix (three rows, or OpenCV's own object with
`data`) and distortion_coefficients (k1, k2, p1, p2 and up to ten more). Source: OpenCV's model of a
camera, https://docs.opencv.org/4.x/d9/d0c/group__calib3d.html.
"""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.files import file_reading, safe_text
from walkergen.core.numerics import Array
from walkergen.guests.track.film.blobs import Blobs

MAX_BYTES = 1_000_000
COEFFICIENT_COUNTS = (4, 5, 8, 12, 14)
"""Numbers of coefficients that OpenCV supports."""

ASPECT_TOLERANCE = 0.01
"""Largest relative difference of the shapes of two pictures of one lens, width over height."""

MAX_RESIDUAL_PX = 0.05
"""Largest distance, pixels, of a position from itself after correction and distortion. If it is larger, the
coefficients have no inverse there."""

STRETCH_STEP_PX = 1.0
"""Half of the distance over which the local stretch by a lens is measured, pixels."""


class Lens(NamedTuple):
    """Lens of a camera, for pictures of one size. Its fields are plain numbers, for a manifest in JSON."""

    width: int
    """Width of the pictures of the calibration, pixels."""
    height: int
    focal: tuple[float, float]
    """Focal lengths along a row and down, pixels."""
    middle: tuple[float, float]
    """Position of the optical axis, pixels; the middle of a pixel has whole numbers."""
    distortion: tuple[float, ...]

    def for_film(self, width: int, height: int) -> "Lens":
        """Return the lens for pictures of another size (pixels). Raises InputError if their shape differs."""
        if abs(width * self.height / (height * self.width) - 1.0) > ASPECT_TOLERANCE:
            raise InputError(
                f"‹lens›: calibrated with pictures of {self.width} x {self.height}, the film has "
                f"{width} x {height}. Film the checkerboard as you film walkers"
            )
        along, down = width / self.width, height / self.height
        x, y = self.middle
        return Lens(
            width,
            height,
            (along * self.focal[0], down * self.focal[1]),
            ((x + 0.5) * along - 0.5, (y + 0.5) * down - 0.5),
            self.distortion,
        )

    @property
    def matrix(self) -> Array:
        """Camera matrix, shape (3, 3)."""
        return np.array([(self.focal[0], 0.0, self.middle[0]), (0.0, self.focal[1], self.middle[1]), (0.0, 0.0, 1.0)])

    def undistort(self, pixels: Array) -> Array:
        """Return positions in the picture, shape (..., 2), corrected for lens distortion, with the same focal length.

        Pixels count from the picture's upper left corner. Raises InputError where the lens has no solution.
        """
        import cv2

        matrix, distortion = self.matrix, np.array(self.distortion)
        seen = pixels.reshape(-1, 1, 2) - 0.5
        rays = np.asarray(cv2.undistortPoints(seen, matrix, distortion), float).reshape(-1, 2)
        ahead = np.column_stack([rays, np.ones(len(rays))])
        again, _ = cv2.projectPoints(ahead, np.zeros(3), np.zeros(3), matrix, distortion)
        off = np.hypot(*(np.asarray(again).reshape(-1, 2) - seen.reshape(-1, 2)).T)
        if not (off < MAX_RESIDUAL_PX).all():
            raise InputError(
                f"‹lens›: its distortion is off by {np.nanmax(off):.2g} pixels at the walkers. "
                "Calibrate with a checkerboard that reaches the edges of the picture"
            )
        return np.asarray(rays * self.focal + self.middle + 0.5).reshape(pixels.shape)

    def undistort_blobs(self, blobs: Blobs, offset: tuple[int, int]) -> Blobs:
        """Return blobs corrected for lens distortion: positions, directions, lengths and areas.

        `offset`: position (x, y) in the whole picture of the pixel from which the blobs' positions count.
        """
        places = np.column_stack([blobs.x, blobs.y]) + offset + 0.5

        def undistort_vectors(angle: Array) -> Array:
            """Return corrected vectors, shape (n, 2), of unit vectors at angles (rad), shape (n,), one at each blob."""
            step = STRETCH_STEP_PX * np.column_stack([np.cos(angle), -np.sin(angle)])
            vectors = self.undistort(places + step) - self.undistort(places - step)
            return np.asarray(0.5 * vectors / STRETCH_STEP_PX)

        def undistort_angles(angle: Array) -> Array:
            """Return corrected directions (rad), shape (n,), NaN where unknown."""
            known = ~np.isnan(angle)
            vector = undistort_vectors(np.where(known, angle, 0.0))
            turned = angle + np.angle(np.exp(1j * (np.arctan2(-vector[:, 1], vector[:, 0]) - angle)))
            return np.where(known, turned, np.nan)

        ahead, across = undistort_vectors(blobs.axis), undistort_vectors(blobs.axis + 0.5 * math.pi)
        x, y = (self.undistort(places) - np.array(offset) - 0.5).T
        area = np.abs(ahead[:, 0] * across[:, 1] - ahead[:, 1] * across[:, 0])
        return blobs._replace(
            x=x,
            y=y,
            area=blobs.area * area,
            axis=undistort_angles(blobs.axis),
            mark=undistort_angles(blobs.mark),
            length=blobs.length * np.linalg.norm(ahead, axis=1),
            width=blobs.width * np.linalg.norm(across, axis=1),
        )


def read_lens(path: Path) -> Lens:
    """Read a lens from a JSON file of its calibration. Raises InputError for missing or impossible numbers."""
    data = file_reading.read_json(path, MAX_BYTES)
    if not isinstance(data, dict):
        raise InputError(f"{path}: must be a JSON object with camera_matrix and more, see ‹help›")
    width, height = (_parse_numbers(data, name, path, (1,))[0] for name in ("image_width", "image_height"))
    matrix = _parse_numbers(data, "camera_matrix", path, (9,))
    distortion = _parse_numbers(data, "distortion_coefficients", path, COEFFICIENT_COUNTS)
    fx, skew, x, zero, fy, y, *last = matrix
    if min(fx, fy, width, height) <= 0 or (skew, zero, *last) != (0.0, 0.0, 0.0, 0.0, 1.0):
        raise InputError(
            f"{path}: camera_matrix must have rows fx, 0, cx; 0, fy, cy; 0, 0, 1 with fx, fy > 0, "
            "and the sizes of the pictures must be > 0"
        )
    return Lens(round(width), round(height), (fx, fy), (x, y), tuple(distortion))


def _parse_numbers(data: Mapping[str, Any], name: str, path: Path, counts: tuple[int, ...]) -> list[float]:
    """Parse the numbers of the key `name`, nested in rows or not. Raises InputError unless their count is allowed."""
    value = data.get(name)
    if isinstance(value, dict):
        value = value.get("data")
    cells: list[Any] = [value]
    while any(isinstance(cell, list) for cell in cells):
        cells = [inner for cell in cells for inner in (cell if isinstance(cell, list) else [cell])]
    sound = all(isinstance(cell, int | float) and abs(cell) < 1e9 for cell in cells)
    if not sound or len(cells) not in counts:
        seen = "is missing" if value is None else f"= {safe_text.shorten_line(str(value))[:40]}"
        many = " or ".join(map(str, counts))
        raise InputError(f"{path}: {name} {seen}: must be {many} number{'s' * (many != '1')}")
    return [float(cell) for cell in cells]
