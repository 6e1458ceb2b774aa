"""Landing of one foot on relaxed legs: a cascade of impacts (docs/physics.md section 5, trap 1).

The flexible tensor sets the impulse F(v) of an impact, the rigid tensor the velocity after it, v' =
v + H_rigid F(v): infinitely many impacts may pass at one instant. F is homogeneous of degree 1 in
v, and for Poisson's and Newton's laws linear within each type of impact. So the sequence ends in
one of three ways, after finite work:

* an impact separates the foot;
* the foot slides on throughout (type I, IV) and its approach dies geometrically: closed form;
* both components die: the impulse is the one that stops the foot in the rigid tensor.

Long runs of impacts of one type are powers of one matrix and are raised by squaring. Under
Stronge's law, which is not linear, they are made one by one.

Limit: where friction is high enough for either tensor to jam (H_yy / |H_xy| and more), types may
follow one another chaotically, some tens to hundreds of times: in 1 of 25 000 pairs of random
tensors with friction up to 1e3, in walkers from friction 1.5 on. Rounding then grows to the size of
the landing, which the last digit of any number decides: the sum is lawful (in the cone, leaving, by
the body's inertia), but exact arithmetic determines it no better. Else it is that of the impacts
one by one, to 1e-6 at a condition of 1e4.
"""

import math
from typing import NamedTuple

from walkergen.numerics.kernels import kernel
from walkergen.simulation.record import tally_impact
from walkergen.simulation.relaxed.state import Tensor
from walkergen.theory.impact import FROM_REST, NONE, STRONGE, TYPE_I, TYPE_IV, determinant, impact

MOST_IMPACTS = 1_000_000
# Impacts after which runs of one type are raised to powers; after which `_trapped` is asked.
GALLOP_AFTER, SLOW = 8, 4096
NEIGHBOURS = (0.125, -0.125, 0.001, -0.001)
# Speeds, over the first speed, that count as dead, as zero but for rounding, as without bound.
DEAD, ROUNDING, BOUNDLESS = 1e-13, 1e-14, 1e100


class Landing(NamedTuple):
    """Outcome of a cascade at one foot: impulse (g mm/s), velocity (mm/s), type."""

    F_x: float
    F_y: float
    v_x: float
    v_y: float
    """Velocity after it, over the plate; v_y = 0: the foot stays down."""
    kind: int
    """`Kind` of the first impact; 0: the foot was not approaching."""
    finished: bool
    """False: no end within `MOST_IMPACTS` (the law makes energy without bound)."""


@kernel
def stopping_impulse(H: Tensor, v_x: float, v_y: float) -> tuple[float, float]:
    """Impulse that stops a foot, F = -H^-1 v, g mm/s."""
    det = determinant(H.xx, H.xy, H.yy)
    return (H.xy * v_y - H.yy * v_x) / det, (H.xy * v_x - H.xx * v_y) / det


@kernel
def cascade(own, rigid, v_x, v_y, contact, counts):
    """`Landing` of a foot that meets the plate with (v_x, v_y < 0) mm/s, after all its impacts.

    `own` (Tensor, 1/g, in the plate's frame) sets each impulse, `rigid` the velocity after it.
    Impacts summed in closed form count as one.
    """
    e, mu, law = contact.restitution, contact.friction, contact.law
    F_x, F_y, u_x, u_y, first = 0.0, 0.0, v_x, v_y, NONE
    size = max(abs(v_x), abs(v_y))
    mark_x, mark_y, widest = 0.0, 0.0, 0.0
    for n in range(MOST_IMPACTS):
        hit = impact(own.xx, own.xy, own.yy, u_x, u_y, e, mu, law)
        tally_impact(counts, hit.kind, hit.sticks)
        first = hit.kind if n == 0 else first
        if hit.kind == TYPE_I or hit.kind == TYPE_IV or mu == 0.0:
            s_mu = -mu if hit.kind == TYPE_IV else mu
            slope = rigid.yy - s_mu * rigid.xy
            end_x = u_x + (rigid.xy - s_mu * rigid.xx) * (-u_y / slope)
            if 0.0 < slope * hit.F_y <= -u_y and (end_x * u_x >= 0.0 or mu == 0.0):
                rest = -u_y / slope
                return Landing(F_x - s_mu * rest, F_y + rest, end_x, 0.0, first, True)
        w_x = u_x + (rigid.xx * hit.F_x + rigid.xy * hit.F_y)
        w_y = u_y + (rigid.xy * hit.F_x + rigid.yy * hit.F_y)
        G_x, G_y = hit.F_x, hit.F_y
        dies = hit.kind == FROM_REST and w_x == 0.0 and u_y < w_y <= 0.0
        if n >= GALLOP_AFTER and law != STRONGE and u_x != 0.0:  # which is not linear
            w_x, w_y = _gallop(own, rigid, u_x, u_y, w_x, w_y, hit, contact)
            G_x, G_y = stopping_impulse(rigid, u_x - w_x, u_y - w_y)
        t_x, t_y, u_x, u_y, F_x, F_y = u_x, u_y, w_x, w_y, F_x + G_x, F_y + G_y
        left = max(abs(u_x), abs(u_y))
        if n >= SLOW:
            widest = max(widest, (abs(w_x - t_x) + abs(w_y - t_y)) / left)
            if n & (n - 1) == 0:  # at powers of two
                dies = dies or _trapped(mark_x, mark_y, u_x, u_y, widest)
                mark_x, mark_y, widest = u_x, u_y, 0.0
        if dies or left <= DEAD * size:
            F_x, F_y = stopping_impulse(rigid, v_x, v_y)
            return Landing(F_x, F_y, 0.0, 0.0, first, True)
        if u_y >= -ROUNDING * size:
            return Landing(F_x, F_y, u_x, u_y if u_y > ROUNDING * size else 0.0, first, True)
        if not left < BOUNDLESS * size:
            break
    return Landing(F_x, F_y, u_x, u_y, first, False)


