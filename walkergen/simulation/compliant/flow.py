"""Flow of the compliant (or braced) walker between events: fixed contact modes, high order.

Contact forces that follow from the accelerations hold closed feet on the plate; the integrator is
the embedded pair of Dormand and Prince (1980), order 5(4), with an error estimate.
"""

import math
from typing import NamedTuple

import numpy as np

from walkergen.numerics.dormand_prince import ERROR_WEIGHTS, WEIGHTS
from walkergen.numerics.kernels import kernel
from walkergen.simulation.compliant.chain import (
    LOOSE,
    angle,
    chain_of,
    feet_changes,
    feet_turning,
    feet_velocities,
    free_acceleration,
    gaps,
    longest_leg,
    mobility_of,
    power_lost,
    push,
)
from walkergen.simulation.compliant.contact import FRICTIONLESS, JAMMED, frictions, give, impulses
from walkergen.simulation.drive import acceleration, velocity
from walkergen.simulation.effects.acting import across, along
from walkergen.simulation.world import (
    ANGLE_BACK,
    FORWARD,
    MODE_BACK,
    MODE_FRONT,
    OPEN,
    PHASE,
    PITCH,
    RATE_BACK,
    RATE_FRONT,
    SPIN,
    STICK,
    V_X,
    V_Y,
    X,
    Y,
)

ROUNDING = 2e-15
"""Relative rounding of a foot's height, from some ten operations."""


class Work(NamedTuple):
    """Arrays of a run; rows of state and three integrals: plate work, friction and damping loss."""

    now: np.ndarray
    trial: np.ndarray
    stage: np.ndarray
    slopes: np.ndarray
    rows: np.ndarray
    scales: np.ndarray


@kernel
def _leg_slopes(legs, z, dz, change):
    """Set the time derivatives of the legs' angles and rates in `dz`."""
    if legs is not None:
        _, _, spin, back, front = change
        for i in range(2):
            dz[ANGLE_BACK + i] = z[RATE_BACK + i]
        dz[RATE_BACK], dz[RATE_FRONT] = back - spin, front - spin


@kernel
def level_of(drive, z):
    """Depth (mm) below the plate at which a foot has landed: the rounding of its height."""
    return ROUNDING * (abs(z[Y]) + drive.amplitude)


@kernel
def _margin(mode, gap, level, v_x, F_x, F_y, yy, friction):
    """Quantity that is positive while a foot's mode holds and passes zero at its event."""
    if mode == OPEN:
        return gap + level
    if mode == STICK:
        return yy * min(F_y, friction * F_y - abs(F_x))
    if friction < FRICTIONLESS:
        return yy * F_y
    return min(yy * F_y, v_x if mode == FORWARD else -v_x)


@kernel
def accelerations(world, z, chain):
    """Accelerations without contact: of the chain (`respond`), and of its feet over the plate."""
    free = free_acceleration(world, z, chain)
    d, turning = feet_changes(chain, free), feet_turning(world.walker, z, chain)
    lift = acceleration(world.drive, z[PHASE])
    return free, (
        d[0] + turning[0],
        d[1] + turning[1] - lift,
        d[2] + turning[2],
        d[3] + turning[3] - lift,
    )


@kernel
def slopes_of(world, z, dz, rows):
    """Time derivative of state and integrals in the present modes; returns the feet's margins."""
    back, front, friction = int(z[MODE_BACK]), int(z[MODE_FRONT]), frictions(world)
    chain = chain_of(world.walker, z, LOOSE)
    free, a = accelerations(world, z, chain)
    W = mobility_of(chain)
    F = impulses(W, a, back, front, friction, rows)
    held = push(chain, F)
    change = (
        free[0] + held[0],
        free[1] + held[1],
        free[2] + held[2],
        free[3] + held[3],
        free[4] + held[4],
    )
    dz[X], dz[Y], dz[PITCH], dz[PHASE] = z[V_X], z[V_Y], z[SPIN], world.drive.omega
    dz[V_X], dz[V_Y], dz[SPIN] = change[0], change[1], change[2]
    dz[MODE_BACK] = dz[MODE_FRONT] = 0.0
    u = feet_velocities(world, z, chain)
    n = z.size - 3
    dz[n] = (F[1] + F[3]) * velocity(world.drive, z[PHASE])
    dz[n + 1] = -F[0] * u[0] - F[2] * u[2]
    legs = world.walker.legs
    _leg_slopes(legs, z, dz, change)
    dz[n + 2] = power_lost(
        world, z[PITCH], z[V_X], z[V_Y], angle(legs, z, RATE_BACK), angle(legs, z, RATE_FRONT)
    )
    gap, level = gaps(world.drive, z, chain), level_of(world.drive, z)
    # Half of what counts as jammed: no rounding hides a located jam from what resolves it.
    beyond = abs(give(W, back, front, friction)) - 0.5 * JAMMED
    if beyond <= 0.0:
        return beyond, beyond
    return (
        _margin(back, gap[0], level, u[0], F[0], F[1], W.bb_yy, friction[0]),
        _margin(front, gap[1], level, u[2], F[2], F[3], W.ff_yy, friction[1]),
    )


@kernel
def shoot(world, work, t):
    """One Runge-Kutta step of t s from work.now to work.trial; returns the lesser margin there.

    The first row of work.slopes must hold the slopes at work.now.
    """
    now, stage, slopes = work.now, work.stage, work.slopes
    margins = (0.0, 0.0)
    for i in range(6):
        target = work.trial if i == 5 else stage
        for k in range(now.size):
            total = 0.0
            for j in range(i + 1):
                total += WEIGHTS[i + 1, j] * slopes[j, k]
            target[k] = now[k] + t * total
        margins = slopes_of(world, target, slopes[i + 1], work.rows)
    return min(margins[0], margins[1])


@kernel
def scales_of(world, state):
    """Unit of each entry's error: speeds of a fall by a leg's length, 1e-3 of it, 1e-3 rad."""
    length = longest_leg(world.walker)
    gravity = math.hypot(along(world.acting), across(world.acting))
    scales = np.full(state.size, 1e-3)
    scales[X], scales[Y] = 1e-3 * length, 1e-3 * length
    scales[V_X], scales[V_Y] = math.sqrt(gravity * length), math.sqrt(gravity * length)
    scales[SPIN] = math.sqrt(gravity / length)
    scales[RATE_BACK:] = scales[SPIN]
    return scales


@kernel
def error_of(work, t, tolerance):
    """Largest error of the step of t seconds, in units of its scale, over the tolerance."""
    worst = 0.0
    for k in range(work.scales.size):
        total = 0.0
        for j in range(7):
            total += ERROR_WEIGHTS[j] * work.slopes[j, k]
        worst = max(worst, abs(t * total) / work.scales[k])
    return worst / tolerance
