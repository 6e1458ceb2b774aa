"""Scenes of the hard cases: engines on masses in closed form, and what is read from their states.

Masses in closed form (a box on two thin uniform legs; braced legs without mass) make a walker and
its mirror image exact images of each other, to the last bit, which a mesh does not.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from walkergen.scene import GRAVITY, Scene
from walkergen.simulation import drive as plate
from walkergen.simulation import engines, record
from walkergen.simulation.compliant import legs as chains
from walkergen.simulation.run import Engine, Outcome
from walkergen.walker.design import Design
from walkergen.walker.mass import MassProperties

Array = npt.NDArray[np.float64]

# Places in the state of either engine.
X, Y, PITCH, V_X, V_Y, SPIN, PHASE, MODE_BACK, MODE_FRONT = range(9)
ANGLE_BACK, ANGLE_FRONT, RATE_BACK, RATE_FRONT = range(9, 13)
OPEN, STICK = 0.0, 1.0

LEG, HALF, TALL = 7.5, 6.5, 9.0
"""The paper's walker, mm: length of a leg; half the distance of the feet; height of O at tilt 0."""

STILL = {"frequency_hz": 90.0, "gamma": 1e-30}
"""A plate at rest: its amplitude vanishes against the rounding of any height."""


def shaken(gamma: float) -> dict[str, float]:
    """A drive at the paper's 90 Hz."""
    return {"frequency_hz": 90.0, "gamma": gamma}


def design_of(model: str, tilt_deg: float) -> Design:
    """The paper's walker, braced for the rigid model."""
    kind = "braced" if model == "rigid" else "flexible"
    return Design.model_validate({"legs": {"tilt_deg": tilt_deg, "kind": kind}})


def masses(design: Design, leg_mass: float | None = None) -> MassProperties:
    """Masses of a box on two thin uniform legs; a braced walker's legs weigh nothing."""
    body, limb = design.body, design.legs
    density = 1e-3 * design.material.density_g_cm3
    M = density * body.length_mm * body.depth_mm * body.thickness_mm
    J = M * (body.length_mm**2 + body.thickness_mm**2) / 12.0
    m = density * limb.length_mm * design.leg_thickness * body.depth_mm
    m = 0.0 if design.braced else (m if leg_mass is None else leg_mass)
    c = 0.5 * np.array(design.anchor_to_foot)
    a, b = (np.array(anchor) for anchor in design.anchors)
    return MassProperties(M, J, m, m * limb.length_mm**2 / 12.0, a, b, c, c, design.braced)


def scene_of(model: str, method: str, **tables: dict[str, Any]) -> Scene:
    """A scene with the given tables, on one model and method."""
    data = {key: dict(value) for key, value in tables.items()}
    data.setdefault("legs", {})["model"] = model
    data.setdefault("run", {})["method"] = method
    return Scene.model_validate(data)


def engine_of(
    model: str,
    method: str,
    tilt_deg: float = 10.0,
    leg_mass: float | None = None,
    **tables: dict[str, Any],
) -> Engine:
    """The engine of the paper's walker at a tilt on a scene of the given tables."""
    design = design_of(model, tilt_deg)
    scene = scene_of(model, method, **tables)
    return engines.prepare(scene, design, masses(design, leg_mass)).engine


def with_legs(engine: Engine, factor: float, ratio: float) -> Engine:
    """The same compliant walker on springs `factor` times as stiff, with a damping ratio."""
    walker, *others = engine.arguments
    k = factor * walker.legs.stiffness
    c = 2.0 * ratio * math.sqrt(k * walker.legs.inertia)
    legs = walker.legs._replace(stiffness=k, damping=c)
    return engine._replace(arguments=(walker._replace(legs=legs), *others))


def advance(engine: Engine, state: Array, seconds: float) -> tuple[Outcome, record.Tally]:
    """Advance `state` in place; how it ended, and the record."""
    tally = record.new(len(state))
    status = engine.advance(*engine.arguments, state, seconds, tally)
    return (Outcome.OK if status == 0 else engine.failures[status]), tally


