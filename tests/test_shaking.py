"""A plate in place of a motor: predictions, what is drawn, and what a fit learns."""

import numpy as np
import pytest
from motor_rival import carrying, throwing

from walkergen.lab.fit import learn
from walkergen.lab.fit.job import Job
from walkergen.scene import Scene
from walkergen.simulation.run import simulate
from walkergen.theory import prediction, shaking, uncertain
from walkergen.walker import solids
from walkergen.walker.design import Design

SMALL = {"diameter_mm": 2.0, "height_mm": 1.0, "mass_g": 1e-3, "up_mm": 1.2}
"""Motor that fits into a pocket of the paper's walker."""


@pytest.mark.slow
@pytest.mark.parametrize("turned", [False, True])
def test_along_the_run_it_runs_within_the_bounds_of_the_plate_that_shakes_alike(turned):
    for tilt, push in ((10.0, 1.8), (15.0, 2.4)):
        plan = carrying(
            throwing(push, axis="along", reversed=turned),
            tilt=tilt,
            run={"seconds": 2.0, "discard_seconds": 0.5, "runs": 4},
        )
        speed = np.mean([simulate(plan, number).speed for number in range(4)])
        row = prediction.predict(plan.case.design, plan.case.mass, plan.scene)
        assert row.speed_by == "table"
        assert row.speed_low_95_mm_s < speed < row.speed_high_95_mm_s


def predicted(drive, motor=None):
    """Prediction of a walker with a motor, and its plate."""
    plan = carrying(drive, motor)
    case = plan.case
    row = prediction.predict(case.design, case.mass, plan.scene)
    return row, shaking.of(plan.scene, case.design, case.mass), plan


def test_a_motor_along_the_run_is_predicted_as_the_plate_that_moves_as_far():
    row, shaken, plan = predicted(throwing(1.8, axis="along"))
    scene = plan.scene.variant(**{"drive": shaken.drive.model_dump(exclude_none=True)})
    plate = prediction.predict(plan.case.design, plan.case.mass, scene)
    assert shaken.drive.peak_gamma == pytest.approx(1.8)
    assert row.theory_mm_s == pytest.approx(plate.theory_mm_s)
    # Medians of the same draws; the motor's own error widens the bounds
    assert row.speed_mm_s == pytest.approx(plate.speed_mm_s, rel=0.03)
    assert row.speed_sd_mm_s > plate.speed_sd_mm_s


def test_what_the_plate_leaves_out_widens_the_bounds_and_is_said():
    widths, notes = [], []
    for axis, place_of in (("along", {}), ("along", {"up_mm": 6.0}), ("across", {})):
        row, _, _ = predicted(throwing(1.8, axis=axis), place_of)
        widths.append(row.speed_high_95_mm_s - row.speed_low_95_mm_s)
        notes.append(row.note)
    assert widths[0] < min(widths[1:])
    assert ["its push along the run" in note for note in notes] == [False, False, True]
    strong, _, _ = predicted(throwing(2.8, axis="across"))
    assert "bounds are wide" not in strong.note
    _, up, _ = predicted(throwing(1.8, axis="up"))
    assert up.drive.peak_gamma < 1e-5 < up.swing


def test_frequency_and_moment_are_drawn_and_the_rating_stays_with_the_motor():
    drive = {"frequency_hz": 100.0, "rated_g": 0.02, "on_mass_g": 100.0, "frequency_sd_hz": 8.0}
    plan = carrying(drive | {"eccentric_sd_g_mm": 0.001}, SMALL)
    scene, design = plan.scene, plan.case.design
    inputs = {one.name: one for one in uncertain.inputs(scene, design, "space")}
    assert inputs["drive.frequency_hz"].sd == 8.0
    assert inputs["drive.eccentric_g_mm"].mean == scene.drive.eccentric
    sagged, _, _ = uncertain.applied(scene, design, {"drive.frequency_hz": 80.0})
    assert sagged.drive.frequency == 80.0
    assert sagged.drive.eccentric == scene.drive.eccentric
    row = prediction.predict(design, plan.case.mass, scene)
    exact = scene.variant(**{"drive.frequency_sd_hz": 0.0, "drive.eccentric_sd_g_mm": 0.0})
    without = prediction.predict(design, plan.case.mass, exact)
    assert row.speed_sd_mm_s > without.speed_sd_mm_s
    assert "drive.frequency_hz" not in {one.name for one in uncertain.inputs(Scene(), Design(), "space")}


def test_the_moment_is_learnt_from_speeds_along_the_run(tmp_path):
    """Speeds of the table at a moment of 0.8 of what the scene has, with 40 % of doubt."""
    rows = ["tilt_deg,speed_mm_s,speed_se_mm_s"]
    drive, design = throwing(2.4, axis="along"), Design.model_validate({"motor": SMALL})
    for tilt in (6.0, 10.0, 14.0):
        one = design.variant(tilt_deg=tilt)
        row = prediction.predict(one, solids.mass_of(one), carrying(drive).scene)
        rows.append(f"{tilt:g},{row.speed_mm_s:.3f},1.0")
    (tmp_path / "speeds.csv").write_text("\n".join(rows) + "\n")
    true = drive["eccentric_g_mm"]
    doubt = {"eccentric_g_mm": 1.25 * true, "eccentric_sd_g_mm": 0.5 * true}
    scene = carrying(drive | doubt).scene
    job = Job(design, scene, fix=("restitution=0.22", "friction=0.25"), prior="flat", ahead=())
    learnt = learn.learn(tmp_path / "speeds.csv", job, lambda *progress: None)
    (moment,) = (row for row in learnt.rows if row.name == "eccentric_g_mm")
    assert moment.sd < 0.6 * doubt["eccentric_sd_g_mm"]
    assert moment.mean == pytest.approx(true, abs=2.0 * moment.sd)
    assert learnt.scene.drive.eccentric_g_mm == pytest.approx(moment.mean)
    assert learnt.scene.drive.eccentric_sd_g_mm == pytest.approx(moment.sd)
