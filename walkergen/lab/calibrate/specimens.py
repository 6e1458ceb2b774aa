"""Strips as they were measured: sizes, deflections, frequencies, checked to be those of a beam."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from walkergen.analysis import beams
from walkergen.errors import InputError
from walkergen.lab.calibrate.form import AIR, Reading, Readings

SIZES = ("thickness_mm", "width_mm", "free_length_mm")
BENDS, RINGS = "deflection", "ring"
"""Methods by which a strip tells its modulus."""

METHODS = (BENDS, RINGS, "both")
"""Methods that may count."""

SOLID = (0.0, 0.05)
"""Share of air, and its error, in a strip of which nothing is said."""

WORST, SHORTEST = 0.25, 10.0
"""Largest relative error of a size; least length of a strip over its thickness, for a beam."""


class Specimen(NamedTuple):
    """Strip with its readings."""

    name: str
    sizes: Mapping[str, Reading]
    bends: Sequence[Reading]
    rings: Sequence[Reading]
    """Frequencies, Hz; weight_g is what sits on the tip."""
    air: tuple[float, float]
    """Share of its outline that is air, and the error of that."""


def read(readings: Readings) -> tuple[list[Specimen], list[str]]:
    """Strips that tell a modulus, and notes on those that do not. Raises InputError."""
    strips, notes = [], []
    for part in sorted(name for name in readings if name.startswith("strip_")):
        own = readings[part]
        rings = [*own.get("ring_hz", ()), *(_as_frequency(time) for time in own.get("swings_20_s", ()))]
        bends = own.get("deflection_mm", ())
        if not (rings or bends):
            continue
        missing = [name for name in SIZES if name not in own]
        if missing:
            notes.append(f"{part}: no {' and no '.join(missing)}: its modulus is not estimated")
            continue
        sizes = {name: own[name][0] for name in SIZES}
        _check_sizes(part, sizes)
        for bend in bends:
            _check(part, bend, sizes["free_length_mm"].value)
        (air,) = own.get(AIR, [None])
        open_ = SOLID if air is None else (0.01 * air.value, 0.01 * air.error)
        strips.append(Specimen(part, sizes, bends, rings, open_))
    return strips, notes


def _as_frequency(time: Reading) -> Reading:
    """Frequency, Hz, of a time of 20 swings, s."""
    hertz = 20.0 / time.value
    scale = hertz / time.value
    return time._replace(value=hertz, error=time.error * scale, stated=time.stated * scale)


def _check_sizes(part: str, sizes: Mapping[str, Reading]) -> None:
    """Raise InputError for sizes that are hardly known, or no beam's."""
    for name, size in sizes.items():
        if size.error > WORST * size.value:
            raise InputError(
                f"{part}: {name} = {size.value:.3g} ± {size.error:.2g}: its error must be at most "
                f"{WORST:.0%} of it: measure better or leave the strip out"
            )
    thick, wide, long = (sizes[name].value for name in SIZES)
    if long < SHORTEST * thick:
        raise InputError(
            f"{part}: free_length_mm = {long:g}: must be at least {SHORTEST:g} times the "
            f"thickness, {thick:.3g} mm, to bend as a beam"
        )
    if long < wide:
        raise InputError(
            f"{part}: free_length_mm = {long:g}: must be at least the width, {wide:.3g} mm: wider ones bend as plates"
        )


def _check(part: str, bend: Reading, length: float) -> None:
    """Raise InputError for a deflection that is no small bend of its strip."""
    if bend.at_mm > length:
        raise InputError(f"{part}: at_mm = {bend.at_mm:g}: beyond the strip's free_length_mm = {length:g}")
    if bend.value > beams.LARGEST_BEND * bend.at_mm:
        raise InputError(
            f"{part}: deflection_mm of {bend.value:.3g} under {bend.weight_g:g} g at "
            f"{bend.at_mm:g} mm: is {bend.value / bend.at_mm:.1%} of the length, at most "
            f"{beams.LARGEST_BEND:.0%} counts as a bend: hang less, or nearer to the block"
        )


def only(strips: Sequence[Specimen], method: str) -> list[Specimen]:
    """Strips with the readings of one method alone; those without any are left out."""
    kept = [strip._replace(rings=()) if method == BENDS else strip._replace(bends=()) for strip in strips]
    return [strip for strip in kept if strip.bends or strip.rings]
