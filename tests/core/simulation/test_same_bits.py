"""Symmetries of a run from the command's function: a scaled walker, a later start, the mirror image, other headings."""

import math
from functools import partial

import pytest

import walkergen as wg
from walkergen.commands.selftest.scenes import advance, masses, paper_drive
from walkergen.commands.selftest.space_scenes import max_pose_difference, moving_start, quarter_turn
from walkergen.core.scene import Scene
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.space.state import C_Z, HEADING, LEGS, PHASE, Q_X, Q_Y, ROLL, SHOWN_Y, V_Z, W_X, W_Y
from walkergen.core.walker.design import Design

KINDS = pytest.mark.parametrize("kind", ["flexible", "braced"])


def scaled(power, kind):
    """Design and scene with lengths, moduli and tip radii x 4^power, and frequency x 2^-power."""
    length, seconds = 4.0**power, 2.0**power
    tables = Design().variant(tilt_deg=10.0, kind=kind).model_dump(include={"body", "legs"}, exclude_none=True)
    for table in tables.values():
        table.update({key: value * length for key, value in table.items() if key.endswith("_mm")})
    design = Design.model_validate(tables | {"material": {"youngs_modulus_gpa": 3.0 * length}})
    scene = Scene.model_validate(
        {
            "drive": {"frequency_hz": 90.0 / seconds, "gamma": 1.8},
            "arena": {"kind": "plane"},
            "plate": {"youngs_modulus_gpa": Scene().plate.elastic.youngs_modulus_gpa * length},
            "feet": {"tip_radius_um": 5.0 * length},
            "run": {"seconds": 0.25 * seconds, "discard_seconds": 0.125 * seconds, "runs": 2},
            "effects": {"off": ["air_drag"]},
        }
    )
    return design, scene


@KINDS
@pytest.mark.parametrize("power", [-1, 1, 2])
def test_lengths_times_4_run_at_twice_the_speed_to_the_bit(kind, power):
    """Dimensional analysis: with g given, speeds go as the root of lengths; powers of two change no bit."""
    pairs = scaled(0, kind), scaled(power, kind)
    own, other = (wg.simulate(design, scene=scene).speed.value for design, scene in pairs)
    assert abs(own) > 0.0
    assert other == own * 2.0**power


@KINDS
@pytest.mark.parametrize("contact", [{"restitution": 0.9, "friction": 0.1}, {"restitution": 0.5, "friction": 2.0}])
def test_images_of_a_start_move_as_images(kind, contact):
    """Some landings long. A mirror image differs by what sums in another order round, a quarter turn by the root of 1/2
    as well, and a start a period later by the rounding of 2 pi: none of the three can be equal to the bit.
    """
    design = Design().variant(tilt_deg=10.0, kind=kind)
    tables = {"drive": paper_drive(1.8), "arena": {"kind": "plane"}, "contact": contact}
    plan = prepare(Scene.model_validate(tables), design, masses(design))
    twists = range(1, 2 * len(plan.world.walker.stiffness), 2)
    for image_of, limit in ((partial(mirror_image, twists=twists), 1e-15), (quarter_turn, 1e-13), (later, 1e-13)):
        state = moving_start(plan)
        image = image_of(state)
        advance(plan, state, 6e-3)
        advance(plan, image, 6e-3)
        # mm and rad: rounding of 10 mm, 2e-15, grown by at most a hundred; a mirror image has hardly any
        assert max_pose_difference(image_of(state), image) < limit


def mirror_image(state, twists):
    """Return the mirror image z -> -z of a state."""
    image = state.copy()
    image[[SHOWN_Y, HEADING, ROLL, C_Z, V_Z, W_X, W_Y, Q_X, Q_Y, *(LEGS + entry for entry in twists)]] *= -1.0
    return image


def later(state):
    """Return a state one period of the plate later."""
    image = state.copy()
    image[PHASE] += 2.0 * math.pi
    return image
