"""Contact, density and damping from readings: each a closed form with its error."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.analysis.beams import damping_ratio
from walkergen.analysis.inverse import Measured
from walkergen.errors import InputError
from walkergen.lab.calibrate import filmed, form, parts
from walkergen.lab.calibrate.form import Reading, Readings
from walkergen.lab.calibrate.modulus import AT_SD_MM
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


class _Single(NamedTuple):
    """Value by one part's readings alone."""

    part: str
    value: float
    error: float
    tries: int


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
    volume = parts.block_volume(*(size.value for size in sizes))
    density_g_cm3 = 1e3 * mass.value / volume if volume > 0.0 else math.inf
    if not LIGHTEST <= density_g_cm3 <= HEAVIEST:
        raise InputError(
            f"block: mass and sizes tell a density of {density_g_cm3:.3g} g/cm3: must lie in "
            f"{LIGHTEST:g}..{HEAVIEST:g}: are these grams and millimetres?"
        )
    sd = density_g_cm3 * math.hypot(*(reading.error / reading.value for reading in (mass, *sizes)))
    return Value(density_g_cm3, sd, sum(reading.tries for reading in (mass, *sizes)), ("block",), 0.0)


def missing_of_density(readings: Readings) -> list[str]:
    """Quantities that a density lacks; none where all or none are there."""
    own = readings.get("block", {})
    needed = ("mass_g", "length_mm", "width_mm", "height_mm")
    absent = [name for name in needed if name not in own]
    return absent if len(absent) < len(needed) else []


def friction(readings: Readings) -> Value | None:
    """Friction, tan of the angle at which block and walker slide, or by films of slides.

    None without any.
    """
    singles = []
    for part in CARRIERS:
        for reading in readings.get(part, {}).get("slides_deg", ()):
            angle = math.radians(reading.value)
            slope = 1.0 + math.tan(angle) ** 2
            error = slope * math.radians(reading.error)
            singles.append(_Single(part, math.tan(angle), error, reading.tries))
        for reading in readings.get(part, {}).get(form.FILMED, ()):
            assert reading.tracks is not None
            seen = filmed.friction(reading.tracks, reading.value, reading.error)
            singles.append(_Single(f"{part}'s film", *seen, reading.tries))
    return _mean(singles)


def damping(readings: Readings) -> Value | None:
    """Damping ratio from the swings after which half of the way is left; None without any.

    Air and clamp take their part, and a strip's plastic is that of a leg.
    """
    singles = []
    for part in sorted(readings):
        for reading in readings[part].get("swings_to_half", ()):
            ratio = damping_ratio(math.log(2.0) / reading.value)
            error = ratio * reading.error / reading.value
            singles.append(_Single(part, ratio, error, reading.tries))
    return _mean(singles)


def rebound(readings: Readings) -> Rebound | None:
    """Rebound of the walker, from the time to its second landing and the height; None without any.

    After a fall by h it flies for t = 2 sqrt(2 h_2 / g), and sqrt(h_2 / h) is t sqrt(g / (8 h)).
    Raises InputError for one above 1.
    """
    flights = readings.get("walker", {}).get("flight_s", ())
    if not flights:
        return None
    ratios = np.array([flight.value * math.sqrt(GRAVITY / (8.0 * flight.at_mm)) for flight in flights])
    for flight, ratio in zip(flights, ratios, strict=True):
        if ratio > 1.0:
            raise InputError(
                f"walker: flight_s = {flight.value:.3g} after a drop of {flight.at_mm:g} mm: it "
                f"would come up {ratio**2:.2f} times as high: are these seconds, not of a film in "
                "slow motion, and millimetres?"
            )
    errors = np.array(
        [
            ratio * math.hypot(flight.stated / flight.value, 0.5 * AT_SD_MM / flight.at_mm)
            for flight, ratio in zip(flights, ratios, strict=True)
        ]
    )
    tries = np.array([flight.tries for flight in flights])
    shares = tries / tries.sum()
    heights = np.array([flight.at_mm for flight in flights])
    sd = float(np.hypot.reduce(shares * errors))
    measured = Measured(float(shares @ ratios), sd, int(tries.sum()))
    return Rebound(measured, float(shares @ heights), _spread(flights, ratios))


def _spread(flights: Sequence[Reading], ratios: np.ndarray) -> float:
    """Standard deviation from drop to drop, from whatever height, beyond that of the clock."""
    tries = np.array([flight.tries for flight in flights])
    per_second = ratios / np.array([flight.value for flight in flights])
    within = np.array([(flight.tries - 1) * (flight.scatter or 0.0) ** 2 for flight in flights])
    clock = np.array([flight.tries * flight.stated**2 for flight in flights]) * per_second**2
    freedoms = int(tries.sum()) - 1
    if not freedoms:
        return 0.0
    middle = tries @ ratios / tries.sum()
    squares = (within * per_second**2 + tries * (ratios - middle) ** 2).sum()
    return math.sqrt(max(squares / freedoms - tries @ clock / tries.sum(), 0.0))


def _mean(singles: Sequence[_Single]) -> Value | None:
    """Mean of single values, weighted by their errors; None without any.

    Where they disagree its error grows by the root of chi2 over the degrees of freedom (Birge).
    """
    if not singles:
        return None
    values = np.array([single.value for single in singles])
    errors = np.array([single.error for single in singles])
    weights = errors**-2
    mean = float(weights @ values / weights.sum())
    chi2 = float((((values - mean) / errors) ** 2).sum())
    sd = float(weights.sum() ** -0.5) * math.sqrt(max(1.0, chi2 / max(len(singles) - 1, 1)))
    carriers = tuple(single.part for single in singles)
    return Value(mean, sd, sum(single.tries for single in singles), carriers, chi2)
