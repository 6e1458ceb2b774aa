"""Flight: the exact flow between contacts, and the first contact with a guarantee.

The gap of a point over the plate is smooth, with known bounds of its second and third derivative.
From any instant they give a time before which it cannot close; stepping by such times approaches
the first contact from above, to third order, and cannot jump over one: neither a grazing one nor
the first of two close ones.
"""

import math
from typing import NamedTuple

from walkergen.numerics.kernels import kernel
from walkergen.simulation.drive import acceleration, derivative_bound, height, moved_on, velocity
from walkergen.simulation.effects.acting import across, along
from walkergen.simulation.relaxed.state import TRIAL_FRICTION, TRIAL_WORK, Point, lever
from walkergen.simulation.world import MODE_BACK, MODE_FRONT, PHASE, PITCH, SPIN, V_X, V_Y, State, World, X, Y

# What ends a stretch of motion.
NOTHING, TOUCH, CORNER, STUCK = 0, 1, 2, 3
MOST_STEPS = 100_000
# Rounding of a height over the way flown: heights far above a small walker lose its digits.
ROUNDING = 1e-15
# Share of the snap speed: a foot at the surface that moves inward faster has landed.
INWARD = 1e-3


class Gap(NamedTuple):
    """Height of a point over the plate and its derivatives: mm, mm/s, mm/s^2."""

    height: float
    rate: float
    curvature: float


@kernel
def drift(world: World, state: State, dt: float, out: State) -> None:
    """Exact ballistic flight of `dt` seconds from `state` to `out` (may be the same array)."""
    g_x, g_y = along(world.acting), across(world.acting)
    out[X] = state[X] + dt * (state[V_X] + 0.5 * g_x * dt)
    out[Y] = state[Y] + dt * (state[V_Y] - 0.5 * g_y * dt)
    out[PITCH] = state[PITCH] + state[SPIN] * dt
    out[V_X] = state[V_X] + g_x * dt
    out[V_Y] = state[V_Y] - g_y * dt
    out[SPIN] = state[SPIN]
    out[PHASE] = moved_on(world.drive, state[PHASE], dt)
    out[MODE_BACK] = state[MODE_BACK]
    out[MODE_FRONT] = state[MODE_FRONT]
    out[TRIAL_WORK] = 0.0
    out[TRIAL_FRICTION] = 0.0


@kernel
def quadratic_wait(value: float, rate: float, bound: float) -> float:
    """First s > 0 with value + rate s - bound s^2 / 2 = 0, for value >= 0; infinity if none."""
    root = math.sqrt(max(rate * rate + 2.0 * bound * value, 0.0))
    if rate < 0.0:
        return 2.0 * value / (root - rate)
    if bound <= 0.0:
        return math.inf
    return (rate + root) / bound


@kernel
def cubic_wait(gap: Gap, margin: float, bound: float) -> float:
    """Time within which margin + rate s + curvature s^2 / 2 - bound s^3 / 6 stays positive.

    Any window S gives such a time: within it the curvature is at least curvature - bound S / 3. The
    best S is the cubic's own root, approached by Newton's method from an upper bound of it.
    """
    s = max(9.0 * gap.curvature / bound, (18.0 * margin / bound) ** (1.0 / 3.0))
    if gap.rate > 0.0:
        s = max(s, math.sqrt(18.0 * gap.rate / bound))
    for _ in range(5):
        slope = gap.rate + s * (gap.curvature - 0.5 * bound * s)
        if slope >= 0.0:
            break
        s -= (margin + s * (gap.rate + s * (0.5 * gap.curvature - bound * s / 6.0))) / slope
    return min(s, quadratic_wait(margin, gap.rate, bound * s / 3.0 - gap.curvature))


@kernel
def first_contact(world: World, state: State, limit: float) -> tuple[float, int]:
    """Time (s) to the first contact within `limit`, and what touches: TOUCH, CORNER, NOTHING."""
    walker = world.walker
    dt, event = _first_of_two(world, walker.feet[0], walker.feet[1], state, limit)
    # The pitch is monotone in flight: a corner can have been first only beyond the safe pitch.
    end_pitch = state[PITCH] + state[SPIN] * dt
    if max(abs(state[PITCH]), abs(end_pitch)) > walker.safe_pitch:
        for pair in range(2):
            low, high = walker.corners[pair], walker.corners[pair + 2]
            corner_dt, touched = _first_of_two(world, low, high, state, dt)
            if touched != NOTHING:
                dt, event = corner_dt, CORNER if touched == TOUCH else STUCK
    return dt, event


@kernel
def _first_of_two(world: World, first: Point, second: Point, state: State, limit: float) -> tuple[float, int]:
    g_y, Omega = across(world.acting), state[SPIN]
    third = abs(Omega) ** 3
    second_bound = g_y + derivative_bound(world.drive, 2)
    third_bound = derivative_bound(world.drive, 3) + 1e-30
    reach_1, reach_2 = math.hypot(first[0], first[1]), math.hypot(second[0], second[1])
    bounds_1 = second_bound + Omega * Omega * reach_1, third_bound + third * reach_1
    bounds_2 = second_bound + Omega * Omega * reach_2, third_bound + third * reach_2
    t = 0.0
    for _ in range(MOST_STEPS):
        pitch, phase = state[PITCH] + Omega * t, state[PHASE] + world.drive.omega * t
        sin, cos = math.sin(pitch), math.cos(pitch)
        rise = state[Y] + t * (state[V_Y] - 0.5 * g_y * t) - height(world.drive, phase)
        rate = state[V_Y] - g_y * t - velocity(world.drive, phase)
        pull = -g_y - acceleration(world.drive, phase)
        way = abs(state[Y]) + t * (abs(state[V_Y]) + 0.5 * g_y * t)
        slack = max(world.options.gap_tolerance, ROUNDING * way)
        gap_1 = _gap(lever(first, sin, cos), rise, rate, pull, Omega)
        gap_2 = _gap(lever(second, sin, cos), rise, rate, pull, Omega)
        snap = world.options.snap_speed
        landed_1, landed_2 = _lands(gap_1, slack, snap), _lands(gap_2, slack, snap)
        if landed_1 or landed_2:
            return t - min(t, max(_since(gap_1, landed_1), _since(gap_2, landed_2))), TOUCH
        t += min(_wait(gap_1, slack, bounds_1), _wait(gap_2, slack, bounds_2))
        if t >= limit:
            return limit, NOTHING
    return t, STUCK


@kernel
def _gap(r: Point, rise: float, rate: float, pull: float, Omega: float) -> Gap:
    return Gap(rise + r[1], rate + Omega * r[0], pull - Omega * Omega * r[1])


@kernel
def _lands(gap: Gap, slack: float, snap: float) -> bool:
    """True when a point at or below the plate's surface moves inward by more than rounding."""
    if gap.height > 0.0 or gap.rate >= 0.0:
        return False
    inward = gap.rate < -INWARD * snap and gap.curvature < 0.0
    return inward or gap.height <= -0.75 * slack


@kernel
def _since(gap: Gap, landed: bool) -> float:
    """Time (s) since a landed point passed the surface, to first order: undoes the tolerance."""
    fast = landed and gap.rate * gap.rate > -4.0 * gap.height * abs(gap.curvature)
    return gap.height / gap.rate if fast else 0.0


@kernel
def _wait(gap: Gap, slack: float, bounds: tuple[float, float]) -> float:
    margin = max(gap.height + slack, 0.0)
    return max(quadratic_wait(margin, gap.rate, bounds[0]), cubic_wait(gap, margin, bounds[1]))
