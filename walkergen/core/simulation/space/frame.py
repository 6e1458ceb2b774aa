"""Frozen frames: contact directions, Jacobians and inverse mass held for a few steps.

Legs enter with the inertia of the implicit midpoint rule, which their springs and dampers raise by
h c / 2 + h^2 k / 4: no step is too long for a stiff leg.

`world` holds what stays the same in a run, `state` (1-d array, entries named by constants as C_X) what changes, and
`work` memory for results (state.py). C is the centre of mass of the whole walker, O that of its body. W is the rate
(rad/s, body axes) at which body and legs would turn together with locked joints. k numbers the contacts.
"""

import math

from walkergen.core.numerics.kernels import lean
from walkergen.core.simulation.effects import motor as motors
from walkergen.core.simulation.effects import noise as noises
from walkergen.core.simulation.effects import sway as sways
from walkergen.core.simulation.effects.active_effects import force_in_space, gravity_along, gravity_into
from walkergen.core.simulation.space.flight import lag_torque, pass_time
from walkergen.core.simulation.space.pose import fill_points, plate_sway, surface_normal, turn, update_pose
from walkergen.core.simulation.space.state import C_X, C_Z, LEGS, NOISE, PHASE, V_X, W_X
from walkergen.core.simulation.world import acceleration

_noise_acceleration = noises.acceleration
_sways, _sway_motion = sways.moves, sways.motion
_motor_acts, _motor_spin, _motor_torque = motors.acts, motors.spin, motors.torque


@lean
def fill_leg_mobility(walker, work, h):
    """Fill `work.swing`, the inverse inertia of the legs' coordinates for steps of h seconds, by Gauss-Jordan.

    `work.swung[0]` keeps the h of the last call: for the same h nothing is computed.
    """
    n, swing, A = len(walker.stiffness), work.swing, work.A
    if work.swung[0] == h:
        return
    work.swung[0] = h
    for i in range(n):
        for j in range(n):
            A[i, j] = walker.hinge_inertia[i, j]
            swing[i, j] = 1.0 if i == j else 0.0
        # Eq. 7.5 by the implicit midpoint: G + h c / 2 + h^2 k / 4
        A[i, i] += 0.5 * h * walker.damping[i] + 0.25 * h * h * walker.stiffness[i]
    for i in range(n):
        pivot = 1.0 / A[i, i]
        for c in range(n):
            A[i, c] *= pivot
            swing[i, c] *= pivot
        for j in range(n):
            if j != i:
                factor = A[j, i]
                for c in range(n):
                    A[j, c] -= factor * A[i, c]
                    swing[j, c] -= factor * swing[i, c]


@lean
def _fill_row(J, points, shift, lock, leg, f, k, m, d_x, d_y, d_z):
    """Fill row m of the Jacobian J: how fast contact k moves along the direction d (body axes) by each velocity.

    `leg` is the number of its leg (-1: none), `f` the number of coordinates of each leg. `points` are those of `Work`,
    `shift` and `lock` those of `Walker`.
    """
    n = J.shape[1] - 6
    p_x, p_y, p_z = points[k].at[0], points[k].at[1], points[k].at[2]
    t_x, t_y, t_z = p_y * d_z - p_z * d_y, p_z * d_x - p_x * d_z, p_x * d_y - p_y * d_x
    # Eq. 7.6: (d, r x d, d . (dr/dq - P - Lambda x r))
    J[m, 0], J[m, 1], J[m, 2] = d_x, d_y, d_z
    J[m, 3], J[m, 4], J[m, 5] = t_x, t_y, t_z
    for j in range(n):
        J[m, 6 + j] = -(
            shift[0, j] * d_x
            + shift[1, j] * d_y
            + shift[2, j] * d_z
            + lock[0, j] * t_x
            + lock[1, j] * t_y
            + lock[2, j] * t_z
        )
    if leg >= 0:
        for j in range(f):
            turned = points[k].turned[j]
            along = turned[0] * d_x + turned[1] * d_y + turned[2] * d_z
            J[m, 6 + leg * f + j] += along


