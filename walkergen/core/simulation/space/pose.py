"""Pose of a walker in the 3D simulation: rotation, points of contact, their gaps, and what moves them.

`world` holds what stays the same in a run, `state` (1-d array, entries named by constants as C_X) what changes, and
`work` memory for results (state.py). C is the centre of mass of the whole walker, O that of its body. W is the rate
(rad/s, body axes) at which body and legs would turn together with locked joints. k numbers the contacts.
"""

import math

from walkergen.core.numerics.kernels import lean
from walkergen.core.simulation.effects import motor as motors
from walkergen.core.simulation.effects import noise as noises
from walkergen.core.simulation.effects import roughness as rough
from walkergen.core.simulation.effects import sway as sways
from walkergen.core.simulation.space.state import (
    C_X,
    C_Y,
    C_Z,
    HEADING,
    HEIGHT,
    LEGS,
    NOISE,
    PHASE,
    PITCH,
    Q_0,
    Q_X,
    Q_Y,
    Q_Z,
    ROLL,
    SHOWN_X,
    SHOWN_Y,
    V_X,
    W_X,
)
from walkergen.core.simulation.world import TWO_PI, height, velocity

SMALL_ANGLE_SQUARED = 0.01
"""Square of an angle (rad^2) below which its series are exact to rounding: 0.1 rad."""

_noise_height, _noise_velocity = noises.height, noises.velocity
_surface = rough.surface
_sways, _sway_displacements = sways.moves, sways.displacements_and_slopes
_motor_acts, _swing_of_motor = motors.acts, motors.fill_swing


@lean
def plate_height(world, state):
    """Return the height of the plate's middle, mm, without its roughness."""
    shaken = height(world.drive, state[PHASE])
    return shaken + _noise_height(world.acting.noise, state[NOISE])


@lean
def plate_velocity(world, state):
    """Return the vertical velocity of the plate's middle, mm/s."""
    shaken = velocity(world.drive, state[PHASE])
    return shaken + _noise_velocity(world.acting.noise, state[NOISE])


@lean
def plate_sway(world, state):
    """Return the plate's displacements along x and z, mm, then its slopes along both; zeros if it does not sway."""
    if not _sways(world.acting.sway):
        return 0.0, 0.0, 0.0, 0.0
    return _sway_displacements(world.acting.sway, state[PHASE])


@lean
def rotation_coefficients(square):
    """Compute sin(a) / a and (1 - cos(a)) / a^2 from the square of an angle a (rad).

    Small angles, such as turns in a step, take series, which need a tenth of the time.
    """
    if square < SMALL_ANGLE_SQUARED:
        s = 1.0 + square * (-1 / 6 + square * (1 / 120 + square * (-1 / 5040 + square * (1 / 362880))))
        c = 0.5 + square * (-1 / 24 + square * (1 / 720 + square * (-1 / 40320 + square * (1 / 3628800))))
        return s, c
    angle = math.sqrt(square)
    return math.sin(angle) / angle, (1.0 - math.cos(angle)) / square


@lean
def turn(state, x, y, z):
    """Turn the body's quaternion in `state`, in place, by the rotation vector (x, y, z) in body axes, rad."""
    square = 0.25 * (x * x + y * y + z * z)
    s, c = rotation_coefficients(square)
    c, x, y, z = 1.0 - c * square, 0.5 * s * x, 0.5 * s * y, 0.5 * s * z
    q, i, j, k = state[Q_0], state[Q_X], state[Q_Y], state[Q_Z]
    p_0 = q * c - i * x - j * y - k * z
    p_x = q * x + i * c + j * z - k * y
    p_y = q * y - i * z + j * c + k * x
    p_z = q * z + i * y - j * x + k * c
    size = 1.0 / math.sqrt(p_0 * p_0 + p_x * p_x + p_y * p_y + p_z * p_z)
    state[Q_0], state[Q_X], state[Q_Y], state[Q_Z] = p_0 * size, p_x * size, p_y * size, p_z * size


@lean
def fill_rotation(state, R):
    """Fill R, shape (3, 3), with the rotation matrix from body axes to the world."""
    q, i, j, k = state[Q_0], state[Q_X], state[Q_Y], state[Q_Z]
    R[0, 0], R[0, 1], R[0, 2] = 1 - 2 * (j * j + k * k), 2 * (i * j - q * k), 2 * (i * k + q * j)
    R[1, 0], R[1, 1], R[1, 2] = 2 * (i * j + q * k), 1 - 2 * (i * i + k * k), 2 * (j * k - q * i)
    R[2, 0], R[2, 1], R[2, 2] = 2 * (i * k - q * j), 2 * (j * k + q * i), 1 - 2 * (i * i + j * j)


