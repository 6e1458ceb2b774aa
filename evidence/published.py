"""Facts that the paper states, from published.toml, and their comparison with our numbers."""

import math
import tomllib
from pathlib import Path
from typing import NamedTuple

from walkergen.core.numerics.quantity import Quantity, Verdict


class Fact(NamedTuple):
    """Statement of the paper that a number can be compared with."""

    key: str
    figure: int
    quote: str
    where: str
    quantity: str
    """Name of the number that is compared with the statement."""
    unit: str
    value: float
    """Stated value; a bound where only one of `low` and `high` is finite."""
    low: float
    high: float
    """Upper end of the range from `low` that counts as agreement."""
    margin: str
    """Origin of `low` and `high`: "stated", or our reading of the words."""

    @property
    def bound(self) -> bool:
        """True when the paper states a limit, not a value."""
        return math.isinf(self.low) or math.isinf(self.high)

    @property
    def claim(self) -> str:
        """Stated value and margin in a few characters."""
        unit = f" {self.unit}" if self.unit else ""
        if math.isinf(self.low):
            return f"< {self.value:g}{unit}"
        if math.isinf(self.high):
            return f"> {self.value:g}{unit}"
        if math.isclose(self.high - self.value, self.value - self.low):
            return f"{self.value:g} ± {self.high - self.value:.3g}{unit}"
        return f"{self.value:g} ({self.low:.2g} to {self.high:.2g}){unit}"

    def verdict(self, ours: Quantity) -> Verdict:
        """Compare our number with the statement. They agree if all of the 95 % bounds are within the range."""
        return ours.compare_with_range(self.low, self.high)

    def distance(self, ours: Quantity) -> float | None:
        """Return the distance of our number from the stated value or bound."""
        if ours.value is None:
            return None
        if self.bound:
            return max(self.low - ours.value, ours.value - self.high, 0.0)
        return abs(ours.value - self.value)


def _read_facts() -> dict[str, Fact]:
    rows = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))["fact"]
    return {row["key"]: Fact(**row) for row in rows}


FACTS = _read_facts()
"""Facts by key, in the order of the paper."""
