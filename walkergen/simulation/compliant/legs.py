"""The walker: a body and two legs hinged at its anchors (physics.md section 5, model B).

Coordinates: x, y and pitch of the body's centre of mass O, and the angles alpha of the legs
against the body, zero when relaxed. Each leg hangs on a torsional spring with a damper. A braced
walker is the same with `legs` None: its state has no leg coordinates and its code no springs.

A state is a float64 array: X, Y, PITCH, their rates V_X, V_Y, SPIN, the drive's PHASE, the contact
mode of either foot, and with legs the angles and their rates. Lengths in mm, masses in g, rad, s.
"""

import math
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.scene import GRAVITY
from walkergen.simulation import drive as plates
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

Array = npt.NDArray[np.float64]

X, Y, PITCH, V_X, V_Y, SPIN, PHASE, MODE_BACK, MODE_FRONT = range(9)
ANGLE_BACK, ANGLE_FRONT, RATE_BACK, RATE_FRONT = range(9, 13)
RIGID_SIZE, COMPLIANT_SIZE = 9, 13

OK, TOPPLED, FAILED, FOLDED = range(4)
"""Statuses of `advance`: done; a body corner touches the plate; no progress; a leg at 90 deg."""

Spring = Literal["cantilever", "pseudo-rigid", "frequency"]
SPRING_FACTORS: dict[Spring, float] = {"cantilever": 3.0, "pseudo-rigid": 3.11, "frequency": 4.12}
"""k_t l / (E I): static tip stiffness; pseudo-rigid-body pair; first frequency (section 5)."""


class Swing(NamedTuple):
    """The legs' two modes in flight, linear in the angles, seen from the body (closed form)."""

    cos: float
    sin: float
    """First mode is (cos, sin) in (alpha back, alpha front), the second (-sin, cos)."""
    mobility_1: float
    mobility_2: float
    """Inverse inertia of either mode, 1/(g mm^2): angular acceleration per torque at the hinges."""
    share_back: float
    share_front: float
    """The body's turn per turn of a leg: pitch + sum(share alpha) turns uniformly in flight."""


class Legs(NamedTuple):
    """Two equal legs on torsional springs."""

    mass: float
    inertia: float
    """Of one leg about its anchor, g mm^2."""
    centre_x: float
    centre_y: float
    """Anchor -> centre of mass of the relaxed leg (c_A)."""
    stiffness: float
    """Torsional, g mm^2/s^2 per rad."""
    damping: float
    """g mm^2/s per rad."""
    swing: Swing


class Walker(NamedTuple):
    """Everything the integrators know of a walker; vectors in the body's frame, from O."""

    mass: float
    """Of the body (flexible legs) or of all (braced), g."""
    inertia: float
    """Of the same about O, g mm^2."""
    back_x: float
    back_y: float
    front_x: float
    front_y: float
    """Anchors."""
    reach_x: float
    reach_y: float
    """Anchor -> foot, relaxed."""
    corner_back_x: float
    corner_front_x: float
    corner_y: float
    """Lower corners of the body."""
    gravity_x: float | None
    gravity_y: float
    """Gravity in the plate's frame, mm/s^2: a slope tilts it; level: x is None."""
    legs: Legs | None


def walker_of(
    design: Design,
    mass: MassProperties,
    *,
    damping_ratio: float = 0.05,
    spring: Spring = "cantilever",
    slope: float | None = None,
) -> Walker:
    """The walker of a design with its mass properties; braced designs get legs None.

    damping_ratio is that of a free leg on a held body; slope (rad) is the
    plate's descent toward +x; None: level, and absent from the compiled code.
    """
    O = np.array(design.anchors[0]) - mass.a  # noqa: E741  (the paper's name)
    half, bottom = 0.5 * design.body.length_mm, -0.5 * design.body.thickness_mm
    legs = None
    if not mass.rigid:
        second_moment = design.body.depth_mm * design.leg_thickness**3 / 12.0
        modulus = 1e9 * design.material.youngs_modulus_gpa  # 1 Pa = 1 g/(mm s^2)
        stiffness = SPRING_FACTORS[spring] * modulus * second_moment / design.legs.length_mm
        legs = _legs(mass, stiffness, damping_ratio)
    reach = mass.c_A + mass.c_T
    return Walker(
        mass=float(mass.M),
        inertia=float(mass.J),
        back_x=float(mass.a[0]),
        back_y=float(mass.a[1]),
        front_x=float(mass.b[0]),
        front_y=float(mass.b[1]),
        reach_x=float(reach[0]),
        reach_y=float(reach[1]),
        corner_back_x=float(-half - O[0]),
        corner_front_x=float(half - O[0]),
        corner_y=float(bottom - O[1]),
        gravity_x=None if slope is None else GRAVITY * math.sin(slope),
        gravity_y=-GRAVITY * math.cos(slope or 0.0),
        legs=legs,
    )


def _legs(mass: MassProperties, stiffness: float, damping_ratio: float) -> Legs:
    inertia = float(mass.j + mass.m * mass.c_A @ mass.c_A)
    damping = 2.0 * damping_ratio * math.sqrt(stiffness * inertia)
    c_x, c_y = (float(value) for value in mass.c_A)
    return Legs(float(mass.m), inertia, c_x, c_y, stiffness, damping, _swing(mass, inertia))


def _swing(mass: MassProperties, inertia: float) -> Swing:
    """Modes of the relaxed chain in flight: its rotations' inertia without the translations."""
    m, ratio = mass.m, mass.m / (mass.M + 2.0 * mass.m)
    anchors = mass.a + mass.b
    inertias = np.full((3, 3), -m * ratio * float(mass.c_A @ mass.c_A))
    inertias[1, 1] += inertia
    inertias[2, 2] += inertia
    inertias[0, 0] = mass.J + m * (mass.a @ mass.a + mass.b @ mass.b - ratio * anchors @ anchors)
    for leg, anchor in ((1, mass.a), (2, mass.b)):
        inertias[0, leg] = inertias[leg, 0] = m * (anchor - ratio * anchors) @ mass.c_A
    hinges = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
    mobility, modes = np.linalg.eigh(hinges @ np.linalg.solve(inertias, hinges.T))
    cos, sin = modes[:, 0]
    shares = inertias.sum(axis=0)[1:] / inertias.sum()
    return Swing(*(float(value) for value in (cos, sin, *mobility, *shares)))


def new_state(
    walker: Walker, plate: plates.Plate, clearance: float, pitch: float = 0.0, phase: float = 0.0
) -> Array:
    """A state at rest in the laboratory, relaxed, its lower foot `clearance` mm over the plate."""
    state = np.zeros(RIGID_SIZE if walker.legs is None else COMPLIANT_SIZE)
    state[PITCH], state[PHASE] = pitch, phase
    cos, sin = math.cos(pitch), math.sin(pitch)
    feet = [
        sin * (anchor_x + walker.reach_x) + cos * (anchor_y + walker.reach_y)
        for anchor_x, anchor_y in (
            (walker.back_x, walker.back_y),
            (walker.front_x, walker.front_y),
        )
    ]
    state[Y] = plates.height(plate, phase) + clearance - min(feet)
    return state
