"""Contacts of bodies with bodies and walls: impulses in a short time step (tick), between two free motions.

A corner compressed by d pushes with k d during compression and with e^2 k d during release. k is such that any two
bodies part after the same time (docs/physics.md section 9). The corner returns the share e^2 of the work done on it, as
in Stronge's definition of restitution. This holds for any masses, positions and number of corners in touch. Friction
acts along the face and up or down it, at most its coefficient times the normal impulse. A tick's impulse covers the
time that the corner touches: touch and parting err by second order.

Springs replace rigid impulses for two reasons. A printed corner and a face part after 0.1 to 0.2 ms (Hertz), a fiftieth
of a period of the plate, so both models give the same velocities. Springs also hold walkers that push each other and
jams of many, and the order of contacts does not matter.

`crowd` is a `bodies.Crowd` and `free` its arrays; `i` and `j` are numbers of walkers. a_x, a_y, a_z: a point from C in
body axes, mm. `pushes`: True to apply impulses, False to only add the energy of contacts to the crowd's book.
`layer`: 0 at the bottom of both bodies, 1 at the top. mobility: inverse effective mass, 1/g.
"""

import math

from walkergen.core.numerics.kernels import kernel_without_refcount, lean
from walkergen.core.simulation import record
from walkergen.core.simulation.space.state import C_X, C_Y, C_Z, LEGS, QUIET, V_X, W_X
from walkergen.core.simulation.world import OK
from walkergen.guests.crowd.space.bodies import (
    ALONG,
    DEEPEST,
    LIFTED,
    LOST,
    PERIODIC,
    PRESSED,
    RECTANGLE,
    RING,
    RUBBED,
    STORED,
    UP,
    WORK,
    X,
    Z,
)
from walkergen.guests.crowd.space.gaps import box_distance, closest_point, minimum_image, to_body_frame, to_plane


@lean
def _to_body_axes(free, i, x, y, z):
    """Return a point of the world (mm) in the axes of body i, from its centre of mass C. `free`: `bodies.Free`."""
    R, state = free.R, free.state
    d_x, d_y, d_z = x - state[i, C_X], y - state[i, C_Y], z - state[i, C_Z]
    return (
        R[i, 0, 0] * d_x + R[i, 1, 0] * d_y + R[i, 2, 0] * d_z,
        R[i, 0, 1] * d_x + R[i, 1, 1] * d_y + R[i, 2, 1] * d_z,
        R[i, 0, 2] * d_x + R[i, 1, 2] * d_y + R[i, 2, 2] * d_z,
    )


@lean
def _height(free, i, b_x, b_z, y):
    """Return the height in the world (mm) of the point (b_x, y, b_z) of body i, given in body axes from C."""
    R = free.R
    return free.state[i, C_Y] + R[i, 1, 0] * b_x + R[i, 1, 1] * y + R[i, 1, 2] * b_z


@lean
def _velocity(free, i, a_x, a_y, a_z):
    """Return the velocity (mm/s, world axes) of point a of body i. a_x, a_y, a_z: mm from C, body axes."""
    R, now, n, shift = free.R, free.now, free.coordinates[i], free.shift
    v_x = now[i, 0] + now[i, 4] * a_z - now[i, 5] * a_y
    v_y = now[i, 1] + now[i, 5] * a_x - now[i, 3] * a_z
    v_z = now[i, 2] + now[i, 3] * a_y - now[i, 4] * a_x
    for j in range(n):
        rate = free.state[i, LEGS + n + j]
        v_x -= shift[i, 0, j] * rate
        v_y -= shift[i, 1, j] * rate
        v_z -= shift[i, 2, j] * rate
    return (
        R[i, 0, 0] * v_x + R[i, 0, 1] * v_y + R[i, 0, 2] * v_z,
        R[i, 1, 0] * v_x + R[i, 1, 1] * v_y + R[i, 1, 2] * v_z,
        R[i, 2, 0] * v_x + R[i, 2, 1] * v_y + R[i, 2, 2] * v_z,
    )


