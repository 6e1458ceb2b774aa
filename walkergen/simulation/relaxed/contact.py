"""Impacts at one instant, of one foot or both, until every closed contact is quiet.

Rules, all symmetric under exchange of the feet (docs/physics.md section 5, model A):

* Rounds. In each, every closed foot that approaches receives the impulse of its own cascade,
  computed from the velocity before the round. Rounds go on until no closed foot approaches.
* Simultaneous landing (trap 3). When both approach in one round, both impulses are scaled by kappa
  (`_share`): a level symmetric landing has the restitution of a single foot.
* Snap (trap 2). Closed feet whose normal speed is below `snap_speed` close for good, both at once:
  the normal velocities, and a tangential one that friction can hold, are projected to zero.
"""

import math

from walkergen.numerics.kernels import kernel
from walkergen.simulation.drive import height, velocity
from walkergen.simulation.effects.acting import across, along
from walkergen.simulation.record import IMPACT_LOSS, PLATE_WORK, add_impulse, note_event
from walkergen.simulation.relaxed.cascade import Landing, cascade, stopping_impulse
from walkergen.simulation.relaxed.state import impulse_tensor, lever, levers, rigid_tensor
from walkergen.simulation.relaxed.sustained import NO_JAM, choose_modes
from walkergen.simulation.world import PHASE, PITCH, SPIN, V_X, V_Y, X, Y
from walkergen.theory.impact import NONE

MOST_ROUNDS = 10_000
# Height, in gap tolerances, up to which a foot takes part: what the snap speed can climb.
CLOSED = 16.0


@kernel
def land(world, state, t, tally):
    """Resolve the instant t (s) in place: velocities, modes, tally; False: impacts do not end."""
    v_p, v_y = velocity(world.drive, state[PHASE]), state[V_Y]
    before = _energy(world, state, v_p)
    near = _near(world, state)
    settled = False
    for _ in range(MOST_ROUNDS):
        struck, finished = _round(world, state, v_p, near, t, tally)
        if not finished:
            break
        if not struck:
            jammed = choose_modes(world, state, near[0], near[1])
            if jammed == NO_JAM:
                settled = True
                break
            _stop(world.walker, state, v_p, world.walker.feet[jammed])
    tally.sums[PLATE_WORK] += world.walker.mass * v_p * (state[V_Y] - v_y)
    tally.sums[IMPACT_LOSS] -= _energy(world, state, v_p) - before
    return settled


@kernel
def _near(world, state):
    back, front = levers(world.walker, state[PITCH])
    limit = height(world.drive, state[PHASE]) + CLOSED * world.options.gap_tolerance
    return state[Y] + back[1] <= limit, state[Y] + front[1] <= limit


@kernel
def _round(world, state, v_p, near, t, tally):
    """One round of impacts: (whether a foot was struck, whether every cascade came to an end)."""
    walker = world.walker
    back, front = levers(walker, state[PITCH])
    at_back = _meet(world, 0, back, near[0], state, v_p, tally.counts)
    at_front = _meet(world, 1, front, near[1], state, v_p, tally.counts)
    scale = _share(walker, back, front, at_back, at_front)
    v_x, v_y, Omega = state[V_X], state[V_Y] - v_p, state[SPIN]
    if at_back.kind != NONE:
        _note(tally, t, 0.0, at_back, scale, v_x - Omega * back[1], v_y + Omega * back[0])
    if at_front.kind != NONE:
        _note(tally, t, 1.0, at_front, scale, v_x - Omega * front[1], v_y + Omega * front[0])
    F_x, F_y = at_back.F_x + at_front.F_x, at_back.F_y + at_front.F_y
    torque = _torque(back, at_back) + _torque(front, at_front)
    state[V_X] += scale * F_x / walker.mass
    state[V_Y] += scale * F_y / walker.mass
    state[SPIN] += scale * torque / walker.inertia
    return at_back.kind != NONE or at_front.kind != NONE, at_back.finished and at_front.finished


@kernel
def _meet(world, foot, r, near, state, v_p, counts):
    """`Landing` of a foot (0 back, 1 front) at r, if it is `near` and approaches."""
    v_y = state[V_Y] - v_p + state[SPIN] * r[0]
    if not near or v_y >= -world.options.snap_speed:
        return Landing(0.0, 0.0, 0.0, 0.0, NONE, True)
    v_x, rigid = state[V_X] - state[SPIN] * r[1], rigid_tensor(world.walker, r)
    sin, cos = math.sin(state[PITCH]), math.cos(state[PITCH])
    own = impulse_tensor(world.walker.flexible[foot], rigid, sin, cos)
    return cascade(own, rigid, v_x, v_y, world.contacts[foot], counts)


@kernel
def _share(walker, back, front, at_back, at_front):
    """Factor kappa = sum_i F_i H_ii F_i / sum_ij F_i H_ij F_j, H rigid; 1 unless both strike."""
    if at_back.kind == NONE or at_front.kind == NONE:
        return 1.0
    torque_back, torque_front = _torque(back, at_back), _torque(front, at_front)
    alone = _work(walker, at_back.F_x, at_back.F_y, torque_back) + _work(
        walker, at_front.F_x, at_front.F_y, torque_front
    )
    F_x, F_y = at_back.F_x + at_front.F_x, at_back.F_y + at_front.F_y
    return alone / _work(walker, F_x, F_y, torque_back + torque_front)


@kernel
def _work(walker, F_x, F_y, torque):
    return (F_x * F_x + F_y * F_y) / walker.mass + torque * torque / walker.inertia


@kernel
def _torque(r, hit):
    return r[0] * hit.F_y - r[1] * hit.F_x


@kernel
def _note(tally, t, foot, hit, scale, v_x, v_y):
    add_impulse(tally.sums, hit.kind, scale * hit.F_y)
    note_event(tally.events, t, foot, scale * hit.F_x, scale * hit.F_y, v_x, v_y, hit.kind)


@kernel
def _stop(walker, state, v_p, d):
    """Stop a jammed foot at once: sliding, it would be pressed ever harder into the plate."""
    r = lever(d, math.sin(state[PITCH]), math.cos(state[PITCH]))
    v_x, v_y = state[V_X] - state[SPIN] * r[1], state[V_Y] - v_p + state[SPIN] * r[0]
    F_x, F_y = stopping_impulse(rigid_tensor(walker, r), v_x, v_y)
    state[V_X] += F_x / walker.mass
    state[V_Y] += F_y / walker.mass
    state[SPIN] += (r[0] * F_y - r[1] * F_x) / walker.inertia


@kernel
def _energy(world, state, v_p):
    """Kinetic energy in the plate's frame and potential energy, g mm^2/s^2."""
    v_y = state[V_Y] - v_p
    kinetic = world.walker.mass * (state[V_X] ** 2 + v_y**2) + world.walker.inertia * state[SPIN] ** 2
    return 0.5 * kinetic + world.walker.mass * (across(world.acting) * state[Y] - along(world.acting) * state[X])
