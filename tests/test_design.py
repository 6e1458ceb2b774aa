"""Designs from TOML: defaults, round trip, and every mistake named in one go."""

import math
import sys
from pathlib import Path

import pytest

import walkergen
from walkergen.errors import GeometryError, InputError
from walkergen.files import config, templates
from walkergen.walker.design import Design

PACKAGE = Path(walkergen.__file__).parent


def written(tmp_path, text, name="mine.toml"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def mistakes(tmp_path, text):
    with pytest.raises(InputError) as caught:
        config.read(written(tmp_path, text), Design)
    return str(caught.value).splitlines()


def test_defaults_are_the_paper_template():
    paper = templates.load("koumakis2016", "walkers", Design)
    ours = Design(name="koumakis2016", description=paper.description)
    assert paper == ours


def test_toml_round_trip(tmp_path):
    design = Design.model_validate(
        {"name": "a-b_1", "legs": {"tilt_deg": 12.25, "foot": "round"}, "weighed": {"body_mass_g": 0.8}}
    )
    assert config.read(written(tmp_path, templates.dump(design, "mine")), Design) == design


@pytest.mark.parametrize("walker", ["koumakis2016", "bristle"])
def test_a_dump_runs_no_python_of_ours_in_which_a_ctrl_c_would_be_lost(walker):
    """pydantic takes any exception of such a function for its failure, and goes on."""
    design, ours = templates.load(walker, "walkers", Design), []

    def called(frame, event, argument):
        if event == "call" and Path(frame.f_code.co_filename).is_relative_to(PACKAGE):
            ours.append(frame.f_code.co_name)

    sys.setprofile(called)
    try:
        data = design.model_dump(exclude_unset=True)
    finally:
        sys.setprofile(None)
    assert not ours
    assert Design.model_validate(data) == design


def test_whole_numbers_are_numbers(tmp_path):
    assert config.read(written(tmp_path, "[legs]\ntilt_deg = 12"), Design).legs.tilt_deg == 12.0


def test_name_defaults_to_the_files(tmp_path):
    assert config.read(written(tmp_path, "[legs]\ntilt_deg = 12"), Design).name == "mine"


def test_all_mistakes_at_once_with_line_key_value_and_range(tmp_path):
    lines = mistakes(
        tmp_path,
        'name = "../x"\n[body]\nlength_mm = "ten"\ndepth_mm = nan\nthickness_mm = [1]\n'
        '[legs]\ntilt = 3\nkind = "soft"\nlength_mm = -1\nflexible_thickness_mm = 1e300\n'
        "[material]\ndensity_g_cm3 = 0\nyoungs_modulus_gpa = inf\n[bodi]\nx = 1\n",
    )
    expected = [
        ("mine.toml:1: name = '../x'", ""),
        ("mine.toml:3: body.length_mm = 'ten'", "must be a number >= 1e-06 and <= 1e+06"),
        ("mine.toml:4: body.depth_mm = nan", ">= 1e-06"),
        ("mine.toml:5: body.thickness_mm = [1]", ">= 1e-06"),
        ("mine.toml:8: legs.kind = 'soft'", "'flexible', 'braced'"),
        ("mine.toml:9: legs.length_mm = -1", ">= 1e-06"),
        ("mine.toml:10: legs.flexible_thickness_mm = 1e+300", "<= 1e+06"),
        ("mine.toml:7: legs.tilt", "did you mean legs.tilt_deg?"),
        ("mine.toml:12: material.density_g_cm3 = 0", ">= 0.001"),
        ("mine.toml:13: material.youngs_modulus_gpa = inf", ">= 1e-06"),
        ("mine.toml:14: bodi", "did you mean body?"),
    ]
    assert len(lines) == len(expected)
    for start, hint in expected:
        assert any(start in line and hint in line for line in lines), (start, lines)


@pytest.mark.parametrize("value", ["true", '"1"', "[]", "{}", "nan", "inf", "-inf", "0", "-1", "1e300"])
def test_numbers_are_strict(tmp_path, value):
    (line,) = mistakes(tmp_path, f"[body]\nlength_mm = {value}\n")
    assert "mine.toml:2: body.length_mm" in line


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("", "sets nothing"),
        ("# only a comment\n", "sets nothing"),
        ("body = 3", "must be a table"),
        ("[body\n", "not valid TOML"),
        ("a = " + "[" * 20000, "not valid TOML"),
        ("[legs]\ntilt_deg = 1\ntilt_deg = 2\n", "not valid TOML"),
    ],
)
def test_unusable_files(tmp_path, text, word):
    lines = mistakes(tmp_path, text)
    assert len(lines) == 1
    assert word in lines[0]