@lean
def _body_wrench(free, i, a_x, a_y, a_z, f_x, f_y, f_z):
    """Return a force f, given in the world, and its moment about C, both in the axes of body i. f acts at point a."""
    R = free.R
    b_x = R[i, 0, 0] * f_x + R[i, 1, 0] * f_y + R[i, 2, 0] * f_z
    b_y = R[i, 0, 1] * f_x + R[i, 1, 1] * f_y + R[i, 2, 1] * f_z
    b_z = R[i, 0, 2] * f_x + R[i, 1, 2] * f_y + R[i, 2, 2] * f_z
    return b_x, b_y, b_z, a_y * b_z - a_z * b_y, a_z * b_x - a_x * b_z, a_x * b_y - a_y * b_x


@lean
def _mobility(free, i, a_x, a_y, a_z, d_x, d_y, d_z):
    """Return the inverse effective mass (1/g) of point a of body i along the unit vector d (world), with rigid legs."""
    _, _, _, t_x, t_y, t_z = _body_wrench(free, i, a_x, a_y, a_z, d_x, d_y, d_z)
    I = free.inverse_inertia  # noqa: E741
    return free.inverse_mass[i] + (
        t_x * (I[i, 0, 0] * t_x + I[i, 0, 1] * t_y + I[i, 0, 2] * t_z)
        + t_y * (I[i, 1, 0] * t_x + I[i, 1, 1] * t_y + I[i, 1, 2] * t_z)
        + t_z * (I[i, 2, 0] * t_x + I[i, 2, 1] * t_y + I[i, 2, 2] * t_z)
    )


@lean
def _apply_impulse(free, i, a_x, a_y, a_z, f_x, f_y, f_z):
    """Apply an impulse f (world, g mm/s) to a point of body i: change its state and its work in `free`.

    Returns the point's velocity after it in the world, mm/s. Legs lag as far as their joints allow.
    """
    state, now, n, m = free.state, free.now, free.coordinates[i], free.inverse_mass[i]
    shift, lock, I = free.shift, free.lock, free.inverse_inertia  # noqa: E741
    u_x, u_y, u_z = _velocity(free, i, a_x, a_y, a_z)
    b_x, b_y, b_z, t_x, t_y, t_z = _body_wrench(free, i, a_x, a_y, a_z, f_x, f_y, f_z)
    state[i, V_X] += m * f_x
    state[i, V_X + 1] += m * f_y
    state[i, V_X + 2] += m * f_z
    now[i, 0] += m * b_x
    now[i, 1] += m * b_y
    now[i, 2] += m * b_z
    for row in range(3):
        gained = I[i, row, 0] * t_x + I[i, row, 1] * t_y + I[i, row, 2] * t_z
        state[i, W_X + row] += gained
        now[i, 3 + row] += gained
    for j in range(n):
        hinge_impulse = shift[i, 0, j] * b_x + shift[i, 1, j] * b_y + shift[i, 2, j] * b_z
        hinge_impulse += lock[i, 0, j] * t_x + lock[i, 1, j] * t_y + lock[i, 2, j] * t_z
        for k in range(n):
            slower = free.hinge_mobility[i, k, j] * hinge_impulse
            state[i, LEGS + n + k] -= slower
            for row in range(3):
                now[i, 3 + row] += lock[i, row, k] * slower
    state[i, QUIET] = 0.0
    v_x, v_y, v_z = _velocity(free, i, a_x, a_y, a_z)
    done = 0.5 * (f_x * (u_x + v_x) + f_y * (u_y + v_y) + f_z * (u_z + v_z))
    free.sums[i, record.PLATE_WORK] += done
    return v_x, v_y, v_z


@lean
def _spring_impulse(stiffness, depth, speed, tick):
    """Return the impulse of a spring (g mm/s) in a tick (s) centred on now, during which it may touch or part.

    The depth is in mm now and changes at `speed` (mm/s). The spring pushes only while it touches.
    """
    if depth >= speed * tick:
        return stiffness * depth * tick
    inside = depth / speed + 0.5 * tick
    return 0.5 * stiffness * speed * inside * inside


