"""Hard cases of the planar models, by the sections of docs/physics.md, and their scenes."""

import math
from collections.abc import Iterator
from typing import Any

from walkergen.jobs.trust.selftest.case import Check
from walkergen.jobs.trust.selftest.scenes import Array, Limit, endures, masses, scene_of
from walkergen.scene import GRAVITY
from walkergen.simulation import record
from walkergen.simulation.model import Plan
from walkergen.simulation.plan import prepare
from walkergen.simulation.world import PITCH, V_X, Y
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


STEPPED: tuple[Limit, Limit] = (
    (2e-2, "steps of 30 us: second order, of impacts and friction"),
    (4e-3, "a foot's way in a step of 30 us at 130 mm/s, where legs lighter by 1e-9 swing back many times within it"),
)
EXACT: tuple[Limit, Limit] = (1e-9, "rounding and the rocking integrator's 1e-11 a step"), (1e-9, "rounding")
"""Largest share of the exchanged energy that may be unaccounted for, and largest depth below the
plate, mm: by steps and by events."""


def survives(plan: Plan, seconds: float, about: str, limit: Limit | None = None) -> Iterator[Check]:
    """Checks of a tilted drop, however extreme; `limit` in place of that of its energy."""
    state = plan.start(0.03, 0.0, 1.0)
    state[PITCH] += 2e-3
    state[V_X] = 5.0
    lift(plan, state, 0.03)
    energy, depth = STEPPED if plan.resolved.model == "compliant" else EXACT
    return endures(plan, state, seconds, about, limit or energy, depth)