def test_files_that_are_not_text(tmp_path):
    binary = tmp_path / "binary.toml"
    binary.write_bytes(bytes(range(256)))
    huge = tmp_path / "huge.toml"
    with huge.open("wb") as stream:
        stream.truncate(100_000_000)
    for path, word in [
        (binary, "UTF-8"),
        (huge, "bytes"),
        (tmp_path, "folder"),
        (tmp_path / "none.toml", "no such"),
        (tmp_path / ("x" * 300 + ".toml"), "too long"),
        (tmp_path / "a\0b.toml", "control"),
    ]:
        with pytest.raises(InputError, match=word):
            config.read(path, Design)


@pytest.mark.parametrize(
    ("legs", "kind", "word"),
    [
        ({"tilt_deg": 70.0}, "flexible", "leaves the body"),
        ({"tilt_deg": -70.0}, "flexible", "leaves the body"),
        ({"contact_spacing_mm": 28.0}, "flexible", "leaves the body"),
        ({"contact_spacing_mm": 0.3}, "flexible", "run into each other"),
        ({"contact_spacing_mm": 3.0, "tilt_deg": 30.0}, "braced", "crosses the other leg's brace"),
        ({"brace_thickness_mm": 1.5}, "braced", "thicker than the foot"),
        ({"length_mm": 0.2, "foot": "round"}, "flexible", "no side left"),
        ({"length_mm": 0.3, "foot": "square", "tilt_deg": 60.0}, "flexible", "no side left"),
    ],
)
def test_impossible_geometry_is_refused_with_the_limit(legs, kind, word):
    with pytest.raises(GeometryError, match=word):
        Design.model_validate({"legs": {**legs, "kind": kind}})


def test_the_limit_named_is_the_limit():
    with pytest.raises(GeometryError, match=r"up to 68.16 deg") as caught:
        Design().variant(tilt_deg=70.0)
    assert "14.000 mm" in str(caught.value)
    Design().variant(tilt_deg=68.16)
    with pytest.raises(GeometryError):
        Design().variant(tilt_deg=68.18)


def test_a_family_is_checked_before_any_member_is_made():
    with pytest.raises(GeometryError) as caught:
        Design().members([0.0, 10.0, 65.0, 70.0])
    lines = str(caught.value).splitlines()
    assert len(lines) == 3  # braced at 65 and 70, flexible at 70
    members = Design().members([0.0, 10.0])
    assert [(m.legs.kind, m.legs.tilt_deg) for m in members] == [
        ("flexible", 0.0),
        ("flexible", 10.0),
        ("braced", 0.0),
        ("braced", 10.0),
    ]


def test_a_weighed_leg_belongs_to_one_kind():
    design = Design.model_validate({"weighed": {"leg_mass_g": 0.03}})
    with pytest.raises(GeometryError, match="--legs flexible"):
        design.members()
    assert len(design.members([5.0], ["flexible"])) == 1


@pytest.mark.parametrize("tilt", [-40.0, 0.0, 10.0, 45.0])
@pytest.mark.parametrize("foot", ["flat", "square", "round"])
def test_feet_stay_where_they_are_whatever_the_tilt(tilt, foot):
    design = Design.model_validate({"legs": {"tilt_deg": tilt, "foot": foot}})
    for limb, x in zip(design.limbs, (-6.5, 6.5), strict=True):
        assert limb.anchor[0] + limb.anchor_to_foot[0] == pytest.approx(x, abs=1e-12)
        if foot == "flat":
            assert math.hypot(*limb.anchor_to_foot) == pytest.approx(7.5, rel=1e-15)


def test_impossible_geometry_in_a_file_names_the_line(tmp_path):
    (line,) = mistakes(tmp_path, "[legs]\nfoot = 'flat'\ntilt_deg = 70.0\n")
    assert "mine.toml:3: legs.tilt_deg = 70 (flexible): a leg leaves the body" in line


def test_legs_are_computed_once_and_anew_for_a_copy_with_others():
    design = Design()
    assert design.limbs is design.limbs
    longer = design.model_copy(update={"legs": design.legs.model_copy(update={"length_mm": 9.0})})
    assert {limb.length for limb in longer.limbs} == {9.0}
    assert longer == Design.model_validate({"legs": {"length_mm": 9.0}})
