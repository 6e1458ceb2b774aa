"""3D simulation of a walker on elastic feet: its first state, its energy, and the feet and plate that each run draws.

A state is a 1-d array, whose entries are named by constants as C_X (state.py). C is the centre of mass of the whole
walker, O that of its body. W is the rate at which body and legs would turn together with locked joints.
"""

import math

import numpy as np
import numpy.typing as npt

from walkergen.core.numerics.kernels import kernel
from walkergen.core.simulation.effects import motor as motors
from walkergen.core.simulation.effects import noise, roughness
from walkergen.core.simulation.effects.active_effects import gravity_along, gravity_into
from walkergen.core.simulation.effects.effect import Case
from walkergen.core.simulation.effects.feet import UNEVENNESS, sample_heights
from walkergen.core.simulation.effects.resolve import Resolved
from walkergen.core.simulation.space.flight import legs_energy
from walkergen.core.simulation.space.points import mirror_order
from walkergen.core.simulation.space.pose import fill_points, plate_velocity, point_velocity, update_pose
from walkergen.core.simulation.space.state import (
    ACROSS,
    ALONG,
    C_X,
    C_Y,
    C_Z,
    HEADING,
    J_A,
    LEGS,
    MODE,
    OPEN,
    PHASE,
    PITCH,
    Q_0,
    Q_Y,
    Q_Z,
    ROW_LENGTH,
    SHEAR,
    SHOWN_X,
    SHOWN_Y,
    U_A,
    V_X,
    W_X,
    W_Y,
    W_Z,
    Walker,
    Work,
    first_row,
    state_size,
    work_for,
)
from walkergen.core.simulation.space.tips import elastic_energy
from walkergen.core.simulation.world import State, World

Array = npt.NDArray[np.float64]


def initial_state(
    world: World, clearance: float, pitch: float = 0.0, phase: float = 0.0, roll: float = 0.0, heading: float = 0.0
) -> State:
    """Return the state of a relaxed walker at rest in the laboratory, its lowest corner `clearance` mm over the plate.

    The body is rolled about its own x axis, then pitched, then turned; angles in rad. A walker that is held in its
    plane does not roll.
    """
    roll = roll if world.walker.inverse_mass[2] > 0.0 else 0.0
    state = np.zeros(state_size(world.walker))
    c, s = math.cos(0.5 * pitch), math.sin(0.5 * pitch)
    a, b = math.cos(0.5 * roll), math.sin(0.5 * roll)
    state[Q_0 : Q_0 + 4] = c * a, c * b, s * b, s * a
    if heading:
        turn_to(state, heading)
    state[PHASE] = phase
    if (walled := world.walker.wall_distance > 0.0).any():  # the lane's middle is the body's, not that of its mass
        edges = world.walker.root[walled]
        sides = math.cos(heading) * edges[:, 2] - math.sin(heading) * edges[:, 0]
        state[C_Z] = 0.0 - 0.5 * (sides.min() + sides.max())
    work = work_for(world.walker, state)
    update_pose(world, state, work)
    _set_motor_rates(world, state, work)
    fill_points(world, state, work)
    gaps = work.points["gap"][world.walker.wall_distance == 0.0]
    state[C_Y] += clearance - float(gaps.min())
    update_pose(world, state, work)
    return state


def turn_to(state: State, heading: float) -> None:
    """Turn a walker's state in place from heading 0 to `heading`, rad to the left."""
    c, s = math.cos(0.5 * heading), math.sin(0.5 * heading)
    q, i, j, k = state[Q_0 : Q_0 + 4]
    state[Q_0 : Q_0 + 4] = c * q - s * j, c * i + s * k, c * j + s * q, c * k - s * i
    state[HEADING] = heading


def _set_motor_rates(world: World, state: State, work: Work) -> None:
    """Set the turning rate in `state`, and `work`, so that the body oscillates with its motor and does not spin."""
    walker, rotor = world.walker, world.acting.motor
    if motors.acts(rotor):
        still = rotor._replace(spin=(0.0, 0.0, 0.0))
        turning = motors.spin(still, walker.centre, walker.mass, work.thrown)
        state[W_X : W_Z + 1] = -walker.inverse_inertia @ np.array(turning)
        update_pose(world, state, work)


