"""Beams clamped at one end: their deflection under a weight, and their ringing frequency.

The Euler-Bernoulli beam, extended for a printed strip on a block: large bends, the softness of its root, the stiffness
of a strip that is wide at its clamp, the air that it moves, and a mass on its tip. mm, g, s; moduli in Pa = g/(mm s^2).
"""

import math
from typing import NamedTuple

from walkergen.core.scene import GRAVITY

FIRST_MODE = 1.875104068711961**2
"""Square of the first root of cos x cosh x = -1: a cantilever's first mode."""

ROOT_FACTOR, ROOT_FACTOR_SD = 0.42, 0.1
"""Length that a root in a block of its own material adds to a beam, over its thickness. Plane elements, which the
tests repeat, give 0.42 for blocks 5 to 20 times as thick, held at back or sides; a half-space 16.67 / (12 pi) = 0.44
(O'Donnell, J. Appl. Mech. 27, 461, 1960). The deviation is for hands that hold a block."""

CLAMP_FACTOR, CLAMP_FACTOR_SD = 0.05, 0.02
"""Apparent shortening of a strip at its clamp, over its width. There the strip cannot curve across, and is stiffer by
1 / (1 - nu^2). Ritz's method for a clamped plate with a loaded end, widths of 0.05 to 0.4 of its length, gives 0.033,
0.050, 0.068 at nu = 0.30, 0.36, 0.42."""

AIR_DENSITY = 1.2e-6
"""Density of air, g/mm^3."""

MAX_BEND = 0.2
"""Largest depth over length for `deflection` to hold within 0.2 %."""

BEND_STIFFENS = 4.0 / 35.0
"""Second order of the elastica under a weight that stays vertical: depth over length is
a / 3 (1 - 4 a^2 / 35 + ...), a = weight times length^2 over bending stiffness."""


class Strip(NamedTuple):
    """Sizes of a strip that sticks out of a block, as printed, not as drawn; mm."""

    thickness: float
    width: float
    length: float
    """Free length, from the block to the end."""


def effective_length(
    length: float, strip: Strip, root_factor: float = ROOT_FACTOR, clamp_factor: float = CLAMP_FACTOR
) -> float:
    """Return the length (mm) of a beam with a rigid root that bends as much as a real strip of this `length` (mm).

    `root_factor`: length that a soft root adds, over the thickness. `clamp_factor`: length that the clamp takes off,
    over the width.
    """
    return length + root_factor * strip.thickness - clamp_factor * strip.width


def bending_stiffness(modulus: float, strip: Strip) -> float:
    """Return the bending stiffness E I of a strip, g mm^3/s^2, from the modulus in Pa."""
    return modulus * strip.width * strip.thickness**3 / 12.0


def deflection(load: float, length: float, stiffness: float) -> float:
    """Compute the deflection (mm) under a weight of `load` (g) at `length` (mm) from a rigid root.

    `stiffness`: E I, g mm^3/s^2. Valid up to MAX_BEND of the length.
    """
    bend = load * GRAVITY * length**2 / stiffness
    return length * bend / (3.0 * (1.0 + BEND_STIFFENS * bend * bend))


def natural_frequency(stiffness: float, mass: float, length: float, tip_mass: float = 0.0) -> float:
    """Return a beam's first natural frequency (Hz). `stiffness`: E I, g mm^3/s^2. Masses in g, length in mm."""
    mode = first_mode(tip_mass / mass)
    return mode * math.sqrt(stiffness / (mass * length**3)) / (2.0 * math.pi)


def moving_mass(density: float, strip: Strip) -> float:
    """Compute the moving mass (g) of a strip with a density (g/mm^3): the strip and the air around it.

    Air adds pi / 4 AIR_DENSITY width^2 per length (a flat plate in an ideal fluid), 1 % of a printed line's mass.
    """
    across = density * strip.thickness * strip.width + 0.25 * math.pi * AIR_DENSITY * strip.width**2
    return across * strip.length


def first_mode(mass_ratio: float) -> float:
    """Compute x^2, to which the first natural frequency of a cantilever with a mass on its tip is proportional.

    x is the first root of 1 + cos x cosh x + mass_ratio x (cos x sinh x - sin x cosh x) = 0 (Blevins, Formulas for
    natural frequency and mode shape, 1979, table 8-8). `mass_ratio`: mass on the tip over that of the cantilever.
    """
    from scipy.optimize import brentq

    if mass_ratio == 0.0:
        return FIRST_MODE

    def frequency_equation(x: float) -> float:
        c, s = math.cos(x), math.sin(x)
        ch, sh = math.cosh(x), math.sinh(x)
        return 1.0 + c * ch + mass_ratio * x * (c * sh - s * ch)

    # Rayleigh: x^4 is near 3 / (mass_ratio + 0.24), and the only root below that of the bare beam
    return float(brentq(frequency_equation, 1e-6, math.sqrt(FIRST_MODE), xtol=1e-14)) ** 2


def damping_ratio(decrement: float) -> float:
    """Return the damping ratio of an oscillation with this logarithmic decrement."""
    return decrement / math.hypot(2.0 * math.pi, decrement)
