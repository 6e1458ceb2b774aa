"""From readings of strips, block and walker to material and contact: recovered within their errors.

The bench that makes the readings solves the elastica and beam elements; what is known of it was
hidden from the estimates.
"""

import math

import calibration_bench as bench
import numpy as np
import pytest

from walkergen.analysis import beams
from walkergen.analysis.beams import Strip
from walkergen.errors import InputError
from walkergen.files import templates
from walkergen.files.tables import csv_text
from walkergen.jobs.calibration import contact, form, modulus, parts
from walkergen.jobs.calibration.modulus import BENDS, RINGS, Density
from walkergen.printing.printers import Printer
from walkergen.scene import Scene
from walkergen.walker.design import Design

PAPER = templates.load("koumakis2016", "walkers", Design)
LANE = templates.load("lane-90hz", "scenes", Scene)
PRINTER = templates.load("prusa-mk3s", "printers", Printer)
STRIPS = parts.strips(PAPER, PRINTER)
MODULUS, DENSITY = 2.7e9, 1.22e-3
"""Hidden modulus, Pa, and density, g/mm^3."""


class Person:
    """A person with ruler, caliper and phone, whose hand is as sure as the form says."""

    def __init__(self, seed, creep=0.0, ridges=0.0):
        self.random = np.random.default_rng(seed)
        self.creep, self.ridges = creep, ridges
        self.rows = []

    def reads(self, part, name, value, *beside, error=None):
        quantity = form.quantities(part)[name]
        error = quantity.error if error is None else error
        seen = value + error * self.random.normal()
        self.rows.append((part, name, seen, error, *(beside or ("", "", ""))))

    def measures_strips(self):
        for one in STRIPS:
            drawn = one.strip
            strip = Strip(drawn.thickness * (1.0 + 0.04 * self.random.normal()), 5.05, drawn.length)
            for _ in range(3):
                self.reads(one.name, "thickness_mm", strip.thickness + self.ridges)
            self.reads(one.name, "width_mm", strip.width)
            self.reads(one.name, "free_length_mm", strip.length)
            for weight in (one.light_g, one.heavy_g):
                self.bends(one.name, strip, weight)
            hertz = bench.rings(MODULUS, DENSITY, strip)
            for _ in range(3):
                self.reads(one.name, "swings_20_s", 20.0 / hertz)

    def bends(self, name, strip, weight):
        at = strip.length - 2.0
        place = at + modulus.AT_SD_MM * self.random.normal()
        load = weight * (1.0 + modulus.WEIGHT_SD * self.random.normal())
        sunk = bench.sunk(MODULUS * (1.0 - self.creep), strip, load, place)
        for _ in range(3):
            zero = 40.0 + 0.5 * self.random.normal()
            self.reads(name, "deflection_mm", 40.0 - sunk, zero, weight, at)

    def measures_block(self):
        size = parts.block_size(PRINTER)
        self.reads("block", "mass_g", DENSITY * parts.block_volume(*size))
        for name, value in zip(("length_mm", "width_mm", "height_mm"), size, strict=True):
            self.reads("block", name, value)
        for _ in range(6):
            self.reads("block", "slides_deg", math.degrees(math.atan(0.25)))

    def writes(self, folder):
        path = folder / "measurements.csv"
        path.write_text(csv_text(form.HEADER, self.rows))
        return path


@pytest.fixture(scope="module")
def crowd(tmp_path_factory):
    """Forms of some people who measured the same plate."""
    folder, found = tmp_path_factory.mktemp("crowd"), []
    for seed in range(20):
        person = Person(seed)
        person.measures_strips()
        person.measures_block()
        found.append(form.read(person.writes(folder)))
    return found


def fitted(readings):
    strips, notes = modulus.specimens(readings)
    assert notes == []
    density = contact.density(readings)
    return modulus.fit(strips, Density(density.value, density.sd))


@pytest.mark.parametrize("load", [0.05, 0.2])
@pytest.mark.parametrize("strip", [Strip(0.4, 5.0, 50.0), Strip(1.67, 5.0, 100.0)])
def test_closed_forms_are_the_elastica_and_the_elements(strip, load):
    stiff = beams.stiffness(MODULUS, strip)
    at = strip.length - 2.0
    long = beams.effective(at, strip)
    weight = 3.0 * load * stiff / (9806.65 * long**2)
    sunk = bench.sunk(MODULUS, strip, weight, at)
    assert beams.sunk(weight, long, stiff) == pytest.approx(sunk, rel=2e-3)
    whole = strip._replace(length=beams.effective(strip.length, strip))
    mass = beams.moving_mass(DENSITY, whole)
    for tip in (0.0, 0.3, 3.0):
        heard = bench.rings(MODULUS, DENSITY, strip, tip)
        assert beams.rings(stiff, mass, whole.length, tip) == pytest.approx(heard, rel=5e-4)


