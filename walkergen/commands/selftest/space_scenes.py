"""Scenes of the hard cases in space: plans, throws, images of states, and general conditions."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from walkergen.commands.selftest.case import Check
from walkergen.commands.selftest.scenes import Limit, advance, check_motion, paper_plan
from walkergen.core.numerics import Array
from walkergen.core.scene import GRAVITY
from walkergen.core.simulation.plan import Plan
from walkergen.core.simulation.space.state import (
    C_X,
    C_Z,
    HEADING,
    LEGS,
    Q_0,
    Q_X,
    Q_Y,
    Q_Z,
    ROLL,
    SHOWN_X,
    SHOWN_Y,
    V_X,
    V_Z,
    W_X,
    W_Y,
    W_Z,
)

POSE_SLICE = slice(SHOWN_X, ROLL + 1)
"""Position of O (mm) and the three angles (rad) in a state."""

SETTLING_S = 1.0
"""Time (s) after which a walker placed on a still plate is at rest."""


def space_plan(tilt_deg: float = 10.0, **tables: Any) -> Plan:
    """Prepare the 3D simulation of the paper's walker, on a plane unless `tables` of the scene differ."""
    return paper_plan(tilt_deg, **({"arena": {"kind": "plane"}} | tables))


def moving_start(plan: Plan, roll: float = 1e-3, gap: float = 0.05) -> Array:
    """Return the state of a walker with a `roll` (rad), dropped from `gap` mm with everything moving."""
    state = plan.initial_state(clearance=gap, pitch=4e-3, phase=1.0, roll=roll)
    state[[V_X, V_Z, W_X, W_Y, W_Z]] = 12.0, 3.0, 0.5, 0.3, 0.7
    return state


def resting_state(plan: Plan) -> Array:
    """Return the state of a walker that was put down on its feet and came to rest."""
    state = plan.initial_state(clearance=0.0, pitch=0.0, phase=0.0)
    advance(plan, state, SETTLING_S)
    return state


def mirror_image(state: Array) -> Array:
    """Return the mirror image z -> -z of the state of a two-legged walker with twist, except for the contacts."""
    image = state.copy()
    twists = [LEGS + 1, LEGS + 3, LEGS + 5, LEGS + 7]  # their angles, then their rates
    image[[SHOWN_Y, HEADING, ROLL, C_Z, V_Z, W_X, W_Y, Q_X, Q_Y, *twists]] *= -1.0
    return image


def quarter_turn(state: Array) -> Array:
    """Return the state after a quarter turn about the vertical, to the left."""
    image, half = state.copy(), math.sqrt(0.5)
    q, i, j, k = state[Q_0 : Q_Z + 1]
    image[Q_0 : Q_Z + 1] = half * (q - j), half * (i + k), half * (j + q), half * (k - i)
    for x, z in ((C_X, C_Z), (V_X, V_Z)):
        image[x], image[z] = state[z], -state[x]
    image[SHOWN_X], image[SHOWN_Y] = -state[SHOWN_Y], state[SHOWN_X]
    image[HEADING] += 0.5 * math.pi
    return image


def max_pose_difference(a: Array, b: Array) -> float:
    """Return the largest difference of position (mm) and angles (rad)."""
    return float(np.abs(a[POSE_SLICE] - b[POSE_SLICE]).max())


def max_compression(plan: Plan, speed: float) -> float:
    """Return an upper bound (mm) of a foot's compression when the walker falls on it at `speed`, mm/s.

    The whole walker lands on one corner. Its leg and its tip each take all of the energy, and the weight's work on the
    other: half of m g sag for a leg, 0.6 of it for a tip. The tip's 0.4 K d^2.5 = m v^2 / 2 + m g d then ends before d
    = (1.25 m v^2 / K)^0.4 + (2.5 m g / K)^(2/3). Other corners, hinges and dampers take their part.
    """
    walker, on_plate = plan.world.walker, plan.world.walker.wall_distance == 0.0
    k, tip = float(walker.spring[on_plate].min()), float(walker.tip[on_plate].min())
    weight = walker.mass * GRAVITY
    leg_sag, tip_sag = weight / k, (weight / tip) ** (2.0 / 3.0)
    leg = leg_sag + math.sqrt(leg_sag**2 + walker.mass / k * (speed**2 + 1.2 * GRAVITY * tip_sag))
    pressed = (1.25 * walker.mass * (speed**2 + GRAVITY * leg_sag) / tip) ** 0.4
    return float(leg + pressed + (2.5 * weight / tip) ** (2.0 / 3.0))


def friction_windup(plan: Plan) -> float:
    """Return how far (mm) friction can wind up a corner on which the walker stands: its tip, hinge and twist."""
    walker = plan.world.walker
    load = walker.mass * GRAVITY / np.count_nonzero(walker.wall_distance == 0.0)
    depth = (load / float(walker.tip[0])) ** (2.0 / 3.0)
    tangent = 1.0 / (1.0 / float(walker.spring[0]) + 1.0 / (1.5 * float(walker.tip[0]) * math.sqrt(depth)))
    compliance = 1.0 / (float(walker.shear[0]) * tangent)
    hinge, twist = float(walker.stiffness[0]), float(walker.stiffness[1])
    compliance += 2.0 * (float(np.hypot(*walker.reach[0])) ** 2 / hinge + float(walker.side[0]) ** 2 / twist)
    return float(walker.friction[0] * load * compliance)


def check_constant_velocity(plan: Plan, seconds: float) -> Check:
    """Check that a walker thrown on a plate without friction keeps its velocity along it."""
    state = moving_start(plan)
    before = state[[V_X, V_Z]]
    advance(plan, state, seconds)
    change = float(np.abs(state[[V_X, V_Z]] - before).max())
    return Check("change of the velocity of C along the plate, mm/s", change, 1e-11, "rounding")


def check_space_motion(plan: Plan, state: Array, seconds: float, about: str, tolerance: Limit) -> Iterator[Check]:
    """Yield the checks of `check_motion`; the limit of a foot's depth follows from the energy of the fall."""
    fallen = max(plan.energy(state) - plan.energy(plan.initial_state(clearance=0.0, pitch=0.0, phase=0.0)), 0.0)
    speed = plan.scene.drive.peak_speed + math.sqrt(2.0 * fallen / plan.world.walker.mass)
    reason = "all of the walker on one corner's spring, at twice the speeds of plate and drop"
    return check_motion(plan, state, seconds, about, tolerance, (max_compression(plan, 2.0 * speed), reason))
