"""Straight line through the origin, as of speed against plate speed."""

from typing import NamedTuple

import numpy as np

from walkergen.core.numerics import Array
from walkergen.core.numerics.quantity import Quantity


class Line(NamedTuple):
    """Straight line through the origin, fitted to points with errors."""

    slope: Quantity
    chi2: float
    """Sum of the weighted squared residuals."""
    p_value: float
    """Probability of a chi2 at least as large if the points lie on a line through the origin."""
    points: int


def line_through_origin(x: Array, y: Array, errors: Array) -> Line:
    """Fit y = slope x by weighted least squares. Arrays have shape (n,), n >= 2; errors of y are > 0."""
    from scipy.stats import chi2 as chi2_law

    weights = errors**-2.0
    norm = float(np.sum(weights * x**2))
    slope = float(np.sum(weights * x * y)) / norm
    squares = float(np.sum(weights * (y - slope * x) ** 2))
    return Line(Quantity("slope", "", slope, norm**-0.5), squares, float(chi2_law.sf(squares, len(x) - 1)), len(x))
