"""Rest: a walker that stands on stuck feet on a plate that cannot throw it rides along without steps.

`world` holds what stays the same in a run, `state` (1-d array, entries named by constants as C_X) what changes, and
`sums` the sums of its record, which functions add to.
"""

from walkergen.core.numerics.kernels import lean
from walkergen.core.simulation import record
from walkergen.core.simulation.effects.active_effects import gravity_into
from walkergen.core.simulation.space.flight import pass_time
from walkergen.core.simulation.space.pose import plate_height, plate_velocity
from walkergen.core.simulation.space.state import C_X, LEGS, MODE, OPEN, QUIET, ROW_LENGTH, STICK, V_X, W_X, first_row

REST_SPEED_RATIO = 0.0092
"""Speed over the plate whose energy counts as rest, of what gravity gives in a period: 1 mm/s at 90 Hz, where a walker
sways by some 0.3 mm/s on its stuck legs if the plate shakes by 0.5 g."""

DOZE_PERIODS = 2.7
"""Periods of the plate at rest after which the walker rides on it: several of its sway; and more than one, since on a
slope the plate's motion changes what friction has to hold."""

MIN_STUCK_CORNERS = 3
"""Stuck corners on which a walker stands."""


@lean
def _energy_over_plate(world, state):
    """Return the kinetic energy of a walker relative to the plate, g mm^2/s^2."""
    walker, n = world.walker, len(world.walker.stiffness)
    v = state[V_X + 1] - plate_velocity(world, state)
    twice = walker.mass * (state[V_X] ** 2 + v * v + state[V_X + 2] ** 2)
    for i in range(3):
        for j in range(3):
            twice += walker.inertia[i, j] * state[W_X + i] * state[W_X + j]
    for i in range(n):
        for j in range(n):
            twice += walker.hinge_inertia[i, j] * state[LEGS + n + i] * state[LEGS + n + j]
    return 0.5 * twice


@lean
def count_rest_time(world, state, t, period):
    """Count the time at rest in `state`: add t seconds if the walker is calm on stuck feet, else start from 0.

    `period` is that of the plate, s. The plate must be too slow to throw the walker.
    """
    walker, stuck_corners = world.walker, 0
    first = first_row(walker)
    for k in range(len(walker.leg)):
        mode = state[first + ROW_LENGTH * k + MODE]
        if mode == STICK:
            stuck_corners += 1
        elif mode != OPEN:
            stuck_corners = -len(walker.leg)
    slow = REST_SPEED_RATIO * gravity_into(world.acting) * period
    is_calm = stuck_corners >= MIN_STUCK_CORNERS and _energy_over_plate(world, state) < 0.5 * walker.mass * slow * slow
    state[QUIET] = state[QUIET] + t if is_calm else 0.0


@lean
def _stop_motion(world, state, sums):
    """Set a walker's velocities relative to the plate to zero. Their energy counts as lost to dampers."""
    n, v = len(world.walker.stiffness), plate_velocity(world, state)
    sums[record.DAMPING_LOSS] += _energy_over_plate(world, state)
    sums[record.PLATE_WORK] += world.walker.mass * v * (v - state[V_X + 1])
    state[V_X], state[V_X + 1], state[V_X + 2] = 0.0, v, 0.0
    state[W_X : W_X + 3] = 0.0
    state[LEGS + n : LEGS + 2 * n] = 0.0


@lean
def ride_on_plate(world, state, t, sums):
    """Stop a walker that is at rest, and move it with the plate for t seconds."""
    _stop_motion(world, state, sums)
    mass, height, velocity = world.walker.mass, state[C_X + 1], state[V_X + 1]
    before = plate_height(world, state)
    pass_time(world, state, t)
    state[C_X + 1] += plate_height(world, state) - before
    state[V_X + 1] = plate_velocity(world, state)
    lifted = gravity_into(world.acting) * (state[C_X + 1] - height)
    faster = 0.5 * (state[V_X + 1] ** 2 - velocity * velocity)
    sums[record.PLATE_WORK] += mass * (lifted + faster)
    sums[record.CONTACT_TIME] += t
