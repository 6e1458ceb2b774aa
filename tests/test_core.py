"""The core runs alone: from a design to a part, its masses, its predicted and its simulated speed.

The core is what CORE imports, and what that imports, at the top of a module or later.
A change that makes the core larger belongs elsewhere. Where it does not, the same commit raises the limit and says why.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "walkergen"

CORE = (
    "walkergen.walker.solids",
    "walkergen.theory.prediction",
    "walkergen.printing.checks",
    "walkergen.printing.export",
    "walkergen.printing.plates",
    "walkergen.simulation.ensemble",
    "walkergen.simulation.plan",
    "walkergen.simulation.run",
    "walkergen.points.measure",
)

MOST_MODULES, MOST_LINES = 126, 17_980
"""Limits of the core, which may only fall."""

STORY = """
from walkergen.scene import Scene
from walkergen.simulation.plan import prepare
from walkergen.simulation.run import simulate
from walkergen.theory import prediction
from walkergen.walker import solids
from walkergen.walker.design import Design

design = Design.model_validate({"legs": {"tilt_deg": 10.0}})
scene = Scene.model_validate({"run": {"seconds": 0.02, "discard_seconds": 0.0, "runs": 1}})
mass = solids.mass_of(design)
predicted = prediction.predict(design, mass, scene)
run = simulate(prepare(scene, design, mass), 0)
print(len(solids.build(design).walker.triangles), mass.total, predicted.nominal_mm_s, run.outcome.value)
"""


GRAPH = grimp.build_graph("walkergen", exclude_type_checking_imports=True, cache_dir=None)
"""Imports between all modules of the package, also later ones, but not those for types alone."""


def path_of(name: str) -> Path:
    """Return the file of a module."""
    path = ROOT.joinpath(*name.split("."))
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


def core_modules() -> set[str]:
    """Return the names of the modules of the core, with the packages that hold them."""
    found: set[str] = set()
    todo = list(CORE)
    while todo:
        name = todo.pop()
        if name not in found:
            found.add(name)
            todo += GRAPH.find_modules_directly_imported_by(name)
            if "." in name:
                todo.append(name.rpartition(".")[0])
    return found


def test_the_core_stays_small():
    core = core_modules()
    lines = sum(len(path_of(name).read_text(encoding="utf-8").splitlines()) for name in core)
    assert len(core) <= MOST_MODULES
    assert lines <= MOST_LINES


@pytest.mark.slow
def test_the_core_runs_alone(tmp_path):
    for name in core_modules():
        target = tmp_path / path_of(name).relative_to(ROOT)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path_of(name), target)
    shutil.copy(PACKAGE / "theory" / "surrogate.npz", tmp_path / "walkergen" / "theory")
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
