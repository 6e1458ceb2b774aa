"""The table of walkers with a motor: symmetric, honest about its errors, with an end by name."""

import numpy as np
import pytest

from walkergen.files import templates
from walkergen.lab.fit import learn
from walkergen.lab.fit.job import Job
from walkergen.scene import Scene
from walkergen.simulation.plan import prepare
from walkergen.simulation.run import simulate
from walkergen.simulation.space.state import HEADING
from walkergen.theory import motors, prediction, surrogate, uncertain
from walkergen.theory.surrogate import UnknownError
from walkergen.walker import solids
from walkergen.walker.design import Design

TABLE = templates.load("table-motor", "scenes", Scene)
COINBOT, BRISTLEBOT, SPINNER = (
    templates.load(name, "walkers", Design) for name in ("coinbot", "bristlebot", "spinner")
)

SIMULATED = {"coinbot": 116.0, "bristlebot": 174.0, "spinner": 165.0}
"""Speeds (mm/s) of the templates on table-motor as its own 16 runs have them."""


def tabled(design, scene=TABLE):
    return motors.of(scene, design, solids.mass_of(design))


def centre(design, scene=TABLE):
    walker = tabled(design, scene)
    return walker.at(walker.place).centre[0]


@pytest.mark.parametrize("design", [COINBOT, BRISTLEBOT, SPINNER], ids=lambda one: one.name)
def test_templates_are_predicted_by_the_table_within_bounds_that_say_something(design):
    row = prediction.predict(design, solids.mass_of(design), TABLE)
    assert row.speed_by == "table"
    assert "plate" not in row.note
    # By the theory alone coinbot had -191 to 405 mm/s
    assert 0.0 < row.speed_low_95_mm_s < SIMULATED[design.name] < row.speed_high_95_mm_s
    assert row.speed_low_68_mm_s < SIMULATED[design.name] < row.speed_high_68_mm_s


def test_the_mirror_image_with_a_rotor_that_turns_the_other_way_runs_the_other_way():
    turned = {"motor.along_mm": -COINBOT.motor.along_mm, "battery.along_mm": 6.2}
    image = COINBOT.variant(tilt_deg=-10.0, **turned)
    back = TABLE.variant(**{"drive.reversed": True})
    assert centre(image, back) == pytest.approx(-centre(COINBOT), rel=1e-6)
    assert centre(image, TABLE) != pytest.approx(-centre(COINBOT), rel=1e-2)
    # Upright and symmetric it runs by the sense of the rotor alone
    upright = COINBOT.variant(tilt_deg=0.0, **{"motor.along_mm": 0.0, "battery": None})
    assert centre(upright, back) == pytest.approx(-centre(upright), abs=1e-6)
    assert abs(centre(upright)) > 0.01


def test_left_and_right_run_alike():
    image = SPINNER.variant(**{"motor.across_mm": -SPINNER.motor.across_mm})
    assert centre(image) == pytest.approx(centre(SPINNER), rel=1e-6)


@pytest.mark.parametrize(
    ("keys", "scene", "named"),
    [
        ({}, {"drive.eccentric_g_mm": 0.9}, "push over weight in"),
        ({}, {"plate.slope_deg": 1.0}, "level plates"),
        ({}, {"drive.axis": [0.0, 1.0, 1.0]}, "an axis along, across or up"),
        ({}, {"plate.roughness_um": 1.0}, "no plate.roughness_um"),
        ({"legs.kind": "braced"}, {}, "flexible legs"),
        ({"legs.length_mm": 20.0}, {}, "hinge ratio in"),
    ],
)
def test_beyond_the_table_a_prediction_is_as_without_it_and_says_why(keys, scene, named):
    design, where = COINBOT.variant(**keys), TABLE.variant(**scene)
    with pytest.raises(UnknownError, match=named):
        motors.of(where, design, solids.mass_of(design))
    row = prediction.predict(design, solids.mass_of(design), where)
    assert row.speed_by == "theory"
    assert named in row.note
    assert "as its motor does" in row.note
    width = row.speed_high_95_mm_s - row.speed_low_95_mm_s
    assert width > 1.5 * abs(row.speed_mm_s)


def test_legs_that_differ_are_named():
    legs = [leg.model_dump(exclude_unset=True) for leg in SPINNER.legs]
    legs[2]["thickness_mm"] = 0.5
    data = SPINNER.model_dump(exclude_unset=True) | {"legs": legs}
    with pytest.raises(UnknownError, match="all alike"):
        tabled(Design.model_validate(data))


def test_places_of_draws_are_those_of_walkers_so_built():
    values = {
        "drive.frequency_hz": 160.0,
        "drive.eccentric_g_mm": 0.27,
        "contact.friction": 0.2,
        "material.youngs_modulus_gpa": 3.4,
        "feet.unevenness_um": 3.0,
    }
    scene, design, mass = uncertain.applied(TABLE, COINBOT, values)
    built = motors.of(scene, design, mass)
    drawn = uncertain.Drawn({name: np.array([value]) for name, value in values.items()}, 1)
    table = surrogate.of(TABLE, COINBOT, solids.mass_of(COINBOT))
    there = built.at(built.place)
    assert table.speeds(drawn).centre == pytest.approx(there.centre, rel=1e-6)
    assert table.speeds(drawn).sd == pytest.approx(there.sd, rel=1e-6)
    assert table.table is motors.TABLE


def test_the_moment_comes_back_from_simulated_speeds(tmp_path):
    """Speeds of coinbot that were simulated with 0.3 g mm, learnt from with a doubt of a third."""
    rows = "tilt_deg,speed_mm_s,speed_se_mm_s\n5,88,2\n10,116,2\n20,63,2\n"
    (tmp_path / "speeds.csv").write_text(rows)
    doubt = {"drive.eccentric_g_mm": 0.36, "drive.eccentric_sd_g_mm": 0.12}
    held = (f"restitution={TABLE.contact.restitution}", f"friction={TABLE.contact.friction}")
    job = Job(COINBOT, TABLE.variant(**doubt), fix=held, prior="flat", ahead=())
    learnt = learn.learn(tmp_path / "speeds.csv", job, lambda *progress: None)
    (moment,) = (row for row in learnt.rows if row.name == "eccentric_g_mm")
    assert moment.mean == pytest.approx(0.3, abs=2.0 * moment.sd)
    assert moment.sd < 0.7 * 0.12  # learnt: 0.26 +- 0.07
    assert learnt.scene.drive.eccentric_g_mm == pytest.approx(moment.mean)


def test_a_motor_at_the_other_side_circles_the_other_way():
    """The template's comment: 1.8 rad/s to the left."""
    image = SPINNER.variant(**{"motor.across_mm": -SPINNER.motor.across_mm})
    short = {"run.seconds": 0.8, "run.discard_seconds": 0.2, "run.runs": 3}
    rates = []
    for design in (SPINNER, image):
        plan = prepare(TABLE.variant(**short), design, solids.mass_of(design))
        for number in range(3):
            result = simulate(plan, number, sample_interval=0.02, sample_size=HEADING + 1)
            samples = result.tally.samples
            times, *_, heading = samples.rows[: samples.cursor[0]].T
            rates.append((heading[-1] - heading[0]) / (times[-1] - times[0]))
    left, right = np.reshape(rates, (2, 3))
    assert left.mean() > 0.5
    assert right.mean() < -0.5
