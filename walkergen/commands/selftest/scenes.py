"""Scenes of the hard cases: plans with masses in closed form, and results read from their states.

Masses in closed form (a box on two thin uniform legs; braced legs without mass) make a walker and
its mirror image exact images of each other, to the last bit. A mesh does not.
"""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from walkergen.commands.selftest.case import Check, check_fact
from walkergen.core.numerics import Array
from walkergen.core.scene import Scene, still_plate_drive
from walkergen.core.simulation import record
from walkergen.core.simulation.plan import Plan, prepare
from walkergen.core.simulation.run import STATUS_OUTCOMES, Outcome
from walkergen.core.simulation.world import OK
from walkergen.core.walker.design import Design
from walkergen.core.walker.limbs import Limb
from walkergen.core.walker.mass import LegMass, MassProperties, Spatial

LEG_LENGTH_MM, HALF_SPACING_MM = 7.5, 6.5
"""Lengths of the paper's walker, mm: of a leg; half between the feet."""

PHYSICAL_OUTCOMES = Outcome.OK, Outcome.TOPPLED, Outcome.FOLDED

STILL_DRIVE = still_plate_drive(90.0)
"""Drive of a plate at rest: its amplitude vanishes against the rounding of any height."""


def paper_drive(gamma: float) -> dict[str, float]:
    """Return the drive at the paper's 90 Hz with a peak acceleration in units of g."""
    return {"frequency_hz": 90.0, "gamma": gamma}


def paper_design(tilt_deg: float) -> Design:
    """Return the design of the paper's walker."""
    return Design.model_validate({"legs": {"tilt_deg": tilt_deg}})


def masses(design: Design, leg_mass: float | None = None) -> MassProperties:
    """Return the masses of a box on thin uniform legs, without mass if braced.

    `leg_mass` (g) replaces that of a flexible leg. The inertia across the run is that of the same box and of strips
    without thickness.
    """
    length, thickness, depth = design.size
    density = 1e-3 * design.material.density_g_cm3
    M = density * length * depth * thickness
    J = M * (length**2 + thickness**2) / 12.0
    size = np.array([length, thickness, depth])
    box = M / 12.0 * np.diag([size[1] ** 2 + size[2] ** 2, size[0] ** 2 + size[2] ** 2, 12 * J / M])
    legs = tuple(_uniform_leg(limb, density, leg_mass) for limb in design.limbs)
    return MassProperties(M, J, legs, design.rigid, Spatial(0.0, box))


def _uniform_leg(limb: Limb, density: float, leg_mass: float | None) -> LegMass:
    """Return the mass properties of a thin uniform leg; `density` in g/mm^3, `leg_mass` (g) replaces its mass."""
    m = density * limb.length * limb.thickness * limb.width
    m = 0.0 if limb.rigid else (m if leg_mass is None else leg_mass)
    c = 0.5 * np.array(limb.anchor_to_foot)
    along = c / np.hypot(*c)
    second_moment = np.outer((*along, 0.0), (*along, 0.0)) * limb.length**2
    second_moment += np.diag([0, 0, limb.width**2])
    strip = m / 12.0 * (np.trace(second_moment) * np.eye(3) - second_moment)
    anchor, inertia = np.array(limb.anchor), m * limb.length**2 / 12.0
    return LegMass(m, inertia, anchor, c, c, limb.across, strip)


def paper_plan(tilt_deg: float = 10.0, leg_mass: float | None = None, **tables: Any) -> Plan:
    """Prepare the plan of the paper's walker at a tilt, in a scene of the given tables."""
    design = paper_design(tilt_deg)
    return prepare(Scene.model_validate(tables), design, masses(design, leg_mass))


def scaled_paper_plan(scale: float, run: Mapping[str, float] | None = None, **tables: Any) -> Plan:
    """Return the plan of the paper's walker at 1.8 g, with lengths x s and times x sqrt(s).

    Young's moduli x s keep the springs similar; s is `scale`. `run` and `tables` are of the scene.
    """
    paper = paper_design(10.0)
    lengths = {
        name: {k: v * scale if k.endswith("_mm") else v for k, v in section.items()}
        for name, section in paper.model_dump(include={"body", "legs"}, exclude_none=True).items()
    }
    design = Design.model_validate(lengths | {"material": {"youngs_modulus_gpa": 3.0 * scale}})
    drive = {"frequency_hz": 90.0 / math.sqrt(scale), "gamma": 1.8}
    default_scene = Scene()
    similar = {
        "plate": {"youngs_modulus_gpa": default_scene.plate.elastic.youngs_modulus_gpa * scale},
        "feet": {"tip_radius_um": default_scene.feet.tip_radius_um * scale},
    }
    scene = Scene.model_validate({"drive": drive, "run": run or {}, **similar, **tables})
    return prepare(scene, design, masses(design))


def advance(plan: Plan, state: Array, seconds: float) -> tuple[Outcome, record.Tally]:
    """Advance `state` in place by `seconds`. Return how it ended, and the record."""
    tally = record.new_tally(len(state))
    status = plan.advance(state, seconds, tally)
    return (Outcome.OK if status == OK else STATUS_OUTCOMES[status]), tally


Limit = tuple[float, str]
"""Limit of a check, and the reason why it is not tighter."""


def check_motion(
    plan: Plan, state: Array, seconds: float, about: str, tolerance: Limit, deepest: Limit
) -> Iterator[Check]:
    """Yield checks of any motion, however extreme: a physical end, finite, over the plate, its energy balanced.

    PHYSICAL_OUTCOMES excludes failed convergence and unexplained energy. `about` names the motion. Limits:
    `tolerance` of the energy unaccounted for, as a share; `deepest` for a foot below the plate, mm.
    """
    before, outcome, lowest = plan.energy(state), Outcome.OK, 0.0
    sums = np.zeros_like(record.new_tally(0).sums)
    for _ in range(40):  # parts, between which the feet are checked
        outcome, tally = advance(plan, state, seconds / 40)
        sums += tally.sums
        lowest = min(lowest, float(plan.feet(state)[:, 1].min()))
        if outcome is not Outcome.OK:
            break
    finite = bool(np.isfinite(state).all() and np.isfinite(sums).all())
    physical = outcome in PHYSICAL_OUTCOMES
    yield check_fact(f"{about}: a physical end ({outcome.value}), finite", physical and finite)
    error = record.energy_error(sums, plan.energy(state) - before, before)
    yield Check(f"{about}: energy unaccounted for", error, *tolerance)
    yield Check(f"{about}: foot below the plate, mm", -lowest, *deepest)
