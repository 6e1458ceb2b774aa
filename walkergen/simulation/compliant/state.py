"""Hinged walker: a body and legs on hinges at its anchors (docs/physics.md section 5, model B).

Each leg hangs on a torsional spring with a damper; its angle against the body is zero when relaxed.
A braced walker has `legs` None: its state has no leg coordinates and its code no springs.
"""

import math
from typing import NamedTuple

import numpy as np

from walkergen.simulation.drive import height
from walkergen.simulation.effects.compliance import Spring, stiffness
from walkergen.simulation.world import COMPLIANT_SIZE, PHASE, PITCH, RIGID_SIZE, State, World, Y
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties, from_centre
from walkergen.walker.planar import in_plane


class Swing(NamedTuple):
    """Modes of the two legs in flight, linear in their angles, seen from the body."""

    cos: float
    sin: float
    """Modes in (alpha back, alpha front): the first is (cos, sin), the second (-sin, cos)."""
    mobility_1: float
    mobility_2: float
    """Inverse inertia of either mode, 1/(g mm^2): angular acceleration per torque at the hinges."""
    share_back: float
    share_front: float
    """Backward turn of the body over a leg's: pitch + sum(share alpha) is uniform in flight."""


class Legs(NamedTuple):
    """Two equal legs on torsional springs; the mass (g) is that of a single leg."""

    mass: float
    inertia: float
    """Moment of inertia of one leg about its anchor, g mm^2."""
    centre_x: float
    centre_y: float
    """Vector anchor -> centre of mass of the relaxed leg (c_A), mm."""
    stiffness: float
    """Torsional stiffness of a hinge, g mm^2/s^2 per rad."""
    damping: float
    """Torsional damping of a hinge, g mm^2/s per rad."""
    swing: Swing


class Walker(NamedTuple):
    """Everything the integrators know of a walker; vectors from O, in mm, in the body's frame."""

    mass: float
    """Mass of the body (flexible legs) or of the whole (braced), g."""
    inertia: float
    """Moment of inertia about O of what `mass` counts, g mm^2."""
    back_x: float
    back_y: float
    front_x: float
    front_y: float
    """Vectors O -> anchors."""
    reach_x: float
    reach_y: float
    """Vector anchor -> foot of a relaxed leg."""
    corner_back_x: float
    corner_front_x: float
    corner_y: float
    """Vectors O -> lower corners of the body."""
    legs: Legs | None


def walker_of(
    design: Design,
    mass: MassProperties,
    *,
    damping_ratio: float = 0.05,
    spring: Spring = "cantilever",
) -> Walker:
    """Walker of a design, legs None if braced; `damping_ratio`: of a free leg on a held body."""
    flat, size = in_plane(design, mass), design.size
    back, front = flat.mass.legs
    low = np.array([(-0.5 * size.length, -0.5 * size.thickness),
                    (0.5 * size.length, -0.5 * size.thickness)])  # fmt: skip
    (left, bottom), (right, _) = from_centre(design, mass, low)
    legs = None
    if not mass.rigid:
        hinge = stiffness(flat.limbs[0], design.material.youngs_modulus, spring)
        legs = _legs(flat.mass, hinge, damping_ratio)
    reach = back.c_A + back.c_T
    return Walker(
        mass=float(mass.M),
        inertia=float(mass.J),
        back_x=float(back.anchor[0]),
        back_y=float(back.anchor[1]),
        front_x=float(front.anchor[0]),
        front_y=float(front.anchor[1]),
        reach_x=float(reach[0]),
        reach_y=float(reach[1]),
        corner_back_x=float(left),
        corner_front_x=float(right),
        corner_y=float(bottom),
        legs=legs,
    )


def _legs(mass: MassProperties, stiffness: float, damping_ratio: float) -> Legs:
    leg = mass.legs[0]
    inertia = float(leg.inertia)
    damping = 2.0 * damping_ratio * math.sqrt(stiffness * inertia)
    c_x, c_y = (float(value) for value in leg.c_A)
    return Legs(float(leg.m), inertia, c_x, c_y, stiffness, damping, _swing(mass, inertia))


def _swing(mass: MassProperties, inertia: float) -> Swing:
    """Modes of the relaxed chain in flight, from the inertia of its rotations about its centre."""
    back, front = mass.legs
    m, ratio = back.m, back.m / (mass.M + 2.0 * back.m)
    a, b, c_A = back.anchor, front.anchor, back.c_A
    anchors = a + b
    inertias = np.full((3, 3), -m * ratio * float(c_A @ c_A))
    inertias[1, 1] += inertia
    inertias[2, 2] += inertia
    inertias[0, 0] = mass.J + m * (a @ a + b @ b - ratio * anchors @ anchors)
    for leg, anchor in ((1, a), (2, b)):
        inertias[0, leg] = inertias[leg, 0] = m * (anchor - ratio * anchors) @ c_A
    hinges = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
    mobility, modes = np.linalg.eigh(hinges @ np.linalg.solve(inertias, hinges.T))
    cos, sin = modes[:, 0]
    shares = inertias.sum(axis=0)[1:] / inertias.sum()
    return Swing(*(float(value) for value in (cos, sin, *mobility, *shares)))


def start(
    world: World, clearance: float, pitch: float = 0.0, phase: float = 0.0, roll: float = 0.0
) -> State:
    """A state at rest in the laboratory, relaxed, its lower foot `clearance` mm over the plate."""
    walker = world.walker
    state = np.zeros(RIGID_SIZE if walker.legs is None else COMPLIANT_SIZE)
    state[PITCH], state[PHASE] = pitch, phase
    cos, sin = math.cos(pitch), math.sin(pitch)
    lower = min(
        sin * (anchor_x + walker.reach_x) + cos * (anchor_y + walker.reach_y)
        for anchor_x, anchor_y in ((walker.back_x, walker.back_y), (walker.front_x, walker.front_y))
    )
    state[Y] = height(world.drive, phase) + clearance - lower
    return state
