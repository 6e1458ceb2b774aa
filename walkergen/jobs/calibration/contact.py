"""Contact, density and damping from readings: each a closed form with its error."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.analysis.beams import damping_ratio
from walkergen.analysis.inverse import Measured
from walkergen.errors import InputError
from walkergen.jobs.calibration import parts
from walkergen.jobs.calibration.form import Reading, Readings
from walkergen.jobs.calibration.modulus import AT_SD_MM
from walkergen.scene import GRAVITY

CARRIERS = ("block", "walker")
"""Parts that slide."""

LIGHTEST, HEAVIEST = 0.05, 25.0
"""Densities (g/cm^3) between foam and gold."""


class Value(NamedTuple):
    """Number with its standard error, and what it is the mean of."""

    value: float
    sd: float
    readings: int
    parts: tuple[str, ...]
    chi2: float
    """Sum of squares of the parts about their mean, over their errors."""

    @property
    def agrees(self) -> bool:
        """False where parts disagree by more than two errors, and `sd` is larger by that."""
        return self.chi2 <= 4.0 * max(len(self.parts) - 1, 1)


class Rebound(NamedTuple):
    """Rebound of a dropped walker."""

    measured: Measured
    """Mean, with the error of clock and ruler."""
    height: float
    """Height of the drop, mm; the mean, where there were several."""
    spread: float
    """Standard deviation from drop to drop beyond that of the clock; 0 where none is seen."""

    @property
    def sd(self) -> float:
        """Standard error of the mean, of clock, ruler and what differs from drop to drop."""
        return math.hypot(self.measured.sd, self.spread / math.sqrt(self.measured.tries))


def density(readings: Readings) -> Value | None:
    """Density of the block, g/cm^3; None where its mass or a size is missing."""
    own = readings.get("block", {})
    needed = ("mass_g", "length_mm", "width_mm", "height_mm")
    if any(name not in own for name in needed):
        return None
    mass, *sizes = (own[name][0] for name in needed)
    volume = parts.block_volume(*(one.value for one in sizes))
    found = 1e3 * mass.value / volume if volume > 0.0 else math.inf
    if not LIGHTEST <= found <= HEAVIEST:
        raise InputError(
            f"block: mass and sizes tell a density of {found:.3g} g/cm3: must lie in "
            f"{LIGHTEST:g}..{HEAVIEST:g}: are these grams and millimetres?"
        )
    sd = found * math.hypot(*(one.error / one.value for one in (mass, *sizes)))
    return Value(found, sd, sum(one.tries for one in (mass, *sizes)), ("block",), 0.0)


def missing_of_density(readings: Readings) -> list[str]:
    """Quantities that a density lacks; none where all or none are there."""
    own = readings.get("block", {})
    needed = ("mass_g", "length_mm", "width_mm", "height_mm")
    absent = [name for name in needed if name not in own]
    return absent if len(absent) < len(needed) else []


def friction(readings: Readings) -> Value | None:
    """Friction, tan of the angle at which block and walker slide; None without any."""
    found = []
    for part in CARRIERS:
        for one in readings.get(part, {}).get("slides_deg", ()):
            angle = math.radians(one.value)
            slope = 1.0 + math.tan(angle) ** 2
            found.append((part, math.tan(angle), slope * math.radians(one.error), one.tries))
    return _mean(found)


def damping(readings: Readings) -> Value | None:
    """Damping ratio from the swings after which half of the way is left; None without any.

    Air and clamp take their part, and a strip's plastic is that of a leg.
    """
    found = []
    for part in sorted(readings):
        for one in readings[part].get("swings_to_half", ()):
            ratio = damping_ratio(math.log(2.0) / one.value)
            found.append((part, ratio, ratio * one.error / one.value, one.tries))
    return _mean(found)


def rebound(readings: Readings) -> Rebound | None:
    """Rebound of the walker, from the time to its second landing and the height; None without any.

    After a fall by h it flies for t = 2 sqrt(2 h_2 / g), and sqrt(h_2 / h) is t sqrt(g / (8 h)).
    Raises InputError for one above 1.
    """
    found = readings.get("walker", {}).get("flight_s", ())
    if not found:
        return None
    ratios = np.array([one.value * math.sqrt(GRAVITY / (8.0 * one.at_mm)) for one in found])
    for one, ratio in zip(found, ratios, strict=True):
        if ratio > 1.0:
            raise InputError(
                f"walker: flight_s = {one.value:.3g} after a drop of {one.at_mm:g} mm: it would "
                f"come up {ratio**2:.2f} times as high: are these seconds, not of a film in slow "
                "motion, and millimetres?"
            )
    errors = np.array([
        ratio * math.hypot(one.stated / one.value, 0.5 * AT_SD_MM / one.at_mm)
        for one, ratio in zip(found, ratios, strict=True)
    ])  # fmt: skip
    tries = np.array([one.tries for one in found])
    shares = tries / tries.sum()
    heights = np.array([one.at_mm for one in found])
    sd = float(np.hypot.reduce(shares * errors))
    measured = Measured(float(shares @ ratios), sd, int(tries.sum()))
    return Rebound(measured, float(shares @ heights), _spread(found, ratios))


def _spread(found: Sequence[Reading], ratios: np.ndarray) -> float:
    """Standard deviation from drop to drop, from whatever height, beyond that of the clock."""
    tries = np.array([one.tries for one in found])
    per_second = ratios / np.array([one.value for one in found])
    within = np.array([(one.tries - 1) * (one.scatter or 0.0) ** 2 for one in found])
    clock = np.array([one.tries * one.stated**2 for one in found]) * per_second**2
    freedoms = int(tries.sum()) - 1
    if not freedoms:
        return 0.0
    middle = tries @ ratios / tries.sum()
    squares = (within * per_second**2 + tries * (ratios - middle) ** 2).sum()
    return math.sqrt(max(squares / freedoms - tries @ clock / tries.sum(), 0.0))


def _mean(found: Sequence[tuple[str, float, float, int]]) -> Value | None:
    """Mean of (part, value, error, readings), weighted; None without any.

    Where they disagree its error grows by the root of chi2 over the degrees of freedom (Birge).
    """
    if not found:
        return None
    values, errors = (np.array([one[place] for one in found]) for place in (1, 2))
    weights = errors**-2
    mean = float(weights @ values / weights.sum())
    chi2 = float((((values - mean) / errors) ** 2).sum())
    sd = float(weights.sum() ** -0.5) * math.sqrt(max(1.0, chi2 / max(len(found) - 1, 1)))
    return Value(mean, sd, sum(one[3] for one in found), tuple(one[0] for one in found), chi2)
