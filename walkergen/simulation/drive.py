"""The vibrating plate: y_p = A [sin(phase) + ratio sin(2 phase + shift)], phase = omega t.

The phase is kept in 0..2 pi and never the absolute time, so that a run of 1e5 s still resolves
1e-9 s. A second harmonic that is None leaves nothing in the compiled code.
"""

import math
from typing import NamedTuple

from walkergen.numerics.kernels import kernel

TWO_PI = 2.0 * math.pi


class Harmonic(NamedTuple):
    """Second harmonic of the drive."""

    ratio: float
    """Amplitude over that of the fundamental."""
    shift: float
    """Phase shift, rad."""


class Plate(NamedTuple):
    """A plate shaken vertically, at rest when `amplitude` is 0."""

    amplitude: float
    """mm"""
    omega: float
    """rad/s, > 0 (also when the amplitude is 0)."""
    harmonic: Harmonic | None


class Contact(NamedTuple):
    """Foot on plate."""

    restitution: float
    """0..1"""
    friction: float
    """Coulomb's coefficient, >= 0."""
    law: int
    """A value of `impact.Law`."""


@kernel
def _harmonic_height(harmonic, phase):
    if harmonic is None:
        return 0.0
    return harmonic.ratio * math.sin(2.0 * phase + harmonic.shift)


@kernel
def _harmonic_velocity(harmonic, phase):
    if harmonic is None:
        return 0.0
    return 2.0 * harmonic.ratio * math.cos(2.0 * phase + harmonic.shift)


@kernel
def _harmonic_acceleration(harmonic, phase):
    if harmonic is None:
        return 0.0
    return -4.0 * harmonic.ratio * math.sin(2.0 * phase + harmonic.shift)


@kernel
def height(plate: Plate, phase: float) -> float:
    """Height of the plate's surface, mm."""
    return plate.amplitude * (math.sin(phase) + _harmonic_height(plate.harmonic, phase))


@kernel
def velocity(plate: Plate, phase: float) -> float:
    """Vertical velocity of the plate, mm/s."""
    both = math.cos(phase) + _harmonic_velocity(plate.harmonic, phase)
    return plate.amplitude * plate.omega * both


@kernel
def acceleration(plate: Plate, phase: float) -> float:
    """Vertical acceleration of the plate, mm/s^2."""
    both = _harmonic_acceleration(plate.harmonic, phase) - math.sin(phase)
    return plate.amplitude * plate.omega * plate.omega * both


@kernel
def _harmonic_bound(harmonic, order):
    if harmonic is None:
        return 0.0
    return abs(harmonic.ratio) * 2.0**order


@kernel
def derivative_bound(plate: Plate, order: int) -> float:
    """Upper bound of |d^order height / dt^order|, mm/s^order; attained without a harmonic."""
    return (
        abs(plate.amplitude) * plate.omega**order * (1.0 + _harmonic_bound(plate.harmonic, order))
    )
