"""Walkers that the surrogate declines: simulated shortly, kept, and said to fall where they do."""

import pytest

from walkergen.points import short, speeds
from walkergen.points.store import Store
from walkergen.scene import Scene
from walkergen.walker import solids
from walkergen.walker.design import Design


@pytest.fixture(autouse=True)
def own_store(tmp_path, monkeypatch):
    monkeypatch.setattr(short, "Store", lambda: Store(tmp_path / "points.sqlite"))


PLATE = {"frequency_hz": 90.0, "gamma": 1.8}


def on_plane(**tables):
    return Scene.model_validate({"arena": {"kind": "plane"}, "drive": PLATE} | tables)


def predicted(design, scene, model="best"):
    return speeds.predict(design, solids.mass_of(design), scene, model=model)


def test_what_the_surrogate_declines_is_simulated_once_and_then_known():
    """By direct runs 39.5 mm/s; short runs err by some more."""
    design, scene = Design().variant(tilt_deg=10.0), on_plane(contact={"friction": 0.6})
    assert predicted(design, scene, "known").speed_mm_s is None
    row = predicted(design, scene)
    assert row.speed_by == "runs"
    assert row.nominal_mm_s == pytest.approx(39.5, rel=0.2)
    assert row.speed_low_95_mm_s < row.speed_low_68_mm_s < row.speed_mm_s < row.speed_high_68_mm_s
    assert predicted(design, scene, "known") == row


def test_walkers_that_fall_have_no_speed():
    """Topples in 16 of 16 runs; the table before gave it 121 mm/s."""
    legs = {"tilt_deg": 1.4, "length_mm": 8.05, "flexible_thickness_mm": 0.533, "contact_spacing_mm": 14.19}
    body = {"length_mm": 26.1, "thickness_mm": 3.11, "depth_mm": 8.16}
    scene = on_plane(drive={"frequency_hz": 60.6, "gamma": 2.43}, contact={"restitution": 0.88, "friction": 0.073})
    row = predicted(Design.model_validate({"legs": legs, "body": body}), scene)
    assert row.speed_mm_s is None
    assert row.falls >= short.FALLS_ALL


def test_a_record_becomes_bounds_with_the_models_own_error():
    record = {"nominal": 50.0, "low": 48.0, "high": 52.0, "falls": 0.0, "mean": 40.0, "sd": 10.0}
    record |= dict(zip(short.ENDS, (20.0, 30.0, 50.0, 60.0), strict=True))
    spread = short.spread(record, on_plane(prediction={"model_sd": 0.0}))
    assert spread.bounds == (20.0, 30.0, 50.0, 60.0)
    wider = short.spread(record, on_plane(prediction={"model_sd": 0.15}))
    assert wider.bounds[3] == pytest.approx(40.0 + (20.0**2 + (1.96 * 6.0) ** 2) ** 0.5, rel=1e-3)
