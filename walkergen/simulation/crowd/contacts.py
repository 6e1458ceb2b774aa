"""Contacts of bodies with bodies and walls: impulses in a tick, between two drifts of both.

A corner that gives by d pushes with stiffness times d as long as it is pressed on, and with that
times e^2 as it comes back: of the work that it took it returns the share e^2, as Stronge defines
restitution, whatever the masses, the place and the number of corners in touch. Friction takes what
slips, at most its coefficient times the normal impulse, along the face and up or down it. A tick's
impulse is that of the time in which the corner touches: touch and parting err by second order.

Why springs and not rigid impulses: a printed corner and a face part after 0.1 to 0.2 ms (Hertz), a
fiftieth of a period of the plate, so that either gives the same velocities; but springs also hold
walkers that push each other and jams of many, without an order of contacts that would matter.
"""

import math

from walkergen.numerics.kernels import inlined, kernel, lean
from walkergen.simulation import record
from walkergen.simulation.crowd.bodies import (
    DEEPEST,
    LOST,
    PERIODIC,
    RECTANGLE,
    RING,
    RUBBED,
    STORED,
    WORK,
    X,
    Z,
)
from walkergen.simulation.crowd.gaps import closest, image, inward, outward
from walkergen.simulation.space.pose import place, plate_velocity
from walkergen.simulation.space.state import C_X, C_Y, C_Z, LEGS, QUIET, V_X, W_X
from walkergen.simulation.world import OK


@lean
def _seen_from(state, work, x, y, z):
    """Point of the world in body axes from C."""
    R = work.R
    d_x, d_y, d_z = x - state[C_X], y - state[C_Y], z - state[C_Z]
    return (
        R[0, 0] * d_x + R[1, 0] * d_y + R[2, 0] * d_z,
        R[0, 1] * d_x + R[1, 1] * d_y + R[2, 1] * d_z,
        R[0, 2] * d_x + R[1, 2] * d_y + R[2, 2] * d_z,
    )


@lean
def _height(state, work, b_x, b_z, y):
    """Height in the world of a body's point (body axes from C)."""
    R = work.R
    return state[C_Y] + R[1, 0] * b_x + R[1, 1] * y + R[1, 2] * b_z


@lean
def _velocity(walker, state, work, a_x, a_y, a_z):
    """Velocity in the world of a point of the body, mm/s."""
    R, now, n, shift = work.R, work.now, len(walker.stiffness), walker.shift
    v_x = now[0] + now[4] * a_z - now[5] * a_y
    v_y = now[1] + now[5] * a_x - now[3] * a_z
    v_z = now[2] + now[3] * a_y - now[4] * a_x
    for j in range(n):
        rate = state[LEGS + n + j]
        v_x, v_y, v_z = v_x - shift[0, j] * rate, v_y - shift[1, j] * rate, v_z - shift[2, j] * rate
    return (
        R[0, 0] * v_x + R[0, 1] * v_y + R[0, 2] * v_z,
        R[1, 0] * v_x + R[1, 1] * v_y + R[1, 2] * v_z,
        R[2, 0] * v_x + R[2, 1] * v_y + R[2, 2] * v_z,
    )


@lean
def _mobility(walker, work, a_x, a_y, a_z, d_x, d_y, d_z):
    """Inverse mass (1/g) of a point of the body along a direction of the world, legs locked."""
    R, inverse = work.R, walker.inverse_inertia
    b_x = R[0, 0] * d_x + R[1, 0] * d_y + R[2, 0] * d_z
    b_y = R[0, 1] * d_x + R[1, 1] * d_y + R[2, 1] * d_z
    b_z = R[0, 2] * d_x + R[1, 2] * d_y + R[2, 2] * d_z
    t = (a_y * b_z - a_z * b_y, a_z * b_x - a_x * b_z, a_x * b_y - a_y * b_x)
    total = walker.inverse_mass[0]
    for i in range(3):
        for j in range(3):
            total += t[i] * inverse[i, j] * t[j]
    return total


