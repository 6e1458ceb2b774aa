"""Young's modulus from strips that sink under weights and ring, with all that is not known exactly.

One least-squares fit: the modulus is free; sizes, density and the softness of the roots may move
within their own errors, so that what strips share counts once and what differs averages out. The
sum of squares at its end, chi2, says whether the strips agree.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.analysis import beams
from walkergen.analysis.beams import Strip
from walkergen.errors import InputError
from walkergen.jobs.calibration.form import AIR, Reading, Readings
from walkergen.scene import GRAVITY

Array = npt.NDArray[np.float64]

PA, GRAM = 1e9, 1e-3
"""Units inside over those outside: Pa in a GPa, g/mm^3 in a g/cm^3."""

SIZES = ("thickness_mm", "width_mm", "free_length_mm")
BENDS, RINGS = "deflection", "ring"
"""Methods by which a strip tells its modulus."""

METHODS = (BENDS, RINGS, "both")
"""Methods that may count."""

OFFSET = "offset"
"""What a fit may free beside: a length on all thicknesses; RINGS: a modulus of the ring's own."""

WEIGHT_SD, AT_SD_MM = 0.01, 0.5
"""Errors assumed of weights, relative, and of the places where they hang."""

DENSITY_SD = 0.03
"""Relative error of a density that was not measured."""

SOLID = (0.0, 0.05)
"""Share of air, and its error, in a strip of which nothing is said."""

OTHERS = 4
"""Numbers that all strips share beside the modulus: density, root, clamp, air."""

WORST, SHORTEST = 0.25, 10.0
"""Largest relative error of a size; least length of a strip over its thickness, for a beam."""

SOFTEST, STIFFEST = 1e-4, 1e3
"""Moduli (GPa) between gels and diamond: what is told beyond was written in other units."""

DISAGREES = 0.05
"""Probability of so large a chi2 below which strips disagree."""

ROUNDS = 2
"""Fits, of which each takes the errors that grow with a deflection from the one before."""


class Specimen(NamedTuple):
    """Strip with its readings."""

    name: str
    sizes: Mapping[str, Reading]
    bends: Sequence[Reading]
    rings: Sequence[Reading]
    """Frequencies, Hz; weight_g is what sits on the tip."""
    air: tuple[float, float]
    """Share of its outline that is air, and the error of that."""


class Density(NamedTuple):
    """Density of the strips, g/cm^3."""

    value: float
    sd: float


class Fit(NamedTuple):
    """Young's modulus that strips agree on, as well as they do."""

    modulus: float
    """GPa."""
    sd: float
    """Standard error, GPa; larger by the root of chi2 over dof where strips disagree."""
    chi2: float
    dof: int
    probability: float | None
    """Probability of so large a chi2 by chance; None without degrees of freedom."""

    @property
    def agrees(self) -> bool:
        """False where the strips disagree beyond their errors."""
        return self.probability is None or self.probability >= DISAGREES


class Point(NamedTuple):
    """Modulus by one strip and one method alone."""

    strip: str
    method: str
    thickness: float
    """mm."""
    thickness_sd: float
    modulus: float
    """GPa."""
    sd: float
    readings: int


class Systematic(NamedTuple):
    """Number that is 0 if all is as assumed, fitted beside the modulus."""

    value: float
    sd: float

    @property
    def seen(self) -> bool:
        """True when it differs from 0 by two errors."""
        return abs(self.value) > 2.0 * self.sd


def specimens(readings: Readings) -> tuple[list[Specimen], list[str]]:
    """Strips that tell a modulus, and notes on those that do not. Raises InputError."""
    found, notes = [], []
    for part in sorted(name for name in readings if name.startswith("strip_")):
        own = readings[part]
        rings = [
            *own.get("ring_hz", ()),
            *(_as_frequency(one) for one in own.get("swings_20_s", ())),
        ]
        bends = own.get("deflection_mm", ())
        if not (rings or bends):
            continue
        missing = [name for name in SIZES if name not in own]
        if missing:
            notes.append(f"{part}: no {' and no '.join(missing)}: its modulus is not estimated")
            continue
        sizes = {name: own[name][0] for name in SIZES}
        _check_sizes(part, sizes)
        for one in bends:
            _check(part, one, sizes["free_length_mm"].value)
        (air,) = own.get(AIR, [None])
        open_ = SOLID if air is None else (0.01 * air.value, 0.01 * air.error)
        found.append(Specimen(part, sizes, bends, rings, open_))
    return found, notes


def _as_frequency(one: Reading) -> Reading:
    """Frequency, Hz, of a time of 20 swings, s."""
    hertz = 20.0 / one.value
    scale = hertz / one.value
    return one._replace(value=hertz, error=one.error * scale, stated=one.stated * scale)


