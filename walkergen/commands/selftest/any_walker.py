"""Hard cases of any walker in space: unlike legs, two materials, many legs, other bodies."""

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from walkergen.commands.selftest.case import SPACE, Case, Check, check_fact
from walkergen.commands.selftest.scenes import advance, paper_drive
from walkergen.commands.selftest.space_scenes import (
    check_constant_velocity,
    check_space_motion,
    max_pose_difference,
    moving_start,
    quarter_turn,
)
from walkergen.core.numerics import Array
from walkergen.core.printing.export import stl_bytes
from walkergen.core.scene import Scene
from walkergen.core.simulation.plan import Plan, prepare
from walkergen.core.simulation.space.model import mirror_state
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties, Spatial

COMPARISON_S = 6e-3
"""Time (s) of the comparison of images, as for the paper's walker."""

RUN_S = 0.15
"""Duration, s: some hundred landings of corners."""

ENERGY_LIMIT = 1e-2, "second order in the steps, of landings inside a step"

ROUNDING_REASON = "rounding, grown six times by each landing of a corner"

MIRROR = np.diag([-1.0, 1.0, 1.0])

THREE_LEGS: tuple[dict[str, Any], ...] = (
    {"along_mm": -7.0, "tilt_deg": 10.0},
    {"along_mm": 1.0, "tilt_deg": 10.0, "thickness_mm": 0.6, "width_mm": 5.0, "friction": 0.05},
    {"along_mm": 6.0, "tilt_deg": -10.0, "kind": "braced"},
)
"""Three legs that differ in everything except their height."""

DISC_BODY = {"outline": "disc", "length_mm": 22.0, "thickness_mm": 2.0}

ONE_BRACED_LEG: tuple[dict[str, Any], ...] = ({"along_mm": -6.5, "kind": "braced"}, {"along_mm": 6.5})


def _design(legs: Any, **tables: Any) -> Design:
    """Make a design with these legs, flexible and tilted by 10 deg by default."""
    return Design.model_validate({"legs": legs, **tables})


def _plan(design: Design, mass: MassProperties | None = None, arena: str = "plane") -> Plan:
    """Prepare the 3D simulation of a design, shaken at 1.8 g, in an `arena` ("plane" or "lane")."""
    scene = Scene.model_validate({"arena": {"kind": arena}, "drive": paper_drive(1.8)})
    return prepare(scene, design, solids.mass_of(design) if mass is None else mass)


def _check_mirror_image() -> Iterator[Check]:
    """Check that the mirror image of a walker on three unlike legs runs exactly the other way."""
    design = _design(list(THREE_LEGS))
    mirrored_legs = [leg | {"along_mm": -leg["along_mm"], "tilt_deg": -leg["tilt_deg"]} for leg in THREE_LEGS[::-1]]
    mass = solids.mass_of(design)
    plan, mirror_plan = _plan(design, mass), _plan(_design(mirrored_legs), _mirrored_mass(mass))
    state = moving_start(plan)
    mirrored = mirror_state(plan.world.walker, state)
    advance(plan, state, COMPARISON_S)
    advance(mirror_plan, mirrored, COMPARISON_S)
    difference = max_pose_difference(mirror_state(plan.world.walker, state), mirrored)
    yield Check(f"after {COMPARISON_S:g} s, mm", difference, 1e-9, ROUNDING_REASON)


def _mirrored_mass(mass: MassProperties) -> MassProperties:
    """Return the masses of the mirror image x -> -x, with the legs in reverse order."""
    assert mass.spatial is not None
    legs = tuple(
        leg._replace(
            anchor=leg.anchor * (-1.0, 1.0),
            c_A=leg.c_A * (-1.0, 1.0),
            c_T=leg.c_T * (-1.0, 1.0),
            tensor=None if leg.tensor is None else MIRROR @ leg.tensor @ MIRROR,
        )
        for leg in mass.legs[::-1]
    )
    whole = Spatial(mass.spatial.z, MIRROR @ mass.spatial.body @ MIRROR)
    return mass._replace(legs=legs, spatial=whole)


def _check_listed_legs() -> Iterator[Check]:
    """Check that two equal legs run identically to the last bit, whether listed separately or not."""
    final_states: list[Array] = []
    for legs in ({"tilt_deg": 10.0}, [{"tilt_deg": 10.0, "along_mm": x} for x in (-6.5, 6.5)]):
        plan = _plan(_design(legs))
        state = moving_start(plan)
        advance(plan, state, RUN_S)
        final_states.append(state)
    same = bool(np.array_equal(final_states[0], final_states[1]))
    yield check_fact("[legs] against [[legs]]: the same bits", same)


