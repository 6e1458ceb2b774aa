"""What happens at one instant: impacts of one foot or both, until every closed contact is quiet.

Rules, all symmetric under exchange of the feet:

* Rounds. In each, every closed foot that approaches receives the impulse of its own cascade,
  computed from the velocity before the round. Rounds go on until no closed foot approaches.
* When both approach in one round (simultaneous landing, physics.md trap 3), both impulses are
  scaled by kappa = sum_i F_i H_ii F_i / sum_ij F_i H_ij F_j (H: rigid). The energy then changes by
  kappa times what the two would change alone, so that the pair gains nothing that the feet alone
  do not gain; a level symmetric landing has the restitution of a single foot.
* Snap (trap 2). Closed feet whose normal speed is below `snap_speed` close for good, both at once:
  the normal velocities, and a tangential one that friction can hold, are projected to zero.
"""

import math

from walkergen.numerics.kernels import kernel
from walkergen.simulation.drive import height, velocity
from walkergen.simulation.record import IMPACT_LOSS, PLATE_WORK, note_event
from walkergen.simulation.relaxed.cascade import Landing, cascade, stopping_impulse
from walkergen.simulation.relaxed.sustained import BACK_JAMS, NO_JAM, choose_modes
from walkergen.simulation.relaxed.walker import (
    OMEGA,
    PHASE,
    PITCH,
    V_X,
    V_Y,
    X,
    Y,
    across,
    along,
    back_tensor,
    front_tensor,
    impulse_tensor,
    lever,
    rigid_tensor,
)

MOST_ROUNDS = 10_000
# A foot within this many gap tolerances of the plate takes part: what the snap speed can climb.
CLOSED = 16.0


@kernel
def land(walker, plate, contact, options, state, t, tally):
    """Resolve the present instant in place: velocities, contact modes, tally. False: no end.

    Every foot within `CLOSED` gap tolerances takes part; t (s) is for the record of events.
    """
    v_p, v_y = velocity(plate, state[PHASE]), state[V_Y]
    before = _energy(walker, options, state, v_p)
    near_back, near_front = _near(walker, plate, options, state)
    settled = False
    for _ in range(MOST_ROUNDS):
        struck, finished = _round(
            walker, contact, options, state, v_p, near_back, near_front, t, tally
        )
        if not finished:
            break
        if not struck:
            jammed = choose_modes(walker, plate, contact, options, state, near_back, near_front)
            if jammed == NO_JAM:
                settled = True
                break
            _stop(walker, state, v_p, walker.d_back if jammed == BACK_JAMS else walker.d_front)
    tally.sums[PLATE_WORK] += walker.M * v_p * (state[V_Y] - v_y)
    tally.sums[IMPACT_LOSS] -= _energy(walker, options, state, v_p) - before
    return settled


@kernel
def _near(walker, plate, options, state):
    sin, cos = math.sin(state[PITCH]), math.cos(state[PITCH])
    limit = height(plate, state[PHASE]) + CLOSED * options.gap_tolerance
    return (
        state[Y] + lever(walker.d_back, sin, cos)[1] <= limit,
        state[Y] + lever(walker.d_front, sin, cos)[1] <= limit,
    )


@kernel
def _round(walker, contact, options, state, v_p, near_back, near_front, t, tally):
    """One round of impacts: if any foot was struck, and if every cascade came to an end."""
    sin, cos = math.sin(state[PITCH]), math.cos(state[PITCH])
    back, front = lever(walker.d_back, sin, cos), lever(walker.d_front, sin, cos)
    tensor, flexible = rigid_tensor(walker, back), back_tensor(walker.flexible)
    at_back = _meet(tensor, flexible, back, near_back, state, v_p, contact, options, tally.counts)
    tensor, flexible = rigid_tensor(walker, front), front_tensor(walker.flexible)
    at_front = _meet(
        tensor, flexible, front, near_front, state, v_p, contact, options, tally.counts
    )
    scale = _share(walker, back, front, at_back, at_front)
    v_x, v_y, Omega = state[V_X], state[V_Y] - v_p, state[OMEGA]
    if at_back.kind != 0:
        _note(tally, t, 0.0, at_back, scale, v_x - Omega * back[1], v_y + Omega * back[0])
    if at_front.kind != 0:
        _note(tally, t, 1.0, at_front, scale, v_x - Omega * front[1], v_y + Omega * front[0])
    F_x, F_y = at_back.F_x + at_front.F_x, at_back.F_y + at_front.F_y
    torque = _torque(back, at_back) + _torque(front, at_front)
    state[V_X] += scale * F_x / walker.M
    state[V_Y] += scale * F_y / walker.M
    state[OMEGA] += scale * torque / walker.J
    return at_back.kind != 0 or at_front.kind != 0, at_back.finished and at_front.finished


@kernel
def _meet(rigid, own, r, near, state, v_p, contact, options, counts):
    """The cascade of one foot, if it is closed and approaches."""
    v_y = state[V_Y] - v_p + state[OMEGA] * r[0]
    if not near or v_y >= -options.snap_speed:
        return Landing(0.0, 0.0, 0.0, 0.0, 0, True)
    v_x = state[V_X] - state[OMEGA] * r[1]
    sin, cos = math.sin(state[PITCH]), math.cos(state[PITCH])
    return cascade(impulse_tensor(own, rigid, sin, cos), rigid, v_x, v_y, contact, counts)


@kernel
def _share(walker, back, front, at_back, at_front):
    """The kappa of the module's second rule; 1 unless both feet are struck."""
    if at_back.kind == 0 or at_front.kind == 0:
        return 1.0
    torque_back, torque_front = _torque(back, at_back), _torque(front, at_front)
    alone = _work(walker, at_back.F_x, at_back.F_y, torque_back) + _work(
        walker, at_front.F_x, at_front.F_y, torque_front
    )
    F_x, F_y = at_back.F_x + at_front.F_x, at_back.F_y + at_front.F_y
    return alone / _work(walker, F_x, F_y, torque_back + torque_front)


@kernel
def _work(walker, F_x, F_y, torque):
    return (F_x * F_x + F_y * F_y) / walker.M + torque * torque / walker.J


@kernel
def _torque(r, hit):
    return r[0] * hit.F_y - r[1] * hit.F_x


@kernel
def _note(tally, t, foot, hit, scale, v_x, v_y):
    note_event(tally.events, t, foot, scale * hit.F_x, scale * hit.F_y, v_x, v_y, hit.kind)


@kernel
def _stop(walker, state, v_p, d):
    """Stop a jammed foot at once: sliding, it would be pressed ever harder into the plate."""
    r = lever(d, math.sin(state[PITCH]), math.cos(state[PITCH]))
    v_x, v_y = state[V_X] - state[OMEGA] * r[1], state[V_Y] - v_p + state[OMEGA] * r[0]
    F_x, F_y = stopping_impulse(rigid_tensor(walker, r), v_x, v_y)
    state[V_X] += F_x / walker.M
    state[V_Y] += F_y / walker.M
    state[OMEGA] += (r[0] * F_y - r[1] * F_x) / walker.J


@kernel
def _energy(walker, options, state, v_p):
    """Kinetic energy in the plate's frame and potential energy, g mm^2/s^2."""
    v_y = state[V_Y] - v_p
    kinetic = walker.M * (state[V_X] ** 2 + v_y**2) + walker.J * state[OMEGA] ** 2
    return 0.5 * kinetic + walker.M * (across(options) * state[Y] - along(options) * state[X])
