"""Hard cases of any walker in space: unlike legs, two materials, many legs, other bodies."""

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from walkergen.commands.selftest.case import SPACE, Case, Check, exactly
from walkergen.commands.selftest.scenes import Array, advance, shaken
from walkergen.commands.selftest.space_scenes import apart, quarter_turned, survives, thrown, unslowed
from walkergen.core.printing.export import stl_bytes
from walkergen.core.scene import Scene
from walkergen.core.simulation.plan import Plan, prepare
from walkergen.core.simulation.space.model import mirrored
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties, Spatial

IMAGED = 6e-3
"""Time (s) after which images are compared, as for the paper's walker."""

RUN = 0.15
"""Duration, s: some hundred landings of corners."""

BALANCE = 1e-2, "second order in the steps, of landings inside a step"

GROWN = "rounding, grown six times by each landing of a corner"

MIRROR = np.diag([-1.0, 1.0, 1.0])

THREE: tuple[dict[str, Any], ...] = (
    {"along_mm": -7.0, "tilt_deg": 10.0},
    {"along_mm": 1.0, "tilt_deg": 10.0, "thickness_mm": 0.6, "width_mm": 5.0, "friction": 0.05},
    {"along_mm": 6.0, "tilt_deg": -10.0, "kind": "braced"},
)
"""Three legs that differ in all but their height."""

DISC = {"outline": "disc", "length_mm": 22.0, "thickness_mm": 2.0}

ONE_BRACED: tuple[dict[str, Any], ...] = ({"along_mm": -6.5, "kind": "braced"}, {"along_mm": 6.5})


def _design(legs: Any, **tables: Any) -> Design:
    """Design with these legs, flexible and tilted by 10 deg where they do not say."""
    return Design.model_validate({"legs": legs, **tables})


def _plan(design: Design, mass: MassProperties | None = None, arena: str = "plane") -> Plan:
    """Plan of a design in space, shaken at 1.8 g."""
    scene = Scene.model_validate({"arena": {"kind": arena}, "drive": shaken(1.8)})
    return prepare(scene, design, solids.mass_of(design) if mass is None else mass)


def _images() -> Iterator[Check]:
    """Check that the mirror image of a walker on three unlike legs runs exactly the other way."""
    design = _design(list(THREE))
    turned = [leg | {"along_mm": -leg["along_mm"], "tilt_deg": -leg["tilt_deg"]} for leg in THREE[::-1]]
    mass = solids.mass_of(design)
    plan, mirror_plan = _plan(design, mass), _plan(_design(turned), _mirrored_mass(mass))
    state = thrown(plan)
    other = mirrored(plan.world.walker, state)
    advance(plan, state, IMAGED)
    advance(mirror_plan, other, IMAGED)
    off = apart(mirrored(plan.world.walker, state), other)
    yield Check(f"after {IMAGED:g} s, mm", off, 1e-9, GROWN)


def _mirrored_mass(mass: MassProperties) -> MassProperties:
    """Masses of the mirror image x -> -x, legs listed the other way round."""
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


def _listed() -> Iterator[Check]:
    """Check that two equal legs run to the last bit alike, listed one by one or not."""
    ends: list[Array] = []
    for legs in ({"tilt_deg": 10.0}, [{"tilt_deg": 10.0, "along_mm": x} for x in (-6.5, 6.5)]):
        plan = _plan(_design(legs))
        state = thrown(plan)
        advance(plan, state, RUN)
        ends.append(state)
    same = bool(np.array_equal(ends[0], ends[1]))
    yield exactly("[legs] against [[legs]]: the same bits", same)


def _smooth() -> Iterator[Check]:
    """Check that own frictions of 0 leave the scene's without effect."""
    yield unslowed(_plan(_design([leg | {"friction": 0.0} for leg in THREE])), RUN)


def _survivors() -> Iterator[Check]:
    """Check runs of walkers of every kind: a physical end, every energy accounted for."""
    for about, design, arena in (
        ("three unlike legs", _design(list(THREE)), "plane"),
        ("one leg braced, one free", _design(list(ONE_BRACED)), "plane"),
        ("disc between walls", _design(_on_disc(), body=DISC), "lane"),
    ):
        plan = _plan(design, arena=arena)
        yield from survives(plan, thrown(plan), RUN, about, BALANCE)


def _on_disc() -> list[dict[str, Any]]:
    return [{"along_mm": x, "width_mm": 6.0} for x in (-5.0, 5.0)]


def _disc() -> Iterator[Check]:
    """Check that a disc has no corners: on an endless plane it runs alike in every direction."""
    plan = _plan(_design(_on_disc(), body=DISC))
    reach = float(np.abs(plan.world.walker.corners[:, [0, 2]]).max())
    wide = np.hypot(*plan.world.walker.corners[:, [0, 2]].T).max()
    off = float(np.hypot(*plan.world.walker.centre[[0, 2]]))
    yield Check(
        "farthest point of its hull from C beyond its radius, mm", wide - 11.0, 2.0 * off, "twice C's way off O"
    )
    yield exactly("its hull is as wide as long", abs(reach / wide - 1.0) < 0.02)
    state = thrown(plan)
    turned = quarter_turned(state)
    advance(plan, state, IMAGED)
    advance(plan, turned, IMAGED)
    yield Check("quarter turn, mm", apart(quarter_turned(state), turned), 1e-9, GROWN)


def _forty() -> Iterator[Check]:
    """Check a walker on forty legs, which stands on all of them at once."""
    legs = [
        {"along_mm": -12.0 + 1.25 * k, "across_mm": z, "width_mm": 2.0, "length_mm": 3.0}
        for k in range(20)
        for z in (-3.0, 3.0)
    ]
    plan = _plan(_design(legs))
    state = plan.start(0.0, 0.0, 0.0)
    off = float(np.abs(plan.feet(state)[:, 1]).max())
    yield Check("heights of forty feet that stand, mm", off, 1e-9, "rounding of a mesh's masses")
    yield from survives(plan, thrown(plan), 4e-3, "forty legs", BALANCE)


def _mesh() -> Iterator[Check]:
    """Check that a box read from a file runs as the same box given by its lengths."""
    box = solids.build(Design()).body
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "box.stl"
        upright = box._replace(vertices=box.vertices[:, [0, 2, 1]] * (1.0, -1.0, 1.0))
        path.write_bytes(stl_bytes(upright, "box"))
        ends: list[Array] = []
        for body in ({}, {"mesh": str(path)}):
            plan = _plan(_design({"tilt_deg": 10.0, "width_mm": 8.0}, body=body))
            state = thrown(plan)
            advance(plan, state, IMAGED)
            ends.append(state)
    yield Check("after 6 ms, mm", apart(*ends), 1e-7, "rounding of masses, grown by landings")


CASES = [
    Case("space: mirror image of three unlike legs", "7", "mirror symmetry", SPACE, _images),
    Case("space: two equal legs, listed or not", "7", "identity: equal walkers move equally", SPACE, _listed),
    Case(
        "space: feet of another material without friction", "7", "Newton: momentum along a smooth plate", SPACE, _smooth
    ),
    Case("space: unlike legs, mixed legs, a disc between walls", "7", "first law: energy book", SPACE, _survivors),
    Case("space: a disc has no corners", "7", "symmetry under rotation", SPACE, _disc),
    Case("space: forty legs", "7", "geometry: feet in one plane; first law", SPACE, _forty),
    Case("space: a box from a file", "7", "identity: equal bodies move equally", SPACE, _mesh),
]
