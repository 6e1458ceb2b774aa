"""Hard cases of contacts in space: friction, jamming, stiffness from soft to rigid, walls."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from walkergen.commands.selftest.case import SPACE, Case, Check, check_fact
from walkergen.commands.selftest.scenes import STILL_DRIVE, advance, masses, paper_design, paper_drive
from walkergen.commands.selftest.space_scenes import (
    check_constant_velocity,
    check_space_motion,
    max_compression,
    max_pose_difference,
    mirror_image,
    moving_start,
    space_plan,
)
from walkergen.core.scene import GRAVITY, PAPER_CONTACT, Scene
from walkergen.core.simulation import record
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.space.state import C_X, C_Z, Q_Z, V_X, V_Y, V_Z
from walkergen.core.simulation.space.walker import make_walker, mobility
from walkergen.core.walker.mass import to_rigid

RUN_S = 0.3
"""Duration, s: some hundred landings of corners."""

FIRST_TOUCH_S, LANE_GAP_MM = 2e-5, 8.5
"""Time (s) of the first touch of a wall and the plate, and the gap (mm) of the lane."""

BOUNCES_S = 0.5
"""Duration (s) of free bounces: a hundred landings of corners and more."""

ENERGY_LIMIT = 1e-2, "second order in the steps, of landings inside a step; up to 2e-3 at the feet's own step"

CONE_CUT_LIMIT = (
    0.1,
    "where no modes of the contacts agree in a step, forces are cut to the cone: some percent in one step",
)


def _check_no_friction() -> Iterator[Check]:
    """Check that feet without friction do not push along the plate."""
    plan = space_plan(drive=paper_drive(1.8), contact={"friction": 0.0, "restitution": 0.5})
    yield check_constant_velocity(plan, RUN_S)


def _check_friction() -> Iterator[Check]:
    """Check motions at several tilts, frictions and restitutions, up to jamming."""
    for tilt, friction in ((10.0, 0.23), (10.0, 0.3), (10.0, 1e3), (20.0, 0.3), (35.0, 1.0)):
        for restitution in (0.02, 0.5, 1.0):
            plan = space_plan(tilt, drive=paper_drive(1.8), contact={"friction": friction, "restitution": restitution})
            title = f"{tilt:g} deg, mu = {friction:g}, e = {restitution:g}"
            yield from check_space_motion(
                plan, moving_start(plan), RUN_S, title, CONE_CUT_LIMIT if friction > 1.0 else ENERGY_LIMIT
            )


def _check_zero_slip() -> Iterator[Check]:
    """Check a landing at a tangential velocity of exactly zero: the limit of slow slips."""
    for friction in (0.1, 0.25, 2.0):
        plan = space_plan(drive=STILL_DRIVE, contact={"friction": friction, "restitution": 0.5})
        final_states = []
        for slip in (0.0, 1e-9, -1e-9):
            state = plan.initial_state(clearance=0.0, pitch=4e-3, phase=0.0, roll=2e-3)
            state[[V_X, V_Y]] = slip, -20.0
            advance(plan, state, 2e-3)
            final_states.append(state)
        finite = all(bool(np.isfinite(state).all()) for state in final_states)
        yield check_fact(f"mu = {friction:g}: finite", finite)
        yield Check(
            f"mu = {friction:g}: end without slip against slips of +-1e-9 mm/s, mm",
            max(
                max_pose_difference(final_states[0], final_states[1]),
                max_pose_difference(final_states[0], final_states[2]),
            ),
            1e-9,
            "2e-12 mm of way, grown by a landing",
        )


def _check_lossless_bounces() -> Iterator[Check]:
    """Check that free bounces of undamped smooth feet gain no energy, and lose little of it by the step."""
    for tilt in (5.0, 10.0, 20.0, 35.0):
        step_us = 1e6 * space_plan(tilt, drive=paper_drive(1.8)).world.options.step
        at_step, at_fine_step = _energy_changes(tilt, step_us), _energy_changes(tilt, step_us / 16.0)
        gained = max(max(change for change, _ in at_step), 0.0)
        yield Check(
            f"{tilt:g} deg: energy gained in {BOUNCES_S:g} s, relative", gained, 0.02, "steps of second order lose it"
        )
        lost = max(-math.log1p(change) / landings for change, landings in at_step)
        yield Check(
            f"{tilt:g} deg: energy lost in a landing, relative",
            lost,
            0.02 * (1.0 - PAPER_CONTACT.restitution**2),
            "the step takes less than a fiftieth of what the damper of the paper's restitution takes",
        )
        lost_at_fine_step = max(abs(change) / landings for change, landings in at_fine_step)
        yield Check(
            f"{tilt:g} deg: at a sixteenth of the step, over that",
            lost_at_fine_step / lost,
            1.0 / 16.0,
            "of more than first order",
        )


def _energy_changes(tilt: float, step_us: float) -> list[tuple[float, int]]:
    """Return the relative change of energy in the bounces of ten drops, and the landings of each.

    `tilt` in deg. Energies count from the standing walker.
    """
    plan = space_plan(
        tilt,
        drive=STILL_DRIVE,
        contact={"friction": 0.0, "restitution": 1.0},
        legs={"damping_ratio": 0.0},
        run={"step_us": step_us},
    )
    changes = []
    for offset in np.linspace(-1.0, 1.0, 10):
        state = plan.initial_state(
            clearance=0.5 + 0.1 * offset, pitch=4e-3 * offset, phase=0.0, roll=3e-3 + 1e-3 * offset
        )
        at_rest = plan.energy(plan.initial_state(clearance=0.0, pitch=0.0, phase=0.0))
        before = plan.energy(state) - at_rest
        _, tally = advance(plan, state, BOUNCES_S)
        changes.append(((plan.energy(state) - at_rest) / before - 1.0, int(tally.counts[record.IMPACTS])))
    return changes


def _check_stiffness() -> Iterator[Check]:
    """Check motions on feet a hundred times softer and stiffer, and rigid ones."""
    tips: dict[str, dict[str, Any]] = {
        "tips a hundred times softer": {"plate": {"youngs_modulus_gpa": 0.0167}},
        "tips a hundred times stiffer": {"feet": {"tip_radius_um": 5e4}},
        "rigid tips": {"feet": {"rigid_tips": True}},
    }
    for title, tables in tips.items():
        plan = space_plan(drive=paper_drive(1.8), contact={"restitution": 0.5}, **tables)
        yield from check_space_motion(plan, moving_start(plan), RUN_S, title, ENERGY_LIMIT)


def _check_frozen_joints() -> Iterator[Check]:
    """Check joints without compliance: inverse mass and motion equal those without joints, on a soft plate."""
    tilt, modulus = 20.0, 9000.0
    design = paper_design(tilt)
    stiff = design.model_copy(update={"material": design.material.model_copy(update={"youngs_modulus_gpa": modulus})})
    scene = Scene.model_validate(
        {
            "drive": STILL_DRIVE,
            "arena": {"kind": "plane"},
            "contact": {"restitution": 0.5},
            "plate": {"youngs_modulus_gpa": 0.1},
            "run": {"step_us": 1.0},
        }
    )
    with_joints = prepare(scene, stiff, masses(stiff))
    case = with_joints.case._replace(mass=to_rigid(masses(stiff)))
    rigid_walker, _ = make_walker(case, with_joints.resolved)
    # Dampers are given for corners with their own legs' masses
    rigid_walker = rigid_walker._replace(damper=with_joints.world.walker.damper)
    without_joints = with_joints._replace(world=with_joints.world._replace(walker=rigid_walker))
    walker = with_joints.world.walker
    frozen = mobility(walker._replace(hinge_mobility=0.0 * walker.hinge_mobility))
    rigid = mobility(without_joints.world.walker)
    yield Check(
        "inverse mass at the corners, relative",
        float(np.abs(frozen - rigid).max() / np.abs(rigid).max()),
        1e-12,
        "rounding",
    )
    velocities = []
    for plan in (with_joints, without_joints):
        state = plan.initial_state(clearance=0.05, pitch=4e-3, phase=0.0, roll=2e-3)
        advance(plan, state, 8e-3)
        velocities.append(state[C_X : Q_Z + 1])
    yield Check(
        "velocities after five landings against those without joints, mm/s and rad/s",
        float(np.abs(velocities[0] - velocities[1]).max()),
        0.2,
        "give of the joints, some thousandth of that of the tips; the walker falls at 31 mm/s",
    )


def _check_wall_and_plate() -> Iterator[Check]:
    """Check edges that touch a wall and feet that touch the plate in the same step."""
    for restitution in (0.02, 0.5, 1.0):
        plan = space_plan(
            drive=STILL_DRIVE,
            arena={"kind": "lane", "gap_mm": LANE_GAP_MM, "wall_restitution": restitution},
            contact={"restitution": restitution},
        )
        state = plan.initial_state(clearance=0.0, pitch=0.0, phase=0.0)
        state[C_Z] = 0.25
        state[[V_X, V_Y, V_Z]] = 10.0, -20.0, 30.0
        image = mirror_image(state)
        touched = state.copy()
        advance(plan, touched, FIRST_TOUCH_S)
        pushed = bool(touched[V_Z] < 30.0 and touched[V_Y] > -20.0 - GRAVITY * FIRST_TOUCH_S)
        yield check_fact(f"e = {restitution:g}: wall and plate push at once", pushed)
        title = f"e = {restitution:g}: both walls, alike, mm"
        direct = state.copy()
        advance(plan, direct, 1e-3)
        advance(plan, image, 1e-3)
        yield Check(title, max_pose_difference(mirror_image(direct), image), 1e-9, "rounding, grown by landings")
        yield from check_space_motion(plan, state, RUN_S, f"e = {restitution:g}", ENERGY_LIMIT)
        play = 0.5 * (LANE_GAP_MM - plan.case.design.size.depth)
        yield Check(
            f"e = {restitution:g}: middle of the walker beyond its play between the walls, mm",
            max(abs(float(state[C_Z])) - play, 0.0),
            max_compression(plan, math.hypot(10.0, 20.0, 30.0)),
            "all of the walker on one corner against a wall, at the speed of its start",
        )


CASES = [
    Case(
        "space: no friction, no push along the plate",
        "7",
        "Newton: momentum along a smooth plate",
        SPACE,
        _check_no_friction,
    ),
    Case("space: friction, jamming and beyond", "7", "first law: energy book; Coulomb's cone", SPACE, _check_friction),
    Case("space: landing without slip", "7", "Coulomb: continuous in the slip", SPACE, _check_zero_slip),
    Case(
        "space: undamped smooth feet keep their energy",
        "7",
        "first law: no loss without damper or slip",
        SPACE,
        _check_lossless_bounces,
    ),
    Case(
        "space: feet a hundred times softer and stiffer",
        "7",
        "first law: energy book; static stiffness",
        SPACE,
        _check_stiffness,
    ),
    Case(
        "space: stiff hinges and twist are braced legs", "7", "rigid bodies: parallel axes", SPACE, _check_frozen_joints
    ),
    Case("space: wall and plate in one step", "7", "mirror symmetry; first law", SPACE, _check_wall_and_plate),
]