@lean
def _normal_impulse(stiffness, kept, depth, u, mobility, tick):
    """Compute the impulse (g mm/s) along the normal in a tick (s), and that of a spring without loss.

    `kept`: restitution squared. `depth`: overlap, mm. `u`: normal velocity (mm/s), positive when parting.
    """
    whole = _spring_impulse(stiffness, depth, abs(u), tick)
    after = u + mobility * whole
    if u >= 0.0:
        whole = _spring_impulse(stiffness, depth, u + kept * mobility * whole, tick)
        return kept * whole, whole
    if after <= 0.0:
        return whole, whole
    stopped = -u / (after - u)
    return whole * (stopped + (1.0 - stopped) * kept), whole


@kernel_without_refcount
def _resolve_contact(crowd, i, j, x, z, n_x, n_z, b_x, b_z, y_i, c_x, c_z, y_j, depth, pushes):
    """Push bodies i and j (j = -1: a wall) apart at one contact or, unless `pushes`, only add its energy to the book.

    Changes the bodies' states and the crowd's book. The touch is at (x, z) of the plane (body i's image). Its normal
    (n_x, n_z) points from j to i. In each body's axes it is the point (b_x, y_i, b_z) of i and (c_x, y_j, c_z) of j.
    `depth`: overlap, mm.
    """
    law, book, free, wall = crowd.law, crowd.book, crowd.free, j < 0
    moves_i, moves_j = crowd.status[i] == OK, not wall and crowd.status[j] == OK
    y = _height(free, i, b_x, b_z, y_i)
    x_j, z_j = x, z
    if not wall:
        y = 0.5 * (y + _height(free, j, c_x, c_z, y_j))
        x_j = crowd.planar[j, X] + minimum_image(crowd.ground, x - crowd.planar[j, X])
        z_j = crowd.planar[j, Z] + minimum_image(crowd.ground, z - crowd.planar[j, Z])
    a_x, a_y, a_z = _to_body_axes(free, i, x, y, z)
    d_x, d_y, d_z = _to_body_axes(free, max(j, 0), x_j, y, z_j)
    u_x, u_y, u_z = 0.0, 0.0, 0.0
    if moves_i:
        u_x, u_y, u_z = _velocity(free, i, a_x, a_y, a_z)
    v_x, v_y, v_z = 0.0, 0.0, 0.0
    if wall:
        v_y = crowd.planar[i, LIFTED]
    elif moves_j:
        v_x, v_y, v_z = _velocity(free, j, d_x, d_y, d_z)
    u_x, u_y, u_z = u_x - v_x, u_y - v_y, u_z - v_z
    u_n = u_x * n_x + u_z * n_z
    t_x, t_y, t_z = u_x - u_n * n_x, u_y, u_z - u_n * n_z
    slip = math.sqrt(t_x * t_x + t_y * t_y + t_z * t_z)
    if slip > 0.0:
        t_x, t_y, t_z = t_x / slip, t_y / slip, t_z / slip
    along, across = 0.0, 0.0
    if moves_i:
        along += _mobility(free, i, a_x, a_y, a_z, n_x, 0.0, n_z)
        across += _mobility(free, i, a_x, a_y, a_z, t_x, t_y, t_z)
    if moves_j:
        along += _mobility(free, j, d_x, d_y, d_z, n_x, 0.0, n_z)
        across += _mobility(free, j, d_x, d_y, d_z, t_x, t_y, t_z)
    if along == 0.0:
        return
    book[DEEPEST] = max(book[DEEPEST], depth)
    stiffness = law.spring / along
    if not pushes:
        book[STORED] += 0.5 * stiffness * depth * depth
        return
    row = 1 if wall else 0
    push, whole = _normal_impulse(stiffness, law.kept[row], depth, u_n, along, crowd.tick[0])
    rub = min(law.friction[row] * push, slip / across)
    f_x, f_y, f_z = push * n_x - rub * t_x, -rub * t_y, push * n_z - rub * t_z
    w_x, w_y, w_z = 0.0, 0.0, 0.0
    if moves_i:
        w_x, w_y, w_z = _apply_impulse(free, i, a_x, a_y, a_z, f_x, f_y, f_z)
    if moves_j:
        v_x, v_y, v_z = _apply_impulse(free, j, d_x, d_y, d_z, -f_x, -f_y, -f_z)
    w_x, w_y, w_z = w_x - v_x, w_y - v_y, w_z - v_z
    w_n = w_x * n_x + w_z * n_z
    rubbed = t_x * (u_x + w_x) + t_y * (u_y + w_y) + t_z * (u_z + w_z)
    book[WORK] += 0.5 * push * (u_n + w_n)
    book[LOST] += (whole - push) * 0.5 * (max(u_n, 0.0) + max(w_n, 0.0))
    book[RUBBED] += 0.5 * rub * rubbed
    book[PRESSED] += push
    book[ALONG] += rub * math.hypot(t_x, t_z)
    book[UP] += rub * abs(t_y)


