"""A speed with its error, as predictions and simulations give it."""

import math
from typing import NamedTuple

from walkergen.analysis.estimates import Estimate, with_error


class Speed(NamedTuple):
    """Speed with its error, all in mm/s; NaN where runs leave a number unknown."""

    value: float
    se: float
    """Standard error of a simulated mean; of a prediction its standard deviation."""
    low_95: float
    """Bounds that hold the speed with 95 %."""
    high_95: float

    def __str__(self) -> str:
        if math.isnan(self.value):
            return "none"
        if math.isnan(self.se):
            return f"{self.value:.2f} mm/s, standard error unknown"
        found = f"{with_error(Estimate(self.value, self.se))} mm/s"
        if math.isnan(self.low_95) or math.isnan(self.high_95):
            return f"{found}, bounds unknown"
        return f"{found}, with 95 % {self.low_95:.1f} to {self.high_95:.1f}"


def speed_of(
    value: float | None, se: float | None, low_95: float | None, high_95: float | None
) -> Speed:
    """Speed of numbers of which None is unknown, all in mm/s."""
    four = (math.nan if one is None else float(one) for one in (value, se, low_95, high_95))
    return Speed(*four)
