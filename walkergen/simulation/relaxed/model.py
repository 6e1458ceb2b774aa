"""Model A, relaxed legs, and the rigid walker from event to event, each as a `Model`."""

from walkergen.simulation import world
from walkergen.simulation.drive import Drive
from walkergen.simulation.effects.effect import Case
from walkergen.simulation.effects.resolve import Resolved
from walkergen.simulation.model import Model, same
from walkergen.simulation.relaxed import events, state

EVENTS = Model(
    start=state.start,
    advance=events.advance,
    energy=state.energy,
    feet=state.feet,
    momentum=state.momentum,
    pose=world.pose,
    coarser=state.coarser,
    resting=state.resting,
    columns=world.RIGID_COLUMNS,
    drawn=same,
)
"""Method from event to event, with flights and contacts as exact as rounding allows."""


def of(case: Case, resolved: Resolved, drive: Drive) -> tuple[Model, state.Walker, state.Options]:
    """Model, walker and options of a case: relaxed legs, or rigid where its mass is."""
    walker = state.walker_of(case.design, case.mass)
    return EVENTS, walker, state.options_for(walker, drive, resolved.acting.gravity.size)
