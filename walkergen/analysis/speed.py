"""A speed with its error, as predictions and simulations give it."""

import math
from typing import NamedTuple

from walkergen.files import words


class Speed(NamedTuple):
    """Speed with its error, all in mm/s; NaN where runs leave a number unknown."""

    value: float
    se: float
    """Standard error of a simulated mean; of a prediction its standard deviation."""
    low_95: float
    """Bounds that hold the speed with 95 %; that of another print, where runs share an orbit."""
    high_95: float
    orbit: str = ""
    """Name of what all runs end on, so that they tell no error: one periodic orbit, or at rest."""

    def __str__(self) -> str:
        if math.isnan(self.value):
            return "none"
        if self.orbit:
            return f"{self.value:.2f} mm/s, {self.orbit}{self._of_prints()}"
        if math.isnan(self.se):
            return f"{self.value:.2f} mm/s, standard error unknown"
        found = f"{words.with_error(self.value, self.se)} mm/s"
        if math.isnan(self.low_95) or math.isnan(self.high_95):
            return f"{found}, bounds unknown"
        return f"{found}, with 95 % {self.low_95:.1f} to {self.high_95:.1f}"

    def _of_prints(self) -> str:
        """Bounds of prints in words; "" where they are unknown."""
        if math.isnan(self.low_95):
            return ""
        return f"; 95 % of prints {self.low_95:.1f} to {self.high_95:.1f}"


def speed_of(
    value: float | None, se: float | None, low_95: float | None, high_95: float | None,
    orbit: str = "",
) -> Speed:  # fmt: skip
    """Speed of numbers of which None is unknown, all in mm/s."""
    four = [math.nan if one is None else float(one) for one in (value, se, low_95, high_95)]
    return Speed(four[0], four[1], four[2], four[3], orbit)