@lean
def update_pose(world, state, work):
    """Fill `R`, `now`, `motion` and `thrown` of `work` from a state, and update the entries that a trajectory shows.

    Returns the change of the heading, rad.
    """
    walker, R, now, motion = world.walker, work.R, work.now, work.motion
    n, lock, shift = len(walker.stiffness), walker.lock, walker.shift
    fill_rotation(state, R)
    for row in range(3):
        # Eq. 7.2: w = W - Lambda q'
        spin = state[W_X + row]
        for j in range(n):
            spin -= lock[row, j] * state[LEGS + n + j]
        v = R[0, row] * state[V_X] + R[1, row] * state[V_X + 1] + R[2, row] * state[V_X + 2]
        now[row] = motion[row] = v
        now[3 + row], motion[3 + row] = spin, state[W_X + row]
    c_x, c_y, c_z = walker.centre[0], walker.centre[1], walker.centre[2]
    for j in range(n):
        c_x -= shift[0, j] * state[LEGS + j]
        c_y -= shift[1, j] * state[LEGS + j]
        c_z -= shift[2, j] * state[LEGS + j]
    if _motor_acts(world.acting.motor):
        thrown = work.thrown
        _swing_of_motor(world.acting.motor, walker.mass, state[PHASE], thrown)
        c_x, c_y, c_z = c_x - thrown[0, 0], c_y - thrown[0, 1], c_z - thrown[0, 2]
        for row in range(3):
            now[row] -= thrown[1, row]
    state[SHOWN_X] = state[C_X] + R[0, 0] * c_x + R[0, 1] * c_y + R[0, 2] * c_z
    state[HEIGHT] = state[C_Y] + R[1, 0] * c_x + R[1, 1] * c_y + R[1, 2] * c_z
    state[SHOWN_Y] = -(state[C_Z] + R[2, 0] * c_x + R[2, 1] * c_y + R[2, 2] * c_z)
    state[PITCH] = math.asin(min(max(R[1, 0], -1.0), 1.0))
    state[ROLL] = math.atan2(-R[1, 2], R[1, 1])
    turned = math.atan2(-R[2, 0], R[0, 0]) - state[HEADING]
    turned -= TWO_PI * math.floor(turned / TWO_PI + 0.5)
    state[HEADING] += turned
    return turned


@lean
def fill_points(world, state, work):
    """Fill `work.points` at the pose in `work`: positions (`at`), derivatives by leg angles (`turned`) and gaps."""
    walker, R = world.walker, work.R
    n, f = len(walker.stiffness), walker.freedoms
    o_x, o_y, o_z = 0.0, 0.0, 0.0
    for j in range(n):
        o_x -= walker.shift[0, j] * state[LEGS + j]
        o_y -= walker.shift[1, j] * state[LEGS + j]
        o_z -= walker.shift[2, j] * state[LEGS + j]
    if _motor_acts(world.acting.motor):
        o_x, o_y, o_z = o_x - work.thrown[0, 0], o_y - work.thrown[0, 1], o_z - work.thrown[0, 2]
    plate = plate_height(world, state)
    s_x, s_z, t_x, t_z = plate_sway(world, state)
    for k in range(len(walker.leg)):
        leg, side, point = walker.leg[k], walker.side[k], work.points[k]
        p_x, p_y, p_z = walker.root[k, 0] + o_x, walker.root[k, 1] + o_y, walker.root[k, 2] + o_z
        if leg >= 0:
            alpha = state[LEGS + leg * f] if f > 0 else 0.0
            twist = state[LEGS + leg * f + 1] if f > 1 else 0.0
            s, c = rotation_coefficients(alpha * alpha)
            s, c = s * alpha, 1.0 - c * alpha * alpha
            r_x = c * walker.reach[k, 0] - s * walker.reach[k, 1]
            r_y = s * walker.reach[k, 0] + c * walker.reach[k, 1]
            # Eq. 7.1, with n = z x axis: across the leg, in the plane
            n_x = -(s * walker.axis[k, 0] + c * walker.axis[k, 1])
            n_y = c * walker.axis[k, 0] - s * walker.axis[k, 1]
            s, c = rotation_coefficients(twist * twist)
            s, c = side * s * twist, side * (1.0 - c * twist * twist)
            p_x, p_y, p_z = p_x + r_x + s * n_x, p_y + r_y + s * n_y, p_z + c
            bend, twisted = point.turned[0], point.turned[1]
            bend[0], bend[1] = -(r_y + s * n_y), r_x + s * n_x
            twisted[0], twisted[1], twisted[2] = c * n_x, c * n_y, -s
        point.at[0], point.at[1], point.at[2] = p_x, p_y, p_z
        x = state[C_X] + R[0, 0] * p_x + R[0, 1] * p_y + R[0, 2] * p_z - s_x
        z = state[C_Z] + R[2, 0] * p_x + R[2, 1] * p_y + R[2, 2] * p_z - s_z
        if walker.wall_distance[k] > 0.0:
            point.gap = walker.wall_distance[k] - abs(z)
        else:
            y = state[C_Y] + R[1, 0] * p_x + R[1, 1] * p_y + R[1, 2] * p_z
            under = plate + (t_x * x + t_z * z)
            if walker.wall_distance[k] < 0.0:
                point.gap = under - walker.wall_distance[k] - y
            else:
                bump, _, _ = _surface(world.acting.roughness, x, z)
                point.gap = y - under - bump


