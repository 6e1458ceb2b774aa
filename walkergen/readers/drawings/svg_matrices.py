"""Matrices of an SVG drawing, shape (2, 3): transforms, one after the other, and boxes fitted into windows."""

import math
import re
from collections.abc import Sequence

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.numerics import Array

NUMBERS_PATTERN = r"(?:[-+0-9.eE,\s]|px|deg|g?rad|turn)*"
TRANSFORMS_PATTERN = re.compile(
    rf"\s*(?:(?:matrix|(?:translate|scale|skew)[XY]?|rotate)\s*\({NUMBERS_PATTERN}\)[\s,]*)*", re.IGNORECASE
)
"""Lists of transforms within the plane, by plain numbers."""

ALIGNMENT_SHARES = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}


def parse_transform(text: str) -> Array | None:
    """Parse a list of transforms to a matrix, shape (2, 3). Return None if it leaves the plane or needs other data."""
    if not TRANSFORMS_PATTERN.fullmatch(text):
        return None
    import svgelements

    try:
        read = svgelements.Matrix(text)
        return np.array([[read.a, read.c, read.e], [read.b, read.d, read.f]], dtype=float)
    except (ValueError, TypeError, IndexError):
        return None


def mean_stretch(matrix: Array) -> float:
    """Return the mean ratio of a line's length after a matrix to that before it, over all directions."""
    return float(math.sqrt(abs(np.linalg.det(matrix[:, :2]))))


def compose(first: Array, second: Array) -> Array:
    """Return the matrix that transforms by the second, then by the first, shape (2, 3)."""
    return np.column_stack([first[:, :2] @ second[:, :2], first[:, :2] @ second[:, 2] + first[:, 2]])


def parse_view_box(text: str, source: str) -> tuple[float, float, float, float]:
    """Return the box of a viewBox: left, top, width and height > 0. Raises InputError."""
    try:
        x, y, width, height = (float(number) for number in re.split(r"[\s,]+", text.strip()))
    except ValueError:
        width = height = 0.0
    if not (0.0 < width < np.inf and 0.0 < height < np.inf):
        raise InputError(f"{source}: viewBox = {text[:60]!r}: it must be four numbers, with width and height > 0")
    return x, y, width, height


def fit_matrix(box: Sequence[float], width: float, height: float, fit: str) -> Array:
    """Return the matrix that fits a box (left, top, width, height) into a window by `fit`, a preserveAspectRatio."""
    scale = np.array([width / box[2], height / box[3]])
    if "none" not in fit:
        scale[:] = scale.max() if "slice" in fit else scale.min()
    match = re.search(r"x(Min|Mid|Max)Y(Min|Mid|Max)", fit)
    share = np.array([ALIGNMENT_SHARES[word] for word in match.groups()] if match else (0.5, 0.5))
    if "none" in fit:
        share[:] = 0.0
    shift = share * (np.array([width, height]) - scale * box[2:4]) - scale * box[0:2]
    return np.column_stack([np.diag(scale), shift])