@lean
def _push(world, state, work, tally, a_x, a_y, a_z, f_x, f_y, f_z):
    """Give an impulse (world, g mm/s) to a point of the body (body axes), and book its work."""
    walker, R = world.walker, work.R
    n, shift, lock, inverse = (
        len(walker.stiffness),
        walker.shift,
        walker.lock,
        (walker.inverse_inertia),
    )
    u_x, u_y, u_z = _velocity(walker, state, work, a_x, a_y, a_z)
    b_x = R[0, 0] * f_x + R[1, 0] * f_y + R[2, 0] * f_z
    b_y = R[0, 1] * f_x + R[1, 1] * f_y + R[2, 1] * f_z
    b_z = R[0, 2] * f_x + R[1, 2] * f_y + R[2, 2] * f_z
    t_x, t_y, t_z = a_y * b_z - a_z * b_y, a_z * b_x - a_x * b_z, a_x * b_y - a_y * b_x
    state[V_X] += walker.inverse_mass[0] * f_x
    state[V_X + 1] += walker.inverse_mass[1] * f_y
    state[V_X + 2] += walker.inverse_mass[2] * f_z
    for i in range(3):
        state[W_X + i] += inverse[i, 0] * t_x + inverse[i, 1] * t_y + inverse[i, 2] * t_z
    for j in range(n):
        left = shift[0, j] * b_x + shift[1, j] * b_y + shift[2, j] * b_z
        left += lock[0, j] * t_x + lock[1, j] * t_y + lock[2, j] * t_z
        for i in range(n):
            state[LEGS + n + i] -= walker.hinge_mobility[i, j] * left
    state[QUIET] = 0.0
    place(world, state, work)
    v_x, v_y, v_z = _velocity(walker, state, work, a_x, a_y, a_z)
    work_done = 0.5 * (f_x * (u_x + v_x) + f_y * (u_y + v_y) + f_z * (u_z + v_z))
    tally.sums[record.PLATE_WORK] += work_done
    return v_x, v_y, v_z


@inlined
def _touched_share(depth, u, tick):
    """Share of a tick's impulse by the time in which a corner touches.

    A corner that comes on at u < 0 touches since depth / u; one that goes parts after as much.
    """
    inside = depth / max(abs(u), 1e-300)
    return 0.5 * (min(inside, tick) + tick) / tick


@inlined
def _normal_impulse(stiffness, kept, depth, u, mobility, tick):
    """Impulse (g mm/s) along the normal in a tick, and the one of a spring that keeps nothing."""
    whole = stiffness * depth * tick * _touched_share(depth, u, tick)
    if u >= 0.0:
        return kept * whole, whole
    after = u + mobility * whole
    if after <= 0.0:
        return whole, whole
    stopped = -u / (after - u)
    return whole * (stopped + (1.0 - stopped) * kept), whole


