"""Walkers from one word: letters, drawings, pictures, meshes. Derived values are reported and can be set."""

import io

import numpy as np
import pytest
import trimesh
from PIL import Image, ImageDraw
from test_placing import DRAWN_PATHS, svg
from typer.testing import CliRunner

import walkergen as wg
from walkergen.cli import command_line
from walkergen.core.errors import GeometryError, InputError
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.spec import name_from_text
from walkergen.files import templates
from walkergen.readers.meshes import faults
from walkergen.readers.walkers.leg_placement import UnplacedError

PAPER = templates.load("koumakis2016", "walkers", Design)


def load_shape(path, **keys):
    return templates.load(path, "walkers", Design).variant(**keys)


@pytest.mark.parametrize("text", ["ANNA", "Ünal", "Ωμέγα", "Иван", "سلام", "שלום", "Գոհար", "i"])
def test_a_name_in_any_script_stands(text):
    design = Design.from_text(text)
    solid = solids.build(design)
    faults.check_solid(solid.walker, text)
    assert solids.mass_of(design).total > 0.1
    assert any("rows" in note for note in design.notes)


def test_letters_have_the_requested_length():
    joined = Design.from_text("ANNA").variant(**{"body.length_mm": 30.0})
    assert joined.size.length == pytest.approx(30.0, abs=0.01)
    with pytest.raises(InputError, match="length_mm and depth_mm each"):
        joined.variant(**{"body.depth_mm": 8.0})


def test_a_text_names_files_of_its_own():
    assert name_from_text("Zoë Müller") == "Zoe-Muller"
    assert name_from_text("王") != name_from_text("李")


def test_a_character_missing_in_the_font_is_reported_with_a_remedy():
    with pytest.raises(GeometryError, match=r"U\+738B .* is not in the font DejaVu Sans; name .*body\.font"):
        Design.from_text("王")


def picture(path, background, ink, **saved):
    image = Image.new("L" if isinstance(ink, int) else "RGBA", (420, 300), background)
    ImageDraw.Draw(image).ellipse((60, 40, 360, 260), fill=ink)
    ImageDraw.Draw(image).ellipse((180, 120, 240, 180), fill=background)
    ImageDraw.Draw(image).rectangle((10, 10, 14, 14), fill=ink)
    image.save(path, **saved)
    return path


@pytest.mark.parametrize(
    ("name", "background", "ink"),
    [("dark.png", 250, 20), ("light.jpg", 30, 220), ("clear.png", (255, 255, 255, 0), (250, 250, 250, 255))],
)
def test_a_picture_is_traced(tmp_path, name, background, ink):
    design = load_shape(picture(tmp_path / name, background, ink))
    assert design.size.length == pytest.approx(28.0)
    assert design.size.depth == pytest.approx(28.0 * 220 / 300, rel=0.01)
    _, hole = design.shape.plan
    assert np.ptp(hole, axis=0) == pytest.approx([5.6, 5.6], rel=0.03)
    told = design.notes[0]
    assert f"traced {name}" in told
    assert "1 speck" in told
    solids.build(design)


def test_a_picture_without_a_shape_is_refused(tmp_path):
    path = tmp_path / "grey.png"
    Image.new("L", (50, 50), 128).save(path)
    with pytest.raises(InputError, match="no shape differs from the background"):
        load_shape(path).size  # noqa: B018
    path.write_bytes(b"no picture")
    with pytest.raises(InputError, match=r"grey.png"):
        load_shape(path).size  # noqa: B018


CROSSING_PATHS = {"crossed": "M0 0L20 20V0L0 20Z", "overlapping": "M0 0H20V10H0ZM10 5H30V15H10Z"}


@pytest.mark.parametrize("name", CROSSING_PATHS)
def test_paths_that_cross_or_touch_are_united(tmp_path, name):
    path = svg(tmp_path, CROSSING_PATHS[name])
    path.write_text(path.read_text().replace("<path", '<path fill="none" stroke="red" stroke-width=".1"'))
    design = load_shape(path)
    assert "united paths that cross or touch" in design.notes[0]
    solids.build(design)
    with pytest.raises(GeometryError, match="cross"):
        design.variant(**{"body.repair": False})


def test_parts_that_touch_in_a_point_are_two_pieces(tmp_path):
    path = svg(tmp_path, "M0 0L10 5L20 0V10L10 5L0 10Z")
    design = load_shape(path)
    assert (
        "touch only in a point, and stay apart there: (10, -5) mm; joined 2 pieces by a base plate" in design.notes[0]
    )
    solids.build(design)
    with pytest.raises(GeometryError, match=r"touch only in a point, at \(10, -5\) mm. Let .* body.repair"):
        design.variant(**{"body.repair": False})


