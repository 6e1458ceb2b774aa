"""Least-squares fits of measured speeds."""

import math
from collections.abc import Sequence
from typing import NamedTuple
import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class Line(NamedTuple):
    """A straight line through the origin."""

    slope: float
    slope_se: float
    chi2: float | None
    """Weighted squared residuals; None without errors of the points."""
    p_value: float | None
    """Probability of a chi2 at least as large if the line is true."""
    points: int


def line_through_origin(x: Array, y: Array, errors: Array | None) -> Line:
    """Weighted least squares of y = slope x, shapes (n,), n >= 2.

    Without errors (None) all points weigh the same and their scatter gives the slope's error.
    """
    from scipy.stats import chi2 as chi2_law

    weights = np.ones_like(x) if errors is None else errors**-2.0
    norm = float(np.sum(weights * x**2))
    slope = float(np.sum(weights * x * y)) / norm
    rest = float(np.sum(weights * (y - slope * x) ** 2))
    if errors is None:
        return Line(slope, math.sqrt(rest / (len(x) - 1) / norm), None, None, len(x))
    return Line(slope, norm**-0.5, rest, float(chi2_law.sf(rest, len(x) - 1)), len(x))