@kernel
def _resolve(crowd, i, j, x, z, n_x, n_z, b_x, b_z, y_i, c_x, c_z, y_j, depth):
    """Push bodies i and j (or a wall, -1) apart where they touch.

    The touch is at (x, z) of the plane in i's image, its normal (n_x, n_z) points from j to i; on i
    it is the point (b_x, y_i, b_z), on j (c_x, y_j, c_z) of their own axes.
    """
    law, book, wall = crowd.law, crowd.book, j < 0
    mover = crowd.movers[i]
    free_i, free_j = crowd.status[i] == OK, not wall and crowd.status[j] == OK
    other = crowd.movers[i if wall else j]
    y = _height(mover.state, mover.work, b_x, b_z, y_i)
    x_j, z_j = x, z
    if not wall:
        y = 0.5 * (y + _height(other.state, other.work, c_x, c_z, y_j))
        x_j = crowd.planar[j, X] + image(crowd.ground, x - crowd.planar[j, X])
        z_j = crowd.planar[j, Z] + image(crowd.ground, z - crowd.planar[j, Z])
    a_x, a_y, a_z = _seen_from(mover.state, mover.work, x, y, z)
    d_x, d_y, d_z = _seen_from(other.state, other.work, x_j, y, z_j)
    u_x, u_y, u_z = 0.0, 0.0, 0.0
    if free_i:
        u_x, u_y, u_z = _velocity(mover.world.walker, mover.state, mover.work, a_x, a_y, a_z)
    v_x, v_y, v_z = 0.0, 0.0, 0.0
    if wall:
        v_y = plate_velocity(mover.world, mover.state)
    elif free_j:
        v_x, v_y, v_z = _velocity(other.world.walker, other.state, other.work, d_x, d_y, d_z)
    u_x, u_y, u_z = u_x - v_x, u_y - v_y, u_z - v_z
    u_n = u_x * n_x + u_z * n_z
    t_x, t_y, t_z = u_x - u_n * n_x, u_y, u_z - u_n * n_z
    slip = math.sqrt(t_x * t_x + t_y * t_y + t_z * t_z)
    if slip > 0.0:
        t_x, t_y, t_z = t_x / slip, t_y / slip, t_z / slip
    along, across = 0.0, 0.0
    if free_i:
        walker, work = mover.world.walker, mover.work
        along += _mobility(walker, work, a_x, a_y, a_z, n_x, 0.0, n_z)
        across += _mobility(walker, work, a_x, a_y, a_z, t_x, t_y, t_z)
    if free_j:
        walker, work = other.world.walker, other.work
        along += _mobility(walker, work, d_x, d_y, d_z, n_x, 0.0, n_z)
        across += _mobility(walker, work, d_x, d_y, d_z, t_x, t_y, t_z)
    if along == 0.0:
        return
    row = 1 if wall else 0
    push, whole = _normal_impulse(law.stiffness, law.kept[row], depth, u_n, along, crowd.tick[0])
    rub = min(law.friction[row] * push, slip / across)
    f_x, f_y, f_z = push * n_x - rub * t_x, -rub * t_y, push * n_z - rub * t_z
    w_x, w_y, w_z = 0.0, 0.0, 0.0
    if free_i:
        w_x, w_y, w_z = _push(
            mover.world, mover.state, mover.work, mover.tally, a_x, a_y, a_z, f_x, f_y, f_z
        )
    if free_j:
        v_x, v_y, v_z = _push(
            other.world, other.state, other.work, other.tally, d_x, d_y, d_z, -f_x, -f_y, -f_z
        )
    w_x, w_y, w_z = w_x - v_x, w_y - v_y, w_z - v_z
    w_n = w_x * n_x + w_z * n_z
    rubbed = t_x * (u_x + w_x) + t_y * (u_y + w_y) + t_z * (u_z + w_z)
    book[WORK] += 0.5 * push * (u_n + w_n)
    book[LOST] += (whole - push) * 0.5 * (max(u_n, 0.0) + max(w_n, 0.0))
    book[RUBBED] += 0.5 * rub * rubbed


@inlined
def _corners_of(crowd, i, j, layer, first, pushes):
    """Meet the corners of body i with body j at one end of their edges; returns how many touch.

    With `pushes` they push; else their energy is stored in the book. Corner on corner is found from
    either side: only the `first` side counts it.
    """
    bodies, planar, law, count = crowd.bodies, crowd.planar, crowd.law, 0
    own, other = bodies.kind[i], bodies.kind[j]
    y_i, y_j = bodies.heights[own, other, layer], bodies.heights[other, own, layer]
    r, r_j = bodies.radius[own], bodies.radius[other]
    for v in range(bodies.first[own], bodies.first[own + 1]):
        b_x, b_z = bodies.corners[v, 0], bodies.corners[v, 1]
        x, z = outward(planar, i, y_i, b_x, b_z)
        s_x = image(crowd.ground, x - planar[j, X]) - (x - planar[j, X])
        s_z = image(crowd.ground, z - planar[j, Z]) - (z - planar[j, Z])
        q_x, q_z = inward(planar, j, y_j, x + s_x, z + s_z)
        if math.sqrt(q_x * q_x + q_z * q_z) - bodies.reach[other] > r:
            continue
        distance, c_x, c_z, is_corner = closest(bodies, other, q_x, q_z)
        depth = r + r_j - distance
        if depth <= 0.0 or (is_corner and not first) or distance == 0.0:
            continue
        count += 1
        crowd.book[DEEPEST] = max(crowd.book[DEEPEST], depth)
        if not pushes:
            crowd.book[STORED] += 0.5 * law.stiffness * depth * depth
            continue
        p_x, p_z = outward(planar, j, y_j, c_x, c_z)
        n_x, n_z = (x + s_x - p_x) / distance, (z + s_z - p_z) / distance
        middle = r - 0.5 * depth
        _resolve(
            crowd, i, j, x - middle * n_x, z - middle * n_z, n_x, n_z,
            b_x, b_z, y_i, c_x, c_z, y_j, depth,
        )  # fmt: skip
    return count


