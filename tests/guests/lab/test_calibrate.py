"""From readings of strips, block and walker to material and contact: recovered within their errors.

The bench that makes the readings solves the elastica and beam elements; what is known of it was
hidden from the estimates.
"""

import json
import math
import re

import calibration_bench as bench
import numpy as np
import pytest
from typer.testing import CliRunner

from walkergen.cli import command_line
from walkergen.core.errors import InputError
from walkergen.core.files.tables import csv_text
from walkergen.core.numerics.quantity import Quantity, Verdict
from walkergen.core.printing.printers import Printer
from walkergen.core.scene import Scene
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.lab import beams, drops
from walkergen.guests.lab.beams import Strip
from walkergen.guests.lab.calibrate import contact, form, make, modulus, parts, specimens
from walkergen.guests.lab.calibrate.specimens import BEND_METHOD, RING_METHOD

PAPER = templates.load("koumakis2016", "walkers", Design)
LANE = templates.load("lane-90hz", "scenes", Scene)
PRINTER = templates.load("prusa-mk3s", "printers", Printer)
STRIPS = parts.make_strips(PAPER, PRINTER)
MODULUS, DENSITY = 2.7e9, 1.22e-3
"""Hidden modulus, Pa, and density, g/mm^3."""
WEIGHED = Quantity("density", "g_cm3", 1.22, 0.02)

AIR = 0.05
"""Share of the strips that the slicer says is air; a print differs by 2 %, all strips alike."""


class Person:
    """A person with ruler, caliper and phone, whose hand is as sure as the form says."""

    def __init__(self, seed, creep=0.0, ridges=0.0):
        self.random = np.random.default_rng(seed)
        self.creep, self.ridges = creep, ridges
        self.air = 0.02 * self.random.normal()
        self.rows = []

    def reads(self, part, name, value, *beside, error=None):
        error = form.reading_kinds(part)[name].error if error is None else error
        seen = value + error * self.random.normal()
        self.rows.append((part, name, seen, error, *(beside or ("", "", ""))))

    def measures_strips(self):
        for one in STRIPS:
            drawn = one.strip
            strip = Strip(drawn.thickness * (1.0 + 0.04 * self.random.normal()), 5.05, drawn.length)
            for _ in range(3):
                self.reads(one.name, "thickness_mm", strip.thickness + self.ridges)
            self.reads(one.name, "width_mm", strip.width)
            self.rows.append((one.name, "air_percent", 100.0 * AIR, 2.0, "", "", ""))
            self.reads(one.name, "free_length_mm", strip.length)
            for weight in (one.light_g, one.heavy_g):
                self.bends(one.name, strip, weight)
            hertz = bench.rings(MODULUS, (1.0 - AIR - self.air) * DENSITY, strip)
            for _ in range(3):
                self.reads(one.name, "swings_20_s", 20.0 / hertz)

    def bends(self, name, strip, weight):
        at = strip.length - 2.0
        place = at + modulus.POSITION_SD_MM * self.random.normal()
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
    for seed in range(100, 116):
        person = Person(seed)
        person.measures_strips()
        person.measures_block()
        found.append(form.read_form(person.writes(folder)))
    return found


def fitted(readings):
    strips, notes = specimens.from_readings(readings)
    assert notes == []
    return modulus.fit(strips, contact.density(readings).number)


def assert_honest(numbers, hidden):
    """Errors are those of the numbers' scatter about what was hidden."""
    pulls = np.array([(value - hidden) / sd for value, sd in (number.pair for number in numbers)])
    assert abs(pulls.mean()) < 3.0 / math.sqrt(len(pulls))
    assert 0.6 < pulls.std() < 1.4


@pytest.mark.parametrize("load", [0.05, 0.2])
@pytest.mark.parametrize("strip", [Strip(0.4, 5.0, 50.0), Strip(1.67, 5.0, 100.0)])
def test_closed_forms_are_the_elastica_and_the_elements(strip, load):
    stiff = beams.bending_stiffness(MODULUS, strip)
    at = strip.length - 2.0
    long = beams.effective_length(at, strip)
    weight = 3.0 * load * stiff / (9806.65 * long**2)
    sunk = bench.sunk(MODULUS, strip, weight, at)
    assert beams.deflection(weight, long, stiff) == pytest.approx(sunk, rel=2e-3)
    whole = strip._replace(length=beams.effective_length(strip.length, strip))
    mass = beams.moving_mass(DENSITY, whole)
    for tip in (0.0, 0.3, 3.0):
        heard = bench.rings(MODULUS, DENSITY, strip, tip)
        assert beams.natural_frequency(stiff, mass, whole.length, tip) == pytest.approx(heard, rel=5e-4)


