"""World that kernels read by name, and the layout of the states of all planar walkers.

A state is a float64 array: place of the centre of mass O and pitch (mm, rad), their rates, the
drive's phase (rad), the contact mode of either foot, and, where legs swing, the angles of the legs
against the body and their rates. Pitch and angles turn counter-clockwise.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.simulation.drive import Drive
from walkergen.simulation.effects.acting import Acting

State = npt.NDArray[np.float64]

X, Y, PITCH, V_X, V_Y, SPIN, PHASE, MODE_BACK, MODE_FRONT = range(9)
ANGLE_BACK, ANGLE_FRONT, RATE_BACK, RATE_FRONT = range(9, 13)
RIGID_SIZE, COMPLIANT_SIZE = 9, 13

OPEN, STICK, FORWARD, BACKWARD = range(4)
"""Contact modes of a foot: in the air, stuck to the plate, sliding toward +x, toward -x."""

OK, TOPPLED, FAILED, FOLDED, INSIDE, RUNAWAY = range(6)
"""Statuses of a model's `advance`: ran to the end; a corner of the body touched the plate; no
progress; a leg turned by 90 deg against the body; a foot inside the plate, at the start or
deeper than a step explains; impacts gained energy without bound, as those of relaxed legs can."""

RIGID_COLUMNS = (
    "x_mm",
    "y_mm",
    "pitch_rad",
    "v_x_mm_s",
    "v_y_mm_s",
    "pitch_rate_rad_s",
    "phase_rad",
    "mode_back",
    "mode_front",
)
"""Names, with units, of the entries of a rigid walker's state, in their order."""

LEG_COLUMNS = ("alpha_back_rad", "alpha_front_rad", "rate_back_rad_s", "rate_front_rad_s")
"""Names, with units, of the entries that swinging legs add."""


class Contact(NamedTuple):
    """Law of contact between one foot and the plate."""

    restitution: float
    """Coefficient of restitution, 0..1."""
    friction: float
    """Coulomb's coefficient, >= 0."""
    law: int
    """A value of `impact.Law`."""


class World(NamedTuple):
    """Everything that does not change while a walker moves."""

    walker: Any
    """The model's own `Walker`."""
    drive: Drive
    contacts: tuple[Contact, ...]
    """Contact of each foot, the back one first; in space the walker knows its own."""
    acting: Acting
    options: Any
    """The model's own `Options`."""


def mirrored(state: State) -> State:
    """State of the mirror image (x -> -x, back and front exchanged), but for the contact modes."""
    image = state.copy()
    image[[X, PITCH, V_X, SPIN]] *= -1.0
    if len(state) == COMPLIANT_SIZE:
        image[[ANGLE_BACK, ANGLE_FRONT]] = -state[[ANGLE_FRONT, ANGLE_BACK]]
        image[[RATE_BACK, RATE_FRONT]] = -state[[RATE_FRONT, RATE_BACK]]
    return image


def pose(state: State) -> tuple[float, float, float]:
    """Place of O in the plate's plane (along x and across it, mm) and heading (rad)."""
    return float(state[X]), 0.0, 0.0