@kernel
def meet(crowd, i, j, pushes):
    """Let bodies i and j push each other where they touch; returns how many corners do."""
    count = 0
    for layer in range(2):
        count += _corners_of(crowd, i, j, layer, True, pushes)
        count += _corners_of(crowd, j, i, layer, False, pushes)
    return count


@inlined
def _at_wall(crowd, i, x, z, n_x, n_z, b_x, b_z, y, depth, pushes):
    """Push body i off a wall at a point, or store its energy; returns 1 where it touches."""
    if depth <= 0.0:
        return 0
    crowd.book[DEEPEST] = max(crowd.book[DEEPEST], depth)
    if pushes:
        _resolve(crowd, i, -1, x, z, n_x, n_z, b_x, b_z, y, 0.0, 0.0, 0.0, depth)
    else:
        crowd.book[STORED] += 0.5 * crowd.law.stiffness * depth * depth
    return 1


@kernel
def meet_wall(crowd, i, pushes):
    """Let body i push off the walls that it touches; returns how many points do."""
    bodies, ground, count = crowd.bodies, crowd.ground, 0
    if ground.kind >= PERIODIC:
        return 0
    kind = bodies.kind[i]
    r = bodies.radius[kind]
    for layer in range(2):
        y = bodies.ends[kind, layer]
        for v in range(bodies.first[kind], bodies.first[kind + 1]):
            b_x, b_z = bodies.corners[v, 0], bodies.corners[v, 1]
            x, z = outward(crowd.planar, i, y, b_x, b_z)
            if ground.kind == RECTANGLE:
                for side in range(4):
                    n_x = (-1.0 if side == 0 else 1.0) if side < 2 else 0.0
                    n_z = (-1.0 if side == 2 else 1.0) if side >= 2 else 0.0
                    half = ground.outer if side < 2 else ground.inner
                    depth = r - half - n_x * x - n_z * z
                    count += _at_wall(
                        crowd, i, x - r * n_x, z - r * n_z, n_x, n_z, b_x, b_z, y, depth, pushes
                    )
            else:
                size = math.sqrt(x * x + z * z)
                n_x, n_z = -x / max(size, 1e-300), -z / max(size, 1e-300)
                count += _at_wall(
                    crowd, i, x - r * n_x, z - r * n_z, n_x, n_z, b_x, b_z, y,
                    size + r - ground.outer, pushes,
                )  # fmt: skip
        if ground.kind == RING:
            q_x, q_z = inward(crowd.planar, i, y, 0.0, 0.0)
            distance, b_x, b_z, _ = closest(bodies, kind, q_x, q_z)
            x, z = outward(crowd.planar, i, y, b_x, b_z)
            size = max(math.sqrt(x * x + z * z), 1e-300)
            count += _at_wall(
                crowd, i, x * ground.inner / size, z * ground.inner / size, x / size, z / size,
                b_x, b_z, y, ground.inner + r - distance, pushes,
            )  # fmt: skip
    return count