@lean
def _rate_acceleration(state, now, points, side, leg, f, n, k):
    """Return the acceleration of contact k from the rates alone (centripetal, Coriolis), body axes, mm/s^2.

    It changes velocities while Jacobians are frozen. `side` is the point's offset (mm) across its leg, `leg` the number
    of the leg (-1: none), `f` the number of coordinates of each leg, n that of all legs.
    """
    w_x, w_y, w_z = now[3], now[4], now[5]
    p_x, p_y, p_z = points[k].at[0], points[k].at[1], points[k].at[2]
    v_x, v_y, v_z = w_y * p_z - w_z * p_y, w_z * p_x - w_x * p_z, w_x * p_y - w_y * p_x
    a_x, a_y, a_z = 0.0, 0.0, 0.0
    if leg >= 0 and f > 0:
        rate = state[LEGS + n + leg * f]
        t_x, t_y = points[k].turned[0, 0], points[k].turned[0, 1]
        v_x, v_y = v_x + 2.0 * rate * t_x, v_y + 2.0 * rate * t_y
        a_x, a_y = -rate * rate * t_y, rate * rate * t_x
        if f > 1:
            twist = state[LEGS + n + leg * f + 1]
            turned = points[k].turned[1]
            t_x, t_y, t_z = turned[0], turned[1], turned[2]
            v_x, v_y, v_z = (v_x + 2.0 * twist * t_x, v_y + 2.0 * twist * t_y, v_z + 2.0 * twist * t_z)
            a_x, a_y = a_x - 2.0 * rate * twist * t_y, a_y + 2.0 * rate * twist * t_x
            small = twist * twist * t_z / side
            a_x, a_y, a_z = a_x + small * t_x, a_y + small * t_y, -twist * twist * side
    return (a_x + w_y * v_z - w_z * v_y, a_y + w_z * v_x - w_x * v_z, a_z + w_x * v_y - w_y * v_x)


@lean
def _apply_inverse_mass(J, MJ, ML, swing, inverse_mass, inverse_inertia, rows):
    """Fill `rows` rows of J M^-1: MJ for the walker as a whole, ML for its legs. `swing`: their inverse inertia."""
    # Eq. 7.3: kinetic energy has no cross terms, so that M^-1 is three blocks
    n = J.shape[1] - 6
    for r in range(rows):
        t_x, t_y, t_z = J[r, 3], J[r, 4], J[r, 5]
        for i in range(3):
            MJ[r, i] = inverse_mass[i] * J[r, i]
            MJ[r, 3 + i] = inverse_inertia[i, 0] * t_x + inverse_inertia[i, 1] * t_y + inverse_inertia[i, 2] * t_z
        for i in range(n):
            total = 0.0
            for j in range(n):
                total += swing[i, j] * J[r, 6 + j]
            ML[r, i] = total


@lean
def fill_midpoint_pose(world, state, work, t):
    """Fill `work` with the pose in the middle of a frame of t seconds, from the rates at its start.

    Jacobians of that pose make the frame of second order, which those of its start do not.
    """
    middle, n = work.midway, len(world.walker.stiffness)
    for i in range(len(state)):
        middle[i] = state[i]
    for i in range(3):
        middle[C_X + i] += 0.5 * t * state[V_X + i]
    for j in range(n):
        middle[LEGS + j] += 0.5 * t * state[LEGS + n + j]
    w = work.now
    turn(middle, 0.5 * t * w[3], 0.5 * t * w[4], 0.5 * t * w[5])
    pass_time(world, middle, 0.5 * t)
    update_pose(world, middle, work)
    fill_points(world, middle, work)


@lean
def _motor_point_acceleration(now, thrown):
    """Return the acceleration (mm/s^2, body axes) of the body's points from a motor.

    `now` and `thrown` are fields of `Work`: turning rate now[3:6], and the rows that `motor.fill_swing` fills.
    """
    x, y, z = thrown[1, 0], thrown[1, 1], thrown[1, 2]
    return (
        -thrown[2, 0] - 2.0 * (now[4] * z - now[5] * y),
        -thrown[2, 1] - 2.0 * (now[5] * x - now[3] * z),
        -thrown[2, 2] - 2.0 * (now[3] * y - now[4] * x),
    )


