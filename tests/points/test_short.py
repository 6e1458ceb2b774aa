"""Walkers outside the surrogate: simulated shortly, stored, and reported if they fall."""

import pytest

from walkergen.core.errors import InputError
from walkergen.core.scene import Scene
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.points import effect_selection, short_simulation, speed_prediction
from walkergen.points.store import Store


@pytest.fixture(autouse=True)
def own_store(tmp_path, monkeypatch):
    for module in (short_simulation, effect_selection):
        monkeypatch.setattr(module, "Store", lambda: Store(tmp_path / "points.sqlite"))


PLATE = {"frequency_hz": 90.0, "gamma": 1.8}


def plane_scene(**tables):
    return Scene.model_validate({"arena": {"kind": "plane"}, "drive": PLATE} | tables)


def predict_design(design, scene, model="best"):
    return speed_prediction.predict(design, solids.mass_of(design), scene, model=model)


@pytest.mark.slow
def test_a_case_that_the_surrogate_declines_is_simulated_once_and_stored():
    """By direct runs 35.2 mm/s; short runs err by some more. On a slope the surrogate is not corrected."""
    contact = {"friction": 0.6, "restitution": 0.4}
    design, scene = Design().variant(tilt_deg=10.0), plane_scene(contact=contact, plate={"slope_deg": 0.5})
    assert predict_design(design, scene, "known").speed.value is None
    row = predict_design(design, scene)
    assert row.speed_by == "runs"
    assert row.nominal.value == pytest.approx(35.2, rel=0.2)
    assert row.speed.low_95 < row.speed.ends[1] < row.speed.value < row.speed.ends[2]
    assert predict_design(design, scene, "known") == row


def test_walkers_that_fall_have_no_speed():
    """Topples in 16 of 16 runs; the table before gave it 121 mm/s."""
    legs = {"tilt_deg": 1.4, "length_mm": 8.05, "flexible_thickness_mm": 0.533, "contact_spacing_mm": 14.19}
    body = {"length_mm": 26.1, "thickness_mm": 3.11, "depth_mm": 8.16}
    scene = plane_scene(drive={"frequency_hz": 60.6, "gamma": 2.43}, contact={"restitution": 0.88, "friction": 0.073})
    row = predict_design(Design.model_validate({"legs": legs, "body": body}), scene)
    assert row.speed.value is None
    assert row.falls >= short_simulation.MAX_FALL_SHARE


def test_a_record_gives_bounds_that_include_the_model_error():
    record = {"nominal": 50.0, "low": 48.0, "high": 52.0, "falls": 0.0, "mean": 40.0, "sd": 10.0}
    record |= dict(zip(short_simulation.BOUND_NAMES, (20.0, 30.0, 50.0, 60.0), strict=True))
    spread = short_simulation.speed_from_record(record, plane_scene(prediction={"model_sd": 0.0}))
    assert spread.speed.ends == (20.0, 30.0, 50.0, 60.0)
    wider = short_simulation.speed_from_record(record, plane_scene(prediction={"model_sd": 0.15}))
    assert wider.speed.ends[3] == pytest.approx(40.0 + (20.0**2 + (1.96 * 6.0) ** 2) ** 0.5, rel=1e-3)


def test_bounds_include_the_error_of_omitted_effects():
    record = {"nominal": 50.0, "low": 47.0, "high": 53.0, "falls": 0.0, "mean": 40.0, "sd": 10.0, "left_out_mm_s": 4.0}
    record |= dict(zip(short_simulation.BOUND_NAMES, (37.0, 38.5, 41.5, 43.0), strict=True))
    exact = plane_scene(prediction={"model_sd": 0.0})
    wider = short_simulation.speed_from_record(record, exact)
    assert wider.nominal.interval() == (45.0, 55.0)
    assert wider.speed.ends[0::3] == (35.0, 45.0)
    few = short_simulation.speed_from_record(record | {"mean": None}, exact)
    assert few.speed.ends[0::3] == (45.0, 55.0)


def test_a_walker_is_simulated_without_effects_below_the_accepted_error(monkeypatch):
    """The same seeds and runs: the noise takes half of the time and changes the last digits alone."""
    monkeypatch.setattr(effect_selection, "MAX_PILOT_SHARE", 1.0)
    monkeypatch.setattr(effect_selection, "MAX_SPENT_SHARE", 1e9)
    run = {"seconds": 0.3, "discard_seconds": 0.1}
    plate = {"noise_ratio": 1e-6}
    held = {"off": ["roll_and_yaw", "leg_twist"]}
    tables = {"plate": plate, "run": run, "arena": {"kind": "lane"}, "effects": held}
    design = Design().variant(tilt_deg=10.0)
    plain, whole, simple = (
        predict_design(design, plane_scene(**tables | more))
        for more in ({"plate": {}}, {}, {"run": run | {"accepted_error": 0.5}})
    )
    assert plain.nominal.value == simple.nominal.value != whole.nominal.value
    assert simple.speed.low_95 < plain.speed.low_95
    assert "left out: plate noise" in simple.note
    assert "left out" not in whole.note


class ReachedError(Exception):
    """A simulation that would begin."""


@pytest.fixture
def would_begin(monkeypatch):
    """Runs of usual length; none is made."""

    def raise_reached(*_, **__):
        raise ReachedError

    monkeypatch.setattr(short_simulation, "find_simplest", raise_reached)
    for name, value in {"MAX_RUN_S": 4.0, "PRINT_S": 2.0, "PRINT_COUNT": 32}.items():
        monkeypatch.setattr(short_simulation, name, value)


@pytest.mark.parametrize(
    ("key", "value"), [("drive.frequency_hz", 1e9), ("run.step_us", 0.01), ("run.discard_seconds", 1e6)]
)
def test_a_walker_that_would_take_minutes_is_refused_by_the_key_that_makes_it_so(key, value, would_begin):
    unknown = {"feet.rigid_tips": True}  # so that the surrogate says nothing of it
    scene = templates.load("plane-90hz", "scenes", Scene).variant(**{key: value, **unknown})
    with pytest.raises(InputError) as refused:
        predict_design(Design(), scene)
    assert refused.value.keys == (f"scene.{key}",)
    assert str(refused.value).startswith(f"scene.{key} = {value:g}: ")
    assert " of CPU time" in str(refused.value)
    assert "`simulate --seconds" in str(refused.value)
    assert "\n" not in str(refused.value)
    assert predict_design(Design(), scene, "known").speed.value is None


def test_a_walker_of_stiff_parts_is_refused_by_its_own_keys(would_begin):
    with pytest.raises(InputError, match="because its parts are stiff, light or small"):
        predict_design(
            Design().variant(**{"material.youngs_modulus_gpa": 1e4}),
            plane_scene(contact={"friction": 0.6}, feet={"rigid_tips": True}),
        )


@pytest.mark.parametrize("restitution", [0.02, 0.8, 1.0])
@pytest.mark.parametrize("tilt", [1.0, 45.0])
def test_usual_walkers_are_short_enough(restitution, tilt, would_begin):
    scene = plane_scene(contact={"restitution": restitution, "friction": 0.9}, feet={"tangential_ratio": 0.5})
    with pytest.raises(ReachedError):
        predict_design(Design().variant(tilt_deg=tilt), scene)
