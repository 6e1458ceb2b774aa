"""Kernels as plain Python move a walker to the last bit as they do compiled."""

import json
import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from walkergen.cli import command_line

SCENE = """
[drive]
frequency_hz = 90.0
gamma = 1.8

[contact]
restitution = {restitution}
friction = 0.25

[run]
discard_seconds = 0.0
seconds = {seconds}
runs = 1
"""

CLOCKS = ("cpu_s", "wall_s")


@pytest.mark.slow
@pytest.mark.parametrize(("legs", "restitution", "seconds"), [("flexible", 0.8, 0.05), ("braced", 0.3, 0.05)])
def test_motion_is_the_same_without_the_compiler(tmp_path, monkeypatch, legs, restitution, seconds):
    """A drop and its first landings; what is compared is each digit."""
    scene = SCENE.format(restitution=restitution, seconds=seconds)
    (tmp_path / "short.toml").write_text(scene)
    words = shlex.split(f"simulate koumakis2016 --scene short.toml --legs {legs} --rate-hz 20000 --json --trajectory")
    monkeypatch.chdir(tmp_path)
    compiled = CliRunner().invoke(command_line, [*words, "compiled.csv"], catch_exceptions=False)
    plain = subprocess.run(
        [sys.executable, "-m", "walkergen", *words, "plain.csv"],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,  # 1 to 4 s measured: one that never ends fails
    )
    assert plain.returncode == 0, plain.stderr
    one, other = json.loads(compiled.stdout), json.loads(plain.stdout)
    assert one["impacts_per_s"] * seconds >= 3
    assert {**one, **dict.fromkeys(CLOCKS)} == {**other, **dict.fromkeys(CLOCKS)}
    rows = (tmp_path / "compiled.csv").read_text().splitlines()
    assert rows == (tmp_path / "plain.csv").read_text().splitlines()
    assert len(rows) > 20000 * seconds


@pytest.mark.slow
def test_walkers_collide_by_closed_forms_without_the_compiler():
    """The collisions of test_crowd.py, whose compiled kernels are tested where time is."""
    chosen = "head_on or corner or glancing or rough or askew"
    words = ["-q", "-n0", "-m", "slow", "-k", chosen, "tests/guests/crowd/test_crowd.py"]
    tested = subprocess.run(
        [sys.executable, "-m", "pytest", *words],
        cwd=Path(__file__).parents[3],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,  # 7 s measured
    )
    assert tested.returncode == 0, tested.stdout
    assert "9 passed" in tested.stdout
