"""The contact's parameters come back from speeds made with known ones, within the stated errors."""

import numpy as np
import pytest

from walkergen.analysis import speeds
from walkergen.core.errors import InputError
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.lab.fit import least_squares

TILTS = np.array([2.5, 5.0, 7.5, 10.0, 12.5, 15.0, 20.0, 25.0, 30.0, 35.0])
TRUE = {"restitution": 0.8, "friction": 0.1, "impact_speed_factor": 0.5}


def masses(tilts, kind="flexible"):
    design = templates.load("koumakis2016", "walkers", Design)
    members = [design.variant(tilt_deg=float(tilt), kind=kind) for tilt in tilts]
    return [solids.mass_of(member) for member in members]


BACK, FRONT = least_squares.inverse_mass_tensors(masses(TILTS))


def measured(rng, se=0.5, mode="coulomb", true=TRUE, plate=31.2):
    ones = np.ones(len(TILTS))
    speeds = least_squares.Speeds(ones, se * ones, plate * ones, BACK, FRONT, mode)
    unit = least_squares.speeds_at_unit_factor(speeds, true["restitution"], true["friction"])
    exact = true["impact_speed_factor"] * unit
    return speeds._replace(speed=exact + se * rng.normal(size=len(TILTS)))


@pytest.mark.parametrize("held", ["restitution", "impact_speed_factor"])
def test_intervals_of_68_percent_cover_the_truth_in_as_many_cases(held):
    inside = {name: [] for name in TRUE if name != held}
    for seed in range(200):
        speeds = measured(np.random.default_rng(seed))
        found = least_squares.fit_contact(speeds, {held: TRUE[held]}, profiles=False)
        for name, hits in inside.items():
            hits.append(abs(found.values[name] - TRUE[name]) < found.errors[name])
    for name, hits in inside.items():
        assert 0.60 <= np.mean(hits) <= 0.76, (name, np.mean(hits))


def test_without_noise_the_parameters_come_back_exactly():
    speeds = measured(np.random.default_rng(0), se=1e-6, plate=np.linspace(20, 40, len(TILTS)))
    found = least_squares.fit_contact(speeds, {"restitution": 0.8}, profiles=False)
    for name, value in TRUE.items():
        assert found.values[name] == pytest.approx(value, rel=1e-4)
    np.testing.assert_allclose(found.predicted, speeds.speed, rtol=1e-5)


def test_profiles_agree_with_the_covariance_where_the_fit_is_sharp():
    found = least_squares.fit_contact(measured(np.random.default_rng(1), se=0.1), {"restitution": 0.8})
    for name, (low, high) in found.intervals.items():
        half = 0.5 * (high - low)
        assert half == pytest.approx(found.errors[name], rel=0.15)
    assert not found.notes


def test_restitution_and_impact_speed_cannot_be_told_apart():
    found = least_squares.fit_contact(measured(np.random.default_rng(2), se=2.0), {})
    assert any("cannot be separated" in note for note in found.notes)
    told = next(note for note in found.notes if "cannot be separated" in note)
    assert "restitution" in told
    assert "impact_speed_factor" in told
    place = found.free.index
    pair = found.correlation[place("restitution"), place("impact_speed_factor")]
    assert pair < -0.95
    low, high = found.intervals["restitution"]
    assert high > 3 * low


def test_friction_is_not_seen_where_all_feet_stick():
    stuck = {**TRUE, "friction": 3.0}
    found = least_squares.fit_contact(measured(np.random.default_rng(3), true=stuck), {"restitution": 0.8})
    assert found.errors["friction"] is None
    assert any(note.startswith("friction: none of these speeds") for note in found.notes)
    assert found.intervals["friction"][1] is None
    error = found.errors["impact_speed_factor"]
    assert found.values["impact_speed_factor"] == pytest.approx(0.5, abs=4 * error)


def test_a_theory_that_does_not_describe_the_speeds_says_so():
    speeds = measured(np.random.default_rng(4))
    found = least_squares.fit_contact(speeds._replace(speed=speeds.speed[::-1]), {"restitution": 0.8})
    assert found.p_value < 1e-6
    assert any("does not describe" in note for note in found.notes)


