"""Young's modulus from strips that sink under weights and ring, with all uncertain inputs.

One least-squares fit: the modulus is free; sizes, density and the softness of the roots may move within their own
errors. So shared errors count once and independent ones average out. The final sum of squares, chi2, shows whether the
strips agree.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core import Quantity
from walkergen.core.errors import InputError
from walkergen.core.numerics import Array
from walkergen.core.scene import GRAVITY
from walkergen.guests.lab import beams
from walkergen.guests.lab.beams import Strip
from walkergen.guests.lab.calibrate.estimate import Estimate
from walkergen.guests.lab.calibrate.specimens import (
    BEND_METHOD,
    RING_METHOD,
    SIZE_READINGS,
    Rough,
    Specimen,
    select_method,
)

PA_PER_GPA, G_MM3_PER_G_CM3 = 1e9, 1e-3
"""Factors from the units of files to those of the code: Pa in a GPa, g/mm^3 in a g/cm^3."""

OFFSET_NAME = "offset"
"""Name of a length that is added to all thicknesses, as a free parameter of a fit. A free RING_METHOD gives the ring
its own modulus."""

WEIGHT_SD, POSITION_SD_MM = 0.01, 0.5
"""Assumed relative error of weights, and error of the positions where they hang."""

DENSITY_SD = 0.03
"""Relative error of a density that was not measured."""

SHARED_PARAMETERS = 4
"""Numbers shared by all strips in addition to the modulus: density, root, clamp, air."""

MIN_MODULUS_GPA, MAX_MODULUS_GPA = 1e-3, 30.0
"""Moduli (GPa) of plastics, from soft elastomers to those filled with short fibres (Ashby,
Materials Selection in Mechanical Design, chart of modulus and density)."""

MIN_SINGULAR_RATIO = 1e-7
"""Singular value of the Jacobian, over the largest one, below which readings do not determine all parameters."""

FIT_ROUNDS = 2
"""Number of successive fits: errors that grow with a deflection come from the fit before."""


class Point(NamedTuple):
    """Modulus from one strip and one method alone."""

    strip: str
    method: str
    thickness: Quantity
    """mm."""
    modulus: Quantity
    """GPa."""
    readings: int


class Moduli(NamedTuple):
    """Young's modulus: fitted to all strips, of each strip, and two checks (`ring_excess` and `thickness_offset`)."""

    fit: Estimate
    """Young's modulus fitted to all strips, GPa."""
    points: Sequence[Point]
    by: str
    """Method of `fit`: BEND_METHOD, RING_METHOD or "both"."""
    ring_over_bend: Quantity | None
    offset: Quantity | None

    @property
    def estimates(self) -> list[Estimate]:
        """Estimates of the modulus and of its two checks, which are 0 if methods and strips agree."""
        named = (("ring over weights", self.ring_over_bend), ("offset of thicknesses", self.offset))
        return [self.fit, *(Estimate(name, number) for name, number in named if number is not None)]


def fit(strips: Sequence[Specimen], density: Quantity) -> Estimate:
    """Return the modulus fitted to all strips, at least one of them with readings. `density`: of the strips, g/cm^3.

    Where strips disagree, the error grows by the root of chi2 over dof. Raises InputError for a modulus outside the
    range of plastics.
    """
    (number,), chi2, dof = _solve(strips, density, ())
    if not MIN_MODULUS_GPA <= number.number <= MAX_MODULUS_GPA:
        raise InputError(
            f"{', '.join(strip.name for strip in strips)}: the readings give a modulus of "
            f"{number.number:.3g} GPa: plastics have {MIN_MODULUS_GPA:g}..{MAX_MODULUS_GPA:g}. Are these mm, g, "
            "s and Hz? Did you correct for a film's slow motion?"
        )
    sets = ("material.youngs_modulus_gpa", "material.youngs_modulus_sd_gpa")
    readings = sum(strip.tries for strip in strips)
    agreed = Estimate("Young's modulus", number, readings, chi2, dof, sets)
    if agreed.agrees:
        return agreed
    return agreed._replace(number=number._replace(se=number.pair[1] * math.sqrt(max(agreed.chi2 / agreed.dof, 1.0))))