def test_pieces_stand_on_a_plate_or_the_largest_is_taken(tmp_path):
    path = svg(tmp_path, "M0 0H20V10H0ZM25 0H30V10H25ZM35 5h0.1v0.1h-0.1z")
    joined, alone = load_shape(path), load_shape(path, **{"body.base": False})
    assert "left out 1 speck; joined 2 pieces by a base plate" in joined.notes[0]
    assert joined.size.length == pytest.approx(32.0, abs=0.01)
    assert "left out 1 piece other than the largest" in alone.notes[0]
    assert alone.size[::2] == pytest.approx((20.0, 10.0))


def test_mirrored_shapes_point_the_other_way(tmp_path):
    path = svg(tmp_path, DRAWN_PATHS["arrow"])
    plain, turned = load_shape(path), load_shape(path, **{"body.mirror": True})
    np.testing.assert_allclose(np.sort(plain.shape.plan[0][:, 0]), np.sort(-turned.shape.plan[0][:, 0]))


def test_a_drawing_without_a_size_is_as_long_as_the_papers_walker(tmp_path):
    path = tmp_path / "icon.svg"
    path.write_text('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 24 24"><path d="M2 2H22V20H2Z"/></svg>')
    design = load_shape(path)
    assert design.size.length == pytest.approx(28.0)
    assert "states no size" in design.notes[0]
    assert design.shape.changes == ()  # no warning: the file was taken as it is
    assert load_shape(path, **{"body.length_mm": 50.0}).size.depth == pytest.approx(45.0)


@pytest.mark.parametrize("scale", [1 / 25.4, 1e-3])
def test_a_size_in_another_unit_is_refused_with_a_question(tmp_path, scale):
    path = tmp_path / "egg.stl"
    egg = trimesh.creation.icosphere(subdivisions=2, radius=0.5)
    egg.apply_scale(20.0 * scale)
    egg.export(path)
    with pytest.raises(InputError, match=r"scale_mm = (25.4|1000)\b"):
        load_shape(path)


def test_an_unstable_shape_is_refused_with_a_remedy_that_works(tmp_path):
    path = tmp_path / "ball.stl"
    trimesh.creation.icosphere(subdivisions=2, radius=2.0).export(path)
    with pytest.raises(GeometryError, match=r"body\.base = true, or make it .* long, body\.length_mm = ") as refusal:
        load_shape(path)
    length = float(str(refusal.value).rpartition("body.length_mm = ")[2].split(",")[0])
    data = {"body.mesh": str(path)}
    for remedy in ({"body.base": True}, {"body.length_mm": length}):
        solids.build(PAPER.variant(**data, **remedy))


def test_a_remedy_set_with_an_unstable_file_works(tmp_path):
    bar = svg(tmp_path, "M0 12H40V15H0z")
    with pytest.raises(GeometryError, match=r"body\.base = true, or make it "):
        wg.predict(bar, set={"legs.tilt_deg": 12})
    with pytest.raises(InputError, match=r"body\.lenght: unknown key"):
        wg.predict(bar, set={"body.lenght": 12})
    for keys in ({"body.base": True}, {"body.length_mm": 80.0}, {"body.text": "ANNA"}):
        assert wg.check(bar, set=keys).facts["plates"] == 1


@pytest.mark.parametrize(
    ("mesh", "remedy"),
    [
        (trimesh.creation.cylinder(5.0, 30.0), {"body.up": "x", "body.forward": "z"}),
        (trimesh.creation.box([1.2, 0.8, 0.3]), {"body.scale_mm": 25.4}),
    ],
)
def test_a_mesh_may_lie_or_be_in_inches(tmp_path, mesh, remedy):
    mesh.export(tmp_path / "own.stl")
    with pytest.raises(GeometryError) as refusal:
        load_shape(tmp_path / "own.stl")
    words = " and ".join(f"{key} = {value}" for key, value in remedy.items())
    assert words in str(refusal.value)
    for tilt in (0.0, 20.0):
        solids.build(PAPER.variant(tilt_deg=tilt, **{"body.mesh": str(tmp_path / "own.stl")}, **remedy))


@pytest.mark.parametrize(("major", "minor", "turn"), [(12.0, 0.8, 0.3), (8.0, 1.2, 1.2), (9.0, 3.0, 0.3)])
def test_legs_under_a_tube_stay_within_it_or_are_not_found(tmp_path, major, minor, turn):
    mesh = trimesh.creation.torus(major, minor, major_sections=64, minor_sections=16)
    mesh.apply_transform(trimesh.transformations.rotation_matrix(turn, [0.0, 1.0, 0.0]))
    path = tmp_path / "tube.stl"
    mesh.export(path)
    try:
        design = load_shape(path)
    except UnplacedError:
        design = PAPER.variant(**{"body.mesh": str(path), "body.base": True})
    solids.build(design)