FLUSH_DISTANCE_MM = 0.05
"""Distance of two corners along their faces, mm, within which these faces end together."""


@lean
def _is_counted_twice(crowd, i, j, layer, first, is_corner, c_x, c_z, end):
    """Return whether another corner counts the touch of a corner of body i with point (c_x, c_z) of body j.

    `first`: whether i is the first body of the pair. `is_corner`: whether the point is a corner of j. `end`: number of
    that corner, or of the closest one. A touch of two corners is found from both bodies. It counts for the first body
    if each corner is the other's closest point, else a face is closer. Faces that end together, turned a little
    against each other, have a corner on either face: the first body's counts.
    """
    if is_corner and not first:
        return True
    bodies, planar = crowd.bodies, crowd.planar
    kind_i, kind_j = bodies.kind[i], bodies.kind[j]
    e_x, e_z = bodies.corners[end, 0], bodies.corners[end, 1]
    if not is_corner and (first or math.hypot(c_x - e_x, c_z - e_z) > FLUSH_DISTANCE_MM):
        return False
    x, z = to_plane(planar, j, bodies.heights[kind_j, kind_i, layer], e_x, e_z)
    x = planar[i, X] + minimum_image(crowd.ground, x - planar[i, X])
    z = planar[i, Z] + minimum_image(crowd.ground, z - planar[i, Z])
    q_x, q_z = to_body_frame(planar, i, bodies.heights[kind_i, kind_j, layer], x, z)
    _, _, _, at_corner, _ = closest_point(bodies, kind_i, q_x, q_z)
    return not at_corner


@lean
def _resolve_corners(crowd, i, j, layer, first, pushes):
    """Resolve the contacts of corners of body i with body j in a layer. Return the number of corners that touch.

    `layer`: 0 at the bottom of both bodies, 1 at the top. `first`: whether i is the pair's first body, which counts
    touches of two corners. `pushes`: as in `resolve_pair`.
    """
    bodies, planar, count = crowd.bodies, crowd.planar, 0
    kind_i, kind_j = bodies.kind[i], bodies.kind[j]
    y_i, y_j = bodies.heights[kind_i, kind_j, layer], bodies.heights[kind_j, kind_i, layer]
    r, r_j = bodies.radius[kind_i], bodies.radius[kind_j]
    for v in range(bodies.first[kind_i], bodies.first[kind_i + 1]):
        b_x, b_z = bodies.corners[v, 0], bodies.corners[v, 1]
        x, z = to_plane(planar, i, y_i, b_x, b_z)
        s_x = minimum_image(crowd.ground, x - planar[j, X]) - (x - planar[j, X])
        s_z = minimum_image(crowd.ground, z - planar[j, Z]) - (z - planar[j, Z])
        q_x, q_z = to_body_frame(planar, j, y_j, x + s_x, z + s_z)
        if box_distance(bodies, kind_j, q_x, q_z) >= r + r_j:
            continue
        distance, c_x, c_z, is_corner, end = closest_point(bodies, kind_j, q_x, q_z)
        depth = r + r_j - distance
        if depth <= 0.0 or distance == 0.0:
            continue
        if _is_counted_twice(crowd, i, j, layer, first, is_corner, c_x, c_z, end):
            continue
        count += 1
        p_x, p_z = to_plane(planar, j, y_j, c_x, c_z)
        n_x, n_z = (x + s_x - p_x) / distance, (z + s_z - p_z) / distance
        middle = r - 0.5 * depth
        _resolve_contact(
            crowd, i, j, x - middle * n_x, z - middle * n_z, n_x, n_z, b_x, b_z, y_i, c_x, c_z, y_j, depth, pushes
        )
    return count


