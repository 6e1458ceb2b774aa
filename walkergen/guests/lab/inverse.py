"""Inverse of a curve: from a bench measurement to the model's parameter, with its errors."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.numerics import Array
from walkergen.core.numerics.quantity import Quantity

CURVE_POINTS = 4001
"""Points at which a curve is read between its own."""

MIN_MEASURED = 1e-9
"""Smallest measured number, in its unit."""

MAX_ERRORS_AWAY = 2.0
"""Errors beyond which a number does not belong to a curve."""


class Curve(NamedTuple):
    """Curve from the model's parameter (`at`, rising) to the measured number."""

    at: Array
    seen: Array
    spread: Array
    """Standard deviation of single tries."""
    tries: Array
    """Number of simulated tries that `seen` is the mean of."""


class Measured(NamedTuple):
    """Number seen on a real bench, and the number of tries whose mean it is."""

    number: Quantity
    tries: int = 1

    @property
    def facts(self) -> dict[str, float | None]:
        """Facts for manifests."""
        return {"value": self.number.value, "sd": self.number.se, "tries": self.tries}


class Branch(NamedTuple):
    """Range of the model's parameter that agrees with the measured number within one error."""

    value: float
    low: float
    high: float


class Answer(NamedTuple):
    """Model parameter derived from a measured number."""

    text: str
    """The range as text."""
    branches: Sequence[Branch]
    """Ranges that agree with it."""
    everywhere: bool = False
    """True when the whole curve agrees: the test does not tell."""
    nearest: float = math.nan
    """Place of the curve nearest to it."""
    misses: float = 0.0
    """Distance there, in errors of the measured number and of the tries together."""

    @property
    def facts(self) -> dict[str, Any]:
        """Facts for JSON."""
        told = {"told": self.text, "branches": [branch._asdict() for branch in self.branches]}
        return {**told, "everywhere": self.everywhere, "nearest": self.nearest, "misses": self.misses}

    def number(self, key: str) -> Quantity:
        """Return the one range that agrees, with half its width as the error; refused if there is not one."""
        if self.everywhere or len(self.branches) != 1:
            return Quantity(key, "", None, refused=self.text)
        (branch,) = self.branches
        return Quantity(key, "", branch.value, 0.5 * (branch.high - branch.low))


def parse_measured(value: float | None, sd: float | None, tries: int, most: float) -> Measured | None:
    """Measured number with its standard error, as a request gives them; None without. Raises InputError.

    Both must be at least MIN_MEASURED and at most `most`.
    """
    if value is None and sd is None:
        return None
    options = (("measured", value), ("measured_sd", sd))
    for (name, number), (other, missing) in (options, options[::-1]):
        if missing is None:
            raise InputError(f"‹{name}=›{number:g}: needs ‹{other}› as well, the number's standard error")
        if number is not None and not MIN_MEASURED <= number <= most:
            raise InputError(f"‹{name}=›{number:g}: must be >= {MIN_MEASURED:g} and <= {most:g}")
    assert value is not None
    assert sd is not None
    return Measured(Quantity("measured", "", float(value), float(sd)), tries)


def invert(curve: Curve, seen: Measured, what: str, where: str = "") -> Answer:
    """Find the values of `what` that explain a measured number, from a curve; `where` ends the text if none does.

    Between its points the curve is cubic and monotone. The errors of the number and the scatter of its tries and of the
    simulated ones add in quadrature. A branch ends at a distance of one error.
    """
    from scipy.interpolate import PchipInterpolator

    value, sd = seen.number.pair
    at = np.linspace(curve.at[0], curve.at[-1], CURVE_POINTS)
    shown = np.asarray(PchipInterpolator(curve.at, curve.seen)(at))
    spread = np.interp(at, curve.at, curve.spread)
    scatter = spread * np.sqrt(1.0 / seen.tries + 1.0 / np.interp(at, curve.at, curve.tries))
    away = (shown - value) / np.hypot(sd, scatter)
    inside = np.abs(away) <= 1.0
    edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int)))
    branches = []
    for first, past in edges.reshape(-1, 2):
        best = first + int(np.argmin(np.abs(away[first:past])))
        branches.append(Branch(float(at[best]), float(at[first]), float(at[past - 1])))
    best = int(np.argmin(np.abs(away)))
    nearest, misses, everywhere = float(at[best]), float(abs(away[best])), bool(inside.all())
    ends = float(curve.at[0]), float(curve.at[-1])
    if everywhere:
        text = f"any {what} from {ends[0]:g} to {ends[1]:g} gives that{where}: it does not tell"
    elif branches:
        text = f"{what} " + ", or ".join(_format_branch(branch, ends) for branch in branches)
    else:
        within = "" if misses > MAX_ERRORS_AWAY else " within one error"
        text = (
            f"no {what} gives that{within}{where}: nearest is {shown[best]:.2f} at {nearest:.2f}, "
            f"{misses:.1f} errors away"
        )
    return Answer(text, branches, everywhere, nearest, misses)


def _format_branch(branch: Branch, ends: tuple[float, float]) -> str:
    """Range of a curve with these ends."""
    cut = [f"{end:g}" for end, own in zip(ends, branch[1:], strict=True) if own == end]
    up, down = branch.high - branch.value, branch.value - branch.low
    digits = error_digits(max(up, down))
    words = f"{branch.value:.{digits}f} (+{up:.{digits}f}, -{down:.{digits}f})"
    return words + (f", cut off at {' and '.join(cut)}" if cut else "")


def error_digits(error: float) -> int:
    """Return the number of decimals that show two digits of an error."""
    return max(1 - math.floor(math.log10(error)), 0) if error > 0.0 else 3
