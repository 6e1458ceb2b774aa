"""`calibrate drop` as a user meets it: a measured rebound becomes the restitution of a scene."""

import json

import pytest

from walkergen.core.scene import Scene
from walkergen.files import templates


@pytest.mark.slow
def test_a_rebound_from_the_hand_that_no_restitution_has_sets_nothing(run, tmp_path):
    words = ("--tilt", "10", "--measured", "0.8", "--measured-sd", "0.05", "--drops", "6")
    data = json.loads(run("calibrate", "drop", *words, "--out", "a", "--json").stdout)
    assert "no restitution explains it at 10 deg" in data["drop"]["told"]
    assert data["settings"] == {}
    assert "contact.restitution keeps the scene's value" in data["notes"]
    assert {path.name for path in (tmp_path / "a").iterdir()} == {"calibration.csv", "calibration.md", "manifest.json"}


def test_a_flat_drop_sets_the_scene(run, tmp_path):
    words = ("--roll-deg", "0", "--drops", "2", "--measured", "0.64", "--measured-sd", "0.05")
    data = json.loads(run("calibrate", "drop", *words, "--no-pictures", "--out", "a", "--json").stdout)
    (branch,) = data["drop"]["branches"]
    value, sd = (data["settings"][f"scene.contact.{key}"] for key in ("restitution", "restitution_sd"))
    assert value == pytest.approx(0.5, abs=0.03)
    assert 0.03 < sd < 0.12
    assert branch["low"] < value < branch["high"]
    scene = templates.load(tmp_path / "a" / "scene.toml", "scenes", Scene)
    assert (scene.contact.restitution, scene.contact.restitution_sd) == (value, sd)
    assert not (tmp_path / "a" / "design.toml").exists()


def test_a_drop_without_its_rebound_is_refused(run):
    assert "--measured is missing" in str(run("calibrate", "drop").exception)
    assert "--measured-sd is missing" in str(run("calibrate", "drop", "--measured", "0.6").exception)
