"""Measured strips: sizes, deflections and frequencies, checked for typical mistakes.

Mistakes in units and times raise errors if the readings show them, or give a note with the ratio that they leave.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core import Quantity
from walkergen.core.errors import InputError
from walkergen.guests.lab import beams
from walkergen.guests.lab.calibrate.form import AIR_SHARE, Reading, Readings

SIZE_READINGS = ("thickness_mm", "width_mm", "free_length_mm")
BEND_METHOD, RING_METHOD = "deflection", "ring"
"""Methods that measure a strip's modulus."""

DEFAULT_AIR = Quantity("air", "", 0.0, 0.05)
"""Default share of air, and its error, in a strip."""

MAX_SIZE_ERROR, MIN_SLENDERNESS = 0.25, 10.0
"""Largest relative error of a size; smallest length of a strip over its thickness, so that it bends as a beam."""

MAX_METHOD_RATIO = 3.0
"""Ratio of the moduli from ring and weights that neither creep nor a soft clamp explains: a plastic's modulus differs
by tens of percent between a second and a hundredth of a second."""

MAX_READING_RATIO = 8.0
"""Ratio of the moduli from two readings of one method above which one reading is wrong: a thickness off by a factor of
2 gives 8."""

SLIP_TOLERANCE = 1.5
"""Largest factor between a ratio of moduli and the ratio that a typical mistake gives."""

TIME_SLIPS = {
    **{n**-2.0: f"1/{n}^2: are the times of a film in slow motion, {n} times too long?" for n in (2, 4, 8, 16, 32)},
    20.0**2: "20^2: are the times of one swing instead of 20?",
}
"""Typical mistakes of times, by the factor by which they change the modulus from the ring. Phones film 60 to 960
frames a second and play 30."""

WEIGHT_SLIPS = {1e-3: "1/1000: are the weights in kg instead of g?"}
"""Typical mistakes of weights, by the factor by which they change the modulus from weights."""


class Specimen(NamedTuple):
    """Strip with its readings."""

    name: str
    sizes: Mapping[str, Quantity]
    """Sizes named by SIZE_READINGS, mm."""
    bends: Sequence[Reading]
    rings: Sequence[Reading]
    """Frequencies, Hz; weight_g is the weight on the tip."""
    air: Quantity
    """Share of its cross-section that is air."""

    @property
    def tries(self) -> int:
        """Number of readings that give its modulus."""
        return sum(reading.tries for reading in (*self.bends, *self.rings))


def from_readings(readings: Readings) -> tuple[list[Specimen], list[str]]:
    """Return the strips that have sizes and give a modulus, and notes on strips without sizes. Raises InputError."""
    strips, notes = [], []
    for part in sorted(name for name in readings if name.startswith("strip_")):
        by_kind = readings[part]
        rings = [*by_kind.get("ring_hz", ()), *(_to_frequency(time) for time in by_kind.get("swings_20_s", ()))]
        bends = by_kind.get("deflection_mm", ())
        if not (rings or bends):
            continue
        missing = [name for name in SIZE_READINGS if name not in by_kind]
        if missing:
            notes.append(f"{part}: no {' and no '.join(missing)}: its modulus is not estimated")
            continue
        sizes = {name: by_kind[name][0].number for name in SIZE_READINGS}
        _check_sizes(part, sizes)
        for bend in bends:
            _check_bend(part, bend, sizes["free_length_mm"].pair[0])
        air = DEFAULT_AIR if AIR_SHARE not in by_kind else scale_quantity(by_kind[AIR_SHARE][0].number, scale=0.01)
        strips.append(Specimen(part, sizes, bends, rings, air))
    return strips, notes


def scale_quantity(number: Quantity, scale: float) -> Quantity:
    """Return a number and its error times a factor, as in another unit. Key and unit stay."""
    value, se = number.pair
    return number._replace(value=scale * value, se=scale * se)


def _to_frequency(time: Reading) -> Reading:
    """Return the reading of a time of 20 swings (s) as a reading of a frequency (Hz)."""
    seconds, se = time.number.pair
    hertz = 20.0 / seconds
    scale = hertz / seconds
    return time._replace(number=Quantity("ring", "hz", hertz, se * scale), stated=time.stated * scale)


