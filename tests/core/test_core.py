"""The core runs alone: from a design to a part, its masses, its predicted and its simulated speed.

It is `walkergen/core`, which imports nothing else of the package, also not later or for types. A change that makes it
larger belongs elsewhere. Where it does not, the same commit raises the limit and says why.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import grimp
import pytest

from walkergen import core

CORE = Path(__file__).parents[2] / "walkergen" / "core"

MOST_MODULES, MOST_LINES = 111, 17_960
"""Limit of the core, which may only fall; tests/project/test_size.py limits its lines."""

STORY = """
from walkergen.core import Design, Scene, build, mass_of, predict, prepare, simulate

design = Design.model_validate({"legs": {"tilt_deg": 10.0}})
scene = Scene.model_validate({"run": {"seconds": 0.02, "discard_seconds": 0.0, "runs": 1}})
mass = mass_of(design)
predicted = predict(design, mass, scene)
run = simulate(prepare(scene, design, mass), 0)
print(len(build(design).walker.triangles), mass.total, predicted.nominal.value, run.outcome.value)
"""

MAX_NAMES = 60
"""Most names that the core publishes."""

GUESTS = {"crowd": 16, "lab": 40, "movie": 6, "sweep": 7, "track": 10}
"""Most modules that a guest imports from inside the core, beyond its published names; they may only fall."""


def test_the_core_stays_small():
    assert len(list(CORE.rglob("*.py"))) <= MOST_MODULES


def test_the_core_imports_nothing_above_it():
    graph = grimp.build_graph("walkergen", cache_dir=None)
    inside = {name for name in graph.modules if f"{name}.".startswith("walkergen.core.")}
    above = {(name, other) for name in inside for other in graph.find_modules_directly_imported_by(name) - inside}
    assert above <= {("walkergen.core.files.output", "walkergen")}  # for its version


def test_the_core_names_no_guest():
    named = {
        str(path.relative_to(CORE))
        for path in CORE.rglob("*.py")
        if re.search(r"walkergen[./]guests|\b(lammps|opencv|sweep|movie)\b", path.read_text(encoding="utf-8"))
    }
    assert named == set()


@pytest.mark.parametrize("guest", GUESTS)
def test_a_guest_imports_only_listed_names_of_the_core(guest):
    graph = grimp.build_graph("walkergen", cache_dir=None)
    names = {name for name in graph.modules if name.startswith(f"walkergen.guests.{guest}")}
    used = {other for name in names for other in graph.find_modules_directly_imported_by(name)}
    assert len({name for name in used if name.startswith("walkergen.core.")}) <= GUESTS[guest]


def test_the_published_names_are_few_and_all_found():
    assert len(set(core.__all__)) == len(core.__all__) <= MAX_NAMES
    assert [name for name in core.__all__ if getattr(core, name, None) is None] == []


def test_a_published_name_is_no_module_of_the_core():
    """An imported module would hide a name that is spelled like it."""
    assert set(core.__all__).isdisjoint(path.stem for path in CORE.iterdir())


@pytest.mark.slow
def test_the_core_runs_alone(tmp_path):
    shutil.copytree(CORE, tmp_path / "walkergen" / "core")
    shutil.copy(CORE.parent / "__init__.py", tmp_path / "walkergen")
    environment = os.environ | {"PYTHONPATH": str(tmp_path), "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(
        [sys.executable, "-c", STORY], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    triangles, total, speed, outcome = done.stdout.split()
    assert int(triangles) > 20
    assert float(total) == pytest.approx(0.8928, abs=1e-4)
    assert float(speed) == pytest.approx(52.3, abs=3.0)
    assert outcome == "ok"
