"""Estimates: numbers from readings, how well the readings agree, and the keys that they set."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core import Quantity

MIN_PROBABILITY = 0.05
"""Probability of so large a chi2 below which readings disagree."""

DIGITS = 6
"""Significant digits of a value in a file; further digits are rounding."""

UNIT_LABELS = {"gpa": "GPa", "g_cm3": "g/cm3", "percent": "%"}
"""Displayed units, by the units in keys."""


class Estimate(NamedTuple):
    """Number from readings, with its standard error (larger if the readings disagree), and the keys that it sets."""

    name: str
    number: Quantity
    readings: int = 0
    chi2: float = 0.0
    """Sum of squares of the readings about their common value, over their errors."""
    dof: int = 0
    sets: tuple[str, ...] = ()
    """Keys of design or scene (the latter begin with scene.) that the number and its error set."""
    parts: tuple[str, ...] = ()
    """Parts whose numbers were averaged, such as block and walker."""

    @property
    def probability(self) -> float | None:
        """Probability of so large a chi2 by chance; None without degrees of freedom."""
        from scipy import special

        return float(special.chdtrc(self.dof, self.chi2)) if self.dof > 0 else None

    @property
    def agrees(self) -> bool:
        """False where the readings disagree beyond their errors."""
        return self.probability is None or self.probability >= MIN_PROBABILITY

    @property
    def settings(self) -> dict[str, float]:
        """Values of number and error by the keys in `sets`."""
        return {key: float(f"{value:.{DIGITS}g}") for key, value in zip(self.sets, self.number.pair, strict=False)}

    @property
    def row(self) -> tuple[str, float, float, str, int, float, int, str]:
        """Row of calibration.csv: name, value, error, unit, readings, chi2, degrees of freedom, key."""
        unit = UNIT_LABELS.get(self.number.unit, self.number.unit)
        key = self.sets[0] if self.sets else ""
        return (self.name, *self.number.pair, unit, self.readings, self.chi2, self.dof, key)


class Single(NamedTuple):
    """Number from the readings of one part alone."""

    part: str
    number: Quantity
    tries: int


def weighted_mean(name: str, singles: Sequence[Single], sets: tuple[str, ...]) -> Estimate | None:
    """Return the mean of single numbers, weighted by their inverse variances, or None without any.

    Where they disagree its error grows by the root of chi2 over the degrees of freedom (Birge). `sets`: keys of design
    and scene for value and error.
    """
    if not singles:
        return None
    values, errors = np.array([single.number.pair for single in singles]).T
    weights = errors**-2
    value = float(weights @ values / weights.sum())
    chi2, dof = float((((values - value) / errors) ** 2).sum()), len(singles) - 1
    se = float(weights.sum() ** -0.5) * math.sqrt(max(1.0, chi2 / max(dof, 1)))
    number = singles[0].number._replace(value=value, se=se)
    parts = tuple(single.part for single in singles)
    return Estimate(name, number, sum(single.tries for single in singles), chi2, dof, sets, parts)
