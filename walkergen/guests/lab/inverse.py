"""Inverse of a simulated curve: from a measured number to the model's parameter, with errors."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core import Quantity
from walkergen.core.numerics import Array

CURVE_POINTS = 4001
"""Number of points at which a curve is interpolated."""

MAX_ERRORS_AWAY = 2.0
"""Standard errors beyond which a number does not belong to a curve."""


class Curve(NamedTuple):
    """Simulated curve: mean measured `number` against the ascending `parameter` of the model, shape (n,) each."""

    parameter: Array
    number: Array
    spread: Array
    """Standard deviation of the number between single tries, shape (n,)."""
    tries: Array
    """Number of simulated tries behind each mean in `number`."""


class Measured(NamedTuple):
    """Mean of measured tries, and their number."""

    number: Quantity
    tries: int = 1


class Branch(NamedTuple):
    """Range of the model's parameter that agrees with the measured number within one error."""

    value: float
    low: float
    high: float


class Answer(NamedTuple):
    """Model parameter derived from a measured number."""

    text: str
    """The ranges of the parameter as a sentence."""
    branches: Sequence[Branch]
    """Ranges that agree with the measured number."""
    everywhere: bool = False
    """True if the whole curve agrees, so that the test determines nothing."""

    def number(self, key: str) -> Quantity:
        """Return the parameter as a quantity called `key`, half its range as error. Refused unless one range agrees."""
        if self.everywhere or len(self.branches) != 1:
            return Quantity(key, "", None, refused=self.text)
        (branch,) = self.branches
        return Quantity(key, "", branch.value, 0.5 * (branch.high - branch.low))


def invert(curve: Curve, measured: Measured, name: str, case: str = "") -> Answer:
    """Find the ranges of the curve's parameter that explain the measured number.

    Between its points the curve is cubic and monotone. The number's error and the scatter of real and simulated tries
    add in quadrature. A range ends at a distance of one error. The answer's text has the `name` of the parameter and
    the `case`, words such as " at 10 deg".
    """
    from scipy.interpolate import PchipInterpolator

    value, sd = measured.number.pair
    grid = np.linspace(curve.parameter[0], curve.parameter[-1], CURVE_POINTS)
    predicted = np.asarray(PchipInterpolator(curve.parameter, curve.number)(grid))
    spread = np.interp(grid, curve.parameter, curve.spread)
    scatter = spread * np.sqrt(1.0 / measured.tries + 1.0 / np.interp(grid, curve.parameter, curve.tries))
    deviations = (predicted - value) / np.hypot(sd, scatter)
    inside = np.abs(deviations) <= 1.0
    edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int)))
    branches = []
    for first, past in edges.reshape(-1, 2):
        best = first + int(np.argmin(np.abs(deviations[first:past])))
        branches.append(Branch(float(grid[best]), float(grid[first]), float(grid[past - 1])))
    ends = float(curve.parameter[0]), float(curve.parameter[-1])
    if inside.all():
        text = f"any {name} from {ends[0]:g} to {ends[1]:g} explains it{case}: this measurement does not determine it"
        return Answer(text, branches, everywhere=True)
    if branches:
        return Answer(f"{name} " + ", or ".join(_format_branch(branch, ends) for branch in branches), branches)
    best = int(np.argmin(np.abs(deviations)))
    misses = float(abs(deviations[best]))
    within = "" if misses > MAX_ERRORS_AWAY else " within one error"
    return Answer(
        f"no {name} explains it{within}{case}: the nearest is {predicted[best]:.2f} at {grid[best]:.2f}, "
        f"{misses:.1f} errors away",
        branches,
    )


def _format_branch(branch: Branch, ends: tuple[float, float]) -> str:
    """Format a range as best value and errors, and name the `ends` of the curve (lowest, highest) that cut it off."""
    cut = [f"{end:g}" for end, bound in zip(ends, branch[1:], strict=True) if bound == end]
    up, down = branch.high - branch.value, branch.value - branch.low
    digits = error_digits(max(up, down))
    text = f"{branch.value:.{digits}f} (+{up:.{digits}f}, -{down:.{digits}f})"
    return text + (f", cut off at {' and '.join(cut)}" if cut else "")


def error_digits(error: float) -> int:
    """Return the number of decimals that show two significant digits of an error."""
    return max(1 - math.floor(math.log10(error)), 0) if error > 0.0 else 3