def test_without_errors_the_scatter_tells_them():
    speeds = measured(np.random.default_rng(5))
    given = least_squares.fit_contact(speeds, {"restitution": 0.8})
    taken = least_squares.fit_contact(speeds._replace(se=None), {"restitution": 0.8})
    assert taken.values == pytest.approx(given.values, rel=1e-3)
    assert taken.chi2 is None
    scatter = np.sqrt(given.chi2 / given.dof)
    for name, error in given.errors.items():
        assert taken.errors[name] == pytest.approx(scatter * error, rel=0.01)


@pytest.mark.parametrize("se", [1e-9, 1e3])
def test_absurdly_sharp_or_vague_speeds_end_in_a_note(se):
    speeds = measured(np.random.default_rng(9))
    found = least_squares.fit_contact(speeds._replace(se=np.full(len(TILTS), se)), {"restitution": 0.8})
    assert found.notes
    assert np.isfinite(found.predicted).all()


def test_too_few_speeds_and_rigid_legs_are_refused():
    speeds = measured(np.random.default_rng(7))
    few = speeds._replace(
        speed=speeds.speed[:3],
        se=speeds.se[:3],
        plate_speed=speeds.plate_speed[:3],
        back=least_squares.InverseMass(*(x[:3] for x in BACK)),
        front=least_squares.InverseMass(*(x[:3] for x in FRONT)),
    )
    with pytest.raises(InputError, match="at least 4"):
        least_squares.fit_contact(few, {})
    with pytest.raises(InputError, match="no parameter is left"):
        least_squares.fit_contact(speeds, TRUE)
    back, front = least_squares.inverse_mass_tensors(masses(TILTS, "braced"))
    with pytest.raises(InputError, match="rigid legs"):
        least_squares.fit_contact(speeds._replace(back=back, front=front), {})


def test_speeds_at_one_tilt_tell_only_a_factor():
    speeds = measured(np.random.default_rng(8), plate=np.linspace(20, 40, len(TILTS)))
    same = [4] * len(TILTS)
    back, front = (least_squares.InverseMass(*(x[same] for x in H)) for H in (BACK, FRONT))
    exact = 0.5 * least_squares.speeds_at_unit_factor(speeds._replace(back=back, front=front), 0.8, 0.1)
    alike = speeds._replace(back=back, front=front, speed=exact)
    found = least_squares.fit_contact(alike, {})
    assert any("cannot be separated" in note for note in found.notes)
    assert found.errors["impact_speed_factor"] is None
    np.testing.assert_allclose(found.predicted, exact, rtol=1e-6)
    told = least_squares.fit_contact(alike, {"restitution": 0.8, "friction": 0.1})
    assert told.errors["impact_speed_factor"] == pytest.approx(0.5 * 0.5 / np.sqrt((exact**2).sum()), rel=1e-6)


def test_measured_speeds_of_another_plate_are_left_out_and_told(tmp_path):
    path = tmp_path / "speeds.csv"
    path.write_text("tilt_deg,speed_mm_s,plate_speed_mm_s\n5,70,31\n10,60,\n15,90,52\n")
    found = speeds.select_plate_speed(speeds.read_speeds(path, "flexible", 31.2), 31.2)
    np.testing.assert_array_equal(found.tilt, [5.0, 10.0])
    np.testing.assert_array_equal(found.speed, [70.0, 60.0])
    assert found.legs == ["flexible", "flexible"]
    assert found.bad == "1 speeds at other plate speeds than 31.2 mm/s left out"


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("10,1e300", "speed_mm_s is '1e300', not a number within ±1e+12"),
        ("10,-1e9", "speed_mm_s must lie within ±100000"),
        ("1e9,5", "tilt_deg must lie within ±90"),
        ("-120,5", "tilt_deg must lie within ±90"),
    ],
)
def test_speeds_that_are_no_measurements_are_left_out_and_told(tmp_path, line, told):
    path = tmp_path / "speeds.csv"
    path.write_text(f"tilt_deg,speed_mm_s\n5,70\n{line}\n")
    found = speeds.read_speeds(path, "flexible", 31.2)
    np.testing.assert_array_equal(found.tilt, [5.0])
    assert found.bad == f"1 bad row left out: line 3: {told}"
