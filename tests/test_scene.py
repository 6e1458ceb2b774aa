"""Drives from any two of their four numbers."""

import itertools
import math

import pytest

from walkergen.errors import InputError
from walkergen.files import config, templates
from walkergen.scene import Drive, Run, Scene

FOUR = {"frequency_hz": 90.0, "amplitude_um": 55.20118808700732,
        "peak_speed_mm_s": 31.21553645344271, "gamma": 1.8}  # fmt: skip


@pytest.mark.parametrize("pair", list(itertools.combinations(FOUR, 2)))
def test_any_two_numbers_determine_the_drive(pair):
    drive = Drive(**{key: FOUR[key] for key in pair})
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
    path.write_text(
        "[drive]\nfrequency_hz = 90\namplitude_um = 55.2\ngamma = 3.0\n[contact]\nlaw = 'hooke'\n"
    )
    with pytest.raises(InputError) as caught:
        config.read(path, Scene)
    lines = str(caught.value).splitlines()
    assert len(lines) == 2
    assert "lane.toml:1: drive" in lines[0]
    assert "contradicts" in lines[0]
    assert "1.8" in lines[0]
    assert "lane.toml:6: contact.law = 'hooke'" in lines[1]


def test_impact_speed_is_a_multiple_of_the_peak_speed():
    scene = Scene.model_validate({"prediction": {"impact_speed_factor": 0.5}})
    assert math.isclose(scene.impact_speed, 0.5 * scene.drive.peak_speed)


@pytest.mark.parametrize("name", templates.names("scenes"))
def test_templates_state_the_defaults_of_everything_that_they_are_not_about(name):
    """What a template shows is what a scene without it would do."""
    scene = templates.load(name, "scenes", Scene)
    about = {"contact", "arena"} | ({"plate", "feet"} if name == "plane-noisy" else set())
    own = {key: getattr(scene, key) for key in ("name", "description", *about)}
    plain = Scene(**own, run=Run(seconds=scene.run.seconds))
    assert scene == plain
