"""`walkergen design`: what it prints, writes and refuses, and how it ends."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from typer.testing import CliRunner

from walkergen.cli import command_line
from walkergen.errors import InputError

ROOT = Path(__file__).parent.parent
QUICK = ("--model", "prediction", "--vary", "legs.tilt_deg=2:40")


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    return tmp_path_factory.mktemp("cache")


@pytest.fixture
def run(monkeypatch, tmp_path, cache):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))
    return lambda *words: CliRunner().invoke(command_line, ["design", *words])


@pytest.mark.slow
def test_a_design_goes_on_to_a_plate_and_a_prediction(run, tmp_path):
    told = run("--speed", "40", "--printer", "ender3", *QUICK)
    assert told.exit_code == 0, told.output
    assert "prediction" in told.output
    assert "yes" in told.output
    folder = tmp_path / "out" / "design-speed40"
    design, scene = str(folder / "design-1.toml"), str(folder / "scene-1.toml")
    row = json.loads(CliRunner().invoke(command_line, ["predict", design, "--scene", scene, "--json"]).stdout)["rows"][
        0
    ]
    assert row["speed_mm_s"] == pytest.approx(40.0, abs=2.0)
    made = CliRunner().invoke(command_line, ["plate", design, "--printer", "ender3", "--out", "plate"])
    assert made.exit_code == 0, made.output
    assert list((tmp_path / "plate").rglob("*.3mf"))
    manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["vary"] == {"legs.tilt_deg": [2.0, 40.0]}
    assert {"design.csv", "design.md", "design.png"} <= set(manifest["files"])


@pytest.mark.slow
def test_json_holds_every_number_and_quiet_says_nothing(run):
    told = run("--fastest", *QUICK, "--json", "--no-pictures", "--out", "fast")
    found = json.loads(told.stdout)
    assert found["wish"] == "fastest"
    assert found["met"] == 3
    assert [row["design"] for row in found["rows"]] == [f"design-{n}.toml" for n in (1, 2, 3)]
    speeds = [row["verified_speed_mm_s"] for row in found["rows"]]
    assert speeds == sorted(speeds, reverse=True)
    assert run("--fastest", *QUICK, "--quiet", "--out", "fast").output == ""


def test_a_wish_that_none_meets_ends_with_one_line_and_the_nearest(run, tmp_path):
    told = run("--speed", "1e6", *QUICK, "--quiet")
    assert told.exit_code == 1
    (line,) = told.stderr.splitlines()
    assert "the largest speed found is" in line
    assert "lower bound of --vary legs.tilt_deg" in line or "at legs.tilt_deg" in line
    assert line.endswith("the nearest are in out/design-speed1e06/")
    assert (tmp_path / "out" / "design-speed1e06" / "design-1.toml").exists()


def test_values_are_held_by_set_and_ranges_are_of_the_scene_too(run):
    told = run(
        "--speed",
        "60",
        "--model",
        "prediction",
        "--set",
        "legs.tilt_deg=10",
        "--set",
        "scene.contact.friction=0.3",
        "--vary",
        "scene.drive.gamma=1.2:3",
        "--json",
        "--no-pictures",
    )
    found = json.loads(told.stdout)
    assert found["met"] >= 1
    assert 1.2 <= found["rows"][0]["scene.drive.gamma"] <= 3.0
    scene = Path("out/design-speed60/scene-1.toml").read_text(encoding="utf-8")
    assert "friction = 0.3\n" in scene


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--speed", "nan"), "--speed nan"),
        ((), "no wish"),
        (("--speed", "40", "--fastest"), "one wish at a time"),
        (("--speed", "40", "--error", "5"), "--error '5'"),
        (("--speed", "40", "--model", "magic"), "--model 'magic'"),
        (("--speed", "40", "--vary", "legs.tilt=2:40"), "did you mean legs.tilt_deg"),
        (("--speed", "40", "--vary", "name=1:2"), "no property"),
        (("--speed", "40", "--set", "legs.tilt=2"), "did you mean legs.tilt_deg"),
        (("--speed", "40", "--set", "legs.tilt_deg=2", "--set", "legs.tilt_deg=3"), "--set legs.tilt_deg: given twice"),
        (("--speed", "40", "--set", "legs.tilt_deg=2", "--vary", "legs.tilt_deg=3:9"), "varies it"),
        (("--speed", "40", "--from", "nowhere"), "no such template"),
        (("--speed", "40", "--workers", "0"), "--workers 0"),
        (("--persistence", "100"), "--model space --scene plane-90hz"),
        (("--turning-radius", "50", "--model", "compliant"), "--model space --scene plane-90hz"),
        (("--turn", "left"), "--turn 'left': must be one of down, up"),
        (("--turn", "down"), "--model space --scene plane-90hz"),
        (("--turn", "down", "--scene", "plane-90hz"), "scene.plate.slope_deg = 0"),
        (("--turn", "down", "--turning-radius", "50"), "one wish at a time"),
        (("--turn", "up", "--scene", "plane-90hz", "--model", "prediction"), "--model space"),
        (("--turn", "up", "--error", "2mm/s"), "no error of a rate of turning"),
        (("--least-sensitive", "--set", "scene.contact.friction=0"), "friction is 0"),
        (("--speed", "40", "--from", "rotator", "--model", "compliant"), "space"),
        (("--speed", "40", *QUICK[:3], "legs.tilt_deg=75:85"), "cannot be built"),
    ],
)
def test_bad_input_is_one_line(run, tmp_path, words, told):
    result = run(*words)
    assert isinstance(result.exception, InputError)
    assert told in str(result.exception)
    assert "\n" not in str(result.exception)
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_ctrl_c_leaves_nothing_half_written(tmp_path):
    # What a shell runs behind it ignores Ctrl-C, and so would its children.
    program = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
        "from walkergen.cli import main; main()"
    )
    words = [
        sys.executable,
        "-c",
        program,
        "design",
        "--speed",
        "40",
        "--model",
        "prediction",
        "--vary",
        "legs.tilt_deg=2:40",
        "--vary",
        "legs.length_mm=5:10",
        "--vary",
        "body.depth_mm=6:10",
        "--out",
        "mine",
    ]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "XDG_CACHE_HOME": str(tmp_path / "c")}
    with subprocess.Popen(
        words, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        points = tmp_path / "c" / "walkergen" / "points" / "points.sqlite"
        until = time.monotonic() + 60.0
        while not points.exists() and time.monotonic() < until:
            time.sleep(0.05)
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        _, told = process.communicate(timeout=60)
    assert process.returncode != 0
    assert "interrupted" in told
    assert "Traceback" not in told
    assert not (tmp_path / "mine").exists()
