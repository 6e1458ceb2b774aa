"""The form of the page follows from the tables that check what people write."""

import itertools
import math
import pickle
import re

import pytest
import trimesh

from walkergen.app import form, slider_ranges, walker_answers
from walkergen.app.document import Document
from walkergen.core.errors import WalkergenError
from walkergen.core.walker import solids
from walkergen.files import templates
from walkergen.readers.walkers.leg_placement import UnplacedError


def document(walker="koumakis2016", **values):
    return Document(walker, "lane-90hz", "prusa-mk3s", values)


def controls(page):
    return {control.key: control for group in form.groups(page) for control in group.controls}


@pytest.mark.parametrize("walker", templates.names("walkers"))
def test_every_control_holds_the_value_of_its_key_and_limits_around_it(walker):
    found = controls(document(walker))
    assert {"body.thickness_mm", "scene.contact.friction", "printer.nozzle_mm"} <= set(found)
    for control in found.values():
        if control.kind == "number" and control.value is not None:
            low = -math.inf if control.low is None else control.low
            assert low <= control.value <= (math.inf if control.high is None else control.high)
        if control.slider:
            low, high = control.slider
            assert control.low <= low < high <= control.high
            assert low <= control.value <= high


L_SHAPE = '<svg xmlns="http://www.w3.org/2000/svg" width="41mm" height="23mm" viewBox="0 0 41 23"><path d="M0 0H41V10H30V23H0Z"/></svg>'  # noqa: E501
OWN = {"drawing": {"body.outline": "own.svg"}, "mesh": {"body.mesh": "own.stl"}, "text": {"body.text": "Ag"}}


@pytest.mark.parametrize("walker", [*templates.names("walkers"), *OWN])
def test_a_shown_value_that_is_written_leaves_the_walker_as_it_is(tmp_path, walker):
    """Within the digits of the page. Values that other keys determine are shown, too, and cannot be written."""
    (tmp_path / "own.svg").write_text(L_SHAPE)
    trimesh.creation.box((51.0, 22.0, 9.0)).export(tmp_path / "own.stl")
    values = {key: str(tmp_path / name) if "own" in name else name for key, name in OWN.get(walker, {}).items()}
    page = document(**values) if walker in OWN else document(walker)
    design, shown = page.load_design(), controls(page)
    for key, control in shown.items():
        if control.value is None or control.follows:
            continue
        again = document(page.walker, **(values | {key: control.value}))
        found = again.load_design()
        assert tuple(found.size) == pytest.approx(tuple(design.size), rel=1e-3), key
        for limb, old in zip(found.limbs, design.limbs, strict=True):
            assert (limb.along, limb.length, limb.width) == pytest.approx((old.along, old.length, old.width), rel=1e-3)
        assert again.load_scene() == page.load_scene()
        assert again.load_printer() == page.load_printer()
    if design.has_automatic_legs or design.body.text:
        assert shown["body.length_mm"].value == pytest.approx(design.size.length, rel=1e-3)


def test_limits_are_those_that_a_refusal_names():
    tilt = controls(document())["legs.tilt_deg"]
    assert (tilt.low, tilt.high, tilt.unit) == (-85.0, 85.0, "°")
    with pytest.raises(WalkergenError, match=">= -85 and <= 85"):
        document(**{"legs.tilt_deg": 89}).load_design()


def test_the_tilt_comes_first_by_the_key_that_the_legs_share():
    assert [each.key for each in form.groups(document())[0].controls] == ["legs.tilt_deg"]
    first = form.groups(document("bristle"))[0].controls
    assert [each.key for each in first] == ["leg_tilt_deg"]
    assert first[0].value == 10.0


def test_keys_that_say_nothing_of_a_shape_have_no_control():
    plain, disc = (controls(document()), controls(document(**form.body_shapes(document())["disc"]["values"])))
    assert "body.depth_mm" in plain
    assert {"body.outline", "body.mesh", "body.up"}.isdisjoint(plain)
    assert "body.outline" in disc
    assert "body.depth_mm" not in disc


def test_a_control_says_what_its_table_says():
    assert "Width across the run" in controls(document())["legs.width_mm"].help


@pytest.mark.parametrize("walker", ["koumakis2016", "maker-large", "bristle", "name"])
def test_every_other_shape_stands_on_the_legs_of_a_walker(walker):
    for name, change in form.body_shapes(document(walker)).items():
        shaped = document(change.get("walker", walker), **change["values"])
        assert shaped.load_design().limbs, name


