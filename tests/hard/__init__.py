"""Hard cases of the planar models, by the sections of docs/physics.md, and their scenes."""

import math
from typing import Any

from walkergen.jobs.trust.selftest.scenes import Array, masses, scene_of
from walkergen.scene import GRAVITY
from walkergen.simulation import record
from walkergen.simulation.model import Plan
from walkergen.simulation.plan import prepare
from walkergen.simulation.world import Y
from walkergen.walker.design import Design

THREE_COORDINATES = ("relaxed", "rigid")
"""Models without leg coordinates, from event to event: instants in finite work, stands in one step.
"""

RIGID, COMPLIANT = ("rigid",), ("compliant",)
EVERY = (*THREE_COORDINATES, *COMPLIANT)
"""Every planar model."""


def drawn(model: str, shape: dict[str, dict[str, Any]], **tables: Any) -> Plan:
    """Plan of a walker of the tables `shape`, masses in closed form."""
    kind = "braced" if model == "rigid" else "flexible"
    design = Design.model_validate({**shape, "legs": {"kind": kind, **shape["legs"]}})
    return prepare(scene_of(model, **tables), design, masses(design))


def with_legs(plan: Plan, factor: float, ratio: float) -> Plan:
    """The same compliant walker on springs `factor` times as stiff, with a damping ratio."""
    walker = plan.world.walker
    springs = [factor * leg.stiffness for leg in walker.legs]
    legs = tuple(
        leg._replace(stiffness=k, damping=2.0 * ratio * math.sqrt(k * leg.inertia))
        for leg, k in zip(walker.legs, springs, strict=True)
    )
    return plan._replace(world=plan.world._replace(walker=walker._replace(legs=legs)))


def lift(plan: Plan, state: Array, gap: float) -> None:
    """Put the lower foot `gap` (mm) over the plate, keeping everything else."""
    state[Y] += gap - float(plan.feet(state)[:, 1].min())


def energy_error(plan: Plan, before: float, state: Array, tally: record.Tally) -> float:
    """Energy unaccounted for over the largest energy exchanged."""
    return record.energy_error(tally.sums, plan.energy(state) - before, before)


def fall_time(gap: float) -> float:
    """Time (s) in which a body falls by `gap` mm."""
    return math.sqrt(2.0 * gap / GRAVITY)
