"""Model B, legs on springs, as a `Model`."""

import numpy as np

from walkergen.simulation.compliant import chain, steps
from walkergen.simulation.compliant.lengths import own_step
from walkergen.simulation.compliant.state import Walker, start, walker_of
from walkergen.simulation.drive import Drive
from walkergen.simulation.effects.effect import Case
from walkergen.simulation.effects.resolve import Resolved
from walkergen.simulation.model import Array, Model, same
from walkergen.simulation.world import LEG_COLUMNS, RATE_BACK, RIGID_COLUMNS, SPIN, V_X, State, World, X, pose


def feet(world: World, state: State) -> Array:
    """Places and velocities of the feet, shape (2, 4), as in `Model.feet`."""
    now = chain.chain_of(world.walker, state, chain.LOOSE)
    x = [state[X] + limb.A_x + limb.r_x for limb in (now.back, now.front)]
    b_x, b_y, f_x, f_y = chain.feet_velocities(world, state, now)
    return np.array([x, chain.gaps(world.drive, state, now), (b_x, f_x), (b_y, f_y)]).T


def momentum(world: World, state: State) -> float:
    """Momentum of body and legs along the plate, g mm/s."""
    walker, legs = world.walker, world.walker.legs
    total, now = walker.mass * state[V_X], chain.chain_of(walker, state, chain.LOOSE)
    for leg, limb, rate in zip(legs, (now.back, now.front), state[RATE_BACK:], strict=True):
        turning = state[SPIN] * limb.A_y + (state[SPIN] + rate) * limb.C_y
        total += leg.mass * (state[V_X] - turning)
    return float(total)


STEPS = Model(
    start=start,
    advance=steps.advance,
    energy=chain.energy,
    feet=feet,
    momentum=momentum,
    pose=pose,
    coarser=steps.coarser,
    resting=steps.resting,
    columns=RIGID_COLUMNS + LEG_COLUMNS,
    drawn=same,
)
"""Method by time steps of second order."""


def of(case: Case, resolved: Resolved, drive: Drive) -> tuple[Model, Walker, steps.Options]:
    """Model, walker and options of a case."""
    legs, step_us = case.scene.legs, case.scene.run.step_us
    walker = walker_of(case.design, case.mass, damping_ratio=legs.damping_ratio)
    return STEPS, walker, steps.Options(own_step(walker, drive.period) if step_us is None else 1e-6 * step_us)
