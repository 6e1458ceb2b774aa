"""Flight in the 3D simulation: the centre of mass falls, the body is a free top, legs swing, each exactly or nearly so.

The legs' coordinates follow tabulated exponentials for times h 2^i, without the torques of the body's turn. The top
keeps its angular momentum exactly and turns by the implicit midpoint rule, solved to rounding.

`world` holds what stays the same in a run, `state` (1-d array, entries named by constants as C_X) what changes, and
`work` memory for results (state.py). C is the centre of mass of the whole walker, O that of its body. W is the rate
(rad/s, body axes) at which body and legs would turn together with locked joints. k numbers the contacts.
"""

import math

from walkergen.core.numerics.kernels import lean
from walkergen.core.simulation import record
from walkergen.core.simulation.effects import motor as motors
from walkergen.core.simulation.effects import noise as noises
from walkergen.core.simulation.effects import roughness as rough
from walkergen.core.simulation.effects import sway as sways
from walkergen.core.simulation.effects.active_effects import force_in_space, gravity_along, gravity_into
from walkergen.core.simulation.space.pose import plate_velocity, point_velocity, rotation_coefficients, turn
from walkergen.core.simulation.space.state import (
    C_X,
    C_Y,
    C_Z,
    HALVINGS,
    LEGS,
    MODE,
    NOISE,
    OPEN,
    PHASE,
    ROW_LENGTH,
    V_X,
    V_Y,
    V_Z,
    W_X,
    first_row,
)
from walkergen.core.simulation.world import advance_phase, derivative_bound

MIDPOINT_ITERATIONS = 6
"""Passes of the midpoint rule: each takes its error down by half the turn of a step."""

MAX_TURN_RAD = 0.02
"""Largest turn of the body in a step of flight or in a frame, rad."""

FOOT_ACCELERATION_FACTOR = 1.75
"""Largest acceleration of a foot over that of a body which leaves its leg behind, a uniform rod."""

_sways, _sway_motion, _sway_bounds = sways.moves, sways.motion, sways.bounds
_noise_advance_time, _noise_bounds, _roughness_slope_bound = noises.advance_time, noises.bounds, rough.slope_bound
_motor_acts, _motor_centrifugal, _motor_swing = motors.acts, motors.centrifugal_acceleration, motors.fill_swing
_motor_strongest = motors.largest_acceleration
_motor_spin, _moment_of = motors.spin, motors.moment_of


@lean
def pass_time(world, state, t):
    """Advance the drive's phase and the noise's time in `state` by t seconds."""
    state[PHASE] = advance_phase(world.drive, state[PHASE], t)
    state[NOISE] = _noise_advance_time(world.acting.noise, state[NOISE], t)


@lean
def _swing_speed(state, R, points, shift, fast, leg, f, k, side):
    """Return an upper bound of the speed (mm/s) that the swing of the legs adds to contact k's approach to its surface.

    The surface is the plate (`side` 1), or the lid (-1). `leg` is the number of the contact's leg (-1: none), `f` the
    number of coordinates of each leg. `R` and `points` are of `Work`, `shift` and `fast` (angular frequencies squared)
    of `Walker`.
    """
    n, speed = shift.shape[1], 0.0
    for j in range(n):
        d, own = -(R[1, 0] * shift[0, j] + R[1, 1] * shift[1, j]), j - leg * f
        if leg >= 0 and 0 <= own < f:
            turned = points[k].turned[own]
            d += R[1, 0] * turned[0] + R[1, 1] * turned[1] + R[1, 2] * turned[2]
        angle, rate = state[LEGS + j], state[LEGS + n + j]
        speed += side * d * rate + abs(d) * math.sqrt(rate * rate + fast[j] * angle * angle)
    return speed


@lean
def max_plate_acceleration(world):
    """Return an upper bound of the plate's vertical acceleration, mm/s^2, with noise."""
    _, strongest = _noise_bounds(world.acting.noise)
    return derivative_bound(world.drive, 2) + strongest


@lean
def longest_flight(world):
    """Return the duration (s) of the longest tabulated flight."""
    return world.options.step * 2.0 ** (len(world.walker.flights) - HALVINGS - 1)


@lean
def _motor_acceleration(walker, motor, points, k, d_x, d_y, d_z):
    """Return the largest acceleration (mm/s^2) that a motor gives contact k along d (body axes), legs rigid."""
    p = points[k].at
    return _motor_strongest(motor, walker.centre, walker.mass, walker.inverse_inertia, p[0], p[1], p[2], d_x, d_y, d_z)


