"""Second harmonic of the drive: the plate moves as A [sin(phase) + ratio sin(2 phase + shift)].

The kernels give the harmonic's part of height, velocity and acceleration over A, A omega and
A omega^2. Limit: ratio 0 is the plain sine (tests/core/simulation/test_engines.py).
"""

import math
from typing import NamedTuple

from walkergen.core.numerics.kernels import kernel
from walkergen.core.simulation.effects.effect import Case, Effect, Rule, decide_from_key

NAME, SWITCH, KEY = "second harmonic", "second_harmonic", "drive.second_harmonic_ratio"


class Harmonic(NamedTuple):
    """Parameters of a second harmonic."""

    ratio: float
    """Amplitude over the fundamental's."""
    shift: float
    """Phase shift, rad."""


OFF = Harmonic(0.0, 0.0)
"""A plain sine."""


def decide(case: Case) -> Effect:
    """Return the effect "second harmonic" of the drive. Its number is its amplitude over the fundamental's."""
    ratio = case.scene.drive.second_harmonic_ratio
    on, reason = decide_from_key(case, KEY, SWITCH)
    return Effect(NAME, on, ratio, "amplitude over the fundamental's", reason, SWITCH)


RULE = Rule(decide, SWITCH, absent_values={KEY: 0.0}, typical_values={KEY: 0.2})


def parameters(case: Case) -> Harmonic:
    """Return the parameters of the second harmonic of the scene's drive."""
    drive = case.scene.drive
    return Harmonic(drive.second_harmonic_ratio, math.radians(drive.second_harmonic_phase_deg))


@kernel
def height(harmonic, phase):
    """Return the second harmonic's part of the plate's height, over A, at a phase (rad) of the fundamental."""
    if harmonic.ratio == 0.0:
        return 0.0
    return harmonic.ratio * math.sin(2.0 * phase + harmonic.shift)


@kernel
def velocity(harmonic, phase):
    """Return the second harmonic's part of the plate's velocity, over A omega, at a phase (rad) of the fundamental."""
    if harmonic.ratio == 0.0:
        return 0.0
    return 2.0 * harmonic.ratio * math.cos(2.0 * phase + harmonic.shift)


@kernel
def acceleration(harmonic, phase):
    """Return the second harmonic's part of the plate's acceleration, over A omega^2, at a fundamental's phase (rad)."""
    if harmonic.ratio == 0.0:
        return 0.0
    return -4.0 * harmonic.ratio * math.sin(2.0 * phase + harmonic.shift)


@kernel
def bound(harmonic, order):
    """Return an upper bound of the second harmonic's |d^order height / dt^order| over A omega^order."""
    if harmonic.ratio == 0.0:
        return 0.0
    return abs(harmonic.ratio) * 2.0**order
