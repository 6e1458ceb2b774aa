"""Every command and every line of Python that the README shows is run."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", README, flags=re.DOTALL)


def commands():
    lines = [line for kind, text in BLOCKS if kind == "sh" for line in text.splitlines()]
    return [line.split("#")[0].strip() for line in lines]


def test_the_setup_is_two_commands_and_the_gate_runs_them():
    setup = [line for line in commands() if ".venv/bin" in line]
    assert len(setup) == 2
    gate = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert setup[0].startswith("python3 -m venv")
    assert "grep -m1 '^python3 -m venv' README.md" in gate
    assert setup[1].startswith(".venv/bin/pip install")
    assert r"grep -m1 '^\.venv/bin/pip install' README.md" in gate


@pytest.mark.slow
def test_the_tour_runs_as_shown(tmp_path):
    tour = [line for line in commands() if line.startswith("walkergen")]
    assert len(tour) == 29
    for line in tour:
        words = [sys.executable, "-m", *shlex.split(line)]
        result = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert result.returncode == 0, (line, result.stderr, result.stdout[-2000:])
        assert result.stdout
    assert len(list((tmp_path / "out" / "mine" / "stl").iterdir())) == 34


def test_the_python_runs_as_shown(tmp_path):
    (code,) = [text for kind, text in BLOCKS if kind == "python"]
    words = [sys.executable, "-c", code]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    result = subprocess.run(
        words, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    assert re.match(r"0\.833 g, \d+ mm/s, with 95 % \d+ to \d+ mm/s", result.stdout)
    assert (tmp_path / "walker.stl").stat().st_size > 500


def test_pictures_shown_exist():
    pictures = re.findall(r"!\[.*?\]\((.*?)\)", README)
    assert pictures
    for picture in pictures:
        start = {".png": b"\x89PNG", ".gif": b"GIF89a"}[Path(picture).suffix]
        assert (ROOT / picture).read_bytes().startswith(start)