@lean
def lag_torque(walker, j, x, y, z, t_x, t_y, t_z):
    """Compute the torque on leg coordinate j, from the leg's inertia, while the body is accelerated and turned.

    The acceleration of the body is (x, y, z), mm/s^2, and the torque on it (t_x, t_y, t_z), g mm^2/s^2.
    """
    shift, lock = walker.shift, walker.lock
    moved = shift[0, j] * x + shift[1, j] * y + shift[2, j] * z
    return -(walker.mass * moved + lock[0, j] * t_x + lock[1, j] * t_y + lock[2, j] * t_z)


@lean
def _add_forced_swing(walker, omega, state, phase, sign):
    """Add to the legs' angles and rates `sign` times the steady swing that a motor at `phase` (rad) forces."""
    n, c, s = len(walker.stiffness), math.cos(phase), math.sin(phase)
    for j in range(n):
        a, b = walker.forced[0, j], walker.forced[1, j]
        state[LEGS + j] += sign * (a * c + b * s)
        state[LEGS + n + j] += sign * omega * (b * c - a * s)


@lean
def _turning_energy(walker, state):
    """Return the rotational kinetic energy of the walker with locked legs, g mm^2/s^2."""
    total = 0.0
    for i in range(3):
        for j in range(3):
            total += 0.5 * walker.inertia[i, j] * state[W_X + i] * state[W_X + j]
    return total


@lean
def _sway_closing_rates(world, state, work, k, side, speed):
    """Return bounds of the speed (mm/s) and acceleration (mm/s^2) that a swaying plate adds to contact k's approach.

    The contact moves at `speed` (mm/s). Its surface is the plate (`side` 1) or the lid (-1). The bounds hold for the
    longest flight.
    """
    R, at, omega, sway = work.R, work.points[k].at, world.drive.omega, world.acting.sway
    amplitude, slope = _sway_bounds(sway)
    x = state[C_X] + R[0, 0] * at[0] + R[0, 1] * at[1] + R[0, 2] * at[2]
    z = state[C_Z] + R[2, 0] * at[0] + R[2, 1] * at[1] + R[2, 2] * at[2]
    _, surface_speed, _, _, _, _ = _sway_motion(sway, omega, state[PHASE], x, z)
    horizontal_speed = speed + omega * amplitude
    distance = math.sqrt(x * x + z * z) + horizontal_speed * longest_flight(world)
    extra_speed = side * surface_speed + slope * (horizontal_speed + omega * amplitude)
    return extra_speed, omega * slope * (omega * (distance + amplitude) + 2.0 * horizontal_speed)


@lean
def clear_time(world, state, work, longest):
    """Return a time (s), at most `longest`, in which no contact can close; set `work.points[k].clear` of contact k."""
    walker, R, points, now = world.walker, work.R, work.points, work.now
    shift, fast, f = walker.shift, walker.fast, walker.freedoms
    leg, place, first, time = walker.leg, walker.wall_distance, first_row(walker), longest
    plate_speed, surface_slope = plate_velocity(world, state), _roughness_slope_bound(world.acting.roughness)
    plate_fall = gravity_into(world.acting) + max_plate_acceleration(world)
    motor, motor_acts = world.acting.motor, _motor_acts(world.acting.motor)
    push = _motor_centrifugal(motor, walker.mass)
    swaying, sway_amplitude, sway_speed = _sways(world.acting.sway), 0.0, 0.0
    if swaying:
        sway_amplitude, _ = _sway_bounds(world.acting.sway)
        sway_speed = world.drive.omega * sway_amplitude
    for k in range(len(leg)):
        gap, points[k].clear = points[k].gap, 0.0
        if state[first + ROW_LENGTH * k + MODE] != OPEN or gap <= 0.0:
            time = 0.0
            continue
        v_x, v_y, v_z = point_velocity(state, now, points, shift, leg[k], f, k)
        if place[k] > 0.0:
            clear = gap / (math.sqrt(v_x * v_x + v_y * v_y + v_z * v_z + 1e-300) + sway_speed)
            if motor_acts:
                max_acceleration = FOOT_ACCELERATION_FACTOR * _motor_acceleration(
                    walker, motor, points, k, R[2, 0], R[2, 1], R[2, 2]
                )
                root = math.sqrt(1.0 + 2.0 * max_acceleration * clear * clear / gap)
                clear *= 2.0 / (1.0 + root)
        else:
            side = 1.0 if place[k] == 0.0 else -1.0
            closing = side * (plate_speed - (R[1, 0] * v_x + R[1, 1] * v_y + R[1, 2] * v_z))
            closing += _swing_speed(state, R, points, shift, fast, leg[k], f, k, side)
            if surface_slope > 0.0:
                closing += surface_slope * (math.sqrt(v_x * v_x + v_y * v_y + v_z * v_z) + sway_speed)
            max_acceleration = plate_fall
            if swaying:
                extra_speed, extra_acceleration = _sway_closing_rates(
                    world, state, work, k, side, math.sqrt(v_x * v_x + v_y * v_y + v_z * v_z)
                )
                closing, max_acceleration = closing + extra_speed, max_acceleration + extra_acceleration
            if motor_acts:
                thrown = _motor_acceleration(walker, motor, points, k, R[1, 0], R[1, 1], R[1, 2])
                max_acceleration += FOOT_ACCELERATION_FACTOR * (thrown + surface_slope * push)
            root = closing + math.sqrt(closing * closing + 2.0 * max_acceleration * gap)
            clear = 2.0 * gap / max(root, 1e-300)
        points[k].clear = clear
        time = min(time, clear)
    return time


