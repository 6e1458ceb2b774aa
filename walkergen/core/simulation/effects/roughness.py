"""Plate roughness: bumps of the plate's surface, as a sum of plane waves of random directions.

Every run draws its own plate: `WAVE_COUNT` waves of one wavelength, with random directions and phases,
isotropic on average. Feet feel the height and, by the tilted normal, the slope, so that energy is
kept. Limit: no waves is the flat plate.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.core.errors import InputError
from walkergen.core.numerics.kernels import lean
from walkergen.core.simulation.effects.effect import Case, Effect, Rule, decide_from_key

NAME, SWITCH, KEY = "plate roughness", "plate_roughness", "plate.roughness_um"

WAVE_COUNT = 12
"""Number of waves: heights are normal within a few percent."""

MAX_RMS_SLOPE = 0.2
"""Largest rms slope at which the tilted normal is a small correction."""


class Roughness(NamedTuple):
    """Random bumps of the plate in one run."""

    waves: npt.NDArray[np.float64]
    """A wave a row, shape (WAVE_COUNT, 4): wave vector (1/mm, x and z), amplitude (mm), phase."""


OFF = Roughness(np.zeros((0, 4)))
"""A flat plate: no waves."""


def decide(case: Case) -> Effect:
    """Return the effect "plate roughness". Its number is the rms slope of the bumps."""
    plate = case.scene.plate
    slope = math.sqrt(2.0) * math.pi * 1e-3 * plate.roughness_um / plate.roughness_length_mm
    on, reason = decide_from_key(case, KEY, SWITCH)
    if on and slope > MAX_RMS_SLOPE:
        raise InputError(
            f"plate.roughness_um = {plate.roughness_um:g} on {plate.roughness_length_mm:g} mm: "
            f"root mean square slope of {slope:.2g}, at most {MAX_RMS_SLOPE:g}. Make bumps lower or longer"
        )
    return Effect(NAME, on, slope, "rms slope", reason, SWITCH)


RULE = Rule(decide, SWITCH, typical_values={KEY: 5.0})


def sample_surface(case: Case, rng: np.random.Generator) -> Roughness:
    """Draw the plate's surface for one run of the scene."""
    plate = case.scene.plate
    direction, phase = rng.uniform(0.0, 2.0 * math.pi, (2, WAVE_COUNT))
    k = 2.0 * math.pi / plate.roughness_length_mm
    size = np.full(WAVE_COUNT, 1e-3 * plate.roughness_um * math.sqrt(2.0 / WAVE_COUNT))
    return Roughness(np.column_stack([k * np.cos(direction), k * np.sin(direction), size, phase]))


@lean
def surface(roughness, x, z):
    """Return the height (mm) of the surface at (x, z), mm, and its slopes along x and z."""
    h, h_x, h_z = 0.0, 0.0, 0.0
    for i in range(len(roughness.waves)):
        k_x, k_z = roughness.waves[i, 0], roughness.waves[i, 1]
        size, phase = roughness.waves[i, 2], roughness.waves[i, 3]
        angle = k_x * x + k_z * z + phase
        h += size * math.sin(angle)
        slope = size * math.cos(angle)
        h_x += k_x * slope
        h_z += k_z * slope
    return h, h_x, h_z


@lean
def slope_bound(roughness):
    """Return an upper bound of the surface's slope: the sum of those of all waves."""
    total = 0.0
    for i in range(len(roughness.waves)):
        k_x, k_z, size = roughness.waves[i, 0], roughness.waves[i, 1], roughness.waves[i, 2]
        total += size * math.sqrt(k_x * k_x + k_z * k_z)
    return total