def fit_each_strip(strips: Sequence[Specimen], density: Quantity) -> list[Point]:
    """Return the modulus fitted to each strip and each method alone. Errors include errors that strips share."""
    by_method = []
    for strip in strips:
        for method in (BEND_METHOD, RING_METHOD):
            for part in select_method([strip], method):
                alone = fit([part], density)
                by_method.append(Point(strip.name, method, part.sizes["thickness_mm"], alone.number, alone.readings))
    return by_method


def ring_excess(strips: Sequence[Specimen], density: Quantity) -> Quantity | None:
    """Compute the excess, in percent, of the modulus from ringing strips over that from strips under weights.

    Plastic that creeps while a weight hangs makes it positive. None unless readings of both methods determine it.
    """
    if not (select_method(strips, BEND_METHOD) and select_method(strips, RING_METHOD)):
        return None
    (_, log_ratio), _, _ = _solve(strips, density, (RING_METHOD,))
    excess, error = log_ratio.pair
    sd = math.exp(excess) * error
    return Quantity("ring_over_weights", "percent", 100.0 * math.expm1(excess), 100.0 * sd) if sd <= 1.0 else None


def thickness_offset(strips: Sequence[Specimen], density: Quantity) -> Quantity | None:
    """Compute the length (mm), added to all thicknesses, that makes strips agree best.

    A caliper measures over the ridges of layers, which stiffen little: that makes it negative. Ring and weights may
    have different moduli. None for a single strip, and where the strips do not determine it.
    """
    if len(strips) < 2:
        return None
    both = bool(select_method(strips, BEND_METHOD)) and bool(select_method(strips, RING_METHOD))
    (_, offset, *_), _, _ = _solve(strips, density, (OFFSET_NAME, RING_METHOD) if both else (OFFSET_NAME,))
    value, sd = offset.pair
    thinnest = min(strip.sizes["thickness_mm"].pair[0] for strip in strips)
    return Quantity("offset", "mm", value, sd) if sd <= thinnest else None


def _solve(strips: Sequence[Specimen], density: Quantity, extras: Sequence[str]) -> tuple[list[Quantity], float, int]:
    """Fit the modulus, and the numbers named in `extras`, to all readings of the strips.

    RING_METHOD is the logarithm of the ring's modulus over that of the weights, OFFSET_NAME a length (mm) on every
    thickness. Returns modulus and extras with errors, chi2, and its degrees of freedom. All sizes, the density, root,
    clamp and air are free too, in units of their errors.
    """
    from scipy.optimize import least_squares

    count = 1 + len(extras)
    parameters = np.zeros(count + SHARED_PARAMETERS + 3 * len(strips))
    parameters[0] = math.log(np.median([single.modulus for single in rough_moduli(strips, density)]))
    deflections = np.array([bend.number.pair[0] for strip in strips for bend in strip.bends])
    tones = np.array([ring.number.pair for strip in strips for ring in strip.rings]).reshape(-1, 2)
    sd = _deflection_errors(strips, deflections)
    for _ in range(FIT_ROUNDS):

        def residuals(parameters: Array, sd: Array = sd) -> Array:
            """Return residuals over errors of deflections and frequencies, then all deviations of uncertain inputs."""
            bends, rings = _predict_readings(strips, density, parameters, extras)
            return np.concatenate([(bends - deflections) / sd, (rings - tones[:, 0]) / tones[:, 1], parameters[count:]])

        solution = least_squares(residuals, parameters, x_scale="jac", xtol=1e-12, ftol=1e-12, gtol=1e-12)
        parameters = solution.x
        sd = _deflection_errors(strips, _predict_readings(strips, density, parameters, extras)[0])
    inverse = np.linalg.pinv(solution.jac)  # its product is the covariance
    errors = np.sqrt((inverse**2).sum(axis=1)[:count])
    if np.linalg.matrix_rank(solution.jac, rtol=MIN_SINGULAR_RATIO) < len(parameters):
        errors[1:] = math.inf
    modulus = math.exp(parameters[0])
    numbers = [Quantity("youngs_modulus", "gpa", modulus, modulus * float(errors[0]))]
    for name, value, error in zip(extras, parameters[1:count], errors[1:], strict=True):
        numbers.append(Quantity(name, "", float(value), float(error)))
    return numbers, float(2.0 * solution.cost), len(solution.fun) - len(parameters)