@lean
def _swing(walker, work, state, level):
    """Swing the legs for Options.step 2^level seconds. Save the start to `work.before`. Return the damped energy."""
    n = len(walker.stiffness)
    before = legs_energy(walker, state)
    P = walker.flights[level + HALVINGS]
    for i in range(2 * n):
        total = 0.0
        for j in range(2 * n):
            total += P[i, j] * state[LEGS + j]
        work.after[i] = total
    for i in range(2 * n):
        work.before[i] = state[LEGS + i]
        state[LEGS + i] = work.after[i]
    return before - legs_energy(walker, state)


@lean
def legs_energy(walker, state):
    """Return the energy of the legs, g mm^2/s^2: kinetic, relative to the motion of the whole, and of their springs."""
    n, total = len(walker.stiffness), 0.0
    for i in range(n):
        total += walker.stiffness[i] * state[LEGS + i] * state[LEGS + i]
        for j in range(n):
            total += walker.hinge_inertia[i, j] * state[LEGS + n + i] * state[LEGS + n + j]
    return 0.5 * total


@lean
def _multiply_vector(M, x, y, z):
    return (
        M[0, 0] * x + M[0, 1] * y + M[0, 2] * z,
        M[1, 0] * x + M[1, 1] * y + M[1, 2] * z,
        M[2, 0] * x + M[2, 1] * y + M[2, 2] * z,
    )


@lean
def _rotate_back(x, y, z, t_x, t_y, t_z):
    """Return the components of the vector (x, y, z) in axes that are turned by the rotation vector t, rad."""
    s, c = rotation_coefficients(t_x * t_x + t_y * t_y + t_z * t_z)
    a_x, a_y, a_z = t_y * z - t_z * y, t_z * x - t_x * z, t_x * y - t_y * x
    b_x, b_y, b_z = t_y * a_z - t_z * a_y, t_z * a_x - t_x * a_z, t_x * a_y - t_y * a_x
    return x - s * a_x + c * b_x, y - s * a_y + c * b_y, z - s * a_z + c * b_z


@lean
def _fall(world, state, work, t, sums):
    """Let the walker's centre of mass fall for t seconds, with constant air drag, whose work is added to `sums`."""
    walker, now = world.walker, work.now
    g_x, g_y = gravity_along(world.acting), -gravity_into(world.acting)
    f_x, f_y, f_z = force_in_space(world.acting, now)
    if f_x != 0.0 or f_y != 0.0 or f_z != 0.0:
        sums[record.DAMPING_LOSS] -= t * (f_x * now[0] + f_y * now[1] + f_z * now[2])
        d_x, d_y, d_z = _multiply_vector(work.R, f_x, f_y, f_z)
        state[V_X] += t * d_x * walker.inverse_mass[0]
        state[V_Y] += t * d_y * walker.inverse_mass[1]
        state[V_Z] += t * d_z * walker.inverse_mass[2]
    state[C_X] += t * (state[V_X] + 0.5 * t * g_x)
    state[C_Y] += t * (state[V_Y] + 0.5 * t * g_y)
    state[C_Z] += t * state[V_Z]
    state[V_X] += t * g_x
    state[V_Y] += t * g_y


