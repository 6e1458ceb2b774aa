"""`simulate`, `explain` and `family --simulate` as a user meets them."""

import json

import numpy as np
import pytest
from command_checks import rows_of

KEYS = {
    "speed_mm_s",
    "speed_se_mm_s",
    "speed_low_95_mm_s",
    "speed_high_95_mm_s",
    "runs",
    "simulated_s",
    "cpu_s",
    "wall_s",
    "impacts_per_s",
    "type_fractions",
    "contact_fraction",
    "max_pitch_deg",
    "energy_error",
    "outcomes",
}

SHORT = ("--seconds", "0.5", "--runs", "2")


def test_json_has_the_named_keys(run):
    result = run("simulate", "koumakis2016", "--scene", "lane-90hz", "--tilt", "10", *SHORT, "--json")
    found = json.loads(result.stdout)
    assert set(found) >= KEYS
    assert (found["tip_radius_um"], found["restitution"], found["friction"]) == (5.0, 0.8, 0.25)
    assert found["runs"] == 2
    assert found["simulated_s"] == pytest.approx(1.0)
    assert sum(found["type_fractions"].values()) - found["type_fractions"]["sticking"] == (pytest.approx(1.0))


def test_overrides_reach_the_scene(run):
    calm = json.loads(run("simulate", "--gamma", "0.5", *SHORT, "--json").stdout)
    assert calm["contact_fraction"] > 0.99
    assert abs(calm["speed_mm_s"]) < 1.0
    told = run("simulate", "--frequency", "80", *SHORT).stdout
    assert "80 Hz, 1.8 g, 35.1 mm/s" in told  # 1.8 g / (2 pi 80 Hz)
    without_walls = ("simulate", "--friction", "0", "--scene", "plane-90hz", *SHORT, "--json")
    smooth = json.loads(run(*without_walls).stdout)
    power = smooth["energies_per_s"]
    assert power["friction"] < 1e-3 * power["impacts"]  # what time steps leave of none
    assert smooth["type_fractions"]["sticking"] == 0.0
    speeds = [
        json.loads(run("simulate", *words, *SHORT, "--json").stdout)["speed_mm_s"]
        for words in ((), ("--step", "20"), ("--step", "10"))
    ]
    assert len(set(speeds[1:])) == 2


def test_trajectory_as_csv_and_npz(run, tmp_path):
    words = ("simulate", "--seconds", "0.1", "--runs", "1", "--quiet")
    run(*words, "--trajectory", "a.csv", "--rate-hz", "2000")
    rows = rows_of(tmp_path / "a.csv")
    film = ["frame", "particle", "x", "y", "theta"]
    assert list(rows[0])[:9] == [*film, "t_s", "x_mm", "y_mm", "theta_rad"]
    assert len(rows) == pytest.approx(201, abs=1)
    assert float(rows[1]["t_s"]) == pytest.approx(5e-4)
    run(*words, "--trajectory", "a.npz", "--rate-hz", "2000")
    with np.load(tmp_path / "a.npz") as data:
        np.testing.assert_array_equal(data["x_mm"], [float(row["x_mm"]) for row in rows])


def test_explain_names_every_effect(run):
    rows = json.loads(run("explain", "koumakis2016", "--no-cost", "--json").stdout)["rows"]
    by_name = {row["effect"]: row for row in rows}
    assert by_name["leg compliance"]["on"]
    assert by_name["yaw and roll"]["on"]
    assert not by_name["plate slope"]["on"]
    assert by_name["air drag"]["number"] < 1e-3
    assert all(row["reason"] for row in rows)


def test_explain_measures_what_an_effect_costs(run, monkeypatch):
    monkeypatch.setattr("walkergen.points.variants.MAX_RUN_S", 0.2)
    rows = json.loads(run("explain", "--json").stdout)["rows"]
    (twist,) = [row for row in rows if row["effect"] == "leg twist"]
    assert twist["cpu_ratio"] > 0


@pytest.mark.slow
def test_family_simulate_adds_columns_and_points(run, tmp_path):
    result = run("family", "--tilt", "10", "--simulate", "--seconds", "0.3", "--runs", "2", "--out", "here")
    assert "simulated" in result.stdout
    assert max(len(line) for line in result.stdout.splitlines()) <= 80
    rows = rows_of(tmp_path / "here" / "family.csv")
    assert len(rows) == 2
    assert all(float(row["sim_speed_mm_s"]) != 0 for row in rows)
    assert "simulated (mm/s, 95 %)" in (tmp_path / "here" / "family.md").read_text(encoding="utf-8")
