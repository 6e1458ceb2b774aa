"""Slips of pen and clock that readings of strips betray: refused, or named by their looks."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from walkergen.errors import InputError
from walkergen.lab.calibrate.specimens import BENDS, RINGS

APART = 3.0
"""Ratio of the moduli by ring and by weights beyond which neither creep nor a soft clamp explains
it: plastics differ by tens of percent between a second and a hundredth."""

ASTRAY = 8.0
"""Ratio of moduli by two readings of one method beyond which one is no modulus of that strip: a
thickness that is off by half."""

CLOSE = 1.5
"""Ratio within which a number looks like that of a slip."""

OF_TIMES = {
    **{n**-2.0: f"1/{n}^2: are the times of a film in slow motion, {n} times too long?" for n in (2, 4, 8, 16, 32)},
    20.0**2: "20^2: are the times of one swing instead of 20?",
}
"""Slips of times by the factor that they leave on the modulus by the ring. Phones film 60 to 960
frames a second and play 30."""

OF_WEIGHTS = {1e-3: "1/1000: are the weights in kg instead of g?"}
"""Slips of weights by the factor that they leave on the modulus by weights."""


class Rough(NamedTuple):
    """Modulus by one reading alone, without the corrections of the fit."""

    strip: str
    method: str
    modulus: float
    """GPa."""


def refuse(rough: Sequence[Rough]) -> None:
    """Raise InputError for readings of which some cannot be of one plastic."""
    for method in (BENDS, RINGS):
        own = sorted((single for single in rough if single.method == method), key=lambda single: single.modulus)
        if own and own[-1].modulus > ASTRAY * own[0].modulus:
            raise InputError(
                f"{method}: {own[0].strip} tells a modulus of about {own[0].modulus:.2g} GPa and "
                f"{own[-1].strip} one of {own[-1].modulus:.2g}: readings of one plastic differ by "
                f"less than {ASTRAY:g} times: is one in another unit, or of another strip?"
            )
    ring, bend = (middle(rough, method) for method in (RINGS, BENDS))
    if ring and bend and not 1.0 / APART <= ring / bend <= APART:
        slip = _slip(ring / bend, OF_TIMES) or _slip(bend / ring, OF_WEIGHTS)
        raise InputError(
            f"the ring tells a modulus of about {ring:.2g} GPa and the weights {bend:.2g}: one "
            f"plastic has both within {APART:g} times: correct the readings, or leave one kind out"
            f"{slip}"
        )


def middle(rough: Sequence[Rough], method: str) -> float | None:
    """Median modulus (GPa) by one method; None without readings."""
    own = [single.modulus for single in rough if single.method == method]
    return float(np.median(own)) if own else None


def notes(rough: Sequence[Rough], usual: float) -> list[str]:
    """Note on a modulus, known by one method alone, that differs from the usual one by a slip."""
    ring, bend = (middle(rough, method) for method in (RINGS, BENDS))
    if ring and bend:
        return []
    alone = ring or bend or usual
    slip = _slip(alone / usual, OF_TIMES if ring else OF_WEIGHTS)
    if not slip or 1.0 / APART <= alone / usual <= APART:
        return []
    return [f"a modulus of about {alone:.2g} GPa, where the design has {usual:g}{slip}"]


def _slip(ratio: float, slips: Mapping[float, str]) -> str:
    """Slip that leaves such a ratio, in words; "" for none."""
    like = min(slips, key=lambda usual: abs(math.log(ratio / usual)))
    return f"; the ratio is near {slips[like]}" if 1 / CLOSE <= ratio / like <= CLOSE else ""
