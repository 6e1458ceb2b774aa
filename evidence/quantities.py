"""Ratios of quantities, and whether two quantities agree."""

import math

from walkergen.core.numerics.quantity import Quantity, Verdict


def ratio(above: Quantity, below: Quantity) -> Quantity:
    """Return the ratio of two independent quantities, the second not 0, with errors to first order."""
    if above.value is None or below.value is None:
        return Quantity(above.key, "", None, None, refused=above.refused or below.refused or "no value")
    quotient = above.value / below.value
    if above.se is None or below.se is None:
        return Quantity(above.key, "", quotient, None, refused=above.refused or below.refused)
    pairs = (above.se, below.se), (above.bias, below.bias)
    se, bias = (math.hypot(one, quotient * other) / abs(below.value) for one, other in pairs)
    return Quantity(above.key, "", quotient, se, bias=bias)


def compare(ours: Quantity, other: Quantity, margin: float = 0.0, allowed: float = 0.0) -> Verdict:
    """Compare a quantity with another. The range is the larger of `margin` times the other and `allowed` in the unit.

    They agree if the whole interval of the difference lies within the range, disagree if none of it does, and are
    undecided otherwise. A noisy number agrees less often, and without a range only numbers without errors agree.
    """
    room = max(margin * abs(other.value or 0.0), allowed)
    return ours.minus(other).compare_with_range(-room, room)
