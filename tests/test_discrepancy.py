"""The table of speeds in space: symmetric, honest about its errors, evaluated without imports."""

import json
import math
import subprocess
import sys

import numpy as np
import pytest

from evidence.tables import cases, fit, make
from walkergen.points.kinds import evaluate
from walkergen.points.point import Point
from walkergen.scene import Drive, Scene
from walkergen.theory import discrepancy, surrogate, uncertain
from walkergen.theory.surrogate import LINEAR_BELOW, Place, UnknownError
from walkergen.walker import solids
from walkergen.walker.design import Design
from walkergen.walker.mass import scaled

DESIGN, SCENE = Design(), Scene(drive=Drive(frequency_hz=90.0, gamma=1.8))
MASS = solids.mass_of(DESIGN)


def place_at(tilt=10.0, **keys):
    design = DESIGN.variant(tilt_deg=tilt)
    return discrepancy.place_of(SCENE.variant(**keys), design, solids.mass_of(design))


def speed_at(tilt, **keys):
    design = DESIGN.variant(tilt_deg=tilt)
    tabled = discrepancy.of(SCENE.variant(**keys), design, solids.mass_of(design))
    return tabled.at(tabled.place).centre[0]


@pytest.mark.slow
def test_rows_of_the_table_are_what_the_model_in_space_gives():
    """Chaotic runs: equal to the bit on one machine, elsewhere within errors of four runs."""
    stored, compared = make.read(), 0
    for case in list(cases.cases(cases.COUNT))[:6]:
        row = make.row(make.PLATES, case, evaluate(Point(case.design, case.scene, simulated=True)))
        if row is None:
            continue
        nearest = stored[np.argmin(np.abs(stored[:, :17] - row[:17]).sum(axis=1))]
        assert nearest[:17] == pytest.approx(row[:17], abs=1e-3)
        # Five standard errors of a difference: t of three freedoms passes them once in 80.
        assert abs(nearest[17] - row[17]) <= 5.0 * math.hypot(nearest[18], row[18]) + 0.02
        compared += 1
    assert compared >= 3


def test_the_mirror_image_runs_the_other_way_and_upright_walkers_do_not_run():
    for slope in (0.0, 2.0):
        right = speed_at(10.0, **{"plate.slope_deg": slope})
        assert speed_at(-10.0, **{"plate.slope_deg": -slope}) == -right
        assert right > 1.0
    assert speed_at(0.0) == 0.0
    down, up = (speed_at(0.0, **{"plate.slope_deg": slope}) for slope in (2.0, -2.0))
    assert down == pytest.approx(-up, abs=1e-6)


def test_errors_stored_are_those_of_rows_left_out():
    """A table that says too little of its error, or too much, is not written unseen."""
    errors = discrepancy.TABLE.facts["errors"]["flexible"]
    assert 0.9 < errors["all"]["z_rms"] < 1.1
    assert 0.92 < errors["all"]["z_within_95"] < 0.98


def test_what_is_covered_is_told_apart_from_what_is_not():
    covered = {"plate.slope_deg": 4.0, "drive.second_harmonic_ratio": 0.3, "plate.noise_ratio": 0.3}
    for key, value in covered.items():
        assert surrogate.of(SCENE.variant(**{key: value}), DESIGN, MASS).table is discrepancy.TABLE
    for keys, told in (
        ({"plate.slope_deg": 6.0}, "slopes beyond 5 deg"),
        ({"plate.noise_ratio": 0.3, "plate.noise_high_hz": 300.0}, "another band"),
        ({"plate.noise_ratio": 0.8}, "noise ratio"),
        ({"plate.roughness_um": 1.0}, "rough"),
        ({"drive.second_harmonic_ratio": 0.9}, "harmonic"),
    ):
        with pytest.raises(UnknownError, match=told):
            surrogate.of(SCENE.variant(**keys), DESIGN, MASS)


def test_places_of_draws_are_those_of_walkers_so_built():
    """Thickness, modulus and masses of a draw against the design that has them."""
    values = {
        "legs.thickness_mm": 0.46,
        "material.youngs_modulus_gpa": 3.4,
        "body mass": 1.03,
        "leg mass": 0.97,
        "contact.friction": 0.2,
    }
    sloping = SCENE.variant(**{"plate.slope_deg": 1.0})
    scene, design, _ = uncertain.applied(sloping, DESIGN, values)
    mass = scaled(MASS, 1.03, 0.97 * 0.46 / DESIGN.limbs[0].thickness)
    built = discrepancy.place_of(scene, design, mass)
    nominal = discrepancy.place_of(sloping, DESIGN, MASS)
    ratio = np.array([0.46 / DESIGN.limbs[0].thickness])
    drawn = nominal.drawn(
        restitution=np.array([scene.contact.restitution]),
        friction=np.array([0.2]),
        thickness=ratio,
        modulus=np.array([3.4 / 3.0]),
        body_mass=np.array([1.03]),
        leg_mass=0.97 * ratio,
        unevenness=np.zeros(1),
    )
    for name, left, right in zip(Place._fields, drawn, built, strict=True):
        # A thinner leg's mass has another lever, and the braced body's gyration another radius.
        assert np.ravel(left)[0] == pytest.approx(right, abs=3e-3), name


def synthetic(count=600):
    """Rows whose speeds, scatter in time and scatter between prints are known."""
    rng = np.random.default_rng(4)
    places = np.tile(np.array(place_at()), (count, 1))
    places[:, 0] = np.sqrt(rng.uniform(1.0, 40.0, count))
    places[:, 1] = rng.uniform(0.1, 0.9, count)
    places[:, 8] = rng.choice([0.0, 0.1, 0.2], count)
    y = 1.5 + np.sin(places[:, 0]) + places[:, 1]
    scatter = np.hypot(0.05, places[:, 8])[:, None] * rng.standard_normal((count, 4))
    speed = LINEAR_BELOW * np.sinh(y + scatter.mean(axis=1))
    se = 0.5 * scatter.std(axis=1, ddof=1) * np.hypot(speed, LINEAR_BELOW)
    rows = np.column_stack([np.zeros(count), places, speed, se, np.full(count, 4.0)])
    return np.vstack([rows, np.column_stack([np.ones(40), rows[:40, 1:]])]), places, y


def test_a_fit_knows_its_function_its_error_and_the_scatter_between_prints():
    made, places, y = synthetic()
    arrays = fit.table(made, cores=1, steps=120)
    found = discrepancy.fitted(arrays, "flexible", places)
    assert np.median(np.abs(found.centre - y)) < 0.03
    uneven = places[:, 8] > 0.0
    assert found.between_prints[uneven] == pytest.approx(places[uneven, 8], rel=0.4)
    assert np.all(found.between_prints[~uneven] == 0.0)
    told = json.loads(str(arrays["facts"]))["errors"]["flexible"]["all"]
    assert 0.85 < told["z_rms"] < 1.15
    assert fit.as_bytes(arrays) == fit.as_bytes(fit.table(made, cores=1, steps=120))


def test_predictions_import_none_of_the_large_libraries():
    """A fresh `predict` is near its bare imports; each of these takes longer than many rows."""
    code = (
        "import sys; from walkergen.theory import prediction; from walkergen.scene import Scene; "
        "from walkergen.walker import solids; from walkergen.walker.design import Design; "
        "d = Design(); prediction.predict(d, solids.mass_of(d), Scene()); "
        "print([m for m in ('scipy', 'sklearn', 'pandas', 'numba', 'threadpoolctl', 'matplotlib') "
        "if m in sys.modules])"
    )
    told = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert told.stdout.strip() == "[]"
