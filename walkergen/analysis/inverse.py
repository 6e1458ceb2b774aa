"""Inverse of a curve: from what was seen on the bench to what the model needs, with its errors."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.errors import InputError

Array = npt.NDArray[np.float64]

FINE = 4001
"""Points at which a curve is read between its own."""

LEAST = 1e-9
"""Least number that is measured, in whatever unit."""

FAR = 2.0
"""Errors beyond which a number does not belong to a curve."""


class Curve(NamedTuple):
    """Curve from what the model needs (`at`, rising) to what is seen."""

    at: Array
    seen: Array
    spread: Array
    """Standard deviation of what one try shows, from try to try."""
    tries: Array
    """Number of simulated tries that `seen` is the mean of."""


class Measured(NamedTuple):
    """Number seen on a real bench."""

    value: float
    sd: float
    tries: int = 1
    """Number of tries whose mean it is."""


class Branch(NamedTuple):
    """Interval of what the model needs that agrees with the measured within one error."""

    value: float
    low: float
    high: float


class Inverse(NamedTuple):
    """Branches that agree with a measured number, and the place of the curve nearest to it."""

    branches: Sequence[Branch]
    nearest: float
    shows: float
    """What is seen at `nearest`."""
    misses: float
    """Distance there, in errors of the measured number and of the tries together."""
    everywhere: bool
    """True when the whole curve agrees: the test does not tell."""


def measured(
    value: float | None, sd: float | None, tries: int, most: float, flag: str = "--measured"
) -> Measured | None:
    """Measured number as the options `flag` and its -sd give it; None without. Raises InputError.

    Both must be at least LEAST and at most `most`.
    """
    if value is None and sd is None:
        return None
    options = ((flag, value), (f"{flag}-sd", sd))
    for (name, number), (other, missing) in (options, options[::-1]):
        if missing is None:
            raise InputError(f"{name} {number:g}: needs {other} as well, the number's standard error")
        if number is not None and not LEAST <= number <= most:
            raise InputError(f"{name} {number:g}: must be >= {LEAST:g} and <= {most:g}")
    assert value is not None
    assert sd is not None
    return Measured(float(value), float(sd), tries)


def invert(curve: Curve, number: Measured) -> Inverse:
    """Branches of a curve that agree with a measured number.

    Between its points the curve is cubic, and monotone. Errors are those of the number, and the
    scatter of so many tries and of the simulated ones, in quadrature; a branch ends where the
    distance is one error.
    """
    from scipy.interpolate import PchipInterpolator

    at = np.linspace(curve.at[0], curve.at[-1], FINE)
    seen = np.asarray(PchipInterpolator(curve.at, curve.seen)(at))
    spread = np.interp(at, curve.at, curve.spread)
    scatter = spread * np.sqrt(1.0 / number.tries + 1.0 / np.interp(at, curve.at, curve.tries))
    away = (seen - number.value) / np.hypot(number.sd, scatter)
    inside = np.abs(away) <= 1.0
    edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int)))
    branches = []
    for first, past in edges.reshape(-1, 2):
        part = slice(first, past)
        best = first + int(np.argmin(np.abs(away[part])))
        branches.append(Branch(float(at[best]), float(at[first]), float(at[past - 1])))
    best = int(np.argmin(np.abs(away)))
    misses = float(abs(away[best]))
    return Inverse(branches, float(at[best]), float(seen[best]), misses, bool(inside.all()))


def in_words(inverse: Inverse, what: str, ends: tuple[float, float], where: str = "") -> str:
    """Answer of an inverse in words; `ends` are those of the curve."""
    if inverse.everywhere:
        return f"any {what} from {ends[0]:g} to {ends[1]:g} gives that{where}: it does not tell"
    if not inverse.branches:
        within = "" if inverse.misses > FAR else " within one error"
        return (
            f"no {what} gives that{within}{where}: nearest is {inverse.shows:.2f} at "
            f"{inverse.nearest:.2f}, {inverse.misses:.1f} errors away"
        )
    return f"{what} " + ", or ".join(_branch_in_words(branch, ends) for branch in inverse.branches)


def _branch_in_words(branch: Branch, ends: tuple[float, float]) -> str:
    cut = [f"{end:g}" for end, own in zip(ends, branch[1:], strict=True) if own == end]
    up, down = branch.high - branch.value, branch.value - branch.low
    digits = digits_of(max(up, down))
    text = f"{branch.value:.{digits}f} (+{up:.{digits}f}, -{down:.{digits}f})"
    return text + (f", cut off at {' and '.join(cut)}" if cut else "")


def digits_of(error: float) -> int:
    """Digits after the point that show two of an error."""
    return max(1 - math.floor(math.log10(error)), 0) if error > 0.0 else 3
