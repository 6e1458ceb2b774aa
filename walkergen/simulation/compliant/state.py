"""Hinged walker: a body and legs on hinges at its anchors (docs/physics.md section 5, model B).

Each leg hangs on a torsional spring with a damper; its angle against the body is zero when relaxed.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.simulation.drive import height
from walkergen.simulation.effects.compliance import stiffness
from walkergen.simulation.world import COMPLIANT_SIZE, PHASE, PITCH, State, World, Y
from walkergen.walker.design import Design
from walkergen.walker.mass import LegMass, MassProperties, from_centre
from walkergen.walker.planar import in_plane

Array = npt.NDArray[np.float64]
Point = tuple[float, float]


class Leg(NamedTuple):
    """One leg on a torsional spring."""

    mass: float
    """Mass, g."""
    inertia: float
    """Moment of inertia about its anchor, g mm^2."""
    centre: Point
    """Vector anchor -> centre of mass of the relaxed leg (c_A), mm."""
    stiffness: float
    """Torsional stiffness of its hinge, g mm^2/s^2 per rad."""
    damping: float
    """Torsional damping of its hinge, g mm^2/s per rad."""


class Ratios(NamedTuple):
    """Numbers of the front leg over the back leg's: exactly 1.0 where the legs are equal, so that
    sums over legs, with the back leg's number before the bracket, are those of equal legs.
    """

    mass: float
    root: float
    """Root of the ratio of the stiffnesses: angles times roots have equal springs."""
    unroot: float
    """1 / root."""
    damping: float


class Swing(NamedTuple):
    """Modes of the two legs in flight, linear in their angles, seen from the body."""

    cos: float
    sin: float
    """Modes in (alpha back, root alpha front), root that of `Ratios`: the first is (cos, sin), the
    second (-sin, cos)."""
    mobility_1: float
    mobility_2: float
    """Inverse inertia of either mode, 1/(g mm^2): angular acceleration per torque at the hinges."""
    excess: float
    """Damping over stiffness of the front leg by that of the back leg, less 1: couples the modes.
    0 where the legs are equal."""
    share_back: float
    share_front: float
    """Backward turn of the body over a leg's: pitch + sum(share alpha) is uniform in flight."""


class Walker(NamedTuple):
    """Everything the integrators know of a walker; vectors in mm, in the body's frame; of two the
    back leg's comes first.
    """

    mass: float
    """Mass of the body, g."""
    inertia: float
    """Moment of inertia of the body about O, g mm^2."""
    anchors: tuple[Point, Point]
    """Vectors O -> anchors."""
    reaches: tuple[Point, Point]
    """Vectors anchor -> foot of relaxed legs."""
    corner_back_x: float
    corner_front_x: float
    corner_y: float
    """Vectors O -> lower corners of the body."""
    legs: tuple[Leg, Leg]
    ratios: Ratios
    swing: Swing


def walker_of(design: Design, mass: MassProperties, *, damping_ratio: float = 0.05) -> Walker:
    """Walker of a design; `damping_ratio`: of a free leg on a held body."""
    flat, size = in_plane(design, mass), design.size
    low = np.array([(-0.5 * size.length, -0.5 * size.thickness), (0.5 * size.length, -0.5 * size.thickness)])
    (left, bottom), (right, _) = from_centre(design, mass, low)
    back, front = flat.mass.legs
    modulus = design.material.youngs_modulus
    stiff_b, stiff_f = (stiffness(limb, modulus) for limb in flat.limbs)
    legs = _leg(back, stiff_b, damping_ratio), _leg(front, stiff_f, damping_ratio)
    ratios = _ratios(*legs)
    return Walker(
        mass=float(mass.M),
        inertia=float(mass.J),
        anchors=(_point(back.anchor), _point(front.anchor)),
        reaches=(_point(back.c_A + back.c_T), _point(front.c_A + front.c_T)),
        corner_back_x=float(left),
        corner_front_x=float(right),
        corner_y=float(bottom),
        legs=legs,
        ratios=ratios,
        swing=_swing(flat.mass, ratios),
    )


def _point(vector: Array) -> Point:
    return float(vector[0]), float(vector[1])


def _leg(leg: LegMass, stiffness: float, damping_ratio: float) -> Leg:
    inertia = float(leg.inertia)
    damping = 2.0 * damping_ratio * math.sqrt(stiffness * inertia)
    return Leg(float(leg.m), inertia, _point(leg.c_A), stiffness, damping)


def _ratios(back: Leg, front: Leg) -> Ratios:
    """Ratios of two legs, of their dampings even where these are zero."""
    stiff = front.stiffness / back.stiffness
    damped = front.stiffness * front.inertia / (back.stiffness * back.inertia)
    root = math.sqrt(stiff)
    return Ratios(front.mass / back.mass, root, 1.0 / root, math.sqrt(damped))


def _swing(mass: MassProperties, ratios: Ratios) -> Swing:
    """Modes of the relaxed chain in flight, from the inertia of its rotations about its centre."""
    back, front = mass.legs
    m, mu = back.m, ratios.mass
    ratio = m / (mass.M + (1.0 + mu) * m)
    a, b, c_b, c_f = back.anchor, front.anchor, back.c_A, front.c_A
    anchors = a + mu * b
    inertias = np.full((3, 3), -m * ratio * mu * float(c_b @ c_f))
    inertias[1, 1] = -m * ratio * float(c_b @ c_b) + back.inertia
    inertias[2, 2] = -m * ratio * mu * mu * float(c_f @ c_f) + front.inertia
    inertias[0, 0] = mass.J + m * (a @ a + mu * (b @ b) - ratio * anchors @ anchors)
    inertias[0, 1] = inertias[1, 0] = m * (a - ratio * anchors) @ c_b
    inertias[0, 2] = inertias[2, 0] = mu * m * (b - ratio * anchors) @ c_f
    hinges = np.array([[-1.0, 1.0, 0.0], [-ratios.root, 0.0, ratios.root]])
    mobility, modes = np.linalg.eigh(hinges @ np.linalg.solve(inertias, hinges.T))
    cos, sin = modes[:, 0]
    excess = ratios.damping / (ratios.root * ratios.root) - 1.0
    shares = inertias.sum(axis=0)[1:] / inertias.sum()
    return Swing(*(float(value) for value in (cos, sin, *mobility, excess, *shares)))


def start(
    world: World, clearance: float, pitch: float = 0.0, phase: float = 0.0, roll: float = 0.0, heading: float = 0.0
) -> State:
    """A state at rest in the laboratory, relaxed, its lower foot `clearance` mm over the plate."""
    walker = world.walker
    state = np.zeros(COMPLIANT_SIZE)
    state[PITCH], state[PHASE] = pitch, phase
    cos, sin = math.cos(pitch), math.sin(pitch)
    lower = min(
        sin * (anchor[0] + reach[0]) + cos * (anchor[1] + reach[1])
        for anchor, reach in zip(walker.anchors, walker.reaches, strict=True)
    )
    state[Y] = height(world.drive, phase) + clearance - lower
    return state
