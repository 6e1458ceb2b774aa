"""Contact, density and damping from readings: closed forms with their errors."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core import Quantity
from walkergen.core.errors import InputError
from walkergen.core.numerics import Array
from walkergen.core.scene import GRAVITY
from walkergen.guests.lab.beams import damping_ratio
from walkergen.guests.lab.calibrate import form, parts, slide_film
from walkergen.guests.lab.calibrate.estimate import Estimate, Single, weighted_mean
from walkergen.guests.lab.calibrate.fields import CalibrateFields
from walkergen.guests.lab.calibrate.form import Reading, Readings
from walkergen.guests.lab.calibrate.modulus import POSITION_SD_MM
from walkergen.guests.lab.inverse import Measured

SLIDING_PARTS = ("block", "walker")
"""Parts that slide."""

MIN_DENSITY_G_CM3, MAX_DENSITY_G_CM3 = 0.05, 25.0
"""Densities (g/cm^3) between foam and gold."""

DENSITY_READINGS = ("mass_g", "length_mm", "width_mm", "height_mm")
"""Readings of the block that a density needs."""


class Rebound(NamedTuple):
    """Rebound of a dropped walker: root of the height after the impact over the height before."""

    measured: Measured
    """Mean rebound, with the error of clock and ruler."""
    height: float
    """Mean height of the drops, mm."""
    spread: float
    """Standard deviation of the rebound from drop to drop, beyond the clock's error; 0 if not measurable."""

    @property
    def estimate(self) -> Estimate:
        """Mean rebound, with the errors of clock and ruler and the scatter of drops."""
        value, sd = self.measured.number.pair
        sd = math.hypot(sd, self.spread / math.sqrt(self.measured.tries))
        return Estimate("rebound of the walker", Quantity("rebound", "", value, sd), self.measured.tries)


def density(readings: Readings) -> Estimate | None:
    """Return the density of the block, g/cm^3; None without its mass or a size. Raises InputError if impossible."""
    block = readings.get("block", {})
    if any(name not in block for name in DENSITY_READINGS):
        return None
    needed = [block[name][0] for name in DENSITY_READINGS]
    (mass, *sizes), errors = zip(*(reading.number.pair for reading in needed), strict=True)
    volume = parts.block_volume(*sizes)
    value = 1e3 * mass / volume if volume > 0.0 else math.inf
    if not MIN_DENSITY_G_CM3 <= value <= MAX_DENSITY_G_CM3:
        raise InputError(
            f"block: mass and sizes give a density of {value:.3g} g/cm3. It must lie in "
            f"{MIN_DENSITY_G_CM3:g}..{MAX_DENSITY_G_CM3:g}. Are these grams and millimetres?"
        )
    sd = value * math.hypot(*(error / each for error, each in zip(errors, (mass, *sizes), strict=True)))
    number = Quantity("density", "g_cm3", value, sd)
    return Estimate("density", number, sum(reading.tries for reading in needed), sets=("material.density_g_cm3",))


def friction(readings: Readings) -> Estimate | None:
    """Return the friction from the angles at which block and walker slide, or from films; None without any."""
    singles = []
    for part in SLIDING_PARTS:
        for reading in readings.get(part, {}).get("slides_deg", ()):
            degrees, error = reading.number.pair
            tangent = math.tan(math.radians(degrees))
            number = Quantity("friction", "", tangent, (1.0 + tangent**2) * math.radians(error))
            singles.append(Single(part, number, reading.tries))
        for reading in readings.get(part, {}).get(form.FILMED_ANGLE, ()):
            assert reading.tracks is not None
            number = slide_film.friction(reading.tracks, *reading.number.pair)
            singles.append(Single(f"{part}'s film", number, reading.tries))
    return weighted_mean("friction", singles, ("scene.contact.friction", "scene.contact.friction_sd"))


def damping(readings: Readings) -> Estimate | None:
    """Return the damping ratio from the number of swings until the amplitude has halved. None without readings.

    It includes the damping by air and clamp. Strip and leg are of the same plastic.
    """
    singles = []
    for part in sorted(readings):
        for reading in readings[part].get("swings_to_half", ()):
            swings, error = reading.number.pair
            ratio = damping_ratio(math.log(2.0) / swings)
            singles.append(Single(part, Quantity("damping_ratio", "", ratio, ratio * error / swings), reading.tries))
    return weighted_mean("damping ratio", singles, ("scene.legs.damping_ratio", "scene.legs.damping_ratio_sd"))


def rebound(readings: Readings) -> Rebound | None:
    """Return the rebound of the walker, from its time in the air after the impact and the height. None without drops.

    After a fall by h it flies for t = 2 sqrt(2 h_2 / g), and sqrt(h_2 / h) is t sqrt(g / (8 h)).
    Raises InputError for a rebound above 1.
    """
    flights = readings.get("walker", {}).get("flight_s", ())
    if not flights:
        return None
    seconds, _ = np.array([flight.number.pair for flight in flights]).T
    heights = np.array([flight.at_mm for flight in flights])
    ratios = seconds * np.sqrt(GRAVITY / (8.0 * heights))
    for time, height, ratio in zip(seconds, heights, ratios, strict=True):
        if ratio > 1.0:
            raise InputError(
                f"walker: flight_s = {time:.3g} after a drop of {height:g} mm: it would rise to {ratio**2:.2f} times "
                "this height. Are these seconds, not of a film in slow motion, and millimetres?"
            )
    stated = np.array([flight.stated for flight in flights])
    errors = ratios * np.hypot(stated / seconds, 0.5 * POSITION_SD_MM / heights)
    tries = np.array([flight.tries for flight in flights])
    weight = tries / tries.sum()
    number = Quantity("rebound", "", float(weight @ ratios), float(np.hypot.reduce(weight * errors)))
    return Rebound(Measured(number, int(tries.sum())), float(weight @ heights), _drop_scatter(flights, seconds, ratios))


def stated_rebound(request: CalibrateFields) -> Rebound:
    """Return the rebound that a request states. Raises InputError without it or its error."""
    for name in ("measured", "measured_sd"):
        if getattr(request, name) is None:
            raise InputError(f"‹{name}› is missing. A drop needs its rebound, ‹measured›, and its error, ‹measured_sd›")
    number = Quantity("measured", "", request.measured, request.measured_sd)
    return Rebound(Measured(number, request.tries), request.height_mm, 0.0)


def _drop_scatter(flights: Sequence[Reading], seconds: Array, ratios: Array) -> float:
    """Return the sd of rebounds between drops beyond the clock's error. `seconds`, `ratios`: flights and rebounds."""
    tries, per_second = np.array([flight.tries for flight in flights]), ratios / seconds
    within = np.array([(flight.tries - 1) * (flight.scatter or 0.0) ** 2 for flight in flights])
    clock = np.array([flight.tries * flight.stated**2 for flight in flights]) * per_second**2
    dof = int(tries.sum()) - 1
    if not dof:
        return 0.0
    mean = tries @ ratios / tries.sum()
    squares = (within * per_second**2 + tries * (ratios - mean) ** 2).sum()
    return math.sqrt(max(squares / dof - tries @ clock / tries.sum(), 0.0))