@lean
def _fill_directions(world, state, work, near, plate_speed, t, m):
    """Fill Jacobians and spring constants of the m contacts in `near`, for a frame of t seconds.

    Also fill the parts of their velocities and accelerations that come from the plate, which starts at `plate_speed`
    (mm/s), and from turning rates.
    """
    walker, R, J, points = world.walker, work.R, work.J, work.points
    upward_acceleration = plate_acceleration(world, state)
    friction, place = walker.friction, walker.wall_distance
    shift, lock, leg, f, upward = (walker.shift, walker.lock, walker.leg, walker.freedoms, walker.upward)
    roughness, has_motor = world.acting.roughness, _motor_acts(world.acting.motor)
    sway, tilted = _sways(world.acting.sway), plate_sway(world, state)
    b_x, b_y, b_z = _motor_point_acceleration(work.now, work.thrown)
    size = math.sqrt(R[0, 0] * R[0, 0] + R[2, 0] * R[2, 0]) + 1e-300
    h_x, h_z = R[0, 0] / size, R[2, 0] / size
    for i in range(m):
        k = near[i].number
        n_x, n_y, n_z = surface_normal(roughness, tilted, place[k], state, R, points, k)
        a_x, a_y, a_z = _rate_acceleration(state, work.now, points, walker.side[k], leg[k], f, J.shape[1] - 6, k)
        if has_motor:
            a_x, a_y, a_z = a_x + b_x, a_y + b_y, a_z + b_z
        for p in range(3):
            if p == 0:
                d_x, d_y, d_z = n_x, n_y, n_z
            elif place[k] > 0.0:
                d_x, d_y, d_z = (1.0, 0.0, 0.0) if p == 1 else (0.0, 1.0, 0.0)
            else:
                d_x, d_y, d_z = (h_x, 0.0, h_z) if p == 1 else (-h_z, 0.0, h_x)
            _fill_row(
                J,
                points,
                shift,
                lock,
                leg[k],
                f,
                k,
                3 * i + p,
                R[0, 0] * d_x + R[1, 0] * d_y + R[2, 0] * d_z,
                R[0, 1] * d_x + R[1, 1] * d_y + R[2, 1] * d_z,
                R[0, 2] * d_x + R[1, 2] * d_y + R[2, 2] * d_z,
            )
            upright, r = upward[k, p], 3 * i + p
            rate_acceleration = J[r, 0] * a_x + J[r, 1] * a_y + J[r, 2] * a_z
            near[i].speed[p] = -upright * plate_speed - 0.5 * t * rate_acceleration
            near[i].drift[p] = rate_acceleration - upright * upward_acceleration
            if sway:
                _subtract_sway(world, state, work, tilted, i, p, t, d_x, d_y, d_z)
        near[i].friction = friction[k]
        near[i].spring, near[i].tip = walker.spring[k], walker.tip[k]
        near[i].shear, near[i].damper = walker.shear[k], walker.damper[k]
    _apply_inverse_mass(J, work.MJ, work.ML, work.swing, walker.inverse_mass, walker.inverse_inertia, 3 * m)


@lean
def _subtract_sway(world, state, work, tilted, i, p, t, d_x, d_y, d_z):
    """Subtract the plate's motion there, beyond that of its middle, from speed and drift of the contact `near[i]`.

    Both are along direction p of the contact, d in world axes. The frame lasts t s; `tilted` is from `plate_sway`.
    """
    near, R, at = work.near, work.R, work.points[work.near[i].number].at
    x = state[C_X] + R[0, 0] * at[0] + R[0, 1] * at[1] + R[0, 2] * at[2] - tilted[0]
    z = state[C_Z] + R[2, 0] * at[0] + R[2, 1] * at[1] + R[2, 2] * at[2] - tilted[1]
    v_x, v_y, v_z, a_x, a_y, a_z = _sway_motion(world.acting.sway, world.drive.omega, state[PHASE], x, z)
    sweeping = d_x * a_x + d_y * a_y + d_z * a_z
    swept = d_x * v_x + d_y * v_y + d_z * v_z - 0.5 * t * sweeping
    near[i].swept[p], near[i].sweeping[p] = swept, sweeping
    near[i].speed[p] -= swept
    near[i].drift[p] -= sweeping


@lean
def sway_work(near, m, t):
    """Compute the work (g mm^2/s^2) of a plate's motion relative to its middle on m contacts in t seconds."""
    total = 0.0
    for i in range(m):
        for p in range(3):
            impulse, carried = near[i].impulse[p], near[i].carried[p]
            total += near[i].swept[p] * impulse + near[i].sweeping[p] * (t * impulse - carried)
    return total


@lean
def fill_frame(world, work, plate_speed, t, m):
    """Fill Jacobians, velocities and inverse mass of the m near contacts of a frame of t seconds.

    At its start the plate moves at `plate_speed` (mm/s, upward).
    """
    state = work.midway
    near, J = work.near, work.J
    n = J.shape[1] - 6
    _fill_directions(world, state, work, near, plate_speed, t, m)
    for i in range(m):
        for p in range(3):
            r = 3 * i + p
            u, drift = near[i].speed[p], near[i].drift[p]
            for j in range(6):
                u += J[r, j] * work.motion[j]
                drift += J[r, j] * work.acting[j]
            for j in range(n):
                u += J[r, 6 + j] * state[LEGS + n + j]
            if _motor_acts(world.acting.motor):
                for j in range(3):
                    u -= J[r, j] * work.thrown[1, j]
            near[i].speed[p], near[i].drift[p] = u, drift
            near[i].impulse[p] = near[i].carried[p] = 0.0
            near[i].free[p] = near[i].middle[p] = 0.0
    _fill_mobility(J, work.MJ, work.ML, work.H, 3 * m)


