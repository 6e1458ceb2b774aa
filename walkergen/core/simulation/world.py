"""World that kernels read: drive, active effects and walker; and statuses of a simulation.

The plate is at height A sin(phase), phase = omega t, plus a second harmonic if the scene has one. The phase is kept, in
0..2 pi, and not the absolute time: a run of 1e5 s still resolves 1e-9 s.
"""

import math
from typing import Any, NamedTuple

from walkergen.core.numerics import Array
from walkergen.core.numerics.kernels import kernel
from walkergen.core.simulation.effects import harmonic as harmonics
from walkergen.core.simulation.effects.active_effects import Acting
from walkergen.core.simulation.effects.harmonic import Harmonic

State = Array

OK, TOPPLED, FAILED, FOLDED = range(4)
"""Statuses of `steps.advance`: ran to the end; a corner of the body touched the plate; no progress;
a leg turned by 90 deg against the body."""

TWO_PI = 2.0 * math.pi

_height, _velocity = harmonics.height, harmonics.velocity
_acceleration, _bound = harmonics.acceleration, harmonics.bound


class Drive(NamedTuple):
    """A plate shaken vertically, at rest when `amplitude` is 0."""

    amplitude: float
    """Amplitude of the fundamental, mm."""
    omega: float
    """Angular frequency, rad/s; > 0 also when the amplitude is 0."""
    harmonic: Harmonic = harmonics.OFF

    @property
    def period(self) -> float:
        """Period of the fundamental, s."""
        return TWO_PI / self.omega


class World(NamedTuple):
    """Everything that does not change while a walker moves."""

    walker: Any
    """A `space.state.Walker`."""
    drive: Drive
    acting: Acting
    options: Any
    """Steps: a `space.state.Options`."""


@kernel
def advance_phase(drive: Drive, phase: float, t: float) -> float:
    """Return the phase (rad, in 0..2 pi) of the drive, t seconds after `phase`."""
    return (phase + drive.omega * t) % TWO_PI


@kernel
def height(drive: Drive, phase: float) -> float:
    """Return the height of the plate's surface at a phase (rad), mm."""
    return drive.amplitude * (math.sin(phase) + _height(drive.harmonic, phase))


@kernel
def velocity(drive: Drive, phase: float) -> float:
    """Return the vertical velocity of the plate at a phase (rad), mm/s."""
    relative_velocity = math.cos(phase) + _velocity(drive.harmonic, phase)
    return drive.amplitude * drive.omega * relative_velocity


@kernel
def acceleration(drive: Drive, phase: float) -> float:
    """Return the vertical acceleration of the plate at a phase (rad), mm/s^2."""
    relative_acceleration = _acceleration(drive.harmonic, phase) - math.sin(phase)
    return drive.amplitude * drive.omega * drive.omega * relative_acceleration


@kernel
def derivative_bound(drive: Drive, order: int) -> float:
    """Return an upper bound of |d^order height / dt^order|, mm/s^order; attained without a harmonic."""
    return abs(drive.amplitude) * drive.omega**order * (1.0 + _bound(drive.harmonic, order))