@kernel
def _trapped(from_x, from_y, to_x, to_y, widest):
    """True when thousands of impacts, each a change <= `widest`, shrank v without turning it.

    The direction of v chatters across the border of two types, both of which lead back to it (a
    sliding mode): it stays, and v dies along it.
    """
    start, end = math.hypot(from_x, from_y), math.hypot(to_x, to_y)
    if start == 0.0:
        return False
    turn = abs(from_x * to_y - from_y * to_x) / (start * end)
    return start > end and math.log(start / end) > 500.0 * widest and turn < 8.0 * widest


@kernel
def _gallop(own, rigid, u_x, u_y, w_x, w_y, hit, contact):
    """Velocity after the impact `hit` (u -> w) and as many more of its type as squaring reaches.

    The ratio v_x/v_y moves one way through the cone of a type, so that a power of the impact's
    matrix whose image is still inside has skipped no other type.
    """
    a, b, c, d, solvable = _matrix(own, rigid, u_x, u_y, hit, contact)
    turns_back = a * d - b * c <= 0.0 or a + d <= 0.0
    inside = solvable and not turns_back and _same_type(own, w_x, w_y, hit, contact)
    while inside:
        next_x, next_y = a * w_x + b * w_y, c * w_x + d * w_y
        inside = _same_type(own, next_x, next_y, hit, contact)
        if inside:
            w_x, w_y = next_x, next_y
            a, b, c, d = a * a + b * c, b * (a + d), c * (a + d), d * d + b * c
    return w_x, w_y


@kernel
def _same_type(own, v_x, v_y, hit, contact):
    if not (v_y < 0.0 and abs(v_y) + abs(v_x) < 1e200):
        return False
    there = impact(own.xx, own.xy, own.yy, v_x, v_y, contact.restitution, contact.friction, contact.law)
    return there.kind == hit.kind and there.sticks == hit.sticks


@kernel
def _matrix(own, rigid, u_x, u_y, hit, contact):
    """Entries (xx, xy, yx, yy) of the linear map v -> v' of a type of impact; False: not known.

    They follow from the impulses at u and at a neighbour of the same type: exact, being linear.
    """
    for step in range(4):
        q_x = u_x * (1.0 + NEIGHBOURS[step])
        near = impact(own.xx, own.xy, own.yy, q_x, u_y, contact.restitution, contact.friction, contact.law)
        if near.kind == hit.kind and near.sticks == hit.sticks:
            xx, yx = (near.F_x - hit.F_x) / (q_x - u_x), (near.F_y - hit.F_y) / (q_x - u_x)
            xy, yy = (hit.F_x - xx * u_x) / u_y, (hit.F_y - yx * u_x) / u_y
            return (
                1.0 + rigid.xx * xx + rigid.xy * yx,
                rigid.xx * xy + rigid.xy * yy,
                rigid.xy * xx + rigid.yy * yx,
                1.0 + rigid.xy * xy + rigid.yy * yy,
                True,
            )
    return 1.0, 0.0, 0.0, 1.0, False