@lean
def _fill_mobility(J, MJ, ML, H, rows):
    """Fill the first `rows` rows of H with the inverse mass at the contacts, J M^-1 J^T, from J and M^-1 J^T."""
    n = J.shape[1] - 6
    for r in range(rows):
        for c in range(r + 1):
            whole = 0.0
            for j in range(6):
                whole += J[r, j] * MJ[c, j]
            for j in range(n):
                whole += J[r, 6 + j] * ML[c, j]
            H[r, c] = H[c, r] = whole


@lean
def plate_acceleration(world, state):
    """Return the vertical acceleration of the plate, mm/s^2."""
    shaken = acceleration(world.drive, state[PHASE])
    return shaken + _noise_acceleration(world.acting.noise, state[NOISE])


@lean
def fill_accelerations(world, state, work):
    """Fill `work.acting`, linear and angular acceleration without contacts: by gravity, drag, rotation and motor."""
    walker, R, now, acting = world.walker, work.R, work.now, work.acting
    g_x, g_y = gravity_along(world.acting), -gravity_into(world.acting)
    f_x, f_y, f_z = force_in_space(world.acting, now)
    for row in range(3):
        acting[row] = R[0, row] * g_x + R[1, row] * g_y
    acting[0] += walker.inverse_mass[0] * f_x
    acting[1] += walker.inverse_mass[1] * f_y
    acting[2] += walker.inverse_mass[2] * f_z
    I, inverse = walker.inertia, walker.inverse_inertia  # noqa: E741
    W_0, W_1, W_2 = state[W_X], state[W_X + 1], state[W_X + 2]
    l_x = I[0, 0] * W_0 + I[0, 1] * W_1 + I[0, 2] * W_2
    l_y = I[1, 0] * W_0 + I[1, 1] * W_1 + I[1, 2] * W_2
    l_z = I[2, 0] * W_0 + I[2, 1] * W_1 + I[2, 2] * W_2
    if _motor_acts(world.acting.motor):
        m_x, m_y, m_z = _motor_spin(world.acting.motor, walker.centre, walker.mass, work.thrown)
        l_x, l_y, l_z = l_x + m_x, l_y + m_y, l_z + m_z
    # Eq. 7.4, with a motor eq. 8.2: (I_C W + spin) x w
    t_x, t_y, t_z = (l_y * now[5] - l_z * now[4], l_z * now[3] - l_x * now[5], l_x * now[4] - l_y * now[3])
    for row in range(3):
        acting[3 + row] = inverse[row, 0] * t_x + inverse[row, 1] * t_y + inverse[row, 2] * t_z
    if _motor_acts(world.acting.motor):
        _add_motor_acceleration(world, work)


@lean
def _add_motor_acceleration(world, work):
    """Add the angular acceleration by a motor to `work.acting`. Fill `work.left`, the torques on lagging legs."""
    walker, inverse, thrown = world.walker, world.walker.inverse_inertia, work.thrown
    p_x, p_y, p_z = _motor_torque(world.acting.motor, walker.centre, walker.mass, thrown)
    for row in range(3):
        turned = inverse[row, 0] * p_x + inverse[row, 1] * p_y + inverse[row, 2] * p_z
        work.acting[3 + row] += turned
    for j in range(len(walker.stiffness)):
        work.left[j] = lag_torque(walker, j, -thrown[2, 0], -thrown[2, 1], -thrown[2, 2], p_x, p_y, p_z)


@lean
def motor_work(walker, motor, state, work, m, t):
    """Compute a motor's work (g mm^2/s^2) in a frame of t seconds: on m contacts, the body and the legs."""
    near, J, thrown, total = work.near, work.J, work.thrown, 0.0
    for i in range(m):
        for p in range(3):
            impulse, carried = near[i].impulse[p], near[i].carried[p]
            for j in range(3):
                rate = thrown[1, j] - 0.5 * t * thrown[2, j]
                later = thrown[2, j] * (t * impulse - carried)
                total += J[3 * i + p, j] * (rate * impulse + later)
    t_x, t_y, t_z = _motor_torque(motor, walker.centre, walker.mass, thrown)
    total += t_x * work.moved[3] + t_y * work.moved[4] + t_z * work.moved[5]
    for j in range(len(walker.stiffness)):
        left = lag_torque(walker, j, -thrown[2, 0], -thrown[2, 1], -thrown[2, 2], t_x, t_y, t_z)
        total += left * (state[LEGS + j] - work.before[j])
    return total
