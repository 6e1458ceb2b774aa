"""Runs that share an orbit agree to rounding: no error is printed of them, but what prints do."""

import json
import shlex

import numpy as np
import pytest
from typer.testing import CliRunner

import walkergen as wg
from walkergen.cli import command_line
from walkergen.core.simulation import ensemble

LOCKED_RUN = ("simulate", "--scene", "lane-90hz", "--restitution", "0.8", "--seconds", "1", "--runs", "4")


@pytest.fixture
def locked_runs(monkeypatch):
    """Runs that all end on one orbit."""
    monkeypatch.setattr(ensemble, "common_orbit", lambda speeds, plate_speed: ensemble.ORBIT)


def simulate(*words):
    result = CliRunner().invoke(command_line, [*LOCKED_RUN, *words])
    assert result.exit_code == 0, result.exception
    return result.stdout


def test_only_runs_that_agree_to_rounding_share_an_orbit():
    locked = 97.4 + 1e-6 * np.arange(4)
    assert ensemble.common_orbit(locked, 31.2) == ensemble.ORBIT
    assert ensemble.common_orbit(np.zeros(4), 31.2) == ensemble.REST
    assert ensemble.common_orbit(locked[:3], 31.2) == ""  # three may agree by chance
    assert ensemble.common_orbit(np.array([*locked, 97.5]), 31.2) == ""
    assert ensemble.common_orbit(np.random.default_rng(1).normal(97.0, 0.1, 4), 31.2) == ""


def test_runs_on_one_orbit_give_no_error_and_prints_give_the_bounds(locked_runs):
    found = json.loads(simulate("--tilt", "10", "--json"))
    assert found["orbit"]["kind"] == ensemble.ORBIT
    assert found["orbit"]["draws"] == 24
    assert found["speed_se_mm_s"] is None
    assert set(found["errors"].values()) == {None}
    assert found["speed_low_95_mm_s"] < found["speed_low_68_mm_s"] < found["speed_mm_s"]
    assert found["speed_mm_s"] < found["speed_high_68_mm_s"] < found["speed_high_95_mm_s"]


def test_chaotic_runs_share_none():
    assert json.loads(simulate("--tilt", "5", "--json"))["orbit"] is None


def test_summary_and_table_report_runs_on_one_orbit(locked_runs):
    text = " ".join(simulate("--tilt", "10").split())
    assert "; one periodic orbit: all runs end this way, so there is no statistical error" in text
    assert "(95 %), from 24 draws" in text
    assert "e-" not in text.partition("unaccounted")[0]  # no error of 1e-9 anywhere
    table = " ".join(simulate("--tilt", "5,10").split())
    assert "(o)" in table
    assert "(o): all runs end this way (one periodic orbit), without statistical error" in table


def test_without_anything_uncertain_the_reason_is_given(locked_runs):
    keys = (
        "scene.contact.restitution_sd",
        "scene.contact.friction_sd",
        "scene.legs.damping_ratio_sd",
        "scene.feet.unevenness_sd_um",
        "legs.thickness_sd_mm",
        "material.youngs_modulus_sd_gpa",
        "weighed.mass_sd_percent",
    )
    certain = [word for key in keys for word in ("--set", f"{key}=0")]
    certain += ["--set", "scene.feet.tip_radius_sd_factor=1"]
    found = json.loads(simulate("--tilt", "10", "--json", *certain))
    assert found["speed_low_95_mm_s"] is None
    assert "no standard deviation above 0" in found["orbit"]["note"]


def test_in_python_too(locked_runs):
    scene = wg.load("lane-90hz").variant(**{"contact.restitution": 0.8})
    runs = wg.simulate("koumakis2016", scene, tilt=10, seconds=1, runs=4)
    assert runs.speed.se is None
    assert "mm/s, one periodic orbit; 95 % of prints " in str(runs.speed)
    assert runs.speed.low_95 < runs.speed.value < runs.speed.high_95
    assert "draws of the uncertain inputs" in dict(runs["summary"].rows)["prints"]


def test_a_walker_at_rest_is_reported_at_rest():
    text = " ".join(simulate("--tilt", "10", "--gamma", "0.5").split())
    assert "0.00 mm/s along the lane" in text
    assert "at rest: all runs end this way, so there is no statistical error" in text


def test_a_family_with_runs_prints_no_error_of_an_orbit(locked_runs, tmp_path):
    words = shlex.split(
        "family koumakis2016 --scene lane-90hz --tilt 10 --legs flexible --simulate --no-pictures --json"
    )
    keys = {"scene.contact.restitution": 0.8, "scene.run.seconds": 1, "scene.run.runs": 4}
    result = CliRunner().invoke(
        command_line, [*words, "--out", str(tmp_path / "one"), *(f"--set={key}={keys[key]}" for key in keys)]
    )
    assert result.exit_code == 0, result.output
    (member,) = json.loads(result.stdout)["rows"]
    assert member["sim_se_mm_s"] is None
    assert member["sim_low_95_mm_s"] is None
    assert "on one periodic orbit" in member["sim_outcomes"]