def body_of(engine: Engine) -> tuple[float, float]:
    """Mass (g) and moment of inertia about O (g mm^2) of the body; of all when braced."""
    walker = engine.arguments[0]
    if isinstance(walker, chains.Walker):
        return walker.mass, walker.inertia
    return walker.M, walker.J


def lift(engine: Engine, state: Array, gap: float) -> None:
    """Put the lower foot `gap` (mm) over the plate, keeping everything else."""
    state[Y] += gap - float(feet(engine, state)[:, 1].min())


def mirrored(state: Array) -> Array:
    """The state of the mirror image (x -> -x, back and front exchanged), but for the modes."""
    image = state.copy()
    image[[X, PITCH, V_X, SPIN]] *= -1.0
    if len(state) > 9:
        image[[ANGLE_BACK, ANGLE_FRONT]] = -state[[ANGLE_FRONT, ANGLE_BACK]]
        image[[RATE_BACK, RATE_FRONT]] = -state[[RATE_FRONT, RATE_BACK]]
    return image


def feet(engine: Engine, state: Array) -> Array:
    """Back and front foot: rows of x (mm), height over the plate (mm), v_x, v_y over the plate."""
    walker, shaker = engine.arguments[:2]
    pitch, spin = state[PITCH], state[SPIN]
    ground, rising = plate.height(shaker, state[PHASE]), plate.velocity(shaker, state[PHASE])
    rows = []
    for foot, (anchor, reach) in enumerate(_limbs(walker)):
        angle, rate = (state[[9 + foot, 11 + foot]]) if len(state) > 9 else (0.0, 0.0)
        A, r = _turned(anchor, pitch), _turned(reach, pitch + angle)
        rows.append(
            (
                state[X] + A[0] + r[0],
                state[Y] + A[1] + r[1] - ground,
                state[V_X] - spin * A[1] - (spin + rate) * r[1],
                state[V_Y] + spin * A[0] + (spin + rate) * r[0] - rising,
            )
        )
    return np.array(rows)


def _limbs(walker: Any) -> list[tuple[Any, Any]]:
    if isinstance(walker, chains.Walker):
        reach = (walker.reach_x, walker.reach_y)
        return [((walker.back_x, walker.back_y), reach), ((walker.front_x, walker.front_y), reach)]
    return [(walker.d_back, (0.0, 0.0)), (walker.d_front, (0.0, 0.0))]


def _turned(d: tuple[float, float], angle: float) -> tuple[float, float]:
    cos, sin = math.cos(angle), math.sin(angle)
    return d[0] * cos - d[1] * sin, d[0] * sin + d[1] * cos


def momentum(engine: Engine, state: Array) -> float:
    """Horizontal momentum of body and legs, g mm/s."""
    walker = engine.arguments[0]
    if not isinstance(walker, chains.Walker):
        return float(walker.M * state[V_X])
    total = walker.mass * state[V_X]
    if walker.legs is not None:
        for foot, (anchor, _) in enumerate(_limbs(walker)):
            angle, rate = state[9 + foot], state[11 + foot]
            A = _turned(anchor, state[PITCH])
            C = _turned((walker.legs.centre_x, walker.legs.centre_y), state[PITCH] + angle)
            speed = state[V_X] - state[SPIN] * A[1] - (state[SPIN] + rate) * C[1]
            total += walker.legs.mass * speed
    return float(total)


def energy_error(engine: Engine, before: float, state: Array, tally: record.Tally) -> float:
    """Energy unaccounted for over the largest energy exchanged."""
    sums = tally.sums
    work = sums[record.PLATE_WORK]
    lost = sums[record.IMPACT_LOSS] + sums[record.FRICTION_LOSS] + sums[record.DAMPING_LOSS]
    unaccounted = engine.energy(state) - before - (work - lost)
    return float(abs(unaccounted) / max(abs(work), abs(lost), abs(before)))


def fall_time(gap: float) -> float:
    """Time (s) of a fall by `gap` mm."""
    return math.sqrt(2.0 * gap / GRAVITY)