def _check_sizes(part: str, sizes: Mapping[str, Quantity]) -> None:
    """Raise InputError for sizes with large errors, or if the strip is too short to bend as a beam."""
    for name, (size, error) in ((name, number.pair) for name, number in sizes.items()):
        if error > MAX_SIZE_ERROR * size:
            raise InputError(
                f"{part}: {name} = {size:.3g} ± {error:.2g}: its error must be at most {MAX_SIZE_ERROR:.0%} of it. "
                "Measure better, or leave the strip out"
            )
    thick, wide, long = (sizes[name].pair[0] for name in SIZE_READINGS)
    if long < MIN_SLENDERNESS * thick:
        raise InputError(
            f"{part}: free_length_mm = {long:g}: must be at least {MIN_SLENDERNESS:g} times the "
            f"thickness, {thick:.3g} mm, to bend as a beam"
        )
    if long < wide:
        raise InputError(
            f"{part}: free_length_mm = {long:g}: must be at least the width, {wide:.3g} mm. Wider strips bend as plates"
        )


def _check_bend(part: str, bend: Reading, length: float) -> None:
    """Raise InputError for a weight beyond the end of the strip, of this length (mm), or too large a deflection."""
    if bend.at_mm > length:
        raise InputError(f"{part}: at_mm = {bend.at_mm:g}: beyond the strip's free_length_mm = {length:g}")
    depth, _ = bend.number.pair
    if depth > beams.MAX_BEND * bend.at_mm:
        raise InputError(
            f"{part}: deflection_mm of {depth:.3g} under {bend.weight_g:g} g at "
            f"{bend.at_mm:g} mm: is {depth / bend.at_mm:.1%} of the length, and must be at most {beams.MAX_BEND:.0%}. "
            "Hang less weight, or hang it closer to the block"
        )


def select_method(strips: Sequence[Specimen], method: str) -> list[Specimen]:
    """Return the strips with the readings of one method alone. Strips without such readings are left out."""
    kept = [strip._replace(rings=()) if method == BEND_METHOD else strip._replace(bends=()) for strip in strips]
    return [strip for strip in kept if strip.bends or strip.rings]


class Rough(NamedTuple):
    """Modulus from one reading alone, without the corrections of the fit."""

    strip: str
    method: str
    modulus: float
    """GPa."""


def check_consistency(rough: Sequence[Rough]) -> None:
    """Raise InputError for readings that cannot belong to one plastic."""
    for method in (BEND_METHOD, RING_METHOD):
        own = sorted((single for single in rough if single.method == method), key=lambda single: single.modulus)
        if own and own[-1].modulus > MAX_READING_RATIO * own[0].modulus:
            raise InputError(
                f"{method}: {own[0].strip} gives a modulus of about {own[0].modulus:.2g} GPa, but "
                f"{own[-1].strip} gives {own[-1].modulus:.2g}. Readings of one plastic differ by less than a factor "
                f"of {MAX_READING_RATIO:g}. Is one in another unit, or of another strip?"
            )
    ring, bend = (median_modulus(rough, method) for method in (RING_METHOD, BEND_METHOD))
    if ring and bend and not 1.0 / MAX_METHOD_RATIO <= ring / bend <= MAX_METHOD_RATIO:
        slip = _describe_slip(ring / bend, TIME_SLIPS) or _describe_slip(bend / ring, WEIGHT_SLIPS)
        raise InputError(
            f"the ring gives a modulus of about {ring:.2g} GPa, but the weights give {bend:.2g}. For one plastic they "
            f"agree within a factor of {MAX_METHOD_RATIO:g}. Correct the readings, or leave one kind out{slip}"
        )


def median_modulus(rough: Sequence[Rough], method: str) -> float | None:
    """Return the median modulus (GPa) from the readings of one method; None without readings."""
    own = [single.modulus for single in rough if single.method == method]
    return float(np.median(own)) if own else None


def slip_notes(rough: Sequence[Rough], usual: float) -> list[str]:
    """Return a note if only one method was used and its modulus is off `usual` (GPa) by a typical mistake's factor."""
    ring, bend = (median_modulus(rough, method) for method in (RING_METHOD, BEND_METHOD))
    if ring and bend:
        return []
    alone = ring or bend or usual
    slip = _describe_slip(alone / usual, TIME_SLIPS if ring else WEIGHT_SLIPS)
    if not slip or 1.0 / MAX_METHOD_RATIO <= alone / usual <= MAX_METHOD_RATIO:
        return []
    return [f"a modulus of about {alone:.2g} GPa; the design has {usual:g}{slip}"]


def _describe_slip(ratio: float, slips: Mapping[float, str]) -> str:
    """Return a text on the mistake whose factor is near `ratio`, or "". `slips`: mistakes by their factors."""
    like = min(slips, key=lambda usual: abs(math.log(ratio / usual)))
    return f"; the ratio is near {slips[like]}" if 1 / SLIP_TOLERANCE <= ratio / like <= SLIP_TOLERANCE else ""
