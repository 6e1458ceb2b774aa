"""Quantities: a number with its error and unit, or why there is none; and how two of them compare.

Every number that walkergen states is one of these. Bounds follow Student's t (Student 1908), those of
a variance chi^2. There is one rule for "agrees", and noise never makes an agreement by it.
"""

import math
from collections.abc import Sequence
from enum import StrEnum
from typing import Any, NamedTuple

import numpy as np

from walkergen.core.files import formatting
from walkergen.core.numerics import Array
from walkergen.core.numerics.distributions import student_quantile

CONFIDENCE = 0.95
"""Confidence of the bounds that compare two quantities."""

UNIT_SYMBOLS = {
    **{"mm_s": "mm/s", "mm2_s": "mm²/s", "per_s": "1/s", "per_mm": "1/mm", "rad_s": "rad/s", "rad2_s": "rad²/s"},
    "percent": "%",
}
"""Units as people read them, if different from those of keys."""

BOUND_ITERATIONS = 50
"""Number of iterations for the lower bound of a variance that is reported only if it is large."""


class Verdict(StrEnum):
    """Result of comparing a quantity with another, or with an allowed range."""

    AGREE = "agree"
    """All of its bounds lie within what is allowed."""
    UNDECIDED = "undecided"
    """Its bounds reach over an end of what is allowed: a smaller error would decide."""
    DISAGREE = "disagree"
    """None of its bounds lies within what is allowed."""
    MISSING = "missing"
    """There is no value."""


