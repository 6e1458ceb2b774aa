"""Quantities beside others: ratios, and whether two agree."""

import math

from walkergen.core.numerics.quantity import Quantity, Verdict


def ratio(above: Quantity, below: Quantity) -> Quantity:
    """Ratio of two independent quantities, the second not 0, without a unit; errors to first order."""
    if above.value is None or below.value is None:
        return Quantity(above.key, "", None, None, refused=above.refused or below.refused or "no value")
    quotient = above.value / below.value
    if above.se is None or below.se is None:
        return Quantity(above.key, "", quotient, None, refused=above.refused or below.refused)
    pairs = (above.se, below.se), (above.bias, below.bias)
    se, bias = (math.hypot(one, quotient * other) / abs(below.value) for one, other in pairs)
    return Quantity(above.key, "", quotient, se, bias=bias)


def compare(ours: Quantity, other: Quantity, margin: float = 0.0, allowed: float = 0.0) -> Verdict:
    """How a quantity stands beside another: their difference within `margin` of the other, or `allowed` in the unit.

    The larger of both counts. It says agree when the whole interval of the difference lies within
    what is allowed, disagree when none of it does, undecided in between: the noisier a number, the
    less it agrees. So without a margin only numbers without errors agree.
    """
    room = max(margin * abs(other.value or 0.0), allowed)
    return ours.minus(other).compare_with_range(-room, room)