def _check_no_friction() -> Iterator[Check]:
    """Check that legs with own frictions of 0 feel no friction from the scene."""
    yield check_constant_velocity(_plan(_design([leg | {"friction": 0.0} for leg in THREE_LEGS])), RUN_S)


def _check_motions() -> Iterator[Check]:
    """Check runs of walkers of every kind: a physical end, every energy accounted for."""
    for about, design, arena in (
        ("three unlike legs", _design(list(THREE_LEGS)), "plane"),
        ("one leg braced, one free", _design(list(ONE_BRACED_LEG)), "plane"),
        ("disc between walls", _design(_disc_legs(), body=DISC_BODY), "lane"),
    ):
        plan = _plan(design, arena=arena)
        yield from check_space_motion(plan, moving_start(plan), RUN_S, about, ENERGY_LIMIT)


def _disc_legs() -> list[dict[str, Any]]:
    return [{"along_mm": x, "width_mm": 6.0} for x in (-5.0, 5.0)]


def _check_disc() -> Iterator[Check]:
    """Check that a disc has no corners: on an endless plane it runs alike in every direction."""
    plan = _plan(_design(_disc_legs(), body=DISC_BODY))
    rim = (plan.world.walker.corners - plan.world.walker.centre)[:, [0, 2]]
    reach, radius = float(np.abs(rim).max()), float(np.hypot(*rim.T).max())
    yield Check("farthest point of its hull from O beyond its radius, mm", radius - 11.0, 1e-12, "rounding")
    yield check_fact("its hull is as wide as long", abs(reach / radius - 1.0) < 0.02)
    state = moving_start(plan)
    turned = quarter_turn(state)
    advance(plan, state, COMPARISON_S)
    advance(plan, turned, COMPARISON_S)
    yield Check("quarter turn, mm", max_pose_difference(quarter_turn(state), turned), 1e-9, ROUNDING_REASON)


def _check_forty_legs() -> Iterator[Check]:
    """Check that a walker on forty legs rests on all of them simultaneously."""
    legs = [
        {"along_mm": -12.0 + 1.25 * k, "across_mm": z, "width_mm": 2.0, "length_mm": 3.0}
        for k in range(20)
        for z in (-3.0, 3.0)
    ]
    plan = _plan(_design(legs))
    state = plan.initial_state(clearance=0.0, pitch=0.0, phase=0.0)
    deviation = float(np.abs(plan.feet(state)[:, 1]).max())
    yield Check("heights of forty feet that stand, mm", deviation, 1e-9, "rounding of a mesh's masses")
    yield from check_space_motion(plan, moving_start(plan), 4e-3, "forty legs", ENERGY_LIMIT)


def _check_mesh_body() -> Iterator[Check]:
    """Check that a box read from a file runs as the same box given by its lengths."""
    box = solids.build(Design()).body
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "box.stl"
        upright = box._replace(vertices=box.vertices[:, [0, 2, 1]] * (1.0, -1.0, 1.0))
        path.write_bytes(stl_bytes(upright, "box"))
        final_states: list[Array] = []
        for body in ({}, {"mesh": str(path)}):
            plan = _plan(_design({"tilt_deg": 10.0, "width_mm": 8.0}, body=body))
            state = moving_start(plan)
            advance(plan, state, COMPARISON_S)
            final_states.append(state)
    yield Check("after 6 ms, mm", max_pose_difference(*final_states), 1e-7, "rounding of masses, grown by landings")


CASES = [
    Case("space: mirror image of three unlike legs", "7", "mirror symmetry", SPACE, _check_mirror_image),
    Case(
        "space: two equal legs, listed or not", "7", "identity: equal walkers move equally", SPACE, _check_listed_legs
    ),
    Case(
        "space: feet of another material without friction",
        "7",
        "Newton: momentum along a smooth plate",
        SPACE,
        _check_no_friction,
    ),
    Case("space: unlike legs, mixed legs, a disc between walls", "7", "first law: energy book", SPACE, _check_motions),
    Case("space: a disc has no corners", "7", "symmetry under rotation", SPACE, _check_disc),
    Case("space: forty legs", "7", "geometry: feet in one plane; first law", SPACE, _check_forty_legs),
    Case("space: a box from a file", "7", "identity: equal bodies move equally", SPACE, _check_mesh_body),
]
