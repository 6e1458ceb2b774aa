"""Assignments KEY=VALUE: as a file's line is read, with its mistakes, and what depends on them."""

import pytest

from walkergen.core.errors import InputError
from walkergen.core.files import assignments
from walkergen.core.files.config import validate
from walkergen.core.scene import Scene
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.sweep import sweep_points

LANE = templates.load("lane-90hz", "scenes", Scene)
PAPER = templates.load("koumakis2016", "walkers", Design)
UNEQUAL = templates.load("unequal-legs", "walkers", Design)


@pytest.mark.parametrize(
    ("text", "pair"),
    [
        ("legs.tilt_deg=12", ("legs.tilt_deg", "12")),
        (" legs[2].friction = a=b ", ("legs[2].friction", "a=b")),
        ("marks.text=", None),
        ("legs tilt=1", None),
        ("legs.=1", None),
        (".legs=1", None),
        ("legs[12345].tilt_deg=1", None),
        ("légs=1", ("légs", "1")),
        ("a=" + "1" * 10_000, None),
    ],
)
def test_key_and_value_are_separated(text, pair):
    if pair:
        assert assignments.split_key_value(text) == pair
        return
    with pytest.raises(InputError, match=r"write KEY=VALUE|At most 10000"):
        assignments.split_key_value(text)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("12", 12),
        ("-1.5e3", -1500.0),
        ("true", True),
        (".217", 0.217),
        ("-5.", -5.0),
        ("-.5e1", -5.0),
        (".", "."),
        ("braced", "braced"),
        ('"12"', "12"),
        ("[1, 2]", [1, 2]),
        ("{a = 1}", {"a": 1}),
        ("07", "07"),
        ("1\nother = 2", "1\nother = 2"),
        ("1\n[table]", "1\n[table]"),
    ],
)
def test_a_value_is_tomls_or_the_text(text, value):
    found = assignments.parse_value(text)
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize("text", ["[" * 5000, "[braced]", "{a = }"])
def test_invalid_lists_are_refused(text):
    with pytest.raises(InputError, match="is not a list or table of TOML"):
        assignments.parse_value(text)


def test_an_unknown_key_names_the_one_that_is_most_like_it():
    with pytest.raises(InputError, match=r"^--set a: unknown key. Did you mean legs\.tilt_deg\?$"):
        assignments.check_key("legs.tlit_deg", Design, "--set a")
    assignments.check_key("legs[2].tilt_deg", Design, "--set a")


def test_a_changed_design_is_the_file_with_that_line():
    found = assignments.replace_values(PAPER, {"legs.tilt_deg": 12, "marks.kind": "none"})
    data = PAPER.model_dump(exclude_unset=True)
    data["legs"]["tilt_deg"] = 12
    data.setdefault("marks", {})["kind"] = "none"
    assert found == validate(data, Design, "rival")
    assert PAPER == templates.load("koumakis2016", "walkers", Design)  # the old one is as it was


def test_entries_are_numbered_from_one():
    found = assignments.replace_values(UNEQUAL, {"legs[2].friction": 0.125})
    frictions = [leg.friction for leg in UNEQUAL.legs]
    assert [leg.friction for leg in found.legs] == [frictions[0], 0.125, *frictions[2:]]


DRIVES = [
    {"frequency_hz": 90.0, "gamma": 1.8},
    {"frequency_hz": 90.0, "amplitude_um": 55.2},
    {"amplitude_um": 55.2, "peak_speed_mm_s": 31.2},
    {"peak_speed_mm_s": 31.2, "gamma": 1.8},
    {"amplitude_um": 55.2, "gamma": 1.8, "second_harmonic_ratio": 0.1},
]
NUMBERS = {
    "frequency_hz": lambda drive: drive.frequency,
    "amplitude_um": lambda drive: 1e3 * drive.amplitude,
    "peak_speed_mm_s": lambda drive: drive.peak_speed,
    "gamma": lambda drive: drive.peak_gamma,
}
close = pytest.approx


@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("key", ["amplitude_um", "peak_speed_mm_s", "gamma"])
def test_one_number_of_the_drive_leaves_the_frequency(drive, key):
    scene = Scene.model_validate({"drive": drive})
    value = 1.7 * NUMBERS[key](scene.drive)
    found = assignments.replace_values(scene, {f"drive.{key}": value}).drive
    assert NUMBERS[key](found) == close(value)
    assert found.frequency == close(scene.drive.frequency)
    # At one frequency the other two are proportional to it.
    assert found.amplitude / scene.drive.amplitude == close(1.7)
    assert found.peak_gamma / scene.drive.peak_gamma == close(1.7)
    assert found.second_harmonic_ratio == scene.drive.second_harmonic_ratio


@pytest.mark.parametrize("drive", DRIVES)
def test_the_frequency_leaves_the_acceleration(drive):
    scene = Scene.model_validate({"drive": drive})
    found = assignments.replace_values(scene, {"drive.frequency_hz": 45.0}).drive
    assert found.frequency == 45.0
    assert found.peak_gamma == close(scene.drive.peak_gamma)
    assert found.amplitude == close(scene.drive.amplitude * (scene.drive.frequency / 45.0) ** 2)


@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("first", NUMBERS)
@pytest.mark.parametrize("second", NUMBERS)
def test_two_numbers_of_the_drive_are_both_set(drive, first, second):
    if first == second:
        return
    scene = Scene.model_validate({"drive": drive})
    wanted = Scene.model_validate({"drive": {"frequency_hz": 70.0, "gamma": 2.4}}).drive
    values = {f"drive.{key}": NUMBERS[key](wanted) for key in (first, second)}
    found = assignments.replace_values(scene, values).drive
    for number in NUMBERS.values():
        assert number(found) == close(number(wanted))


def test_three_numbers_of_the_drive_must_agree():
    good = {"drive.frequency_hz": 90, "drive.gamma": 1.8, "drive.amplitude_um": 55.2}
    assert assignments.replace_values(LANE, good).drive.amplitude == close(0.0552)
    with pytest.raises(InputError, match="contradicts"):
        assignments.replace_values(LANE, good | {"drive.amplitude_um": 70})


def test_setting_the_drive_changes_nothing_else_of_the_scene():
    found = assignments.replace_values(LANE, {"drive.gamma": 2.2})
    assert found.model_copy(update={"drive": LANE.drive}) == LANE


def test_keys_of_the_scene_reach_the_scene_and_messages_name_it():
    design, scene = sweep_points.change_keys(PAPER, LANE, {"scene.legs.damping_ratio": 0.1, "legs.tilt_deg": 12})
    assert (scene.legs.damping_ratio, design.tilt_deg) == (0.1, 12)
    with pytest.raises(InputError, match=r"^set: scene\.contact\.friction = -1: must be"):
        sweep_points.change_keys(PAPER, LANE, {"scene.contact.friction": -1})


@pytest.mark.parametrize(
    "keys", [{"legs.tilt_deg": 100.0, "body.depth_mm": -1.0}, {"legs.tilt_deg": 80.0}, {"legs": 3}]
)
def test_an_error_names_the_key_at_fault_of_each_line(keys):
    with pytest.raises(InputError) as refused:
        PAPER.variant(**keys)
    assert sorted(refused.value.keys) == sorted(keys)
    assert len(str(refused.value).splitlines()) == len(keys)
