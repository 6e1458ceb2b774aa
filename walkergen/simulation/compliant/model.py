"""Model B, legs on springs, and the rigid walker by time steps, behind the seam."""

from walkergen.simulation import world
from walkergen.simulation.compliant import chain, events, state, steps
from walkergen.simulation.drive import Drive
from walkergen.simulation.effects.effect import Case
from walkergen.simulation.effects.resolve import Resolved
from walkergen.simulation.model import Model

STEPS = Model(
    start=state.start,
    advance=steps.advance,
    energy=chain.energy,
    feet=state.feet,
    momentum=state.momentum,
    mirrored=world.mirrored,
    pose=world.pose,
    coarser=steps.coarser,
    resting=steps.resting,
    columns=world.RIGID_COLUMNS + world.LEG_COLUMNS,
)
"""By time steps of second order."""

EVENTS = STEPS._replace(advance=events.advance, coarser=events.coarser, resting=events.resting)
"""From event to event, by an integrator of fifth order: the reference of the steps."""


def of(
    case: Case, resolved: Resolved, drive: Drive
) -> tuple[Model, state.Walker, steps.Options | events.Options]:
    """Model, walker and options of a case: legs on springs, or none where its mass is rigid."""
    legs, stepped = case.scene.legs, resolved.method == "step"
    walker = state.walker_of(
        case.design, case.mass, damping_ratio=legs.damping_ratio, spring=legs.spring
    )
    model = STEPS if stepped else EVENTS
    if walker.legs is None:
        model = model._replace(columns=world.RIGID_COLUMNS)
    step = 1e-6 * case.scene.run.step_us
    return model, walker, steps.Options(step) if stepped else events.Options()