def test_a_modulus_is_recovered_within_its_error_and_the_error_is_honest(crowd):
    fits = [fitted(one) for one in crowd]
    assert_honest([one.number for one in fits], 1e-9 * MODULUS)
    assert np.mean([one.number.se / one.number.value for one in fits]) < 0.05  # it tells 5 %
    assert np.mean([one.chi2 / one.dof for one in fits]) == pytest.approx(1.0, abs=0.35)
    assert sum(one.agrees for one in fits) >= 13
    strips, _ = specimens.from_readings(crowd[0])
    for method in (BEND_METHOD, RING_METHOD):
        value, sd = modulus.fit(specimens.select_method(strips, method), WEIGHED).number.pair
        assert abs(value - 1e-9 * MODULUS) < 3.0 * sd


@pytest.mark.parametrize("times", [1e-2, 10.0])
def test_any_plastic_is_found_and_all_scales(crowd, times):
    # Weights times k: a modulus times k; swings as fast as its root
    strips, _ = specimens.from_readings(crowd[0])
    scaled = [
        strip._replace(
            bends=[bend._replace(weight_g=times * bend.weight_g) for bend in strip.bends],
            rings=[ring._replace(number=specimens.scale_quantity(ring.number, times**0.5)) for ring in strip.rings],
        )
        for strip in strips
    ]
    first, found = (modulus.fit(each, WEIGHED).number.pair for each in (strips, scaled))
    assert found == pytest.approx((times * first[0], times * first[1]), rel=1e-3)


def test_density_and_friction_are_recovered_and_averaged(crowd):
    for what, hidden in ((contact.density, 1e3 * DENSITY), (contact.friction, 0.25)):
        assert_honest([what(one).number for one in crowd], hidden)
    angle = math.radians(1.0) * (1.0 + 0.25**2) / math.sqrt(6.0)
    assert np.median([contact.friction(one).number.se for one in crowd]) == pytest.approx(angle, rel=0.2)


def test_creep_and_ridges_are_named(tmp_path):
    readings = {}
    for name, choices in (("creep", {"creep": 0.3}), ("ridges", {"ridges": 0.08})):
        person = Person(3, **choices)
        person.measures_strips()
        readings[name] = form.read_form(person.writes(tmp_path))
    strips, _ = specimens.from_readings(readings["creep"])
    ring = modulus.ring_excess(strips, WEIGHED)
    assert ring.compare_with_range(0.0, 0.0) is Verdict.DISAGREE
    assert ring.value == pytest.approx(100.0 * (1.0 / 0.7 - 1.0), abs=3.0 * ring.se)
    assert not modulus.fit(strips, WEIGHED).agrees
    offset = modulus.thickness_offset(specimens.from_readings(readings["ridges"])[0], WEIGHED)
    assert offset.compare_with_range(0.0, 0.0) is Verdict.DISAGREE
    assert offset.value == pytest.approx(-0.08, abs=3.0 * offset.se)


def read(folder, *rows):
    """Readings of a form with these rows."""
    path = folder / "m.csv"
    path.write_text(csv_text(form.HEADER, rows))
    return form.read_form(path)


def test_scatter_beyond_the_stated_error_counts(tmp_path):
    angles = (10.0, 18.0, 12.0, 16.0)
    value, sd = contact.friction(
        read(tmp_path, *(("block", "slides_deg", a, 0.5, "", "", "") for a in angles))
    ).number.pair
    assert value == pytest.approx(math.tan(math.radians(14.0)))
    assert sd == pytest.approx(np.radians(np.std(angles, ddof=1) / 2.0) * (1.0 + value**2))


def test_parts_that_disagree_are_said_and_have_the_error_of_their_disagreement(tmp_path):
    rows = [(part, "slides_deg", angle, 0.5, "", "", "") for part, angle in (("block", 12.0), ("walker", 16.0))]
    found = contact.friction(read(tmp_path, *rows))
    assert not found.agrees
    tangents = [math.tan(math.radians(angle)) for angle in (12.0, 16.0)]
    assert found.number.se == pytest.approx(0.5 * (tangents[1] - tangents[0]), rel=0.01)  # Birge, of two