def _check_sizes(part: str, sizes: Mapping[str, Reading]) -> None:
    """Raise InputError for sizes that are hardly known, or no beam's."""
    for name, one in sizes.items():
        if one.error > WORST * one.value:
            raise InputError(
                f"{part}: {name} = {one.value:.3g} ± {one.error:.2g}: its error must be at most "
                f"{WORST:.0%} of it: measure better or leave the strip out"
            )
    thick, long = sizes["thickness_mm"].value, sizes["free_length_mm"].value
    if long < SHORTEST * thick:
        raise InputError(
            f"{part}: free_length_mm = {long:g}: must be at least {SHORTEST:g} times the "
            f"thickness, {thick:.3g} mm, to bend as a beam"
        )


def _check(part: str, one: Reading, length: float) -> None:
    """Raise InputError for a deflection that is no small bend of its strip."""
    if one.at_mm > length:
        raise InputError(
            f"{part}: at_mm = {one.at_mm:g}: beyond the strip's free_length_mm = {length:g}"
        )
    if one.value > beams.LARGEST_BEND * one.at_mm:
        raise InputError(
            f"{part}: deflection_mm of {one.value:.3g} under {one.weight_g:g} g at {one.at_mm:g} "
            f"mm: is {one.value / one.at_mm:.1%} of the length, at most {beams.LARGEST_BEND:.0%} "
            "counts as a bend: hang less, or nearer to the block"
        )


def only(strips: Sequence[Specimen], method: str) -> list[Specimen]:
    """Strips with the readings of one method alone; those without any are left out."""
    kept = [one._replace(rings=()) if method == BENDS else one._replace(bends=()) for one in strips]
    return [one for one in kept if one.bends or one.rings]


def fit(strips: Sequence[Specimen], density: Density) -> Fit:
    """Modulus of strips, of which at least one has readings."""
    solved = _solve(strips, density, ())
    dof = solved.residuals - solved.parameters
    probability = None
    sd = solved.modulus * solved.errors[0]
    if dof > 0:
        from scipy.stats import chi2

        probability = float(chi2.sf(solved.chi2, dof))
        if probability < DISAGREES:
            sd *= math.sqrt(max(solved.chi2 / dof, 1.0))
    return Fit(solved.modulus, sd, solved.chi2, dof, probability)


def points(strips: Sequence[Specimen], density: Density) -> list[Point]:
    """Modulus by each strip and each method alone, with the error of all that it rests on."""
    found = []
    for one in strips:
        for method in (BENDS, RINGS):
            for own in only([one], method):
                alone = fit([own], density)
                count = sum(reading.tries for reading in (*own.bends, *own.rings))
                thickness = own.sizes["thickness_mm"]
                found.append(
                    Point(
                        one.name,
                        method,
                        thickness.value,
                        thickness.error,
                        alone.modulus,
                        alone.sd,
                        count,
                    )
                )
    return found


def ring_over_bend(strips: Sequence[Specimen], density: Density) -> Systematic | None:
    """Relative excess of the modulus by the ring over that by weights; None without both.

    Plastic that creeps while a weight hangs makes it positive.
    """
    if not (only(strips, BENDS) and only(strips, RINGS)):
        return None
    solved = _solve(strips, density, (RINGS,))
    excess = solved.extras[0]
    return Systematic(math.expm1(excess), math.exp(excess) * solved.errors[1])


def offset(strips: Sequence[Specimen], density: Density) -> Systematic | None:
    """Length (mm) that, added to all thicknesses, makes strips agree best; None of a single one.

    A caliper rides on the ridges of layers, which bend no less: that makes it negative. Ring and
    weights may tell different moduli.
    """
    if len(strips) < 2:
        return None
    both = bool(only(strips, BENDS)) and bool(only(strips, RINGS))
    solved = _solve(strips, density, (OFFSET, RINGS) if both else (OFFSET,))
    return Systematic(solved.extras[0], solved.errors[1])


class _Solved(NamedTuple):
    """Minimum of the sum of squares."""

    modulus: float
    """GPa."""
    extras: Sequence[float]
    """Values of what else is free."""
    errors: Array
    """Standard errors of the modulus' logarithm and of what else is free."""
    chi2: float
    residuals: int
    parameters: int