def test_two_equal_legs_can_be_listed():
    legs = form.legs_as_list(document())
    listed = document(legs=legs, leg_tilt_deg=10.0).load_design()
    pair = document().load_design()
    assert [limb.along for limb in listed.limbs] == [limb.along for limb in pair.limbs]
    assert [limb.thickness for limb in listed.limbs] == [limb.thickness for limb in pair.limbs]


def test_sliders_end_where_a_walker_can_no_longer_be_built():
    keys = ["legs.tilt_deg", "legs.contact_spacing_mm", "body.length_mm", "scene.contact.friction", "nosuch"]
    ranges = slider_ranges.slider_ranges(document(), keys)
    assert list(ranges) == keys[:3]
    assert ranges["legs.contact_spacing_mm"][1] < 28.0  # the body's length; the key's own range goes on
    for key, ends in ranges.items():
        assert all(document(**{key: end}).load_design().limbs for end in ends)


def test_a_tilt_beyond_its_slider_makes_it_longer():
    (tilt,) = (control for control in form.groups(document(**{"legs.tilt_deg": 60.0}))[0].controls)
    assert tilt.slider == (-60.0, 60.0)


TOO_LONG = {"body": {"outline": "disc", "length_mm": 28.0, "thickness_mm": 3.0}, "legs.contact_spacing_mm": 22.0}
MESHES = [
    (trimesh.creation.icosphere(2, 2.0), ["put a plate under it", "make it 25 mm long"]),
    (trimesh.creation.cylinder(5.0, 30.0), ["lay it down", "put a plate under it"]),
    (
        trimesh.creation.box([0.9, 0.5, 0.3]),
        ["read it in inches: 22.86 mm", "read it in centimetres: 9 mm", "make it 28 mm long"],
    ),
    (None, ["place the legs automatically"]),
]


def test_a_page_offers_the_legs_of_a_mesh(tmp_path):
    """A page's walker has legs of its own, so it asks: each button gives a walker that runs."""
    parts = [trimesh.creation.box([20.0, 8.0, 2.0])]
    for x, y in itertools.product((-8.0, 8.0), (-3.0, 3.0)):
        parts.append(trimesh.creation.box([0.4, 1.0, 8.0]).apply_translation((x, y, -4.5)))
    trimesh.boolean.union(parts, engine="manifold").export(tmp_path / "own.stl")
    values = {"body.mesh": str(tmp_path / "own.stl")}
    with pytest.raises(WalkergenError) as error:
        document(**values).load_design()
    *_, last = walker_answers.format_refusal(pickle.loads(pickle.dumps(error.value.resolve_remedies())))
    assert [remedy["words"] for remedy in last["helps"]] == ["use its 4 legs", "add legs all the same"]
    for remedy, finished in zip(last["helps"], (True, False), strict=True):
        design = document(**values, **remedy["values"]).load_design()
        solids.mass_of(design)
        assert design.is_complete_mesh is finished


@pytest.mark.parametrize(("mesh", "words"), MESHES)
def test_what_helps_is_data_and_helps(tmp_path, mesh, words):
    """A refusal carries keys and values, for buttons; its words hold neither keys nor flags."""
    values = dict(TOO_LONG)
    if mesh is not None:
        mesh.export(tmp_path / "own.stl")
        values = {"body": {"mesh": str(tmp_path / "own.stl")}, "legs.placement": "auto"}
    with pytest.raises(WalkergenError) as error:
        document(**values).load_design()
    elsewhere = pickle.loads(pickle.dumps(error.value.resolve_remedies()))
    *_, last = walker_answers.format_refusal(elsewhere)
    assert [remedy["words"] for remedy in last["helps"]] == words
    assert not re.search(r"_mm|= true|--|\.\w+_|what helps|own\.stl", last["text"])
    assert walker_answers.trouble_picture(document(**values))["picture"].startswith("data:image/png;") is last["drawn"]
    assert last["drawn"] is isinstance(error.value, UnplacedError)
    for remedy in last["helps"]:
        assert all(key in str(error.value) for key, value in remedy["values"].items() if value is not None)
        body = {**values["body"], **{key[5:]: own for key, own in remedy["values"].items() if key.startswith("body.")}}
        rest = {key: own for key, own in remedy["values"].items() if not key.startswith("body.")}
        kept = {key: own for key, own in body.items() if own is not None}
        solids.mass_of(document(**{**values, "body": kept, **rest}).load_design())