def test_a_modulus_is_recovered_within_its_error_and_the_error_is_honest(crowd):
    fits = [fitted(one) for one in crowd]
    pulls = np.array([(1e9 * one.modulus - MODULUS) / (1e9 * one.sd) for one in fits])
    assert abs(pulls.mean()) < 3.0 / math.sqrt(len(pulls))
    assert 0.6 < pulls.std() < 1.4
    assert np.mean([one.sd / one.modulus for one in fits]) < 0.05  # it tells 5 %
    assert np.mean([one.chi2 / one.dof for one in fits]) == pytest.approx(1.0, abs=0.35)
    assert sum(one.agrees for one in fits) >= 17
    by = [modulus.fit(modulus.only(modulus.specimens(crowd[0])[0], method), Density(1.22, 0.02))
          for method in (BENDS, RINGS)]  # fmt: skip
    assert all(abs(1e9 * one.modulus - MODULUS) < 3e9 * one.sd for one in by)


@pytest.mark.parametrize("times", [1e-3, 1e3])
def test_any_plastic_is_found_and_all_scales(crowd, times):
    # Weights times k: a modulus times k; swings as fast as its root
    readings = {part: dict(own) for part, own in crowd[0].items() if part.startswith("strip")}
    for own in readings.values():
        own["deflection_mm"] = [
            one._replace(weight_g=times * one.weight_g) for one in own["deflection_mm"]
        ]
        own["swings_20_s"] = [
            one._replace(value=one.value / times**0.5, error=one.error / times**0.5)
            for one in own["swings_20_s"]
        ]
    strips, density = modulus.specimens(readings)[0], Density(1.22, 0.02)
    first = modulus.fit(modulus.specimens(crowd[0])[0], density)
    found = modulus.fit(strips, density)
    assert found.modulus == pytest.approx(times * first.modulus, rel=1e-4)
    assert found.sd == pytest.approx(times * first.sd, rel=1e-3)


def test_density_and_friction_are_recovered_and_averaged(crowd):
    for what, hidden in ((contact.density, 1e3 * DENSITY), (contact.friction, 0.25)):
        found = [what(one) for one in crowd]
        pulls = np.array([(one.value - hidden) / one.sd for one in found])
        assert abs(pulls.mean()) < 3.0 / math.sqrt(len(pulls))
        assert 0.6 < pulls.std() < 1.4
    angle = math.radians(1.0) * (1.0 + 0.25**2) / math.sqrt(6.0)
    assert np.median([contact.friction(one).sd for one in crowd]) == pytest.approx(angle, rel=0.2)


def test_creep_and_ridges_are_named(tmp_path):
    readings = {}
    for name, choices in (("creep", {"creep": 0.3}), ("ridges", {"ridges": 0.08})):
        person = Person(3, **choices)
        person.measures_strips()
        readings[name] = form.read(person.writes(tmp_path))
    found = {}
    for name, one in readings.items():
        given = modulus.specimens(one)[0], Density(1.22, 0.02)
        found[name] = modulus.ring_over_bend(*given), modulus.offset(*given), modulus.fit(*given)
    ring, _, fit = found["creep"]
    assert ring.seen
    assert ring.value == pytest.approx(1.0 / 0.7 - 1.0, abs=3.0 * ring.sd)
    assert not fit.agrees
    ring, offset, _ = found["ridges"]
    assert offset.seen
    assert offset.value == pytest.approx(-0.08, abs=3.0 * offset.sd)
    assert not ring.seen


def test_scatter_beyond_the_stated_error_counts(tmp_path):
    path = tmp_path / "m.csv"
    angles = (10.0, 18.0, 12.0, 16.0)
    path.write_text(csv_text(form.HEADER, [("block", "slides_deg", a, 0.5, "", "", "")
                                           for a in angles]))  # fmt: skip
    found = contact.friction(form.read(path))
    assert found.value == pytest.approx(math.tan(math.radians(14.0)))
    expected = np.radians(np.std(angles, ddof=1) / 2.0) * (1.0 + found.value**2)
    assert found.sd == pytest.approx(expected)


def test_a_rebound_is_that_of_a_ball_in_free_flight(tmp_path):
    # h = 10 mm, e = 0.5: the flight between landings lasts 2 e sqrt(2 h / g)
    flight = 2.0 * 0.5 * math.sqrt(2.0 * 10.0 / 9806.65)
    path = tmp_path / "m.csv"
    path.write_text(
        csv_text(form.HEADER, [("walker", "flight_s", flight, 0.001, "", "", 10.0)] * 4)
    )
    seen = contact.rebound(form.read(path))
    assert seen.measured.value == pytest.approx(0.5)
    assert seen.measured.tries == 4
    assert seen.measured.sd == pytest.approx(
        0.5 * math.hypot(0.0005 / flight, 0.5 * modulus.AT_SD_MM / 10.0)
    )
    path.write_text(csv_text(form.HEADER, [("walker", "flight_s", 0.2, 0.001, "", "", 10.0)]))
    with pytest.raises(InputError, match="seconds, and millimetres"):
        contact.rebound(form.read(path))
