"""Nothing that a scene or a design says is silently nothing: it changes the motion, or one line says why not."""

import re

import numpy as np
import pytest

from walkergen.core.errors import InputError
from walkergen.core.scene import Scene
from walkergen.core.simulation import record
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.run import drop_for_run
from walkergen.core.simulation.space.state import V_Z
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design

SECONDS = 0.03
SCENE = Scene.model_validate({"drive": {"frequency_hz": 90.0, "gamma": 1.8}})

MISSING_NUMBERS = {
    "second_harmonic": "drive.second_harmonic_ratio = 0",
    "plate_slope": "plate.slope_deg = 0",
    "unevenness": "feet.unevenness_um = 0",
    "plate_noise": "plate.noise_ratio = 0",
    "plate_roughness": "plate.roughness_um = 0",
    "plate_along": r"plate.horizontal_ratio = \[0, 0\]",
    "plate_gradient": r"plate.gradient_percent_per_mm = \[0, 0\]",
    "plate_rocking": r"plate.rocking_percent_per_mm = \[0, 0\]",
    "lid": "arena.lid_mm is not given",
    "gyroscopic_torque": "there is no motor",
}
"""Effects that need a number, by their switches, with the message for a missing number."""


def scene_of(**keys):
    return SCENE.variant(**keys)


def make_plan(scene, design=None):
    design = design or Design()
    return prepare(scene, design, solids.mass_of(design))


@pytest.mark.parametrize("switch", MISSING_NUMBERS)
def test_an_effect_without_its_number_cannot_be_forced_on(switch):
    with pytest.raises(InputError, match=rf'effects.on = \["{switch}"\]: {MISSING_NUMBERS[switch]}'):
        make_plan(scene_of(**{"effects.on": [switch]}))
    assert not make_plan(scene_of(**{"effects.off": [switch]})).resolved.idle


CHANGED_KEYS = {
    "drive": {"second_harmonic_ratio": 0.2, "second_harmonic_phase_deg": 40.0, "gamma": 2.0, "frequency_hz": 80.0},
    "contact": {"prior": "unknown", "restitution": 0.4, "friction": 0.1},
    "plate": {
        "material": "glass",
        "youngs_modulus_gpa": 5.0,
        "slope_deg": 2.0,
        "noise_ratio": 0.3,
        "noise_band_hz": [30.0, 300.0],
        "roughness_um": 3.0,
        "roughness_length_mm": 2.0,
        "horizontal_ratio": [0.2, 0.2],
        "horizontal_phase_deg": [50.0, 50.0],
        "gradient_percent_per_mm": [0.02, 0.01],
        "rocking_percent_per_mm": [0.02, 0.01],
    },
    "arena": {
        "kind": "plane",
        "width_mm": 200.0,
        "gap_mm": 8.4,
        "lid_mm": 10.53,
        "wall_friction": 0.5,
        "wall_restitution": 0.9,
    },
    "legs": {"damping_ratio": 0.1},
    "feet": {"tip_radius_um": 8.0, "rigid_tips": True, "tangential_ratio": 0.5, "unevenness_um": 10.0},
    "run": {"seed": 2, "step_us": 2.0, "heading_deg": (1.0,)},
    "effects": {"on": ["air_drag"], "off": ["roll_and_yaw", "leg_twist", "lane_walls"]},
}
"""Keys of a scene with another value than by default."""

KEYS_OF_OTHER_TESTS = {
    "drive": {"kind", "amplitude_um", "peak_speed_mm_s", "eccentric_g_mm", "axis"},
    "arena": {"length_mm"},
    "run": {"seconds", "discard_seconds", "runs", "accepted_error"},
}
"""Keys that say how long, how many or by whom: of a motor, which another test has, and of whole jobs."""


def state_after(scene, design=None, seconds=SECONDS):
    """State after a while, and the line on keys without a part."""
    plan = make_plan(scene, design)
    plan, state = drop_for_run(plan, 0)
    state[V_Z] += 100.0  # toward a wall
    plan.advance(state, seconds, record.new_tally(len(state)))
    return state, plan.resolved.idle


def state_or_refusal(keys):
    """What `state_after` gives, or the message of a refusal."""
    try:
        return state_after(scene_of(**keys))
    except InputError as error:
        return str(error)


PLATE_NUMBERS = {
    "plate.noise_ratio": 0.2,
    "plate.roughness_um": 2.0,
    "plate.horizontal_ratio": [0.1, 0.1],
    "plate.gradient_percent_per_mm": [0.01, 0.0],
    "plate.rocking_percent_per_mm": [0.01, 0.0],
}
"""Numbers without which other keys say nothing."""
WALL_NUMBERS = {"drive.second_harmonic_ratio": 0.1, "arena.gap_mm": 8.2}


def test_all_keys_of_a_scene_are_turned():
    for table, keys in CHANGED_KEYS.items():
        own = getattr(Scene(), table)
        known = {name for name in type(own).model_fields if "_sd" not in name} - KEYS_OF_OTHER_TESTS.get(table, set())
        assert known == set(keys), table


@pytest.mark.slow
@pytest.mark.parametrize("numbers", [{}, PLATE_NUMBERS | WALL_NUMBERS], ids=["plain", "rich"])
def test_a_key_of_a_scene_changes_the_motion_or_is_named(numbers):
    still, line = state_after(scene_of(**numbers))
    assert not line
    for table, keys in CHANGED_KEYS.items():
        for key, value in keys.items():
            dotted = f"{table}.{key}"
            turned = state_or_refusal(numbers | {dotted: value})
            if isinstance(turned, str):
                assert key in turned or re.search(rf"\b{table}[.:]", turned), dotted
                assert "\n" not in turned, dotted
                continue
            state, line = turned
            if len(state) != len(still) or not np.array_equal(state, still):
                assert dotted not in line, dotted
            elif table != "effects":  # a switch of what is so anyway says nothing
                assert dotted in line, dotted


DESIGN_KEYS = {
    "legs.tilt_deg": 12.0,
    "legs.length_mm": 8.0,
    "legs.contact_spacing_mm": 14.0,
    "legs.width_mm": 7.0,
    "legs.flexible_thickness_mm": 0.5,
    "legs.kind": "braced",
    "body.length_mm": 30.0,
    "body.depth_mm": 9.0,
    "body.thickness_mm": 3.5,
    "material.density_g_cm3": 1.3,
    "material.youngs_modulus_gpa": 3.5,
    "weighed.body_mass_g": 1.0,
    "weighed.leg_mass_g": 0.05,
    "marks.kind": "digits",
}


@pytest.mark.parametrize("key", DESIGN_KEYS)
def test_a_key_of_a_design_changes_the_motion(key):
    other = Design().variant(**{key: DESIGN_KEYS[key]})
    (plain, _), (state, _) = state_after(scene_of()), state_after(scene_of(), other)
    assert len(state) != len(plain) or not np.array_equal(state, plain)


def test_keys_without_a_part_are_named_in_one_line():
    scene = scene_of(**{"legs.damping_ratio": 0.1, "effects.off": ["roll_and_yaw"], "arena.gap_mm": 9.0})
    line = make_plan(scene, Design().variant(kind="braced")).resolved.idle
    for key in ("legs.damping_ratio (no leg swings)", "arena.gap_mm (no walls)"):
        assert line.count(key) == 1
    assert "\n" not in line
