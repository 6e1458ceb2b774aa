"""The event-driven simulator of the relaxed-legs walker: from event to event, without a time step.

Flight is exact, contacts are found with a guarantee (`flight`); what happens at one instant is
resolved in finite work (`contact`, `cascade`); sustained contact is in closed form on both feet
(`sustained`) and integrated to high order on one (`rocking`). Source: docs/physics.md section 5,
model A; the paper's flexible tensors enter only the impulses.
"""

import math

import numpy as np

from walkergen.numerics.kernels import kernel
from walkergen.simulation import record
from walkergen.simulation.drive import TWO_PI, acceleration, derivative_bound, height
from walkergen.simulation.effects.acting import across, along
from walkergen.simulation.record import Tally, next_sample, take_sample
from walkergen.simulation.relaxed.contact import land
from walkergen.simulation.relaxed.flight import CORNER, NOTHING, STUCK, drift, first_contact
from walkergen.simulation.relaxed.rocking import COLUMNS, FIRST, closed_foot, end_of_step, rock
from walkergen.simulation.relaxed.state import TRIAL_FRICTION, TRIAL_SIZE, TRIAL_WORK, lever, levers
from walkergen.simulation.relaxed.sustained import BREAK, LIFT, LIFT_BACK, LIFT_FRONT, end_of_stand, on_one_foot, stand
from walkergen.simulation.world import (
    BACKWARD,
    FAILED,
    FORWARD,
    INSIDE,
    MODE_BACK,
    MODE_FRONT,
    OK,
    OPEN,
    PHASE,
    PITCH,
    RIGID_SIZE,
    RUNAWAY,
    SPIN,
    STICK,
    TOPPLED,
    V_X,
    V_Y,
    State,
    World,
    Y,
)

MOST_SPEED = 1e3
"""Speed of a runaway over the usual speed: the plate's peak plus sqrt(g |O -> foot|)."""

# Most events in a row without a step of time; largest depth of a start, in gap tolerances.
MOST_AT_ONCE, DEEPEST_START = 1000, 1e7
INSTANT = 1e-12  # rad of the drive


@kernel
def advance(world: World, state: State, duration: float, tally: Tally) -> int:
    """Advance `state` in place by `duration` seconds and fill `tally`; returns a status of `world`.

    Two calls of half the duration agree with a single call to the integrator's tolerance, until
    chaos takes over. After TOPPLED or FAILED, state and elapsed time are those of the event.
    """
    if not _lift_out(world, state):
        return INSIDE
    began, t, at_once = tally.sums[record.ELAPSED], 0.0, 0
    trial, stages = np.zeros(TRIAL_SIZE), np.zeros((7, COLUMNS))
    trial[:RIGID_SIZE] = state
    step = FIRST * TWO_PI / world.drive.omega
    running = True
    while running:
        left = duration - t
        dt, event, step = _stretch(world, state, left, step, trial, stages)
        running = event != NOTHING or dt < left
        _sample(world, state, began + t, dt, tally.samples, stages)
        _tally(state, trial, dt, tally.sums)
        t = t + dt if running else duration
        tally.sums[record.ELAPSED] = began + t
        state[:] = trial[:RIGID_SIZE]
        at_once = at_once + 1 if dt * world.drive.omega < INSTANT else 0
        if event == CORNER:
            return TOPPLED
        if event == STUCK or at_once > MOST_AT_ONCE:
            return FAILED
        if event != NOTHING:
            step = FIRST * TWO_PI / world.drive.omega
            ended = _change(world, state, event, began + t, tally)
            if not ended or _runs_away(world, state):
                return RUNAWAY
            running = t < duration
    return OK


@kernel
def _stretch(world, state, left, step, trial, stages):
    """Move to the next event, by at most `left` s, into `trial`: (time s, event, next step s)."""
    feet = _closed_feet(state)
    if feet == 0:
        dt, event = first_contact(world, state, left)
        drift(world, state, dt, trial)
    elif feet == 2:
        dt, event = end_of_stand(world, state, left)
        stand(world, state, dt, trial)
    else:
        dt, event, step = end_of_step(world, state, left, step, trial, stages)
    return dt, event, step


@kernel
def _runs_away(world, state):
    """True when neither plate nor fall explains the speed any more (H_rigid > H_flexible)."""
    back, front = world.walker.feet
    reach = max(math.hypot(back[0], back[1]), math.hypot(front[0], front[1]))
    usual = derivative_bound(world.drive, 1) + math.sqrt(world.acting.gravity.size * reach)
    speed = max(abs(state[V_X]), abs(state[V_Y]), reach * abs(state[SPIN]))
    return speed > MOST_SPEED * usual


@kernel
def _closed_feet(state):
    return int(state[MODE_BACK] != OPEN) + int(state[MODE_FRONT] != OPEN)


@kernel
def _change(world, state, event, t, tally):
    """Apply an event to modes and velocities; False when the impacts of a landing do not end."""
    if event == LIFT:
        state[MODE_BACK], state[MODE_FRONT] = OPEN, OPEN
    elif event == LIFT_BACK:
        state[MODE_BACK] = OPEN
    elif event == LIFT_FRONT:
        state[MODE_FRONT] = OPEN
    elif event == BREAK:
        _break_away(world, state)
    else:
        return land(world, state, t, tally)
    return True


@kernel
def _break_away(world, state):
    """Make stuck feet slip against the force that held them."""
    pull = -along(world.acting)
    if _closed_feet(state) == 1:
        d, _, foot, _ = closed_foot(world.walker, state)
        r = lever(d, math.sin(state[PITCH]), math.cos(state[PITCH]))
        into = across(world.acting) + acceleration(world.drive, state[PHASE])
        g_x, friction = along(world.acting), world.contacts[foot].friction
        pull = on_one_foot(world.walker, r, state[SPIN], into, g_x, friction, STICK).F_x
    slip = BACKWARD if pull > 0.0 else FORWARD
    if state[MODE_BACK] != OPEN:
        state[MODE_BACK] = slip
    if state[MODE_FRONT] != OPEN:
        state[MODE_FRONT] = slip


@kernel
def _sample(world, state, t, dt, samples, stages):
    """Take the samples wanted between t and t + dt, without any effect on the run."""
    wanted = next_sample(samples)
    if wanted <= t + dt:
        feet, out = _closed_feet(state), np.zeros(TRIAL_SIZE)
        while wanted <= t + dt:
            since = max(wanted - t, 0.0)
            if feet == 0:
                drift(world, state, since, out)
            elif feet == 2:
                stand(world, state, since, out)
            else:
                rock(world, state, since, out, stages)
            take_sample(samples, wanted, out[:RIGID_SIZE])
            wanted = next_sample(samples)


@kernel
def _tally(state, trial, dt, sums):
    if _closed_feet(state) > 0:
        sums[record.CONTACT_TIME] += dt
        sums[record.PLATE_WORK] += trial[TRIAL_WORK]
        sums[record.FRICTION_LOSS] += trial[TRIAL_FRICTION]
    sums[record.LARGEST_PITCH] = max(sums[record.LARGEST_PITCH], abs(trial[PITCH]))


@kernel
def _lift_out(world, state):
    """Raise a walker that starts inside the plate by rounding; False when it starts deeper."""
    back, front = levers(world.walker, state[PITCH])
    depth = height(world.drive, state[PHASE]) - (state[Y] + min(back[1], front[1]))
    if depth > 2.0 * world.options.gap_tolerance:
        if depth > DEEPEST_START * world.options.gap_tolerance:
            return False
        state[Y] += depth
    return True