@kernel_without_refcount
def resolve_pair(crowd, i, j, pushes):
    """Push bodies i and j apart at all contacts or, unless `pushes`, sum their energy. Return the contacts' number."""
    count = 0
    for layer in range(2):
        count += _resolve_corners(crowd, i, j, layer, True, pushes)  # i is the first body
        count += _resolve_corners(crowd, j, i, layer, False, pushes)
    return count


@lean
def _push_off_wall(crowd, i, x, z, n_x, n_z, b_x, b_z, y, depth, pushes):
    """Resolve the contact of body i with a wall and return 1; return 0 if `depth` <= 0. See `_resolve_contact`."""
    if depth <= 0.0:
        return 0
    _resolve_contact(crowd, i, -1, x, z, n_x, n_z, b_x, b_z, y, 0.0, 0.0, 0.0, depth, pushes)
    return 1


@kernel_without_refcount
def resolve_walls(crowd, i, pushes):
    """Push body i off walls at all contacts or, unless `pushes`, sum their energy. Return the contacts' number."""
    bodies, ground, count = crowd.bodies, crowd.ground, 0
    if ground.kind >= PERIODIC:
        return 0
    kind = bodies.kind[i]
    r = bodies.radius[kind]
    for layer in range(2):
        y = bodies.ends[kind, layer]
        for v in range(bodies.first[kind], bodies.first[kind + 1]):
            b_x, b_z = bodies.corners[v, 0], bodies.corners[v, 1]
            x, z = to_plane(crowd.planar, i, y, b_x, b_z)
            if ground.kind == RECTANGLE:
                for side in range(4):
                    n_x = (-1.0 if side == 0 else 1.0) if side < 2 else 0.0
                    n_z = (-1.0 if side == 2 else 1.0) if side >= 2 else 0.0
                    half = ground.outer if side < 2 else ground.inner
                    depth = r - half - n_x * x - n_z * z
                    count += _push_off_wall(crowd, i, x - r * n_x, z - r * n_z, n_x, n_z, b_x, b_z, y, depth, pushes)
            else:
                size = math.sqrt(x * x + z * z)
                n_x, n_z = -x / max(size, 1e-300), -z / max(size, 1e-300)
                count += _push_off_wall(
                    crowd, i, x - r * n_x, z - r * n_z, n_x, n_z, b_x, b_z, y, size + r - ground.outer, pushes
                )
        if ground.kind == RING:
            q_x, q_z = to_body_frame(crowd.planar, i, y, 0.0, 0.0)
            distance, b_x, b_z, _, _ = closest_point(bodies, kind, q_x, q_z)
            x, z = to_plane(crowd.planar, i, y, b_x, b_z)
            size = max(math.sqrt(x * x + z * z), 1e-300)
            n_x, n_z, depth = x / size, z / size, ground.inner + r - distance
            x, z = x * ground.inner / size, z * ground.inner / size
            count += _push_off_wall(crowd, i, x, z, n_x, n_z, b_x, b_z, y, depth, pushes)
    return count
