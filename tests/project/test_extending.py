"""docs/extending.md works: its files and edits, made in a copy of the package, give what its commands promise."""

import json
import math
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from walkergen.core.scene import GRAVITY

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
SECTIONS = {
    section.partition("\n")[0].strip(): re.findall(r'^```(\w+)(?: title="([^"]+)")?\n(.*?)^```$', section, re.M | re.S)
    for section in PAGE.split("\n## ")[1:]
}


def change(path, block):
    """Write a new file, or make an edit: lines after "-" become those after "+", where the block is found once."""
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(block, encoding="utf-8")
        return
    lines, text = block.splitlines(), path.read_text(encoding="utf-8")
    before = "".join(f"{line[1:]}\n" for line in lines if line[:1] != "+")
    after = "".join(f"{line[1:]}\n" for line in lines if line[:1] != "-")
    assert text.count(before) == 1, f"{path.name}: {before}"
    path.write_text(text.replace(before, after), encoding="utf-8")


@pytest.fixture(scope="module")
def extended_copy(tmp_path_factory):
    """Return a folder with a copy of the package, changed as the page describes."""
    folder = tmp_path_factory.mktemp("extended")
    for name in ("walkergen", "templates"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", folder)
    for blocks in SECTIONS.values():
        for _, title, block in blocks:
            if title:
                change(folder / title, block)
    return folder


def run_python(folder, *words):
    """Return what a Python started in the folder prints; kernels run as plain Python."""
    done = subprocess.run(
        [sys.executable, *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(folder), "NUMBA_DISABLE_JIT": "1", "XDG_CACHE_HOME": str(folder)},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,  # seconds measured
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def command(folder, section, *words):
    """Return what the command of a section prints."""
    (line,) = [block for kind, _, block in SECTIONS[section] if kind == "console"]
    return run_python(folder, "-m", *line.removeprefix("$ ").split(), *words)


def test_a_printer_has_plates(extended_copy):
    assert "workbench" in command(extended_copy, "A printer")


LEGS = """
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.sections import tapered

tapering, even = (
    solids.mass_of(Design.model_validate({"legs": {"kind": kind, f"{kind}_thickness_mm": 0.5}})).legs[0].m
    for kind in ("tapered", "flexible")
)
print(float(tapering / even), tapered.SOFTER)
"""


def test_a_kind_of_legs_prints_and_bends_as_its_beam(extended_copy):
    report = json.loads(command(extended_copy, "A kind of legs", "--json"))
    assert report["walls"][0]["thickness_mm"] == 0.5
    lighter, softer = map(float, run_python(extended_copy, "-c", LEGS).split())
    assert lighter == pytest.approx(0.75, rel=1e-6)
    x = np.linspace(0.0, 1.0, 100_001)
    assert softer == pytest.approx(3.0 * np.trapezoid((1.0 - x) ** 2 / (1.0 - 0.5 * x) ** 3, x), rel=1e-8)


FALL = """
from walkergen.core.scene import Scene
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation import record
from walkergen.core.simulation.space.state import V_X
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design

design = Design()
mass = solids.mass_of(design)
plan = prepare(Scene.model_validate({"plate": {"viscous_drag_g_per_s": 5.0}}), design, mass)
state = plan.initial_state(20.0, 0.0, 0.0)
plan.advance(state, 0.02, record.new_tally())
print(float(state[V_X + 1]), float(mass.total))
"""


def test_an_effect_is_explained_and_acts(extended_copy):
    told = command(extended_copy, "An effect")
    assert re.search(r"viscous\s+drag", told)
    speed, mass = map(float, run_python(extended_copy, "-c", FALL).split())
    fallen = -mass * GRAVITY / 5.0 * (1.0 - math.exp(-5.0 * 0.02 / mass))
    assert speed == pytest.approx(fallen, rel=2e-3)  # the drag is that at the start of a frame


def test_a_command_prints_the_frequency_of_a_cantilever(extended_copy):
    (leg, other) = json.loads(command(extended_copy, "A command", "--json"))["legs"]
    assert leg["frequency_hz"] == pytest.approx(1520.0, rel=0.02)  # docs/physics.md section 7
    assert other["leg"] == 2


def test_a_guest_is_a_command_that_no_core_names(extended_copy):
    found = json.loads(command(extended_copy, "A guest", "--json"))["walkers"]
    assert sum(row["chance"] for row in found) == pytest.approx(1.0, abs=1e-9)
    assert max(found, key=lambda row: row["chance"])["tilt_deg"] in (10.0, 15.0)
    done = subprocess.run(
        [Path(sys.executable).with_name("lint-imports")],
        cwd=extended_copy,
        env={**os.environ, "PYTHONPATH": str(extended_copy)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout
