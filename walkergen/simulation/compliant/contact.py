"""Contact of two feet with the plate: impacts at one instant, and the modes of lasting contact.

Modes of lasting contact are enumerated, the last pair first: each foot is open, sticks or slips
either way; impulses follow from the linear equations of the mode pair, and the pair is right if its
signs agree with Coulomb and Signorini. This serves velocities (a time step) and accelerations.

Impacts: one foot after the other by the law of `theory.impact`. Feet that approach in the same
instant get (1 + e) times the impulses of their common plastic impact under every law, each with its
own e, which is mirror-symmetric and never creates energy.
"""

import math
from typing import NamedTuple

import numpy as np

from walkergen.numerics.kernels import inlined, kernel
from walkergen.simulation import record
from walkergen.simulation.compliant.chain import (
    Chain,
    Mobility,
    accelerate,
    chain_of,
    feet_velocities,
    gaps,
    mobility_of,
    push,
    shift,
)
from walkergen.simulation.drive import velocity
from walkergen.simulation.record import Tally, add_impulse, note_event, tally_impact
from walkergen.simulation.world import ANGLE_BACK, ANGLE_FRONT, FORWARD, MODE_BACK, MODE_FRONT, OPEN, PHASE, STICK
from walkergen.theory.impact import FROM_REST, III_MIRRORED, TYPE_I, TYPE_III, TYPE_IV, impact

SHARING = 1e-12
"""Relative softness added to the friction of two feet that stick: how feet on stiff legs share it
is undetermined, and the softness picks least squares (equal halves)."""

SMOOTH = (0.0, 0.0)
"""Friction of both feet where only their normal velocities are to be stopped."""

FRICTIONLESS = 1e-12
"""Coefficient of friction below which no foot sticks: rounding hides the force and its side."""

PLASTIC = (0.0, 0.0)
"""Restitution of both feet where none rebounds."""

ALTERNATIONS = 60
"""Number of impacts at one instant after which the rest of the sequence is taken as plastic."""


@kernel
def applied(W, F):
    """Velocities (back x, y, front x, y) that impulses F at the feet add, W the mobility."""
    b_x, b_y, f_x, f_y = F
    return (
        W.bb_xx * b_x + W.bb_xy * b_y + W.bf_xx * f_x + W.bf_xy * f_y,
        W.bb_xy * b_x + W.bb_yy * b_y + W.bf_yx * f_x + W.bf_yy * f_y,
        W.bf_xx * b_x + W.bf_yx * b_y + W.ff_xx * f_x + W.ff_xy * f_y,
        W.bf_xy * b_x + W.bf_yy * b_y + W.ff_xy * f_x + W.ff_yy * f_y,
    )


@kernel
def _single(xx, xy, yy, u_x, u_y, mode, friction):
    """Impulse at one foot that moves at u: it stops the foot (STICK) or its normal velocity."""
    if mode == STICK:
        d = xx * yy - xy * xy
        return (xy * u_y - yy * u_x) / d, (xy * u_x - xx * u_y) / d
    ratio = -friction if mode == FORWARD else friction
    normal = -u_y / (yy + ratio * xy)
    return ratio * normal, normal


@kernel
def _row(rows, i, mode, friction, w_x, w_y, u_x, u_y):
    """Set two equations of foot i: it stays on the plate, and sticks or obeys sliding friction."""
    for k in range(4):
        rows[2 * i, k] = w_y[k]
        rows[2 * i + 1, k] = w_x[k] if mode == STICK else 0.0
    rows[2 * i, 4] = -u_y
    if mode == STICK:
        rows[2 * i + 1, 2 * i] += SHARING * w_x[2 * i]
        rows[2 * i + 1, 4] = -u_x
    else:
        rows[2 * i + 1, 2 * i] = w_x[2 * i]  # in the unit of the other rows: pivots follow no unit
        rows[2 * i + 1, 2 * i + 1] = w_x[2 * i] * (friction if mode == FORWARD else -friction)
        rows[2 * i + 1, 4] = 0.0


@kernel
def _eliminate(rows):
    """Solve 4 equations by Gauss with partial pivoting, in place; the solution is a tuple."""
    for i in range(4):
        pivot = i
        for j in range(i + 1, 4):
            if abs(rows[j, i]) > abs(rows[pivot, i]):
                pivot = j
        if pivot != i:
            for k in range(i, 5):
                rows[i, k], rows[pivot, k] = rows[pivot, k], rows[i, k]
        for j in range(i + 1, 4):
            factor = rows[j, i] / rows[i, i]
            for k in range(i + 1, 5):
                rows[j, k] -= factor * rows[i, k]
    for i in range(3, -1, -1):
        for k in range(i + 1, 4):
            rows[i, 4] -= rows[i, k] * rows[k, 4]
        rows[i, 4] /= rows[i, i]
    return rows[0, 4], rows[1, 4], rows[2, 4], rows[3, 4]


