"""Bookkeeping of contacts in a step: springs, energies, and landings with their types.

A landing lasts from the first force to the last. Its type is that of an impact (docs/physics.md section 3): whether the
slip along the heading goes on (I, IV), or stops in compression (III) or in restitution (II).

The row of a contact in the 1-d array `state` starts at `at`; constants such as MODE name its entries (state.py).
"""

from walkergen.core.numerics.kernels import lean
from walkergen.core.simulation import record
from walkergen.core.simulation.space.state import (
    ACROSS,
    ALONG,
    IN_COMPRESSION,
    IN_RESTITUTION,
    J_A,
    J_C,
    J_N,
    LANDED,
    MODE,
    OPEN,
    SHEAR,
    SLIDING,
    STICK,
    STOP,
    U_A,
    U_C,
    U_N,
)
from walkergen.core.simulation.space.tips import elastic_energy
from walkergen.core.theory.impact import II_MIRRORED, III_MIRRORED, TYPE_I, TYPE_II, TYPE_III, TYPE_IV

TYPES_FORWARD = (TYPE_I, TYPE_II, TYPE_III)
TYPES_BACKWARD = (TYPE_IV, II_MIRRORED, III_MIRRORED)
"""Types of landings by the values of STOP, for feet that land sliding forward, and backward."""


@lean
def _begin_landing(state, at, t, u_n, u_a, u_c):
    """Record a landing at time t (s), velocity u (normal, along, across; mm/s), in the contact's row from `at` on."""
    state[at + LANDED], state[at + STOP] = t, SLIDING
    state[at + U_N], state[at + U_A], state[at + U_C] = u_n, u_a, u_c
    state[at + J_N] = state[at + J_A] = state[at + J_C] = 0.0


@lean
def end_landing(state, at, k, on_plate, tally):
    """Count the landing of contact k that has ended; `at` is the index of the contact's row in the state.

    Impulses are added up for landings `on_plate`, not for touches of walls or of a lid.
    """
    stop = int(state[at + STOP])
    kind = TYPES_FORWARD[stop] if state[at + U_A] >= 0.0 else TYPES_BACKWARD[stop]
    record.tally_impact(tally.counts, kind, state[at + MODE] == STICK)
    state[at + MODE] = OPEN
    if on_plate:
        record.add_impulse(tally.sums, kind, state[at + J_N])
    record.note_event(
        tally.events, state[at + LANDED], k, state[at + J_A], state[at + J_N], state[at + U_A], state[at + U_N], kind
    )


@lean
def advance_contact(state, near, i, at, t, h, sums):
    """Advance the springs of near contact i over a step of h seconds. Return whether a landing has ended.

    The step ends at t (s). The energy that the contact's damper and slider take is added to `sums`. Its row in the
    state starts at `at`.
    """
    gap, u_n = near[i].gap[0], near[i].middle[0]
    before, mode = int(state[at + MODE]), near[i].tried
    spring, tip = near[i].spring, near[i].tip
    if mode == OPEN:
        if before != OPEN:  # its damper pulls: what its springs still hold is lost
            stretch = state[at + ALONG] * state[at + ALONG] + state[at + ACROSS] * state[at + ACROSS]
            sums[record.IMPACT_LOSS] += elastic_energy(spring, tip, -gap)
            sums[record.FRICTION_LOSS] += 0.5 * state[at + SHEAR] * stretch
            state[at + ALONG] = state[at + ACROSS] = 0.0
            near[i].gap[1] = near[i].gap[2] = 0.0
        near[i].gap[0] = gap + h * u_n
        return before != OPEN
    share = near[i].share
    if before == OPEN:
        _begin_landing(state, at, t - share * h, near[i].speed[0], near[i].speed[1], near[i].speed[2])
        sums[record.IMPACT_LOSS] -= elastic_energy(spring, tip, -gap)
    near[i].gap[0] = gap + h * u_n
    if share < 1.0:  # what its springs and damper took is not what the mean force gave
        work = -h * near[i].force[0] * u_n - share * h * near[i].c_n * u_n * u_n
        sums[record.IMPACT_LOSS] += work - elastic_energy(spring, tip, -near[i].gap[0])
    for axis in range(3):
        state[at + J_N + axis] += h * near[i].force[axis]
    if state[at + STOP] == SLIDING and near[i].middle[1] * state[at + U_A] <= 0.0:
        state[at + STOP] = IN_COMPRESSION if u_n < 0.0 else IN_RESTITUTION
    sums[record.IMPACT_LOSS] += share * h * near[i].c_n * u_n * u_n
    sums[record.FRICTION_LOSS] += _advance_tangential_springs(near, i, h)
    state[at + ALONG], state[at + ACROSS] = near[i].gap[1], near[i].gap[2]
    state[at + MODE], state[at + SHEAR] = mode, near[i].k_t
    return False


@lean
def _advance_tangential_springs(near, i, h):
    """Advance the tangential springs of near contact i over a step of h seconds.

    Returns the energy that the slider and changes of stiffness take, g mm^2/s^2.
    """
    share, k_t = near[i].share, near[i].k_t
    e_1, e_2 = near[i].gap[1], near[i].gap[2]
    u_1, u_2 = near[i].middle[1], near[i].middle[2]
    work = -h * (near[i].force[1] * u_1 + near[i].force[2] * u_2)
    if near[i].tried == STICK:
        e_1, e_2 = e_1 + share * h * u_1, e_2 + share * h * u_2
    else:  # dragged along, the spring carries what friction allows at the end of the step
        radius = near[i].friction * _press_at_end(near, i) / k_t
        e_1, e_2 = radius * near[i].end[0], radius * near[i].end[1]
    near[i].gap[1], near[i].gap[2] = e_1, e_2
    return work + near[i].strain - 0.5 * k_t * (e_1 * e_1 + e_2 * e_2)


@lean
def _press_at_end(near, i):
    """Return the linearized normal force of contact i at the end of a step, g mm/s^2.

    The contact's `gap` must already be that at the end of the step.
    """
    u = 2.0 * near[i].middle[0] - near[i].speed[0]
    force = near[i].k_n * (-near[i].gap[0] - near[i].about) + near[i].push
    return max(force - near[i].c_n * u, 0.0)
