"""Bodies of the closed forms: rigid walkers that are exact mirror images of themselves, as balls.

Upright, without friction, dropped level, such a walker bounces on both feet at once as a ball does.
"""

import numpy as np
import numpy.typing as npt

from walkergen.scene import Drive, Scene
from walkergen.simulation import record
from walkergen.simulation.model import Plan
from walkergen.simulation.plan import prepare
from walkergen.simulation.world import OK
from walkergen.walker.design import Design
from walkergen.walker.mass import LegMass, MassProperties, Spatial

Array = npt.NDArray[np.float64]

HALF, TALL, LEG = 6.5, 9.0, 7.5
"""Lengths of the paper's walker, mm: half between the feet; O above them; a leg."""

FREQUENCY_HZ = 90.0
"""Frequency of every drive here, the paper's."""


def body(tall: float = TALL, mass: float = 0.833, gyration: float | None = None) -> MassProperties:
    """Mass properties of a rigid body on two feet HALF to either side of O, `tall` mm below it.

    `gyration`: radius of gyration about O, mm; without it that of the block that the feet bound.
    """
    radius = (HALF**2 + tall**2) / 3.0 if gyration is None else gyration**2
    J = mass * radius
    c, none = np.array([0.0, -0.5 * LEG]), np.zeros((3, 3))
    legs = tuple(LegMass(0.0, 0.0, np.array([x, LEG - tall]), c, c, 0.0, none) for x in (-HALF, HALF))
    return MassProperties(mass, J, legs, True, Spatial(0.0, np.diag([J, J, J])))


def plan(
    gamma: float, restitution: float, friction: float = 0.0, slope_deg: float = 0.0, mass: MassProperties | None = None
) -> Plan:
    """Plan of a rigid body, by events, on a plate whose peak acceleration is `gamma` g."""
    design = Design.model_validate({"legs": {"tilt_deg": 0.0, "kind": "braced"}})
    tables = {
        # Not validated: a plate at rest has a smaller number than anybody may write
        "drive": Drive.model_construct(frequency_hz=FREQUENCY_HZ, gamma=gamma),
        "contact": {"restitution": restitution, "friction": friction},
        "plate": {"slope_deg": slope_deg},
        "legs": {"model": "rigid"},
    }
    return prepare(Scene.model_validate(tables), design, body() if mass is None else mass)


def advance(plan: Plan, state: Array, seconds: float) -> record.Tally:
    """Advance a state in place. Raises ArithmeticError where the body does not keep upright."""
    tally = record.new(len(state))
    status = plan.advance(state, seconds, tally)
    if status != OK:
        raise ArithmeticError(f"the rigid body's run ended with status {status}")
    return tally