@kernel
def impulses(W, u, back, front, friction, rows):
    """Impulses (back x, y, front x, y) of a mode pair when the feet would move at u without them.

    `friction` is that of either foot (back, front), here and below; `rows` is work space of shape
    (4, 5).
    """
    u_1, u_2, u_3, u_4 = u
    if back == OPEN and front == OPEN:
        return 0.0, 0.0, 0.0, 0.0
    if front == OPEN:
        b_x, b_y = _single(W.bb_xx, W.bb_xy, W.bb_yy, u_1, u_2, back, friction[0])
        return b_x, b_y, 0.0, 0.0
    if back == OPEN:
        f_x, f_y = _single(W.ff_xx, W.ff_xy, W.ff_yy, u_3, u_4, front, friction[1])
        return 0.0, 0.0, f_x, f_y
    b_x, b_y = (W.bb_xx, W.bb_xy, W.bf_xx, W.bf_xy), (W.bb_xy, W.bb_yy, W.bf_yx, W.bf_yy)
    f_x, f_y = (W.bf_xx, W.bf_yx, W.ff_xx, W.ff_xy), (W.bf_xy, W.bf_yy, W.ff_xy, W.ff_yy)
    _row(rows, 0, back, friction[0], b_x, b_y, u_1, u_2)
    _row(rows, 1, front, friction[1], f_x, f_y, u_3, u_4)
    return _eliminate(rows)


@kernel
def _violation(mode, w_x, w_y, F_x, F_y, xx, yy, friction):
    """Excess (in units of u) by which a foot's mode contradicts its signs; w: velocity after."""
    if mode == OPEN:
        return -w_y
    worst = -F_y * yy
    if mode == STICK:
        return max(worst, (abs(F_x) - friction * F_y) * xx)
    return max(worst, -w_x if mode == FORWARD else w_x)


