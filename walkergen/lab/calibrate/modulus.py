"""Young's modulus from strips that sink under weights and ring, with all that is not known exactly.

One least-squares fit: the modulus is free; sizes, density and the softness of the roots may move
within their own errors, so that what strips share counts once and what differs averages out. The
sum of squares at its end, chi2, says whether the strips agree.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.analysis import beams
from walkergen.analysis.beams import Strip
from walkergen.errors import InputError
from walkergen.lab.calibrate.form import Reading
from walkergen.lab.calibrate.slips import Rough
from walkergen.lab.calibrate.specimens import BENDS, RINGS, SIZES, Specimen, only
from walkergen.scene import GRAVITY

Array = npt.NDArray[np.float64]

PA, GRAM = 1e9, 1e-3
"""Units inside over those outside: Pa in a GPa, g/mm^3 in a g/cm^3."""

OFFSET = "offset"
"""Name of a length that is added to all thicknesses, which a fit may leave free; as RINGS, by which
the ring has a modulus of its own."""

WEIGHT_SD, AT_SD_MM = 0.01, 0.5
"""Errors assumed of weights, relative, and of the places where they hang."""

DENSITY_SD = 0.03
"""Relative error of a density that was not measured."""

OTHERS = 4
"""Numbers that all strips share beside the modulus: density, root, clamp, air."""

SOFTEST, STIFFEST = 1e-3, 30.0
"""Moduli (GPa) of plastics, from soft elastomers to those filled with short fibres (Ashby,
Materials Selection in Mechanical Design, chart of modulus and density)."""

DISAGREES = 0.05
"""Probability of so large a chi2 below which strips disagree."""

LEFT_OPEN = 1e-7
"""Least singular value of the slopes, over the largest, below which readings leave numbers open."""

ROUNDS = 2
"""Number of fits, one after the other: errors that grow with a deflection are those of the fit
before."""


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


def fit(strips: Sequence[Specimen], density: Density) -> Fit:
    """Modulus of strips, of which at least one has readings.

    Raises InputError for a modulus that no plastic has.
    """
    solved = _solve(strips, density, ())
    if not SOFTEST <= solved.modulus <= STIFFEST:
        raise InputError(
            f"{', '.join(strip.name for strip in strips)}: the readings tell a modulus of "
            f"{solved.modulus:.3g} GPa: plastics have {SOFTEST:g}..{STIFFEST:g}: are these mm, g, "
            "s and Hz, and is a film's slow motion undone?"
        )
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
    by_method = []
    for strip in strips:
        for method in (BENDS, RINGS):
            for own in only([strip], method):
                alone = fit([own], density)
                count = sum(reading.tries for reading in (*own.bends, *own.rings))
                thickness = own.sizes["thickness_mm"]
                numbers = thickness.value, thickness.error, alone.modulus, alone.sd, count
                by_method.append(Point(strip.name, method, *numbers))
    return by_method


def ring_over_bend(strips: Sequence[Specimen], density: Density) -> Systematic | None:
    """Relative excess of the modulus by the ring over that by weights; None without both.

    Plastic that creeps while a weight hangs makes it positive.
    """
    if not (only(strips, BENDS) and only(strips, RINGS)):
        return None
    solved = _solve(strips, density, (RINGS,))
    excess = solved.extras[0]
    return _if_resolved(Systematic(math.expm1(excess), math.exp(excess) * solved.errors[1]), 1.0)


def _if_resolved(number: Systematic, most: float) -> Systematic | None:
    """Number whose error is at most `most`; None of one that the readings leave open."""
    return number if number.sd <= most else None


def offset(strips: Sequence[Specimen], density: Density) -> Systematic | None:
    """Length (mm) that, added to all thicknesses, makes strips agree best; None of a single one.

    A caliper measures over the ridges of layers, which stiffen little: that makes it negative. Ring
    and weights may tell different moduli. None too where the strips leave it open.
    """
    if len(strips) < 2:
        return None
    both = bool(only(strips, BENDS)) and bool(only(strips, RINGS))
    solved = _solve(strips, density, (OFFSET, RINGS) if both else (OFFSET,))
    thinnest = min(strip.sizes["thickness_mm"].value for strip in strips)
    return _if_resolved(Systematic(solved.extras[0], solved.errors[1]), thinnest)


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
    first[0] = math.log(np.median([single.modulus for single in rough(strips, density)]))
    spread: Array | None = None
    for _ in range(ROUNDS):
        at_last, errors = first, spread
        if errors is None:
            errors = _errors(strips, np.array([bend.value for strip in strips for bend in strip.bends]))

        def misses(at: Array, errors: Array = errors) -> Array:
            bends, rings = _model(strips, density, at, extras)
            heard = [ring for strip in strips for ring in strip.rings]
            seen = [bend.value for strip in strips for bend in strip.bends]
            return np.concatenate(
                [
                    (bends - np.array(seen)) / errors,
                    [(hz - ring.value) / ring.error for hz, ring in zip(rings, heard, strict=True)],
                    at[own:],
                ]
            )

        solution = least_squares(misses, at_last, x_scale="jac", xtol=1e-12, ftol=1e-12, gtol=1e-12)
        first = solution.x
        spread = _errors(strips, _model(strips, density, first, extras)[0])
    across = np.linalg.pinv(solution.jac)  # its product is the covariance
    errors = np.sqrt((across**2).sum(axis=1)[:own])
    if np.linalg.matrix_rank(solution.jac, rtol=LEFT_OPEN) < len(first):
        errors[1:] = math.inf
    return _Solved(
        float(math.exp(first[0])),
        [float(extra) for extra in first[1:own]],
        errors,
        float(2.0 * solution.cost),
        len(solution.fun),
        len(first),
    )


def rough(strips: Sequence[Specimen], density: Density) -> list[Rough]:
    """Modulus by each reading alone: forms grow as it, or as its root."""
    at = np.zeros(1 + OTHERS + 3 * len(strips))
    roughs = []
    for strip in strips:
        for bend in strip.bends:
            sizes = [strip.sizes[name].value for name in SIZES]
            stiff = bend.weight_g * GRAVITY * bend.at_mm**3 / (3.0 * bend.value)
            roughs.append(Rough(strip.name, BENDS, stiff / beams.stiffness(PA, Strip(*sizes))))
        heard = _model([strip._replace(bends=())], density, at, ())[1]
        roughs += [
            Rough(strip.name, RINGS, (ring.value / hertz) ** 2) for ring, hertz in zip(strip.rings, heard, strict=True)
        ]
    return roughs


def _errors(strips: Sequence[Specimen], sunk: Array) -> Array:
    """Errors of deflections, mm: of the readings, of the weights, of the places where they hang."""
    read = [bend for strip in strips for bend in strip.bends]
    reading = np.array([bend.error for bend in read])
    place = np.array([3.0 * AT_SD_MM / bend.at_mm for bend in read])
    errors: Array = np.sqrt(reading**2 + sunk**2 * (WEIGHT_SD**2 + place**2))
    return errors


def _model(strips: Sequence[Specimen], density: Density, at: Array, extras: Sequence[str]) -> tuple[Array, list[float]]:
    """Deflections (mm) and frequencies (Hz) of strips at a place of the search."""
    own = 1 + len(extras)
    slow = fast = PA * math.exp(at[0])
    free = dict(zip(extras, at[1:own], strict=True))
    fast *= math.exp(free.get(RINGS, 0.0))
    added = free.get(OFFSET, 0.0)
    heavy = GRAM * (density.value + density.sd * at[own])
    root = beams.ROOT + beams.ROOT_SD * at[own + 1]
    clamp = beams.CLAMP + beams.CLAMP_SD * at[own + 2]
    filled = [1.0 - specimen.air[0] - specimen.air[1] * at[own + 3] for specimen in strips]
    bends, rings = [], []
    for number, specimen in enumerate(strips):
        first = own + OTHERS + 3 * number
        moved = at[first : first + 3]
        sizes = [
            specimen.sizes[name].value + specimen.sizes[name].error * by for name, by in zip(SIZES, moved, strict=True)
        ]
        strip = Strip(max(sizes[0] + added, 1e-6), max(sizes[1], 1e-6), sizes[2])
        stiff = beams.stiffness(slow, strip)
        bends += [
            beams.sunk(bend.weight_g, beams.effective(bend.at_mm, strip, root, clamp), stiff) for bend in specimen.bends
        ]
        rings += [_rings(ring, strip, heavy * filled[number], fast, root, clamp) for ring in specimen.rings]
    return np.array(bends), rings


def _rings(ring: Reading, strip: Strip, heavy: float, modulus: float, root: float, clamp: float) -> float:
    """Frequency (Hz) of a strip, its root soft, what swings as long as it is.

    A search that strays to a strip without length or mass is kept at a small one.
    """
    length = max(beams.effective(strip.length, strip, root, clamp), strip.thickness)
    long = strip._replace(length=length)
    mass = beams.moving_mass(max(heavy, 1e-6), long)
    return beams.rings(beams.stiffness(modulus, strip), mass, long.length, ring.weight_g)
