"""Claims: a prediction of walkergen beside what is known of it from outside, and the verdict."""

import math
from collections.abc import Callable, Iterator
from typing import Literal, NamedTuple

from walkergen.jobs.trust.published import TIMES, Fact, judge

Bound = Literal["", "<", ">"]
Word = Literal["agree", "undecided", "disagree", "fitted", "not run"]

VERDICTS: dict[Word, str] = {
    "agree": "within the distance allowed",
    "undecided": "within it, but the errors reach beyond what the paper's statement allows",
    "disagree": "outside it, with what we take for the reason",
    "fitted": "within it, by a number that was chosen for it: no test",
    "not run": "what it needs is not installed here: nothing is claimed",
}


class Claim(NamedTuple):
    """Prediction of walkergen beside a number from outside."""

    group: str
    quantity: str
    unit: str
    ours: float | None
    """Number of walkergen; None where it was not made."""
    ours_se: float | None
    """Standard error of it; None for a number without chance."""
    theirs: float | None
    theirs_se: float | None
    margin: float
    """Distance that is allowed whatever the errors: a tolerance, or the reading of a statement."""
    margin_reason: str
    source: str
    why: str
    """Reason why the two differ; of an agreement, what it does not show."""
    bound: Bound = ""
    """Side on which the statement puts our number: "<" below `theirs`, ">" above it."""
    fitted: bool = False
    """True where a number of walkergen was chosen so that the two agree."""
    fact: Fact | None = None
    """Statement of the paper that it is about: `published.judge` says how the two relate."""
    missing: str = ""
    """Reason why the claim was not put to the test; "" when it was."""

    @property
    def gap(self) -> float | None:
        """Ours less theirs; 0 on the side of a bound where ours belongs."""
        if self.ours is None or self.theirs is None:
            return None
        gap = self.ours - self.theirs
        return max(gap, 0.0) if self.bound == "<" else min(gap, 0.0) if self.bound == ">" else gap

    @property
    def error(self) -> float:
        """Standard error of the gap; 0 without errors."""
        return math.hypot(self.ours_se or 0.0, self.theirs_se or 0.0)

    @property
    def z(self) -> float | None:
        """Gap over its standard error; None without one, or on the right side of a bound."""
        if not self.gap and (self.bound or self.gap is None):
            return None
        return self.gap / self.error if self.error and self.gap is not None else None

    @property
    def allowed(self) -> float:
        """Largest gap that agrees."""
        return self.margin + TIMES * self.error

    @property
    def gap_over_allowed(self) -> float | None:
        """Within -1..1 where the two agree; infinite for no finite gap."""
        if self.gap is None:
            return None
        if not math.isfinite(self.gap):
            return math.inf
        if self.gap == 0.0:
            return 0.0
        return self.gap / self.allowed if self.allowed else math.copysign(math.inf, self.gap)

    @property
    def verdict(self) -> Word:
        """Word on the claim."""
        if self.gap_over_allowed is None:
            return "not run"
        if not abs(self.gap_over_allowed) <= 1.0:
            return "disagree"
        if self.fitted:
            return "fitted"
        sure = self.fact is None or judge(self.fact, self.ours, self.ours_se or 0.0).agrees
        return "agree" if sure else "undecided"


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


def exact(
    group: str,
    quantity: str,
    unit: str,
    ours: float,
    theirs: float,
    within: float,
    reason: str,
    source: str,
    why: str = "",
) -> Claim:
    """Claim on a number without chance, which may be off by the share `within` of `theirs`."""
    margin = within * abs(theirs)
    return Claim(group, quantity, unit, ours, None, theirs, None, margin, reason, source, why)


def missing(group: str, quantity: str, unit: str, source: str, reason: str) -> Claim:
    """Claim that was not put to the test, for a reason."""
    return Claim(group, quantity, unit, None, None, None, None, 0.0, "", source, "", missing=reason)