@kernel
def solve(W, u, touching, guess, friction, rows):
    """Modes and impulses of contact: (back, front, impulses).

    u: velocities of the feet without contact. touching: (bool, bool). guess: the mode pair tried
    first. Where every pair contradicts its signs (sliding that jams; Painleve), the least does.
    """
    scale = abs(u[0]) + abs(u[1]) + abs(u[2]) + abs(u[3]) + 1e-300
    best, best_back, best_front = math.inf, OPEN, OPEN
    best_F = (0.0, 0.0, 0.0, 0.0)
    for trial in range(-1, 16):
        back, front = (guess[0], guess[1]) if trial < 0 else (trial // 4, trial % 4)
        if not _allowed(back, touching[0], friction[0]):
            continue
        if not _allowed(front, touching[1], friction[1]):
            continue
        F = impulses(W, u, back, front, friction, rows)
        d = applied(W, F)
        violation = 0.0
        if touching[0]:
            violation = _violation(back, u[0] + d[0], u[1] + d[1], F[0], F[1], W.bb_xx, W.bb_yy, friction[0])
        if touching[1]:
            other = _violation(front, u[2] + d[2], u[3] + d[3], F[2], F[3], W.ff_xx, W.ff_yy, friction[1])
            violation = max(violation, other)
        if violation < best:
            best, best_back, best_front, best_F = violation, back, front, F
        if best <= 1e-12 * scale:
            break
    return best_back, best_front, best_F


@kernel
def _allowed(mode, touching, friction):
    if mode == STICK and friction < FRICTIONLESS:
        return False
    return touching or mode == OPEN


class Instant(NamedTuple):
    """Chain and mobility, which do not change while impacts pass, and the tally of the impacts."""

    chain: Chain
    mobility: Mobility
    rows: np.ndarray
    """Work space of shape (4, 5)."""
    tally: Tally


@kernel
def one_foot(world, restitution, state, now, foot):
    """Impact of foot 0 (back) or 1 by the law of `theory.impact`; changes rates in `state`."""
    u, W, tally = feet_velocities(world, state, now.chain), now.mobility, now.tally
    if foot == 0:
        v_x, v_y, xx, xy, yy = u[0], u[1], W.bb_xx, W.bb_xy, W.bb_yy
    else:
        v_x, v_y, xx, xy, yy = u[2], u[3], W.ff_xx, W.ff_xy, W.ff_yy
    contact = world.contacts[foot]
    hit = impact(xx, xy, yy, v_x, v_y, restitution, contact.friction, contact.law)
    F = (hit.F_x, hit.F_y, 0.0, 0.0) if foot == 0 else (0.0, 0.0, hit.F_x, hit.F_y)
    accelerate(state, push(now.chain, F))
    tally_impact(tally.counts, hit.kind, hit.sticks)
    add_impulse(tally.sums, hit.kind, hit.F_y)
    tally.sums[record.PLATE_WORK] += hit.F_y * velocity(world.drive, state[PHASE])
    tally.sums[record.IMPACT_LOSS] -= 0.5 * (hit.F_x * (v_x + hit.v_x) + hit.F_y * (v_y + hit.v_y))
    note_event(tally.events, tally.sums[record.ELAPSED], foot, hit.F_x, hit.F_y, v_x, v_y, hit.kind)


@kernel
def _restored(W, F, e):
    """Factors of the impulses F (back, front) of a plastic impact, which restitution leaves.

    The restoring impulses R = (e F back, e F front) give back at most what the plastic impact took:
    R W R <= F W F, which unlike e can break where one foot's impulse throws the other down.
    """
    part = 1.0
    if e[0] != e[1]:
        R = (e[0] * F[0], e[0] * F[1], e[1] * F[2], e[1] * F[3])
        compressed, released = _product(F, applied(W, F)), _product(R, applied(W, R))
        if released > compressed:
            part = math.sqrt(compressed / released)
    return 1.0 + part * e[0], 1.0 + part * e[1]


@kernel
def _product(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]


@inlined
def frictions(world):
    """Friction of the back and the front foot."""
    return world.contacts[0].friction, world.contacts[1].friction


@inlined
def restitutions(world):
    """Restitution of the back and the front foot."""
    return world.contacts[0].restitution, world.contacts[1].restitution


@kernel
def both_feet(world, restitution, state, now):
    """Impact of both feet at once: (1 + e) times the impulses of their common plastic impact, each
    foot with its own of both restitutions e, less where unlike ones would create energy.
    """
    u, W, tally = feet_velocities(world, state, now.chain), now.mobility, now.tally
    both = (True, True)
    _, _, F = solve(W, u, both, (STICK, STICK), frictions(world), now.rows)
    b, f = _restored(W, F, restitution)
    F = (b * F[0], b * F[1], f * F[2], f * F[3])
    d = applied(W, F)
    accelerate(state, push(now.chain, F))
    tally.sums[record.PLATE_WORK] += (F[1] + F[3]) * velocity(world.drive, state[PHASE])
    for foot in range(2):
        F_x, F_y, v_x, v_y = F[2 * foot], F[2 * foot + 1], u[2 * foot], u[2 * foot + 1]
        d_x, d_y = d[2 * foot], d[2 * foot + 1]
        tally.sums[record.IMPACT_LOSS] -= F_x * (v_x + 0.5 * d_x) + F_y * (v_y + 0.5 * d_y)
        stops = abs(v_x + d_x) <= 1e-9 * abs(v_x)
        if v_x == 0.0:
            kind = FROM_REST
        elif v_x > 0.0:
            kind = TYPE_III if stops else TYPE_I
        else:
            kind = III_MIRRORED if stops else TYPE_IV
        tally_impact(tally.counts, kind, abs(kind) == TYPE_III)
        add_impulse(tally.sums, kind, F_y)
        note_event(tally.events, tally.sums[record.ELAPSED], foot, F_x, F_y, v_x, v_y, kind)


@kernel
def collide(world, restitution, state, now, touching, rest):
    """Resolve the impacts of one instant in `state`: of touching feet that approach beyond `rest`,
    at the `restitution` of either.

    A foot that would rebound slower than its `rest` (mm/s) stays: so endless impacts (Zeno) end.
    """
    e, u = restitution, feet_velocities(world, state, now.chain)
    if touching[0] and touching[1] and u[1] < -rest[0] and u[3] < -rest[1]:
        bounces = -u[1] * e[0] > rest[0] or -u[3] * e[1] > rest[1]
        both_feet(world, e if bounces else PLASTIC, state, now)
    for _ in range(ALTERNATIONS):
        u = feet_velocities(world, state, now.chain)
        back, front = touching[0] and u[1] < -rest[0], touching[1] and u[3] < -rest[1]
        if not (back or front):
            return
        foot = 0 if back and (not front or u[1] <= u[3]) else 1
        bounces = -u[2 * foot + 1] * e[foot] > rest[foot]
        one_foot(world, e[foot] if bounces else 0.0, state, now, foot)
    both_feet(world, PLASTIC, state, now)


@kernel
def settle(world, state, implicit, rows):
    """Shift the closed feet onto the plate, which takes away the drift of their gaps.

    `implicit`, as in `chain_of`, lets hinges too stiff for the step keep their angles.
    """
    chain = chain_of(world.walker, state, implicit)
    back, front = gaps(world.drive, state, chain)
    modes = ((OPEN if state[MODE_BACK] == OPEN else FORWARD), (OPEN if state[MODE_FRONT] == OPEN else FORWARD))
    W = mobility_of(chain)
    F = impulses(W, (0.0, back, 0.0, front), modes[0], modes[1], SMOOTH, rows)
    shift(state, push(chain, F))


@kernel
def folded(state):
    """True when a leg has turned by 90 degrees against the body: its stop."""
    return max(abs(state[ANGLE_BACK]), abs(state[ANGLE_FRONT])) >= 0.5 * math.pi