def rough_moduli(strips: Sequence[Specimen], density: Quantity) -> list[Rough]:
    """Return the modulus (GPa) from each reading alone, without the corrections of the fit."""
    parameters = np.zeros(1 + SHARED_PARAMETERS + 3 * len(strips))
    roughs = []
    for strip in strips:
        for bend in strip.bends:
            sizes = [strip.sizes[name].pair[0] for name in SIZE_READINGS]
            bending = bend.weight_g * GRAVITY * bend.at_mm**3 / (3.0 * bend.number.pair[0])
            roughs.append(Rough(strip.name, BEND_METHOD, bending / beams.bending_stiffness(PA_PER_GPA, Strip(*sizes))))
        frequencies = _predict_readings([strip._replace(bends=())], density, parameters, ())[1]
        roughs += [
            Rough(strip.name, RING_METHOD, (ring.number.pair[0] / hertz) ** 2)
            for ring, hertz in zip(strip.rings, frequencies, strict=True)
        ]
    return roughs


def _deflection_errors(strips: Sequence[Specimen], deflections: Array) -> Array:
    """Return the errors (mm) of deflections, shape (n,), due to the readings, the weights and their positions."""
    bends = [bend for strip in strips for bend in strip.bends]
    reading = np.array([bend.number.pair[1] for bend in bends])
    position = np.array([3.0 * POSITION_SD_MM / bend.at_mm for bend in bends])
    errors: Array = np.sqrt(reading**2 + deflections**2 * (WEIGHT_SD**2 + position**2))
    return errors


def _predict_readings(
    strips: Sequence[Specimen], density: Quantity, parameters: Array, extras: Sequence[str]
) -> tuple[Array, Array]:
    """Return deflections (mm) and frequencies (Hz) of strips, one for each reading.

    `parameters`: logarithm of the modulus (GPa), values of `extras` (see `_solve`), deviations of density, root, clamp
    and air, and of each strip's sizes. Deviations are in standard errors.
    """

    def perturb(number: Quantity, errors: float) -> float:
        """Return the number plus so many standard errors."""
        value, sd = number.pair
        return value + sd * errors

    count = 1 + len(extras)
    extra_values = dict(zip(extras, parameters[1:count], strict=True))
    static_modulus = PA_PER_GPA * math.exp(parameters[0])
    ring_modulus = static_modulus * math.exp(extra_values.get(RING_METHOD, 0.0))
    solid_density = G_MM3_PER_G_CM3 * perturb(density, parameters[count])
    root = beams.ROOT_FACTOR + beams.ROOT_FACTOR_SD * parameters[count + 1]
    clamp = beams.CLAMP_FACTOR + beams.CLAMP_FACTOR_SD * parameters[count + 2]
    bends, rings = [], []
    for number, specimen in enumerate(strips):
        first = count + SHARED_PARAMETERS + 3 * number
        sizes = [perturb(specimen.sizes[name], parameters[first + index]) for index, name in enumerate(SIZE_READINGS)]
        strip = Strip(max(sizes[0] + extra_values.get(OFFSET_NAME, 0.0), 1e-6), max(sizes[1], 1e-6), sizes[2])
        stiff = beams.bending_stiffness(static_modulus, strip)
        bends += [
            beams.deflection(bend.weight_g, beams.effective_length(bend.at_mm, strip, root, clamp), stiff)
            for bend in specimen.bends
        ]
        # A search that strays to a strip without length or mass is kept at a small one
        long = strip._replace(length=max(beams.effective_length(strip.length, strip, root, clamp), strip.thickness))
        air, air_sd = specimen.air.pair
        mass = beams.moving_mass(max(solid_density * (1.0 - air - air_sd * parameters[count + 3]), 1e-6), long)
        stiff = beams.bending_stiffness(ring_modulus, strip)
        rings += [beams.natural_frequency(stiff, mass, long.length, ring.weight_g) for ring in specimen.rings]
    return np.array(bends), np.array(rings)
