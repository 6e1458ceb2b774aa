"""The table of speeds in space: symmetric, honest about its errors, evaluated without imports."""

import subprocess
import sys

import numpy as np
import pytest

from walkergen.scene import Drive, Scene
from walkergen.theory import discrepancy, surrogate, uncertain
from walkergen.theory.surrogate import Place, UnknownError
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


def test_the_mirror_image_runs_the_other_way_and_upright_walkers_do_not_run():
    for slope in (0.0, 2.0):
        right = speed_at(10.0, **{"plate.slope_deg": slope})
        assert speed_at(-10.0, **{"plate.slope_deg": -slope}) == -right
        assert right > 1.0
    assert speed_at(0.0) == 0.0
    down, up = (speed_at(0.0, **{"plate.slope_deg": slope}) for slope in (2.0, -2.0))
    assert down == pytest.approx(-up, abs=1e-6)


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