def _solve(strips: Sequence[Specimen], density: Density, extras: Sequence[str]) -> _Solved:
    """Fit the modulus, and `extras` of RINGS (excess of its logarithm there) and OFFSET (mm).

    Beside these every size, the density, root, clamp and air are free, in units of their errors.
    """
    from scipy.optimize import least_squares

    own = 1 + len(extras)
    first = np.zeros(own + OTHERS + 3 * len(strips))
    first[0] = math.log(_guess(strips, density))
    spread: Array | None = None
    for _ in range(ROUNDS):
        at_last, errors = first, spread
        if errors is None:
            errors = _errors(strips, np.array([one.value for each in strips for one in each.bends]))

        def misses(at: Array, errors: Array = errors) -> Array:
            bends, rings = _model(strips, density, at, extras)
            heard = [one for each in strips for one in each.rings]
            seen = [one.value for each in strips for one in each.bends]
            return np.concatenate([
                (bends - np.array(seen)) / errors,
                [(hz - one.value) / one.error for hz, one in zip(rings, heard, strict=True)],
                at[own:],
            ])  # fmt: skip

        found = least_squares(misses, at_last, x_scale="jac", xtol=1e-12, ftol=1e-12, gtol=1e-12)
        first = found.x
        spread = _errors(strips, _model(strips, density, first, extras)[0])
    across = np.linalg.pinv(found.jac)  # its product is the covariance
    if not SOFTEST <= math.exp(first[0]) <= STIFFEST:
        raise InputError(
            f"{', '.join(one.name for one in strips)}: the readings tell a modulus of "
            f"{math.exp(first[0]):.3g} GPa: must lie in {SOFTEST:g}..{STIFFEST:g}: are these mm, "
            "g, s and Hz?"
        )
    return _Solved(
        float(math.exp(first[0])), [float(one) for one in first[1:own]],
        np.sqrt((across**2).sum(axis=1)[:own]), float(2.0 * found.cost), len(found.fun), len(first),
    )  # fmt: skip


def _guess(strips: Sequence[Specimen], density: Density) -> float:
    """Modulus (GPa) by a typical reading alone: forms grow as it, or as its root."""
    at = np.zeros(1 + OTHERS + 3 * len(strips))
    found = []
    for one in strips:
        for bend in one.bends:
            sizes = [one.sizes[name].value for name in SIZES]
            stiff = bend.weight_g * GRAVITY * bend.at_mm**3 / (3.0 * bend.value)
            found.append(stiff / beams.stiffness(PA, Strip(*sizes)))
        heard = _model([one._replace(bends=())], density, at, ())[1]
        found += [(ring.value / hertz) ** 2 for ring, hertz in zip(one.rings, heard, strict=True)]
    return float(np.median(found))


def _errors(strips: Sequence[Specimen], sunk: Array) -> Array:
    """Errors of deflections, mm: of the readings, of the weights, of the places where they hang."""
    read = [one for each in strips for one in each.bends]
    reading = np.array([one.error for one in read])
    place = np.array([3.0 * AT_SD_MM / one.at_mm for one in read])
    found: Array = np.sqrt(reading**2 + sunk**2 * (WEIGHT_SD**2 + place**2))
    return found


def _model(
    strips: Sequence[Specimen], density: Density, at: Array, extras: Sequence[str]
) -> tuple[Array, list[float]]:
    """Deflections (mm) and frequencies (Hz) of strips at a place of the search."""
    own = 1 + len(extras)
    slow = fast = PA * math.exp(at[0])
    free = dict(zip(extras, at[1:own], strict=True))
    fast *= math.exp(free.get(RINGS, 0.0))
    added = free.get(OFFSET, 0.0)
    heavy = GRAM * (density.value + density.sd * at[own])
    root = beams.ROOT + beams.ROOT_SD * at[own + 1]
    clamp = beams.CLAMP + beams.CLAMP_SD * at[own + 2]
    filled = [1.0 - one.air[0] - one.air[1] * at[own + 3] for one in strips]
    bends, rings = [], []
    for number, one in enumerate(strips):
        first = own + OTHERS + 3 * number
        moved = at[first : first + 3]
        sizes = [one.sizes[name].value + one.sizes[name].error * by
                 for name, by in zip(SIZES, moved, strict=True)]  # fmt: skip
        strip = Strip(max(sizes[0] + added, 1e-6), max(sizes[1], 1e-6), sizes[2])
        stiff = beams.stiffness(slow, strip)
        bends += [
            beams.sunk(bend.weight_g, beams.effective(bend.at_mm, strip, root, clamp), stiff)
            for bend in one.bends
        ]
        rings += [
            _rings(ring, strip, heavy * filled[number], fast, root, clamp) for ring in one.rings
        ]
    return np.array(bends), rings


def _rings(
    ring: Reading, strip: Strip, heavy: float, modulus: float, root: float, clamp: float
) -> float:
    """Frequency (Hz) of a strip, its root soft, what swings as long as it is."""
    long = strip._replace(length=beams.effective(strip.length, strip, root, clamp))
    mass = beams.moving_mass(heavy, long)
    return beams.rings(beams.stiffness(modulus, strip), mass, long.length, ring.weight_g)
