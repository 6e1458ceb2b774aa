"""Standing walkers: predicted as in space, with no jump to those that run."""

import pytest

from walkergen.core.measure import Runs, measure
from walkergen.core.scene import Scene
from walkergen.core.theory import prediction, stationary
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.points.experiments import Walker

PAPER = templates.load("koumakis2016", "walkers", Design)
PLANE = templates.load("plane-90hz", "scenes", Scene)


def make_case(tilt=10.0, **keys):
    design, scene = PAPER.variant(tilt_deg=tilt), PLANE.variant(**{k.replace("__", "."): v for k, v in keys.items()})
    return scene, design, solids.mass_of(design)


def predict_case(**keys):
    scene, design, mass = make_case(**keys)
    return prediction.predict(design, mass, scene)


@pytest.mark.parametrize("tilt", [0.0, 10.0, 30.0])
@pytest.mark.parametrize("gamma", [0.05, 0.5, 0.9])
def test_a_plate_below_gravity_throws_nothing(tilt, gamma):
    row = predict_case(tilt=tilt, drive__gamma=gamma)
    assert (row.speed.value, row.speed.low_95, row.speed.high_95) == (0.0, 0.0, 0.0)
    assert row.speed_by == "statics"
    assert "the walker stands" in row.note


@pytest.mark.parametrize(
    "keys",
    [
        {"drive__gamma": 1.0},
        {"drive__gamma": 1.8},
        {"drive__gamma": 0.9, "drive__second_harmonic_ratio": 0.1},  # its own acceleration is four times as large
        {"drive__gamma": 0.9, "plate__noise_ratio": 0.3},
        {"drive__gamma": 0.9, "plate__slope_deg": 20.0},  # steeper than friction holds
        {"drive__gamma": 0.95, "tilt": 42.0},  # soft legs amplify
    ],
)
def test_a_walker_that_may_run_is_not_reported_as_standing(keys):
    assert stationary.standing_reason(*make_case(**keys)) == ""


def test_without_friction_nothing_pushes():
    row = predict_case(contact__friction=0.0)
    assert (row.speed.value, row.speed_by) == (0.0, "statics")


@pytest.mark.slow
@pytest.mark.parametrize(
    "keys",
    [
        {"drive__gamma": 0.9},
        pytest.param({"tilt": 30.0, "drive__gamma": 0.8}, marks=pytest.mark.nightly),
        {"contact__friction": 0.0},
    ],
)
def test_the_model_in_space_stands_too(keys):
    scene, design, mass = make_case(**keys)
    assert stationary.standing_reason(scene, design, mass)
    short = scene.variant(**{"run.seconds": 1.0, "run.runs": 4})
    speed = measure(Walker(short, design, mass), Runs(short.run.runs)).quantities["speed_mm_s"]
    # feet creep by a hundredth of the plate's speed at most: they are elastic
    assert abs(speed.value) < 0.01 * scene.drive.peak_speed