def test_a_rebound_is_that_of_a_ball_in_free_flight(tmp_path):
    # h = 10 mm, e = 0.5: the flight between landings lasts 2 e sqrt(2 h / g)
    flight = 2.0 * 0.5 * math.sqrt(2.0 * 10.0 / 9806.65)
    seen = contact.rebound(read(tmp_path, *[("walker", "flight_s", flight, 0.001, "", "", 10.0)] * 4)).measured
    sd = 0.5 * math.hypot(0.0005 / flight, 0.5 * modulus.POSITION_SD_MM / 10.0)
    assert seen.number.pair == pytest.approx((0.5, sd))
    assert seen.tries == 4
    with pytest.raises(InputError, match="slow motion"):
        contact.rebound(read(tmp_path, ("walker", "flight_s", 0.2, 0.001, "", "", 10.0)))


@pytest.mark.parametrize("heights", [(10.0,) * 6, (10.0, 10.4, 9.6, 10.2, 9.9, 9.8)])
def test_drops_that_scatter_have_the_error_of_their_scatter(tmp_path, heights):
    ratios = 0.4 + 0.066 * np.array([-1.2, 1.0, -0.7, 1.3, 0.4, -0.8])
    flights = 2.0 * ratios * np.sqrt(2.0 * np.array(heights) / 9806.65)
    rows = [("walker", "flight_s", flight, 0.002, "", "", at) for flight, at in zip(flights, heights, strict=True)]
    se = contact.rebound(read(tmp_path, *rows)).estimate.number.se
    scatter = ratios.std(ddof=1) / math.sqrt(6)
    ruler = 0.4 * 0.5 * modulus.POSITION_SD_MM / 10.0
    # Heights that are told apart have rulers' errors of their own
    assert math.hypot(scatter, ruler / 6**0.5) <= se * 1.001
    assert se <= 1.001 * math.hypot(scatter, ruler)
    assert contact.rebound(read(tmp_path, rows[0])).spread == 0.0


MISTAKES = {
    "1/8^2: are the times of a film in slow motion": ("swings_20_s", 8.0),
    "1/4^2: are the times of a film in slow motion": ("swings_20_s", 4.0),
    "20^2: are the times of one swing": ("swings_20_s", 0.05),
    "1/1000: are the weights in kg": ("weight_g", 1e-3),
    "strip_2 gives a modulus of about 0.00": ("strip_2", 1e-3),
}


@pytest.mark.parametrize(("told", "slip"), MISTAKES.items(), ids=list(MISTAKES))
@pytest.mark.parametrize("method", ["both", "ring"])
def test_units_and_clocks_that_differ_are_refused_and_named(tmp_path, told, slip, method):
    name, times = slip
    person = Person(3)
    person.measures_strips()
    rows = []
    for part, measured, reading, error, unloaded, weight, at in person.rows:
        if measured == name:
            reading, error = times * reading, times * error
        elif measured == "deflection_mm" and name in ("weight_g", part):
            weight = times * weight
        rows.append((part, measured, reading, error, unloaded, weight, at))
    person.rows = rows
    with pytest.raises(InputError, match=re.escape(told)):
        calibrated(person.writes(tmp_path), tmp_path / "o", "--by", method)
    assert not (tmp_path / "o").exists()


def test_slow_motion_of_a_ring_alone_is_a_note_since_rubber_is_as_soft(tmp_path):
    person = Person(3)
    person.measures_strips()
    person.rows = [
        (part, name, 8.0 * reading, 8.0 * error, *beside)
        if name == "swings_20_s"
        else (part, name, reading, error, *beside)
        for part, name, reading, error, *beside in person.rows
        if name != "deflection_mm"
    ]
    result = calibrated(person.writes(tmp_path), tmp_path / "o", "--json", "--no-pictures")
    assert any("1/8^2" in note for note in json.loads(result.stdout)["notes"])


class Elastic:
    """Drops of a walker that comes up as its feet say, times a half, from the hand."""

    def __init__(self, monkeypatch):
        self.scenes, self.heights = [], []
        monkeypatch.setattr(make.drops, "rebounds_by_restitution", self.rebounds_by_restitution)

    def rebounds_by_restitution(self, scene, design, hand, progress):
        self.scenes.append((scene, design))
        self.heights.append(hand[0].height)
        return [drops.Rebounds(label, 0.5 * label, 0.05, len(hand), 0) for label in drops.RESTITUTIONS]


def calibrated(path, out, *words):
    command = ["calibrate", str(path), "--out", str(out), *words]
    return CliRunner().invoke(command_line, command, catch_exceptions=False)


def whole(folder):
    person = Person(11)
    person.measures_strips()
    person.measures_block()
    for part in ("strip_1", "strip_2"):
        person.reads(part, "swings_to_half", 3.0, error=0.1)
    flight = 2.0 * 0.4 * math.sqrt(2.0 * 10.0 / 9806.65)
    for _ in range(6):
        person.reads("walker", "flight_s", flight, "", "", 10.0, error=1e-4)
    return person.writes(folder)


