"""`accuracy` and `simulate --error` as a user meets them."""

import json
from pathlib import Path

import pytest
from command_checks import rows_of

import walkergen as wg
from walkergen.commands.accuracy import make as accuracy
from walkergen.commands.accuracy.report import Ladder, Rung
from walkergen.core.files.output import Folder

SCENE = """
[drive]
frequency_hz = 90.0
gamma = 1.8

[contact]
restitution = 0.3

[run]
discard_seconds = 0.1
"""


@pytest.fixture
def run(run, home):
    (home / "short.toml").write_text(SCENE)
    return run


@pytest.mark.slow
def test_a_study_of_steps(run, tmp_path):
    words = ("--scene", "short.toml", "--tilt", "10")
    result = run("accuracy", *words, "--budget", "12s", "--json")
    assert result.exit_code == 0, result.exception
    found = json.loads(result.stdout)
    assert set(found["ladders"]) == {"steps-long", "observables"}
    folder = tmp_path / found["folder"]
    assert {path.name for path in folder.iterdir()} == {"accuracy.csv", "accuracy.md", "accuracy.png", "manifest.json"}
    rows = rows_of(folder / "accuracy.csv")
    for name, rungs in found["ladders"].items():
        assert len([row for row in rows if row["ladder"] == name]) == len(rungs)
    assert "--error 5%" in (folder / "accuracy.md").read_text()
    assert (folder / "accuracy.png").read_bytes().startswith(b"\x89PNG")
    rungs = found["ladders"]["steps-long"]
    assert rungs[0]["error"] == 0.0  # the finest step is its own truth
    assert all(rung["error"] < 0.3 and rung["error_sd"] > 0.0 for rung in rungs)


def test_without_a_budget_the_answer_is_what_is_shipped(run, tmp_path, monkeypatch):
    monkeypatch.setattr("walkergen.commands.accuracy.machine_speed.cpu_per_s", lambda: 0.05)
    result = run("accuracy", "--tilt", "5", "--json")
    assert result.exit_code == 0, result.exception
    facts = json.loads(result.stdout)
    errors = [row["error"] for row in facts["answers"]]
    assert errors == ["20 %", "10 %", "5 %", "2 %", "1 %"][-len(errors) :]
    assert {row["known"] for row in facts["answers"]} <= {"measured", "law"}
    times = [row["expected_s"] for row in facts["answers"] if row["expected_s"]]
    assert times == sorted(times)
    assert times[1] > 1.1 * times[0]  # errors that save no time are no rows
    assert (f"Errors above {errors[0]} save no time" in run("accuracy", "--tilt", "5").stdout) == (len(errors) < 5)
    assert facts["ladders"] == {}
    folder = tmp_path / facts["folder"]
    assert {path.name for path in folder.iterdir()} == {"accuracy.csv", "accuracy.md", "accuracy.png", "manifest.json"}


def test_a_folder_in_which_another_study_writes_is_left_alone(run, tmp_path, monkeypatch):
    monkeypatch.setattr("walkergen.commands.accuracy.machine_speed.cpu_per_s", lambda: 0.05)
    with Folder(tmp_path / "here") as folder:
        folder.claim()
        result = run("accuracy", "--tilt", "5", "--out", "here")
        assert "another walkergen writes there" in str(result.exception)
        assert {path.name for path in folder.path.iterdir()} == {".manifest.json.walkergen"}
    assert run("accuracy", "--tilt", "5", "--out", "here").exit_code == 0


@pytest.mark.slow
def test_an_error_that_was_asked_for_is_met(run):
    words = ("simulate", "--scene", "short.toml", "--tilt", "10", "--error", "20%")
    result = run(*words, "--json")
    facts = json.loads(result.stdout)
    met = facts["chosen"]
    assert 0 < met["error"] <= met["allowed"] == pytest.approx(0.2 * facts["speed_mm_s"])
    half = 0.5 * (facts["speed_high_95_mm_s"] - facts["speed_low_95_mm_s"])
    assert met["error"] == pytest.approx(half)
    assert (met["runs"], met["seconds"]) == (facts["runs"], 4.0)  # the longest
    assert "within the" in run(*words).stdout
    same = wg.simulate("koumakis2016", Path("short.toml"), tilt=10, error="20%")
    assert same.speed.value == facts["speed_mm_s"]
    assert same.simulated.chosen.facts == met
    assert "within the" in repr(same)


def test_ctrl_c_keeps_the_ladders_already_done(run, tmp_path, monkeypatch):
    def finished(survey, progress):
        return Ladder(
            "steps-long", "Bias", "bias", "CPU time, s", "the finest", [Rung("a", "9 us", 0.5, None, 1.0, {})]
        )

    def interrupted(survey, progress):
        raise KeyboardInterrupt

    monkeypatch.setattr(accuracy, "LADDERS", (finished, interrupted))
    result = run("accuracy", "--budget", "9s", "--out", "here")
    assert result.exit_code == 130
    assert "9 us" in (tmp_path / "here/accuracy.csv").read_text()
    assert not (tmp_path / "here/accuracy.png").exists()
