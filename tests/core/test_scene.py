"""Drives from any two of their four numbers."""

import itertools
import re

import pytest

from walkergen.core.errors import InputError
from walkergen.core.files import config
from walkergen.core.scene import Drive, Scene
from walkergen.files import templates

DRIVE_NUMBERS = {
    "frequency_hz": 90.0,
    "amplitude_um": 55.20118808700732,
    "peak_speed_mm_s": 31.21553645344271,
    "gamma": 1.8,
}


@pytest.mark.parametrize("pair", list(itertools.combinations(DRIVE_NUMBERS, 2)))
def test_any_two_numbers_determine_the_drive(pair):
    drive = Drive(**{key: DRIVE_NUMBERS[key] for key in pair})
    assert drive.frequency == pytest.approx(90.0, rel=1e-12)
    assert drive.amplitude == pytest.approx(0.05520118808700732, rel=1e-12)
    assert drive.peak_speed == pytest.approx(31.21553645344271, rel=1e-12)
    assert drive.peak_gamma == pytest.approx(1.8, rel=1e-12)


def test_the_paper_drive():
    """docs/physics.md section 1: 1.8 g at 90 Hz is 31.2 mm/s and 55.2 um."""
    drive = templates.load("lane-90hz", "scenes", Scene).drive
    assert drive.peak_speed == pytest.approx(31.2, abs=0.05)
    assert 1e3 * drive.amplitude == pytest.approx(55.2, abs=0.05)
    assert drive.amplitude * drive.omega**2 == pytest.approx(1.8 * 9806.65, rel=1e-12)


def test_redundant_numbers_must_agree():
    assert Drive(frequency_hz=90.0, gamma=1.8, peak_speed_mm_s=31.2).gamma == 1.8
    with pytest.raises(ValueError, match="contradicts frequency_hz and peak_speed_mm_s"):
        Drive(frequency_hz=90.0, gamma=1.8, peak_speed_mm_s=32.0)


@pytest.mark.parametrize("given", [{}, {"gamma": 1.8}])
def test_one_number_is_not_enough(given):
    with pytest.raises(ValueError, match="give any two of"):
        Drive(**given)


def test_mistakes_in_a_scene_are_one_line(tmp_path):
    path = tmp_path / "lane.toml"
    path.write_text("[drive]\nfrequency_hz = 90\namplitude_um = 55.2\ngamma = 3.0\n[contact]\nfriction = -1\n")
    with pytest.raises(InputError) as caught:
        config.read_section(path, Scene)
    lines = str(caught.value).splitlines()
    assert len(lines) == 2
    assert "lane.toml:4: drive.gamma = 3" in lines[0]
    assert "contradicts" in lines[0]
    assert "1.8" in lines[0]
    assert "lane.toml:6: contact.friction = -1" in lines[1]


TEMPLATE_KEYS = {
    "lane-90hz-walls": {"arena.gap_mm", "run.seconds"},
    "plane-90hz": {"arena.kind", "run.seconds"},
    "plane-noisy": {"arena.kind", "run.seconds", "plate.noise_ratio", "feet.unevenness_um"},
    "table-motor": {
        "arena.kind",
        "run.seconds",
        "feet.unevenness_um",
        *(
            f"drive.{key}"
            for key in ("kind", "frequency_hz", "frequency_sd_hz", "gamma", "eccentric_g_mm", "eccentric_sd_g_mm")
        ),
    },
}
"""Keys other than the contact that a template changes from the defaults on purpose."""


@pytest.mark.parametrize("name", templates.names("scenes"))
def test_templates_state_the_defaults_of_everything_but_what_they_are_for(name):
    """What a template shows is what a scene without it would do."""
    scene = templates.load(name, "scenes", Scene)
    plain = Scene(name=scene.name, description=scene.description, contact=scene.contact)
    theirs, ours = plain.model_dump(), scene.model_dump()
    tables = [table for table in ours if isinstance(ours[table], dict)]
    differ = {f"{table}.{key}" for table in tables for key in ours[table] if ours[table][key] != theirs[table][key]}
    assert differ == TEMPLATE_KEYS.get(name, set())


def test_a_prior_supplies_what_a_contact_does_not_give():
    scene = Scene()
    assert scene.contact.origin == "contact of the paper's plate"
    unknown = scene.variant(**{"contact.prior": "unknown"})
    assert unknown.contact.origin == "unknown plastic on an unknown plate"
    assert unknown.contact.restitution_sd > scene.contact.restitution_sd
    given = unknown.variant(**{"contact.restitution": 0.8})
    assert (given.contact.restitution, given.contact.friction) == (0.8, unknown.contact.friction)
    assert given.contact.origin == "restitution as given, else unknown plastic on an unknown plate"
    both = given.variant(**{"contact.friction": 0.2})
    assert both.contact.origin == "contact as given"
    again = given.variant(**{"contact.prior": "paper"})  # what was supplied was never given
    assert (again.contact.restitution, again.contact.friction) == (0.8, scene.contact.friction)


def test_a_friction_of_0_is_exact_and_one_beyond_1000_is_refused():
    """Prints of "friction 0 ± 0.02" ran at up to 43 mm/s; at 1e6, rounding does work in space."""
    smooth = Scene().variant(**{"contact.friction": 0.0})
    assert smooth.contact.friction_sd == 0.0
    assert smooth.variant(**{"contact.friction": 0.2}).contact.friction_sd == Scene().contact.friction_sd
    for key in ("contact.friction", "arena.wall_friction"):
        with pytest.raises(InputError, match=f"{key} = 1001.*1000"):
            Scene().variant(**{key: 1001.0})


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ({"effects.off": ["drag"]}, "effects.off[1] = 'drag': must be one of 'air_drag', "),
        ({"effects.on": ["air_drag"], "effects.off": ["air_drag"]}, "air_drag: in effects.on and in effects.off"),
        ({"effects.air_drag": True}, 'this key was removed. Write effects.off = ["air_drag"] for false'),
    ],
)
def test_effects_are_forced_by_their_names(keys, told):
    with pytest.raises(InputError, match=re.escape(told)) as caught:
        Scene().variant(**keys)
    assert "\n" not in str(caught.value)
    off = Scene().variant(**{"effects.off": ["plate_noise", "leg_twist"]})
    assert [off.effects.forced_state(name) for name in ("leg_twist", "air_drag")] == [False, None]
    assert off.effects.force("leg_twist", True).forced_state("leg_twist")
    assert off.effects.force("leg_twist", None).off == ["plate_noise"]


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("acceleration_g", "gamma: write the same value."),
        ("acceleration_rms_g", "gamma: write 1.414 times"),
        ("accel_m_s2", "gamma: write 0.102 times"),
        ("peak_to_peak_um", "amplitude_um: write 0.5 times"),
        ("displacement_mm", "amplitude_um: write 1000 times"),
        ("velocity_rms_mm_s", "peak_speed_mm_s: write 1.414 times"),
        ("acceleration_db", "10^(dB / 20)"),
        ("gama", "Did you mean drive.gamma"),
    ],
)
def test_a_vibration_under_another_name_is_converted(key, words):
    assert words in config.describe_unknown_key(("drive", key), Scene)