@lean
def _swing_shaken(world, state, work, t, level):
    """Swing the legs as `_swing` does, in t = Options.step 2^level seconds, about the oscillation that a motor forces.

    The returned energy of the legs' dampers excludes the forced oscillation.
    """
    walker, omega, phase = world.walker, world.acting.motor.omega, state[PHASE]
    _add_forced_swing(walker, omega, state, phase, -1.0)
    damped = _swing(walker, work, state, level)
    _add_forced_swing(walker, omega, state, advance_phase(world.drive, phase, t), 1.0)
    c, s = math.cos(phase), math.sin(phase)
    for j in range(len(walker.stiffness)):
        work.before[j] += walker.forced[0, j] * c + walker.forced[1, j] * s
    return damped


@lean
def _turn_free(world, state, work, t):
    """Turn the body, a free top, for t seconds while its legs have swung from `work.before`.

    With a motor the conserved angular momentum includes the rotor's, and its unbalanced mass turns the body to and fro.
    `work.thrown`, the motion of that mass (`motor.fill_swing`), becomes that at the end.
    """
    walker, motor = world.walker, _motor_acts(world.acting.motor)
    n, d_x, d_y, d_z = len(walker.stiffness), 0.0, 0.0, 0.0
    for j in range(n):
        moved = state[LEGS + j] - work.before[j]
        d_x -= walker.lock[0, j] * moved
        d_y -= walker.lock[1, j] * moved
        d_z -= walker.lock[2, j] * moved
    W_0, W_1, W_2 = state[W_X], state[W_X + 1], state[W_X + 2]
    l_x, l_y, l_z = _multiply_vector(walker.inertia, W_0, W_1, W_2)
    s_x, s_y, s_z, h = 0.0, 0.0, 0.0, world.acting.motor.spin
    if motor:
        rotor, centre, mass, thrown = world.acting.motor, walker.centre, walker.mass, work.thrown
        s_x, s_y, s_z = _motor_spin(rotor, centre, mass, thrown)
        l_x, l_y, l_z = l_x + s_x, l_y + s_y, l_z + s_z
        b_x, b_y, b_z = thrown[0, 0], thrown[0, 1], thrown[0, 2]
        _motor_swing(rotor, mass, advance_phase(world.drive, state[PHASE], t), thrown)
        b_x, b_y, b_z = thrown[0, 0] - b_x, thrown[0, 1] - b_y, thrown[0, 2] - b_z
        b_x, b_y, b_z = _moment_of(rotor, centre, mass, b_x, b_y, b_z)
        b_x, b_y, b_z = _multiply_vector(walker.inverse_inertia, b_x, b_y, b_z)
        d_x, d_y, d_z = d_x - b_x, d_y - b_y, d_z - b_z
        s_x, s_y, s_z = _motor_spin(rotor, centre, mass, thrown)
    t_x, t_y, t_z = t * W_0 + d_x, t * W_1 + d_y, t * W_2 + d_z
    for _ in range(MIDPOINT_ITERATIONS):
        m_x, m_y, m_z = _rotate_back(l_x, l_y, l_z, 0.5 * t_x, 0.5 * t_y, 0.5 * t_z)
        if motor:
            m_x, m_y, m_z = m_x - h[0], m_y - h[1], m_z - h[2]
        w_x, w_y, w_z = _multiply_vector(walker.inverse_inertia, m_x, m_y, m_z)
        t_x, t_y, t_z = t * w_x + d_x, t * w_y + d_y, t * w_z + d_z
    turn(state, t_x, t_y, t_z)
    l_x, l_y, l_z = _rotate_back(l_x, l_y, l_z, t_x, t_y, t_z)
    if motor:
        l_x, l_y, l_z = l_x - s_x, l_y - s_y, l_z - s_z
    state[W_X], state[W_X + 1], state[W_X + 2] = _multiply_vector(walker.inverse_inertia, l_x, l_y, l_z)


@lean
def fly(world, state, work, t, level, sums):
    """Move a walker without contacts for t = Options.step 2^level s. Add work of dampers, drag and motor to `sums`."""
    walker, motor = world.walker, _motor_acts(world.acting.motor)
    _fall(world, state, work, t, sums)
    if motor:
        before = _turning_energy(walker, state) + legs_energy(walker, state)
        damped = _swing_shaken(world, state, work, t, level)
    else:
        before, damped = 0.0, _swing(walker, work, state, level)
    sums[record.DAMPING_LOSS] += damped
    _turn_free(world, state, work, t)
    if motor:
        after = _turning_energy(walker, state) + legs_energy(walker, state)
        sums[record.PLATE_WORK] += after - before + damped
    pass_time(world, state, t)
