"""Predictions: rows, their uncertainty and their notes."""

import math

import numpy as np
import pytest

from walkergen import prediction
from walkergen.scene import Scene
from walkergen.walker import solids
from walkergen.walker.design import Design


def row_of(design=None, mode="coulomb", **contact):
    design = design or Design()
    scene = Scene.model_validate({"contact": contact})
    mass = solids.mass_of(design)
    return prediction.predict(design, mass, scene, mode), mass, scene


@pytest.mark.parametrize(
    ("tilt", "mode", "back", "front"),
    [(5, "paper", 5.506, 4.977), (5, "coulomb", 5.249, 4.753), (10, "coulomb", 4.203, 3.790),
     (20, "paper", 2.458, 2.296), (35, "coulomb", 1.335, 1.297)],
)  # fmt: skip
def test_speed_is_the_known_factor_times_the_impact_speed(tilt, mode, back, front):
    """physics.md section 4, e = 0.9, mu = 0.1; feet meet the plate at half its peak speed."""
    scene = Scene.model_validate(
        {
            "drive": {"frequency_hz": 90.0, "gamma": 1.8},
            "contact": {"restitution": 0.9, "friction": 0.1},
            "prediction": {"impact_speed_factor": 0.5},
        }
    )
    impact_speed = 0.5 * 1.8 * 9806.65 / (2.0 * math.pi * 90.0)
    design = Design().variant(tilt_deg=tilt)
    row = prediction.predict(design, solids.mass_of(design), scene, mode)
    # Factors are known to three decimals, for masses of three digits.
    assert row.factor_back == pytest.approx(back, abs=3e-3)
    assert row.factor_front == pytest.approx(front, abs=3e-3)
    assert row.factor_mean == pytest.approx(0.5 * (back + front), abs=3e-3)
    assert row.speed_mm_s == pytest.approx(0.5 * (back + front) * impact_speed, rel=2e-3)


def test_standard_deviation_against_linear_propagation():
    """Rival: finite differences; small deviations, so that the second order is 1 % of the first."""
    tilt20 = Design().variant(tilt_deg=20.0)
    sds = {"restitution": 0.01, "friction": 0.005}
    row, mass, scene = row_of(
        tilt20, restitution_sd=sds["restitution"], friction_sd=sds["friction"]
    )

    def speed(scale_M=1.0, scale_m=1.0, **contact):
        changed = scene.model_copy(update={"contact": scene.contact.model_copy(update=contact)})
        varied = mass._replace(
            M=mass.M * scale_M, J=mass.J * scale_M, m=mass.m * scale_m, j=mass.j * scale_m
        )
        return prediction.predict(tilt20, varied, changed).speed_mm_s

    step = 1e-4
    slopes = [
        (speed(restitution=0.8 + step) - speed(restitution=0.8 - step)) * sds["restitution"],
        (speed(friction=0.25 + step) - speed(friction=0.25 - step)) * sds["friction"],
        (speed(scale_M=1 + step) - speed(scale_M=1 - step)) * 0.02,
        (speed(scale_m=1 + step) - speed(scale_m=1 - step)) * 0.02,
    ]
    expected = np.linalg.norm(slopes) / (2 * step)
    # 4096 draws know a standard deviation to 1.1 %: four of those, and the second order.
    assert row.speed_sd_mm_s == pytest.approx(expected, rel=0.06)


def test_no_uncertainty_in_gives_none_out():
    certain = Design.model_validate({"weighed": {"mass_sd_percent": 0.0}})
    row, _, _ = row_of(certain, restitution_sd=0.0, friction_sd=0.0)
    assert row.speed_sd_mm_s == pytest.approx(0.0, abs=1e-10)


def test_impact_speed_uncertainty_enters():
    design = Design()
    scene = Scene.model_validate({"prediction": {"impact_speed_factor_sd": 0.2}})
    mass = solids.mass_of(design)
    row = prediction.predict(design, mass, scene)
    assert row.speed_sd_mm_s == pytest.approx(0.2 * row.speed_mm_s, rel=0.06)


def test_draws_stay_in_the_physical_range_and_repeat():
    scene = Scene.model_validate(
        {"contact": {"restitution": 1.0, "friction": 0.0, "friction_sd": 1.0}}
    )
    one, two = (prediction.draw(scene, 0.5) for _ in range(2))
    for a, b in zip(one, two, strict=True):
        np.testing.assert_array_equal(a, b)
        assert a.shape == (prediction.DRAWS,)
    assert (one.restitution <= 1).all()
    assert (one.restitution >= 0).all()
    assert (one.friction >= 0).all()
    assert (one.leg > 0).all()


def test_tilt_zero_stands_still_and_its_mirror_image_runs_back():
    assert row_of(Design().variant(tilt_deg=0.0))[0].speed_mm_s == 0.0
    left = row_of(Design().variant(tilt_deg=-12.0))[0]
    right = row_of(Design().variant(tilt_deg=12.0))[0]
    assert left.speed_mm_s == pytest.approx(-right.speed_mm_s, rel=1e-12)


def test_braced_walkers_hardly_move():
    """Paper: rigid objects show no significant propulsion; docs/physics.md: below 2 mm/s."""
    for tilt in (0.0, 10.0, 30.0, 45.0):
        row = row_of(Design().variant(tilt_deg=tilt, kind="braced"))[0]
        assert abs(row.speed_mm_s) < 2.0
        assert row.m_g is None


def test_the_peak_lies_below_ten_degrees():
    """Paper: a maximum always below 10 degrees in a wide range of restitution and friction."""
    for e, mu in ((0.8, 0.25), (0.9, 0.1), (0.5, 0.2)):
        scene = Scene.model_validate({"contact": {"restitution": e, "friction": mu}})
        curve = prediction.curve(Design(), scene, "coulomb", 0.0, 45.0)
        assert 0 < curve.tilt_deg[np.argmax(curve.speed)] < 10


def test_notes_name_where_equation_15_fails():
    """docs/physics.md section 4: below about atan(mu), 14.4 deg at mu = 0.25."""
    limit = math.degrees(math.atan(0.25))
    below, above = (Design().variant(tilt_deg=limit + d) for d in (-1.0, 1.0))
    assert "can stick" in row_of(below)[0].note
    assert row_of(above)[0].note == ""
    assert "eq. 15 fails" in row_of(below, mode="paper")[0].note
    assert "every speed is stationary" in row_of(friction=0.0)[0].note


def test_speed_does_not_depend_on_density():
    light = Design.model_validate({"material": {"density_g_cm3": 0.5}})
    assert row_of(light)[0].speed_mm_s == pytest.approx(row_of()[0].speed_mm_s, rel=1e-12)


def test_a_heavier_leg_changes_the_prediction():
    heavy = Design.model_validate({"weighed": {"leg_mass_g": 0.04}})
    assert row_of(heavy)[0].speed_mm_s < 0.99 * row_of()[0].speed_mm_s