def test_files_go_on_to_family_and_simulate(tmp_path, monkeypatch):
    elastic = Elastic(monkeypatch)
    result = calibrated(whole(tmp_path), tmp_path / "a", "--tilt", "10")
    assert result.exit_code == 0, result.output
    folder = tmp_path / "a" / "calibrate"
    design = templates.load(folder / "design.toml", "walkers", Design)
    scene = templates.load(folder / "scene.toml", "scenes", Scene)
    material = design.material
    pull = (material.youngs_modulus_gpa - 2.7) / material.youngs_modulus_sd_gpa
    assert abs(pull) < 3.0
    assert material.density_g_cm3 == pytest.approx(1.22, abs=0.03)
    assert scene.contact.friction == pytest.approx(0.25, abs=4.0 * scene.contact.friction_sd)
    decrement = math.log(2.0) / 3.0
    assert scene.legs.damping_ratio == pytest.approx(
        beams.damping_ratio(decrement), abs=4.0 * scene.legs.damping_ratio_sd
    )
    # Half of the label comes up: 0.4 is the label 0.8, within height and scatter
    assert scene.contact.restitution == pytest.approx(0.8, abs=0.02)
    sd = 2.0 * math.hypot(0.4 * 0.5 * modulus.POSITION_SD_MM / 10.0, 0.05 * math.sqrt(1 / 6 + 1 / 24))
    assert scene.contact.restitution_sd == pytest.approx(sd, rel=0.1)
    ((surroundings, walker),) = elastic.scenes  # drops know what else was measured
    assert surroundings.contact.friction == scene.contact.friction
    assert walker.material == material
    assert elastic.heights == [10.0]
    assert design.name == "koumakis2016-measurements"
    names = {one.name for one in folder.iterdir()}
    tables = {"calibration.csv", "calibration.md", "strips.csv", "strips.png", "strips.pdf"}
    assert names == tables | {"design.toml", "scene.toml", "manifest.json"}


def test_what_is_missing_stays_and_is_said(tmp_path):
    path = tmp_path / "m.csv"
    rows = [("block", "slides_deg", 14.0, 1.0, "", "", "")] * 3
    rows += [("strip_2", "thickness_mm", 0.8, 0.02, "", "", ""), ("strip_2", "ring_hz", 40.0, 1.0, "", "", "")]
    path.write_text(csv_text(form.HEADER, rows))
    result = calibrated(path, tmp_path / "o", "--json", "--no-pictures")
    found = json.loads(result.stdout)
    assert found["settings"].keys() == {"scene.contact.friction", "scene.contact.friction_sd"}
    told = " / ".join(found["notes"])
    for what in (
        "strip_2: no width_mm and no free_length_mm",
        "no Young's modulus",
        "no density",
        "no damping",
        "no restitution",
    ):
        assert what in told
    design = templates.load(tmp_path / "o" / "calibrate" / "design.toml", "walkers", Design)
    assert design.material == PAPER.material
    scene = templates.load(tmp_path / "o" / "calibrate" / "scene.toml", "scenes", Scene)
    assert scene.contact.restitution == LANE.contact.restitution
    assert scene.contact.friction == pytest.approx(math.tan(math.radians(14.0)), rel=1e-5)


def test_one_method_may_count_alone(tmp_path):
    person = Person(3, creep=0.3)
    person.measures_strips()
    path = person.writes(tmp_path)
    moduli = {}
    for method in ("ring", "deflection", "both"):
        result = calibrated(path, tmp_path / method, "--by", method, "--json", "--no-pictures")
        found = json.loads(result.stdout)
        moduli[method] = found["settings"]["material.youngs_modulus_gpa"]
    assert any("--by ring" in note for note in found["notes"])
    assert moduli["deflection"] < moduli["both"] < moduli["ring"]
    assert moduli["ring"] == pytest.approx(2.7, abs=0.25)
    assert moduli["deflection"] == pytest.approx(0.7 * 2.7, abs=0.25)


def test_what_the_readings_leave_open_is_not_told(crowd):
    strips, _ = specimens.from_readings(crowd[0])
    twins = [strips[0], strips[0]._replace(name="strip_9")]
    density = WEIGHED
    assert modulus.thickness_offset(specimens.select_method(twins, RING_METHOD), density) is None  # equal thicknesses
    assert modulus.thickness_offset(strips[:1], density) is None
    assert modulus.ring_excess(specimens.select_method(strips, BEND_METHOD), density) is None
    alone = modulus.fit(specimens.select_method(strips[:1], RING_METHOD), density)
    assert (alone.dof, alone.probability, alone.agrees) == (0, None, True)
