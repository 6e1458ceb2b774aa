"""Templates of other walkers: they run in space in the direction of the theory."""

import subprocess
import sys

import numpy as np
import pytest

from walkergen.core.scene import Scene
from walkergen.core.theory import prediction
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.points import experiments, walkers

NAMES = ("two-materials", "unequal-legs", "polar-disc", "bristle", "rotator", "name", "bristlebot", "spinner")


def load(name):
    return templates.load(name, "walkers", Design)


def scene_of(seconds, runs=4):
    scene = templates.load("plane-90hz", "scenes", Scene)
    short = {"seconds": seconds, "runs": runs, "discard_seconds": 0.2}
    return scene.model_copy(update={"run": scene.run.model_copy(update=short)})


def simulate_design(design, seconds=0.5, runs=4):
    scene = scene_of(seconds, runs)
    return walkers.simulate(experiments.Walker(scene, design, solids.mass_of(design)), lambda *_: None)


def theory_row(design):
    return prediction.make_row(design, solids.mass_of(design), scene_of(1.0), "coulomb", None)


def change_legs(design, change):
    """Design with every leg of its list changed."""
    data = design.model_dump(exclude_unset=True)
    return Design.model_validate(data | {"legs": [change(leg) for leg in data["legs"]]})


@pytest.mark.parametrize("name", NAMES)
def test_a_template_has_a_theory(name):
    row = theory_row(load(name))
    assert "balanced over" in row.theory_note
    if name == "rotator":
        assert row.theory_mm_s == pytest.approx(0.0, abs=0.1)  # its own mirror image from the side
        assert "it turns" in row.theory_note
    else:
        assert row.theory_mm_s > 1.0


@pytest.mark.parametrize("name", ["two-materials", "unequal-legs", "polar-disc"])
def test_rigid_walkers_run_forward_and_their_mirror_images_backward(name):
    """As the theory says, whose size is off by up to 2.3 times (docs/physics.md section 4b)."""
    design = load(name)

    def ahead(leg):
        return leg | {"along_mm": -leg["along_mm"], "tilt_deg": -leg["tilt_deg"]}

    for walker, way in ((design, 1.0), (change_legs(design, ahead), -1.0)):
        row = theory_row(walker)
        speed, se = simulate_design(walker).summary.speed.pair
        assert way * row.theory_mm_s > 1.0
        assert way * speed > max(1.0, 3.0 * se)


def test_bristle_runs_at_the_speed_of_the_theory():
    """18 legs, 6 of them seen from the side; 60 mm/s simulated in 2 s, 68 by the theory."""
    design = load("bristle")
    row = theory_row(design)
    found = simulate_design(design, 0.1, 2).summary.speed.value
    assert 0.5 < found / row.theory_mm_s < 1.5


def test_rotator_turns_on_the_spot_and_its_mirror_image_the_other_way():
    design = load("rotator")

    def swap_sides(leg):
        return leg | {"mirrored": not leg.get("mirrored", False)}

    rates = []
    for walker in (design, change_legs(design, swap_sides)):
        runs = simulate_design(walker, 0.5).results
        turned = [np.unwrap(run.places[:, 2])[-1] - run.places[0, 2] for run in runs]
        rate = np.array(turned) / 0.5
        assert abs(rate.mean()) > 3.0  # 5.8 rad/s in plane-90hz
        # Its rim runs at 14 mm times the rate, 40 mm in all; the middle stays.
        assert max(np.abs(run.places[:, :2] - run.places[0, :2]).max() for run in runs) < 8.0
        rates.append(rate)
    right, left = rates
    assert right.max() < 0.0 < left.min()
    error = np.hypot(right.std(ddof=1), left.std(ddof=1)) / np.sqrt(len(right))
    assert abs(right.mean() + left.mean()) < 4.0 * error


@pytest.mark.slow
def test_the_modeller_reports_no_leaks_at_the_end(tmp_path):
    words = ["-m", "walkergen", "simulate", "rotator", "--seconds", "0.02", "--runs", "1", "--quiet"]
    done = subprocess.run([sys.executable, *words], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stderr == ""