@kernel
def energy(world, state):
    """Return the energy of a state, g mm^2/s^2 (1e-9 J): kinetic, gravitational and elastic, contacts included."""
    walker = world.walker
    copy = state.copy()
    work = work_for(walker, state)
    update_pose(world, copy, work)
    fill_points(world, copy, work)
    total = legs_energy(walker, state)
    for i in range(3):
        total += 0.5 * walker.mass * state[V_X + i] * state[V_X + i]
        for j in range(3):
            total += 0.5 * walker.inertia[i, j] * state[W_X + i] * state[W_X + j]
    fallen = gravity_along(world.acting) * state[C_X] - gravity_into(world.acting) * state[C_Y]
    total -= walker.mass * fallen
    row = first_row(walker)
    for k in range(len(walker.leg)):
        at = row + ROW_LENGTH * k
        if state[at + MODE] != OPEN:
            total += elastic_energy(walker.spring[k], walker.tip[k], -work.points[k].gap)
            stretch = state[at + ALONG] ** 2 + state[at + ACROSS] ** 2
            total += 0.5 * state[at + SHEAR] * stretch
    return total


def feet(world: World, state: State) -> Array:
    """Compute the middles of the feet, shape (legs, 4): x (mm), height (mm), v_x and v_y (mm/s).

    x is along the lane; height and velocities are over the plate.
    """
    work, copy, walker = work_for(world.walker, state), state.copy(), world.walker
    f = walker.freedoms
    update_pose(world, copy, work)
    fill_points(world, copy, work)
    corners = int(np.count_nonzero(walker.wall_distance == 0.0))
    rows = np.zeros((corners, 4))
    for k in range(corners):
        velocity = work.R @ np.array(point_velocity(copy, work.now, work.points, walker.shift, walker.leg[k], f, k))
        x = state[C_X] + work.R[0] @ work.points["at"][k]
        rows[k] = x, work.points["gap"][k], velocity[0], velocity[1] - plate_velocity(world, copy)
    return 0.5 * (rows[0::2] + rows[1::2])


def mirror_state(walker: Walker, state: State) -> State:
    """Return the state of a walker's mirror image (x -> -x), whose legs are listed in reverse.

    `walker` is that of the given state. Points of the body are listed from back to front, as in both.
    """
    image, n = state.copy(), len(walker.stiffness)
    image[[SHOWN_X, HEADING, PITCH, C_X, V_X, W_Y, W_Z, Q_Y, Q_Z]] *= -1.0
    for first in (LEGS, LEGS + n):
        own = state[first : first + n].reshape(-1, max(walker.freedoms, 1))
        image[first : first + n] = -own[::-1].ravel()
    rows = state[LEGS + 2 * n :].reshape(-1, ROW_LENGTH)[mirror_order(walker)]
    rows[:, [ALONG, U_A, J_A]] *= -1.0
    image[LEGS + 2 * n :] = rows.ravel()
    return image


def pose(state: State) -> tuple[float, float, float]:
    """Return position (along x, and to its left, mm) of the body's centre of mass, and heading (rad), from above."""
    return float(state[SHOWN_X]), float(state[SHOWN_Y]), float(state[HEADING])


def sample_world(case: Case, resolved: Resolved, world: World, rng: np.random.Generator) -> World:
    """Return the world of one run, with uneven feet, plate noise and roughness drawn at random if simulated."""
    walker, acting = world.walker, world.acting
    if resolved.is_on(UNEVENNESS):
        corners = walker.wall_distance == 0.0
        heights = sample_heights(case, int(corners.sum()), rng)
        on_body = walker.leg[corners] < 0  # of braced legs
        root, reach = walker.root.copy(), walker.reach.copy()
        root[corners, 1] += np.where(on_body, heights, 0.0)
        reach[corners, 1] += np.where(on_body, 0.0, heights)
        walker = walker._replace(root=root, reach=reach)
    if resolved.is_on(noise.NAME):
        acting = acting._replace(noise=noise.sample_noise(case, rng))
    if resolved.is_on(roughness.NAME):
        acting = acting._replace(roughness=roughness.sample_surface(case, rng))
    return world._replace(walker=walker, acting=acting)