class Quantity(NamedTuple):
    """Number with its standard error, in a unit; value, error or both are None when refused.

    Notes
    -----
    Bounds follow Student's t (Student, Biometrika 6 (1908) 1), those of a variance follow chi^2.

    Examples
    --------
    >>> from walkergen.core import Quantity
    >>> low, high = Quantity("speed", "mm_s", 60.0, 1.0).interval(0.68)
    >>> print(f"{low:.1f} to {high:.1f} mm/s")
    59.0 to 61.0 mm/s
    """

    key: str
    unit: str
    """As keys write it: mm_s, rad2_s; "" for a pure number."""
    value: float | None
    se: float | None = None
    """Standard error; None if unknown, 0 for a number without chance."""
    freedom: float = math.inf
    """Degrees of freedom of the error: bounds follow Student's t; 0: more values would give none."""
    refused: str = ""
    """Reason why there is no value, or no error; "" where both are known."""
    noise: float | None = None
    """Variance that noise adds to a variance, whose bounds follow chi^2; None for other numbers."""
    power: int = 1
    """Power of the number that is such a variance: 2 for its root, -1 for a time that is 1 over it."""
    least: float = 0.0
    """Variance, with noise, below which such a number is not reported; its lower bound allows for this selection."""
    bias: float = 0.0
    """Largest error (95 %) that more values do not reduce, as of a time step; infinite if unknown."""
    ends: "tuple[float, float, float, float] | None" = None
    """Lower bounds of 95 and 68 %, then upper bounds of 68 and 95 %, if they come from draws and not from the error."""
    sample: str = ""
    """Part of the data that it describes, as "1 of 3 walkers"; "" for all data."""

    def __str__(self) -> str:
        text = self._format_number()
        return f"{text}; {self.sample}" if self.sample and self.value is not None else text

    def _format_number(self) -> str:
        """Format value, error and bounds; without a value, the reason."""
        unit = f" {UNIT_SYMBOLS.get(self.unit, self.unit)}".rstrip()
        if self.value is None:
            return self.refused or "none"
        if self.se is None:
            text = f"{self.value:.2f}{unit}, {self.refused or 'standard error unknown'}"
            return text if self.ends is None else f"{text}; 95 % of prints {self.low_95:.1f} to {self.high_95:.1f}"
        text = f"{formatting.format_with_error(self.value, self.se)}{unit}"
        ends = self.interval()
        if ends is None:
            return f"{text}, bounds unknown"
        error = min(self.se, 9.0)  # so that bounds have one decimal or more
        return f"{text}, with 95 % {' to '.join(formatting.format_to_error(error, ends))}"

    @property
    def known(self) -> bool:
        """Whether there are both a value and a standard error."""
        return self.value is not None and self.se is not None

    @property
    def number(self) -> float:
        """Value of a quantity that has one.

        Raises
        ------
        ValueError
            If there is no value.
        """
        if self.value is None:
            raise ValueError(f"{self.key}: {self.refused or 'no value'}")
        return self.value

    @property
    def pair(self) -> tuple[float, float]:
        """Value and standard error of a quantity that has both.

        Raises
        ------
        ValueError
            If the value or the error is missing.
        """
        if self.value is None or self.se is None:
            raise ValueError(f"{self.key}: {self.refused or 'no error'}")
        return self.value, self.se

    @property
    def column(self) -> str:
        """Name of the column of the value: the key, with the unit if there is one."""
        return f"{self.key}_{self.unit}" if self.unit else self.key

    def interval(self, confidence: float = CONFIDENCE) -> tuple[float, float] | None:
        """Return the bounds that contain the truth with a confidence; None unless both are finite.

        Parameters
        ----------
        confidence : float, default: 0.95
            Between 0 and 1. Draws have two pairs of bounds only: those of 95 % are returned for a confidence of at
            least 0.95, those of 68 % for a lower one.

        Returns
        -------
        tuple of float, or None
            Lower and upper bound. The bias is added in quadrature. For a confidence below 0.95, half of it is added.
        """
        if self.ends is not None and self.value is not None:
            return (self.ends[0], self.ends[3]) if confidence >= CONFIDENCE else self.ends[1:3]
        if self.value is None or self.se is None or math.isinf(self.bias):
            return None
        ends = self._bounds(self.value, self.se, confidence)
        return ends if all(map(math.isfinite, ends)) else None

    @property
    def low_95(self) -> float | None:
        """Lower bound of 95 %; None without bounds."""
        return (self.interval() or (None, None))[0]

    @property
    def high_95(self) -> float | None:
        """Upper bound of 95 %; None without bounds."""
        return (self.interval() or (None, None))[1]

    def _bounds(self, value: float, se: float, confidence: float) -> tuple[float, float]:
        """Return the bounds of a value with a standard error. They may be infinite or NaN."""
        if self.bias:
            half = self._replace(bias=0.0).half_width(confidence)
            wider = math.hypot(half, self.bias if confidence >= CONFIDENCE else 0.5 * self.bias)
            return value - wider, value + wider
        if se == 0.0 and self.noise is None:
            return value, value
        if self.noise is not None:
            with np.errstate(all="ignore"):
                return self._variance_bounds(value, self.noise, confidence)
        half = student_quantile(self.freedom, 0.5 + 0.5 * confidence) * se
        return value - half, value + half

    def row(self, *levels: int, stem: str | None = None) -> dict[str, float | None]:
        """Return value, standard error and bounds by the names of their columns.

        Parameters
        ----------
        *levels : int
            Confidences of bounds, percent.
        stem : str, optional
            Beginning of all names but the first; the key and an underscore by default.

        Returns
        -------
        dict of str to float or None
            The value, its standard error (se) and a low and a high bound for each level.
        """
        start, unit = f"{self.key}_" if stem is None else stem, f"_{self.unit}" if self.unit else ""
        found = {self.column: self.value, f"{start}se{unit}": self.se}
        for level in levels:
            low, high = self.interval(level / 100) or (None, None)
            found |= {f"{start}low_{level}{unit}": low, f"{start}high_{level}{unit}": high}
        return found

    def half_width(self, confidence: float = CONFIDENCE) -> float:
        """Return half of the width of the bounds.

        Parameters
        ----------
        confidence : float, default: 0.95
            Between 0 and 1.

        Returns
        -------
        float
            Half width in the unit of the quantity; infinite without bounds.
        """
        ends = self.interval(confidence)
        return math.inf if ends is None else 0.5 * (ends[1] - ends[0])

    def _variance_bounds(self, value: float, noise: float, confidence: float) -> tuple[float, float]:
        """Return the bounds of `value`, whose power `self.power` is a variance that was measured with added `noise`.

        The sum of variance and noise follows chi^2. If only large variances are reported (`self.least`), the lower
        bound is iterated to allow for this selection.
        """
        from scipy import special

        free, tail = self.freedom, 0.5 - 0.5 * confidence
        total = (value**self.power + noise) * free
        scales = [total / special.chdtri(free, tail), total / special.chdtri(free, 1.0 - tail)]
        if not np.isfinite(scales).all():  # hardly any freedom
            return math.nan, math.nan
        # Lower bound: the variance at which a reported value exceeds this one with the probability `tail`
        for _ in range(BOUND_ITERATIONS if self.least else 0):
            if scales[0] > noise:
                chance = special.chdtrc(free, self.least * free / scales[0])
                scales[0] = total / special.chdtri(free, tail * chance)
        ends = (max(scale - noise, 0.0) for scale in scales)
        low, high = sorted(end ** (1.0 / self.power) if end or self.power > 0 else math.inf for end in ends)
        return low, high

    def compare_with_range(self, low: float, high: float, confidence: float = CONFIDENCE) -> Verdict:
        """Compare the bounds of the quantity with a range.

        Parameters
        ----------
        low, high : float
            Ends of the range, which may be infinite.
        confidence : float, default: 0.95
            Confidence of the bounds.

        Returns
        -------
        Verdict
            AGREE if both bounds are inside, DISAGREE if the range and the bounds do not overlap, MISSING without a
            value, otherwise UNDECIDED.
        """
        if self.value is None:
            return Verdict.MISSING
        ends = self.interval(confidence)
        if ends is None:
            return Verdict.UNDECIDED
        if ends[1] < low or ends[0] > high:
            return Verdict.DISAGREE
        return Verdict.AGREE if low <= ends[0] and ends[1] <= high else Verdict.UNDECIDED

    def minus(self, other: "Quantity") -> "Quantity":
        """Return the difference of two independent quantities.

        Parameters
        ----------
        other : Quantity
            Quantity of the same unit to subtract.

        Returns
        -------
        Quantity
            Difference, under the key of this quantity.

        References
        ----------
        F. E. Satterthwaite, Biometrics Bulletin 2 (1946) 110: the degrees of freedom.
        """
        if self.value is None or other.value is None:
            return self._replace(value=None, se=None, refused=self.refused or other.refused or "no value")
        difference = self.value - other.value
        if self.se is None or other.se is None:
            return Quantity(self.key, self.unit, difference, None, refused=self.refused or other.refused)
        se = math.hypot(self.se, other.se)
        parts = self.se**4 / self.freedom + other.se**4 / other.freedom
        freedom, bias = se**4 / parts if parts > 0.0 else math.inf, math.hypot(self.bias, other.bias)
        return Quantity(self.key, self.unit, difference, se, freedom, bias=bias)


def column_values(row: Any, *levels: int) -> dict[str, Any]:
    """Return the fields of the named tuple `row` by name, each quantity as its columns with bounds of `levels` %."""
    found: dict[str, Any] = {}
    for name, value in row._asdict().items():
        found |= value.row(*levels) if isinstance(value, Quantity) else {name: value}
    return found


def mean(key: str, unit: str, values: "Sequence[float] | Array") -> Quantity:
    """Return the mean of independent values, shape (n,), with an error from their scatter if n > 1."""
    array = np.asarray(values, dtype=float)
    if len(array) == 0:
        return Quantity(key, unit, None, None, refused="no value")
    if len(array) == 1:
        return Quantity(key, unit, float(array[0]), None, refused="no error of one value")
    from walkergen.core.numerics import statistics  # most quantities come with their errors

    value, se, freedom = statistics.weighted_mean(array)
    return Quantity(key, unit, value, se, freedom)


def exact(key: str, unit: str, value: float) -> Quantity:
    """Return a quantity without error, such as a definition or the result of a formula."""
    return Quantity(key, unit, value, 0.0)
