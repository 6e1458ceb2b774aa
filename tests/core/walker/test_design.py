"""Designs from TOML: defaults, round trip, and every mistake named in one go."""

import math
import sys
from pathlib import Path

import pytest

import walkergen
from walkergen.core.errors import GeometryError, InputError
from walkergen.core.files import config
from walkergen.core.walker.design import Design
from walkergen.core.walker.spec import WalkerSpec
from walkergen.files import templates

PACKAGE = Path(walkergen.__file__).parent


def write_design(tmp_path, text, name="mine.toml"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def test_defaults_are_the_paper_template():
    paper = templates.load("koumakis2016", "walkers", Design)
    ours = Design(name="koumakis2016", description=paper.description)
    assert paper == ours


def test_a_specification_reads_no_file_and_a_design_does():
    data = {"body": {"mesh": "nowhere.stl"}, "legs": {"tilt_deg": 5.0}}
    spec = WalkerSpec.model_validate(data)
    assert (spec.kind, spec.tilt_from_keys_deg, spec.has_automatic_legs) == ("flexible", 5.0, True)
    with pytest.raises(InputError, match=r"nowhere\.stl"):
        Design.model_validate(data)


def test_toml_round_trip(tmp_path):
    design = Design.model_validate(
        {"name": "a-b_1", "legs": {"tilt_deg": 12.25, "foot": "round"}, "weighed": {"body_mass_g": 0.8}}
    )
    assert config.read_section(write_design(tmp_path, templates.to_toml(design, "mine")), Design) == design


@pytest.mark.parametrize("walker", ["koumakis2016", "bristle"])
def test_a_dump_calls_no_python_code_that_could_lose_a_ctrl_c(walker):
    """pydantic takes any exception of such a function for its failure, and goes on."""
    design, ours = templates.load(walker, "walkers", Design), []

    def record_call(frame, event, argument):
        if event == "call" and Path(frame.f_code.co_filename).is_relative_to(PACKAGE):
            ours.append(frame.f_code.co_name)

    sys.setprofile(record_call)
    try:
        data = design.model_dump(exclude_unset=True)
    finally:
        sys.setprofile(None)
    assert not ours
    assert Design.model_validate(data) == design


def test_whole_numbers_are_numbers(tmp_path):
    assert config.read_section(write_design(tmp_path, "[legs]\ntilt_deg = 12"), Design).legs.tilt_deg == 12.0


def test_name_defaults_to_the_files(tmp_path):
    assert config.read_section(write_design(tmp_path, "[legs]\ntilt_deg = 12"), Design).name == "mine"


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
            config.read_section(path, Design)


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
    with pytest.raises(GeometryError, match="legs=flexible"):
        design.members()
    assert len(design.members([5.0], ["flexible"])) == 1


@pytest.mark.parametrize("tilt", [-40.0, 0.0, 10.0, 45.0])
@pytest.mark.parametrize("foot", ["flat", "square", "round"])
def test_feet_keep_their_places_at_any_tilt(tilt, foot):
    design = Design.model_validate({"legs": {"tilt_deg": tilt, "foot": foot}})
    for limb, x in zip(design.limbs, (-6.5, 6.5), strict=True):
        assert limb.anchor[0] + limb.anchor_to_foot[0] == pytest.approx(x, abs=1e-12)
        if foot == "flat":
            assert math.hypot(*limb.anchor_to_foot) == pytest.approx(7.5, rel=1e-15)


def test_legs_are_computed_once_and_again_for_a_changed_copy():
    design = Design()
    assert design.limbs is design.limbs
    longer = design.model_copy(update={"legs": design.legs.model_copy(update={"length_mm": 9.0})})
    assert {limb.length for limb in longer.limbs} == {9.0}
    assert longer == Design.model_validate({"legs": {"length_mm": 9.0}})
