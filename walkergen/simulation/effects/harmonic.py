"""Second harmonic of the drive: the plate moves as A [sin(phase) + ratio sin(2 phase + shift)].

The kernels give the harmonic's share of height, velocity and acceleration over A, A omega and
A omega^2; None shares nothing. Limit: ratio 0 is the plain sine (tests/test_engines.py).
"""

import math
from typing import NamedTuple

from walkergen.numerics.kernels import kernel
from walkergen.simulation.effects.effect import Case, Effect, forced

NAME, SWITCH = "second harmonic", "effects.second_harmonic"


class Harmonic(NamedTuple):
    """Second harmonic of a drive."""

    ratio: float
    """Amplitude over that of the fundamental."""
    shift: float
    """Phase shift, rad."""


def verdict(case: Case) -> Effect:
    """On when the scene's drive has a second harmonic."""
    ratio = case.scene.drive.second_harmonic_ratio
    reason = "drive.second_harmonic_ratio" + (" > 0" if ratio > 0 else " = 0")
    on, reason = forced(case.scene.effects.second_harmonic, ratio > 0, reason)
    return Effect(NAME, on, ratio, "amplitude over the fundamental's", reason, SWITCH)


def parameters(case: Case) -> Harmonic:
    """The second harmonic of the scene's drive."""
    drive = case.scene.drive
    return Harmonic(drive.second_harmonic_ratio, math.radians(drive.second_harmonic_phase_deg))


@kernel
def height(harmonic, phase):
    """Share of the height at a phase (rad) of the fundamental."""
    if harmonic is None:
        return 0.0
    return harmonic.ratio * math.sin(2.0 * phase + harmonic.shift)


@kernel
def velocity(harmonic, phase):
    """Share of the velocity."""
    if harmonic is None:
        return 0.0
    return 2.0 * harmonic.ratio * math.cos(2.0 * phase + harmonic.shift)


@kernel
def acceleration(harmonic, phase):
    """Share of the acceleration."""
    if harmonic is None:
        return 0.0
    return -4.0 * harmonic.ratio * math.sin(2.0 * phase + harmonic.shift)


@kernel
def bound(harmonic, order):
    """Largest share of the derivative of that order."""
    if harmonic is None:
        return 0.0
    return abs(harmonic.ratio) * 2.0**order