def test_one_letter_is_a_family(tmp_path):
    heart = str(svg(tmp_path, DRAWN_PATHS["heart"]))
    assert len(PAPER.variant(text="W").members()) == len(PAPER.variant(**{"body.outline": heart}).members()) == 5
    assert PAPER.variant(text="W", **{"family.tilt_deg": [5.0]}).family.tilt_deg == [5.0]


def test_a_long_body_has_more_rows_and_reports_its_lean():
    design = Design.from_text("A" * 30).variant(**{"body.rails_mm": 2.0})
    assert design.size.length > 150.0
    assert len({limb.along for limb in design.limbs}) > 2
    assert "tips over beyond" in design.notes[-1]


def test_another_shape_replaces_all_values_derived_from_the_former(tmp_path):
    path = str(svg(tmp_path, DRAWN_PATHS["heart"]))
    heart = PAPER.variant(**{"body.outline": path})
    assert heart.has_automatic_legs
    assert heart.name == "own-shape"
    assert heart.size == load_shape(tmp_path / "own shape.svg").size
    wide = PAPER.variant(**{"body.outline": path, "legs.width_mm": 5.0, "body.length_mm": 40.0, "name": "mine"})
    assert (wide.has_automatic_legs, wide.name) == (False, "mine")
    assert wide.size.length == pytest.approx(40.0)
    brush = templates.load("bristle", "walkers", Design).variant(**{"body.outline": path})
    assert brush.has_automatic_legs
    assert brush.legs.length_mm == 5.0


@pytest.mark.parametrize("shape", ["heart", "bell"])
def test_given_numbers_replace_derived_ones(tmp_path, shape):
    found = load_shape(svg(tmp_path, DRAWN_PATHS[shape]))
    numbers = found.with_explicit_leg_positions()
    assert not numbers.has_automatic_legs
    for mine, theirs in zip(numbers.limbs, found.limbs, strict=True):
        assert (mine.along, mine.across, mine.width) == pytest.approx((theirs.along, theirs.across, theirs.width))
    assert isinstance(numbers.legs, list) == (shape == "heart")


def test_cad_files_are_refused_with_the_way_to_save_a_mesh(tmp_path):
    with pytest.raises(InputError, match=r"Export it as STL"):
        load_shape(tmp_path / "part.step")


def test_python_loads_a_drawing(tmp_path):
    assert wg.load(svg(tmp_path, DRAWN_PATHS["fish"])).has_automatic_legs


def test_a_text_is_confirmed_once(monkeypatch):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    from walkergen.inputs import from_settings as inputs_of

    given = inputs_of({}, {}, ["design"])
    with pytest.raises(InputError, match="text=ANNA makes a walker"):
        given.design("ANNA")
    for answer in ("y", "n"):
        monkeypatch.setattr("sys.stdin", Terminal(f"{answer}\n"))
        monkeypatch.setattr("sys.stderr", Terminal())
        asked = given._replace(asks=True)
        if answer == "y":
            assert asked.design("ANNA").body.text == "ANNA"
        else:
            with pytest.raises(InputError):
                asked.design("ANNA")


def test_a_command_takes_a_text_and_reports_the_walker():
    shown = CliRunner().invoke(command_line, ["check", "--text", "ANNA", "--tilt", "10"], catch_exceptions=False)
    assert shown.exit_code == 0
    assert "warning" not in shown.stderr
    assert "note: ANNA: legs found" in shown.stderr


def test_an_arrow_is_engraved_on_request_and_points_forward(tmp_path):
    disc = Design.model_validate({"body": {"outline": "disc"}, "marks": {"kind": "text", "text": "→"}})
    plain, marked = solids.build(disc.unmarked), solids.build(disc)
    assert len(marked.walker.triangles) > len(plain.walker.triangles)
    floor = marked.body.vertices[np.isclose(marked.body.vertices[:, 1], 1.5 - disc.marks.depth_mm)]
    tip = floor[np.argmax(floor[:, 0])]
    assert tip[2] == pytest.approx(0.5 * (floor[:, 2].min() + floor[:, 2].max()), abs=0.5)  # a letter of the font


@pytest.mark.slow
def test_a_family_shows_the_outline_taken_from_a_picture(tmp_path):
    path = picture(tmp_path / "blob.png", 250, 20)
    wg.family(path, tilt=10, out=tmp_path / "family")
    assert (tmp_path / "family" / "taken.png").read_bytes().startswith(b"\x89PNG")


def test_a_shape_without_stable_legs_is_drawn_with_the_problem(tmp_path):
    path = tmp_path / "ball.stl"
    trimesh.creation.icosphere(subdivisions=2, radius=2.0).export(path)
    with pytest.raises(GeometryError, match=r"base = true.*A picture is in .*trouble\.png"):
        wg.family(path, out=tmp_path / "out")
    assert [found.name for found in (tmp_path / "out").iterdir() if not found.name.startswith(".")] == ["trouble.png"]
