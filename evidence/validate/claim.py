"""Claims: a prediction of walkergen compared with an outside result, and the verdict."""

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

from walkergen.core.numerics.quantity import Quantity, Verdict
from walkergen.core.numerics.quantity import exact as number

FITTED = "fitted"

VERDICT_MEANINGS = {
    Verdict.AGREE.value: "the whole interval lies within the margin",
    Verdict.UNDECIDED.value: "the interval crosses an end of the margin",
    Verdict.DISAGREE.value: "the interval lies outside the margin; a letter gives our reason",
    FITTED: "not outside the margin, but a number was chosen for it, so this is no test",
    Verdict.MISSING.value: "a program is not installed, so nothing is claimed",
}
"""Words on claims, in the order of the page, and what they mean."""

TITLE = "Predictions of walkergen compared with outside results"

TITLES = {
    "paper": "What the paper states",
    "closed": "Closed forms of mechanics",
    "bouncing": "Bouncing balls and rocking blocks, published",
    "rivals": "Physics engines",
    "programs": "Programs that do part of the work",
}
"""Titles of the groups."""


class Claim(NamedTuple):
    """Prediction of walkergen compared with a number from outside."""

    quantity: str
    ours: Quantity
    """Number of walkergen; without a value where it was not made, with the reason."""
    theirs: Quantity
    below: float
    """Allowed distance of ours below theirs, apart from errors; infinite where a bound is stated."""
    above: float
    margin_reason: str
    source: str
    why: str = ""
    """Reason why the two differ; of an agreement, what it does not show."""
    fitted: bool = False
    """True where a number of walkergen was chosen so that the two agree."""
    group: str = ""

    @property
    def missing(self) -> str:
        """Reason why the claim was not put to the test; "" when it was."""
        return self.ours.refused if self.ours.value is None else ""

    @property
    def bound(self) -> str:
        """Side on which the statement puts our number: "<" below `theirs`, ">" above it, "" at it."""
        return "<" if math.isinf(self.below) else ">" if math.isinf(self.above) else ""

    @property
    def margin(self) -> float:
        """Distance that is allowed, of a bound on its wrong side."""
        return self.above if self.bound == "<" else self.below if self.bound == ">" else max(self.below, self.above)

    @property
    def difference(self) -> Quantity:
        """Ours less theirs, with its error."""
        return self.ours.minus(self.theirs)

    @property
    def gap(self) -> float | None:
        """Ours less theirs; 0 on the side of a bound where ours belongs."""
        gap = self.difference.value
        if gap is None:
            return None
        return max(gap, 0.0) if self.bound == "<" else min(gap, 0.0) if self.bound == ">" else gap

    @property
    def z(self) -> float | None:
        """Gap over its standard error; None without one, or on the right side of a bound."""
        error = self.difference.se
        return self.gap / error if error and self.gap is not None and (self.gap or not self.bound) else None

    @property
    def gap_over_allowed(self) -> float | None:
        """Gap over the margin and half of the bounds of 95 %: beyond -1..1 where the two disagree."""
        if self.gap is None:
            return None
        if not math.isfinite(self.gap):
            return math.inf
        low, high = self.difference.interval() or (0.0, 0.0)
        allowed = (self.above if self.gap > 0.0 else self.below) + 0.5 * (high - low)
        return 0.0 if self.gap == 0.0 else self.gap / allowed if allowed else math.copysign(math.inf, self.gap)

    @property
    def verdict(self) -> Verdict:
        """Verdict by the one rule; what is no number disagrees."""
        if self.ours.value is not None and not math.isfinite(self.ours.value):
            return Verdict.DISAGREE
        return self.difference.compare_with_range(-self.below, self.above)

    @property
    def word(self) -> str:
        """Verdict, one of WORDS: what was fitted is no test unless it disagrees."""
        return FITTED if self.fitted and self.verdict is not Verdict.DISAGREE else self.verdict.value


class Effort(NamedTuple):
    """Amount of simulation behind the statistical claims."""

    quick: bool = False

    @property
    def seconds(self) -> float:
        """Measured time of a run, s."""
        return 1.0 if self.quick else 4.0

    @property
    def runs(self) -> int:
        """Number of runs of an ensemble."""
        return 4 if self.quick else 8


Test = Callable[[Effort], Iterator[Claim]]
"""Function that makes claims at an effort: a row each."""


class Outside(NamedTuple):
    """Where numbers from outside come from, and how close to them ours shall be."""

    source: str
    share: float = 0.0
    """Allowed deviation of ours, as a share of theirs."""
    reason: str = ""
    why: str = ""

    def claim(self, quantity: str, unit: str, ours: float, theirs: float) -> Claim:
        """Claim on a number without chance."""
        return self.compare(quantity, number("", unit, ours), number("", unit, theirs))

    def compare(self, quantity: str, ours: Quantity, theirs: Quantity) -> Claim:
        """Claim on a number with its error."""
        margin = self.share * abs(theirs.value or 0.0)
        return Claim(quantity, ours, theirs, margin, margin, self.reason, self.source, self.why)

    def missing(self, quantity: str, unit: str, reason: str) -> Claim:
        """Claim that was not put to the test, for a reason."""
        none = Quantity("", unit, None, refused=reason)
        return Claim(quantity, none, none, 0.0, 0.0, "", self.source)