@lean
def surface_normal(roughness, swayed, wall_distance, state, R, points, k):
    """Return the normal of the surface at contact k, in world axes. On the plate its vertical part is 1.

    `wall_distance` is the contact's entry of `Walker.wall_distance`. `swayed` is the result of `plate_sway`, `R` the
    rotation from body axes to world axes.
    """
    s_x, s_z, t_x, t_z = swayed
    if wall_distance < 0.0:
        return t_x, -1.0, t_z
    p_x, p_y, p_z = points[k].at[0], points[k].at[1], points[k].at[2]
    z = state[C_Z] + R[2, 0] * p_x + R[2, 1] * p_y + R[2, 2] * p_z - s_z
    if wall_distance > 0.0:
        return 0.0, 0.0, -1.0 if z > 0.0 else 1.0
    x = state[C_X] + R[0, 0] * p_x + R[0, 1] * p_y + R[0, 2] * p_z - s_x
    _, slope_x, slope_z = _surface(roughness, x, z)
    return -slope_x - t_x, 1.0, -slope_z - t_z


@lean
def point_velocity(state, now, points, shift, leg, f, k):
    """Return the velocity of contact point k, body axes, mm/s.

    `leg` is the number of its leg (-1: none), `f` the number of coordinates of each leg. `now` and `points` are those
    of `Work`, `shift` that of `Walker`.
    """
    n = shift.shape[1]
    p_x, p_y, p_z = points[k].at[0], points[k].at[1], points[k].at[2]
    w_x, w_y, w_z = now[3], now[4], now[5]
    v_x = now[0] + w_y * p_z - w_z * p_y
    v_y = now[1] + w_z * p_x - w_x * p_z
    v_z = now[2] + w_x * p_y - w_y * p_x
    for j in range(n):
        rate = state[LEGS + n + j]
        v_x -= shift[0, j] * rate
        v_y -= shift[1, j] * rate
        v_z -= shift[2, j] * rate
    if leg >= 0:
        for j in range(f):
            turned, rate = points[k].turned[j], state[LEGS + n + leg * f + j]
            v_x += turned[0] * rate
            v_y += turned[1] * rate
            v_z += turned[2] * rate
    return v_x, v_y, v_z


@lean
def lowest_corner(world, state, work):
    """Return the height of the body's lowest corner over the plate, mm. At zero the walker has toppled."""
    R, corners, lowest = work.R, world.walker.corners, math.inf
    for i in range(len(corners)):
        y = R[1, 0] * corners[i, 0] + R[1, 1] * corners[i, 1] + R[1, 2] * corners[i, 2]
        lowest = min(lowest, y)
    if _motor_acts(world.acting.motor):
        thrown = work.thrown
        lowest -= R[1, 0] * thrown[0, 0] + R[1, 1] * thrown[0, 1] + R[1, 2] * thrown[0, 2]
    s_x, s_z, t_x, t_z = plate_sway(world, state)
    under = plate_height(world, state) + (t_x * (state[C_X] - s_x) + t_z * (state[C_Z] - s_z))
    return state[C_Y] + lowest - under
