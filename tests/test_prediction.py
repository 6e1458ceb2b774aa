"""Predictions: rows, their uncertainty and their notes."""

import math

import numpy as np
import pytest

from walkergen import prediction, uncertain
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


EXACT = {"restitution_sd": 0.0, "friction_sd": 0.0}


def exactly(**tables):
    """Design and scene without any standard deviation but those given."""
    design = Design.model_validate(
        {"weighed": {"mass_sd_percent": 0.0}, "legs": {"thickness_sd_mm": 0.0, "tilt_deg": 20.0}}
    )
    known = {"contact": EXACT, "prediction": {"impact_speed_factor_sd": 0.0}}
    return design, Scene.model_validate(known | tables)


def test_standard_deviation_against_linear_propagation():
    """Rival: finite differences; small deviations, so that the second order is 1 % of the first."""
    sds = {"restitution": 0.01, "friction": 0.005}
    design, scene = exactly(contact={f"{name}_sd": sd for name, sd in sds.items()})
    design = design.model_copy(
        update={"legs": design.legs.model_copy(update={"thickness_sd_mm": 0.01}),
                "weighed": design.weighed.model_copy(update={"mass_sd_percent": 2.0})}
    )  # fmt: skip
    mass = solids.mass_of(design)

    def speed(scale_M=1.0, scale_m=1.0, **contact):
        changed = scene.model_copy(update={"contact": scene.contact.model_copy(update=contact)})
        legs = tuple(leg._replace(m=leg.m * scale_m, j=leg.j * scale_m) for leg in mass.legs)
        varied = mass._replace(M=mass.M * scale_M, J=mass.J * scale_M, legs=legs)
        return prediction.predict(design, varied, changed).speed_mm_s

    step = 1e-4
    by_leg = speed(scale_m=1 + step) - speed(scale_m=1 - step)
    slopes = [
        (speed(restitution=0.8 + step) - speed(restitution=0.8 - step)) * sds["restitution"],
        (speed(friction=0.25 + step) - speed(friction=0.25 - step)) * sds["friction"],
        (speed(scale_M=1 + step) - speed(scale_M=1 - step)) * 0.02,
        by_leg * 0.02,
        by_leg * 0.01 / 0.4,  # a leg's mass goes with its thickness
    ]
    expected = np.linalg.norm(slopes) / (2 * step)
    found = prediction.predict(design, mass, scene).speed_sd_mm_s
    # Sobol points know a deviation to a percent; the second order is as much.
    assert found == pytest.approx(expected, rel=0.04)


def test_no_uncertainty_in_leaves_the_theorys_own_error():
    design, scene = exactly()
    row = prediction.predict(design, solids.mass_of(design), scene)
    assert row.speed_sd_mm_s == pytest.approx(0.0, abs=1e-10)
    assert row.speed_high_95_mm_s - row.speed_low_95_mm_s > 10.0


def test_impact_speed_uncertainty_enters():
    design, scene = exactly(prediction={"impact_speed_factor_sd": 0.1})
    row = prediction.predict(design, solids.mass_of(design), scene)
    assert row.speed_sd_mm_s == pytest.approx(0.1 / 0.45 * row.speed_mm_s, rel=0.01)


def test_the_first_number_of_a_newcomer_holds_the_papers_speed():
    row, _, _ = row_of()
    assert row.speed_mm_s == pytest.approx(60.0, abs=1.0)  # on which the factor is calibrated
    assert row.speed_low_68_mm_s < 60.0 < row.speed_high_68_mm_s
    assert row.speed_low_95_mm_s < row.speed_low_68_mm_s
    assert row.speed_high_95_mm_s > row.speed_high_68_mm_s


IN_SPACE = {
    (5.0, 0.5): 61.1, (8.0, 0.5): 83.9, (10.0, 0.5): 88.5, (12.0, 0.5): 83.4, (15.0, 0.5): 42.2,
    (20.0, 0.5): 19.5, (35.0, 0.5): 1.7, (5.0, 0.3): 34.7, (10.0, 0.3): 65.9, (15.0, 0.3): 39.5,
    (20.0, 0.3): 21.1, (35.0, 0.3): 1.8, (5.0, 0.8): 119.0, (10.0, 0.8): 110.0,
    (15.0, 0.8): 46.8, (20.0, 0.8): 15.9, (35.0, 0.8): -0.5,
}  # fmt: skip
"""Speeds of the model in space on a plane, mm/s, by tilt and label; errors below 1 mm/s."""


def test_bounds_hold_the_speeds_of_the_model_in_space():
    """All of 17 at 95 %; at 68 % at least 8, that is 11.6 less two binomial deviations of 1.9."""
    inside = 0
    for (tilt, e), speed in IN_SPACE.items():
        row, _, _ = row_of(Design().variant(tilt_deg=tilt), restitution=e)
        assert row.speed_low_95_mm_s < speed < row.speed_high_95_mm_s, (tilt, e)
        inside += row.speed_low_68_mm_s < speed < row.speed_high_68_mm_s
    assert inside >= 8


@pytest.mark.parametrize(
    ("tables", "told"),
    [({"drive": {"frequency_hz": 90.0, "gamma": 5.0}}, "gamma in 1.1..3, not at 5"),
     ({"contact": {"friction": 2.0}}, "friction in 0.05..0.6, not at 2"),
     ({"plate": {"slope_deg": 6.0}}, "slopes beyond 5 deg"),
     ({"feet": {"damping": "hysteretic"}}, "other feet")],
)  # fmt: skip
def test_bounds_are_refused_where_the_theorys_own_error_is_unknown(tables, told):
    design = Design()
    row = prediction.predict(design, solids.mass_of(design), Scene.model_validate(tables))
    assert row.speed_low_95_mm_s is None
    assert told in row.note


def test_draws_stay_in_the_physical_range_and_repeat():
    scene = Scene.model_validate(
        {"contact": {"restitution": 1.0, "friction": 0.0, "friction_sd": 1.0}}
    )
    known = prediction.known_inputs(scene, Design())
    one, two = (uncertain.draws(known, 64, prediction.SEED) for _ in range(2))
    np.testing.assert_array_equal(one, two)
    drawn = {each.name: one[:, place] for place, each in enumerate(known)}
    assert drawn["contact.restitution"].max() <= 1.0
    assert drawn["contact.friction"].min() >= 0.0
    assert drawn["legs.thickness_mm"].min() > 0.0


def test_shares_name_what_to_measure_next():
    """With one input uncertain by far the most, it takes nearly all the variance of the theory."""
    design, scene = exactly(
        prediction={"impact_speed_factor_sd": 0.2}, plate={"slope_deg": 6.0}
    )  # on a slope the theory's own error is unknown and left out
    first, *rest = prediction.shares(design, solids.mass_of(design), scene, "coulomb")
    assert first.name == "prediction.impact_speed_factor"
    assert first.first == pytest.approx(1.0, abs=0.02)
    assert all(abs(one.total) < 0.02 for one in rest)


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
