"""Prints of any walker: how it lies, what the checks tell of it, what is written."""

import io
import json
import math

import numpy as np
import pytest
import shapely
import trimesh
from typer.testing import CliRunner

from walkergen.cli import command_line
from walkergen.commands.export import make as exports
from walkergen.commands.export import profile
from walkergen.commands.family import figures, preview
from walkergen.commands.family import make as families
from walkergen.commands.family.chart_data import ChartData
from walkergen.core.errors import GeometryError, InputError
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.printing import checks, plates, print_sheet, supports, walls
from walkergen.core.printing.printers import Printer
from walkergen.core.scene import Scene
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import solids, weighed_masses
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import weigh
from walkergen.files import templates
from walkergen.points import members as predictions
from walkergen.points import speed_table
from walkergen.readers.drawings import outlines
from walkergen.sheets import plate_map

MK3S = templates.load("prusa-mk3s", "printers", Printer)
PAPER = templates.load("koumakis2016", "walkers", Design)
SCENE = templates.load("plane-90hz", "scenes", Scene)


def leg(along, **keys):
    return {"along_mm": along, "tilt_deg": 10.0, "width_mm": 4.0} | keys


def design_of(body=None, legs=None, **keys):
    data = {"name": "it", "legs": legs or [leg(-5.0), leg(5.0)], **keys}
    return Design.model_validate(data | ({"body": body} if body else {}))


DISC = design_of({"outline": "disc", "length_mm": 20.0, "thickness_mm": 2.0})
PROFILE = design_of(
    {"profile_mm": [[-14, 0], [-8, -1], [8, -1], [14, 0], [10, 3], [-12, 3]], "depth_mm": 8.0},
    legs={"contact_spacing_mm": 13.0},
)
NARROW = design_of({"length_mm": 24.0})
UNLIKE = design_of(
    legs=[
        {"along_mm": -6.0, "kind": "braced", "thickness_mm": 1.0},
        {"along_mm": 6.0, "thickness_mm": 0.5, "tilt_deg": 20.0, "length_mm": 7.8601},
    ]
)


def ball(tmp_path, **keys):
    """Design of an own mesh: a ball of 16 mm diameter."""
    path = tmp_path / "ball.stl"
    trimesh.creation.icosphere(subdivisions=3, radius=8.0).export(path)
    legs = {"width_mm": 2.0, "contact_spacing_mm": 4.0, "length_mm": 6.0, "tilt_deg": 0.0}
    return design_of({"mesh": str(path), **keys}, legs=legs)


def printed(design):
    return solids.orient_for_print(design, solids.build(design).walker)


def told(design, printer=MK3S):
    return checks.check_part("it", design, printed(design), printer)


def lines(design, printer=MK3S):
    return [f"{one.level} {one.line}" for one in told(design, printer)]


@pytest.mark.parametrize("design", [DISC, NARROW, PROFILE, UNLIKE, PAPER])
def test_as_printed_is_the_walker_turned_on_the_bed(design):
    standing = solids.build(design).walker
    lying = solids.orient_for_print(design, standing)
    before, after = (weigh(mesh, 1.0) for mesh in (standing, lying))
    assert after.volume == pytest.approx(before.volume, rel=1e-12)  # a mirror would change its sign
    assert np.linalg.eigvalsh(after.tensor) == pytest.approx(np.linalg.eigvalsh(before.tensor))
    assert lying.vertices[:, 2].min() == 0.0
    if solids.is_printed_on_side(design):
        assert lying is standing  # today's walkers keep their bytes
    else:  # feet on top, all at one height
        feet = lying.vertices[:, 2] > lying.vertices[:, 2].max() - 1e-9
        assert feet.sum() >= 8


def test_legs_narrower_than_a_body_in_side_view_print_upright_unless_they_lie_on_the_bed():
    assert not solids.is_printed_on_side(NARROW)
    flush = [leg(-5.0, across_mm=-2.0), leg(5.0, across_mm=-2.0)]
    assert solids.is_printed_on_side(design_of({"length_mm": 24.0}, flush))
    other_side = [leg(-5.0, across_mm=2.0), leg(5.0, across_mm=2.0)]
    assert not solids.is_printed_on_side(design_of({"length_mm": 24.0}, other_side))
    assert (solids.is_printed_on_side(PROFILE), solids.is_printed_on_side(DISC)) == (True, False)


def test_the_sheet_says_how_each_design_lies():
    (one,) = print_sheet.orientation_settings([PAPER], [False])
    assert (one.name, one.value) == ("orientation", "as in the file: on its side, no supports")
    both = print_sheet.orientation_settings([PAPER, DISC], [False, False])
    assert [row.name for row in both] == ["orientation of koumakis2016", "orientation of it"]
    assert both[1].value.endswith("legs up, no supports")


@pytest.mark.parametrize(("tilt", "level"), [(45.0, False), (45.1, True), (-60.0, True)])
def test_legs_tilted_by_more_than_45_deg_hang_over_air(tilt, level):
    body = {"outline": "ellipse", "length_mm": 60.0, "depth_mm": 30.0}
    legs = [leg(-9.0, tilt_deg=tilt, thickness_mm=1.2), leg(9.0, tilt_deg=tilt, thickness_mm=1.2)]
    seen = [one for one in told(design_of(body, legs)) if "over air" in one.what]
    assert [(one.level, round(one.seen, 6)) for one in seen] == [("warning", abs(tilt))] * level


def test_a_staircase_is_a_step_of_more_than_half_the_leg():
    def warned(tilt):
        legs = [leg(-5.0, tilt_deg=tilt), leg(5.0, tilt_deg=tilt)]
        body = {"outline": "disc", "length_mm": 40.0}
        coarse = MK3S.model_copy(update={"layer_height_mm": 0.25})
        return [one for one in told(design_of(body, legs), coarse) if "staircase" in one.what]

    edge = math.degrees(math.atan(0.2 / 0.25))  # 0.25 tan = half of 0.4
    assert warned(edge - 0.1) == []
    (one,) = warned(edge + 0.1)
    assert one.level == "warning"
    assert (one.seen, one.limit) == (pytest.approx(0.2, rel=0.01), 0.2)


def test_upright_legs_are_advised_as_softer_unless_the_spread_of_e_says_so():
    def softer(design):
        return [one.level for one in told(design) if "across their layers" in one.what]

    assert softer(DISC) == ["advice"]
    body = {"outline": "disc", "length_mm": 20.0}
    assert softer(design_of(body, material={"youngs_modulus_sd_gpa": 0.6})) == []
    assert softer(PAPER) == []


def test_overhang_of_a_ball_is_that_of_the_closed_form(tmp_path):
    """A sphere looks down by more than 45 deg below 45 deg from its pole: 2 pi r^2 (1 - cos)."""
    design = ball(tmp_path)
    cap = 2.0 * math.pi * 64.0 * (1.0 - math.cos(math.pi / 4.0))
    # 5 %: whole triangles of 1.2 mm belong to the cap or not
    assert supports.overhang_area(design, printed(design)) == pytest.approx(cap, rel=0.05)
    (warning,) = [one for one in told(design) if "over air" in one.what]
    assert "turn the mesh by body.up" in warning.change
    for flat in (DISC, NARROW):
        assert supports.overhang_area(flat, printed(flat)) == 0.0


def test_the_first_layer_is_a_section_at_half_its_height(tmp_path):
    """The circle in which a ball of radius r is cut: pi h (2 r - h); prisms have their profile."""
    mesh = trimesh.creation.icosphere(subdivisions=4, radius=8.0)
    lying = Mesh(mesh.vertices, np.asarray(mesh.faces, dtype=np.int64))
    # 2 %: the polyhedron lies inside the ball
    assert supports.section_area(lying, 1.0) == pytest.approx(math.pi * 15.0, rel=0.02)
    assert supports.section_area(lying, 8.0 + 1e-3) == pytest.approx(
        mesh.section([0, 0, 1], [0, 0, 1e-3]).to_2D()[0].area, rel=1e-6
    )
    assert supports.section_area(lying, 17.0) == 0.0
    area = shapely.Polygon(profile.side_profile(PROFILE)[0]).area
    assert supports.section_area(printed(PROFILE), 0.1) == pytest.approx(area, rel=1e-9)


def test_findings_name_the_leg_where_legs_differ():
    thin = design_of(legs=[{"along_mm": -6.0}, {"along_mm": 6.0, "thickness_mm": 0.2}])
    assert any(one.startswith("error it: legs[2] is thinner than") for one in lines(thin))
    assert not any("legs[1] is thinner" in one for one in lines(thin))
    braced = design_of(
        legs=[{"along_mm": -6.0}, {"along_mm": 6.0, "kind": "braced", "tilt_deg": 8.0, "length_mm": 7.4586}]
    )
    assert any("window between leg and brace of legs[2] may fuse" in one for one in lines(braced))
    names = [wall.name for wall in walls.upright_walls(UNLIKE)]
    assert names == ["legs[1]", "legs[2]", "brace of legs[1]", "body"]
    assert [wall.name for wall in walls.upright_walls(PAPER)] == ["leg", "body"]


def test_layers_lie_along_what_prints_upright():
    def about(design):
        return [one.what for one in told(design) if "whole number of layers" in one.what]

    assert about(design_of({"outline": "disc", "length_mm": 20.0, "thickness_mm": 2.1})) == [
        "the body's thickness is not a whole number of layers"
    ]
    assert about(DISC) == []
    flush = [leg(-5.0, across_mm=-2.05, width_mm=3.9), leg(5.0)]
    flush[1]["across_mm"] = -2.0
    assert about(design_of({"length_mm": 24.0}, flush)) == ["the width of legs[1] is not a whole number of layers"]


def test_repairs_of_a_mesh_are_told(tmp_path):
    path = tmp_path / "flipped.stl"
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=8.0)
    mesh.invert()
    mesh.export(path)
    keys = {"width_mm": 2.0, "contact_spacing_mm": 4.0, "length_mm": 6.0, "tilt_deg": 0.0}
    design = design_of({"mesh": str(path), "repair": True}, legs=keys)
    (warning,) = [one for one in told(design) if "not taken as it is" in one.what]
    assert warning.level == "warning"
    facts = print_sheet.body_facts(design)
    assert facts["changes"] == list(design.shape.changes) != []
    assert len(facts["sha256"]) == 64


def test_the_sheet_weighs_every_distinct_leg():
    built = solids.build(UNLIKE)
    weight = print_sheet.expected_masses("it", UNLIKE, built, MK3S)
    density = 1e-3 * UNLIKE.material.density_g_cm3
    assert [(name, leg.mesh_g) for leg, name in weight.legs] == [
        ("legs[1]", pytest.approx(weigh(built.legs[0], density).mass, abs=1e-7)),
        ("legs[2]", pytest.approx(weigh(built.legs[1], density).mass, abs=1e-7)),
    ]
    assert [name for _, name in print_sheet.expected_masses("it", PAPER, solids.build(PAPER), MK3S).legs] == ["leg"]


def test_a_weighed_leg_is_the_mean_of_unlike_legs():
    three = design_of(legs=[leg(-6.0), leg(0.0, width_mm=2.0), leg(6.0)])
    built = solids.build(three)
    meshed = solids.weigh(three, built)
    whole, body = (Quantity("mass", "g", 1.1 * mass, se) for mass, se in ((meshed.total, 0.002), (meshed.M, 0.001)))
    known = weighed_masses.Weighings(grams=whole, body_g=body)
    found = solids.weigh(weighed_masses.apply_masses(three, built, known, "it"), built)
    assert found.total == pytest.approx(1.1 * meshed.total, rel=1e-12)
    each = [own.m / mesh.m for own, mesh in zip(found.legs, meshed.legs, strict=True)]
    assert each == pytest.approx([1.1] * 3, rel=1e-9)
    parts = weighed_masses.Weighings(body_g=known.body_g, leg_g=Quantity("mass", "g", 0.03, 0.002))
    assert weighed_masses.mass_with_error(1.0, parts, 3).se == pytest.approx(math.hypot(0.001, 0.006))


@pytest.mark.parametrize("design", [DISC, NARROW, PAPER, UNLIKE, PROFILE, *PAPER.members([45.0, -40.0], ["flexible"])])
def test_labels_lie_on_their_part_beside_its_legs(design):
    mesh = printed(design)
    room = (
        plate_map._fit_between_legs
        if design.has_legs_table and solids.is_printed_on_side(design)
        else plate_map._fit_on_part
    )
    letters = 4
    x, y, height = room(design, mesh, letters)
    half = 0.5 * plate_map.LETTER_WIDTH_RATIO * letters * height
    box = shapely.box(x - half, y - 0.5 * height, x + half, y + 0.5 * height)
    view = plate_map._top_view(design, mesh)
    whole, legs = (
        shapely.union_all([shapely.Polygon(corners) for corners in triangles]) for triangles in (view.walker, view.legs)
    )
    assert height > 1.0
    if room is plate_map._fit_on_part:
        # 1 %: the circle that holds the label is found to a hundredth of the part's size
        assert whole.difference(legs).buffer(0.05).contains(box)
    else:
        assert whole.intersection(box).area == 0.0


def test_the_map_shows_the_outline_and_the_legs_on_it():
    view = plate_map._top_view(DISC, printed(DISC))
    whole, legs = (
        sum(shapely.Polygon(corners).area for corners in triangles) for triangles in (view.walker, view.legs)
    )
    assert whole == pytest.approx(weigh(solids.build(DISC).body, 1.0).volume / 2.0, rel=1e-5)
    reach = 7.5 * math.sin(math.radians(10.0)) + 0.4 / math.cos(math.radians(10.0))
    # Above the sliver of CLEAR_MM that is left out
    assert legs == pytest.approx(2 * 4.0 * reach, rel=1e-3)


def test_previews_show_bodies_in_plan_view_from_higher_above():
    parts = [preview.Part(design, solids.build(design).walker) for design in (DISC, PAPER)]
    assert [part.view is preview.TOP_CAMERA for part in parts] == [True, False]
    assert [part.label for part in parts] == ["flexible", "10° flexible"]
    (faces,) = preview.preview_figure(parts, "both").axes[0].collections
    alone = [preview.preview_figure([part], "one").axes[0].collections[0] for part in parts]
    assert len(faces.get_paths()) == sum(len(part.get_paths()) for part in alone)


@pytest.mark.parametrize("count", [3, 41])
def test_previews_keep_the_order_of_the_table_and_have_a_ruler(count):
    mesh = solids.build(PAPER).walker
    members = PAPER.members([float(tilt) for tilt in range(count)], None)
    parts = [preview.Part(design, mesh) for design in members]
    figure = preview.preview_figure(parts, "all")
    (axes,) = figure.axes
    *labels, ruler = axes.texts
    assert [label.get_text() for label in labels] == [part.label for part in parts]
    places = [label.xy for label in labels]
    assert sorted(places, key=lambda place: (-place[1], place[0])) == places
    assert ruler.get_text() == "10 mm along the body"
    (bar,) = axes.lines
    (x0, x1), (y0, y1) = bar.get_data()
    along = preview.SIDE_CAMERA[:2, 0] * 10.0  # of the projection, not of the paper
    assert (x1 - x0, y1 - y0) == pytest.approx(tuple(along))
    assert min(label.get_fontsize() for label in axes.texts) >= 7.0
    width = figure.get_figwidth() * 150.0  # pixels: letters of 5 of them were too small to read
    assert labels[0].get_fontsize() / 72.0 * 150.0 / width > 0.009


def test_drawings_are_the_profile_or_the_outline(tmp_path):
    (plan,) = profile.drawing_outlines(DISC)
    assert shapely.Polygon(plan).area == pytest.approx(math.pi * 100.0, rel=1e-4)
    paths = exports.make([PROFILE], ["dxf", "svg"], tmp_path, lambda *_: None).files
    area = weigh(solids.build(PROFILE).walker, 1.0).volume / PROFILE.size.depth
    for path in paths:
        (drawn,) = outlines.from_file(path).polygons
        assert outlines.area(drawn) == pytest.approx(area, rel=1e-9)


@pytest.mark.parametrize(("design", "why"), [(NARROW, "narrower"), (None, "a mesh")])
def test_walkers_without_a_profile_are_refused_before_anything_is_written(tmp_path, design, why):
    design = ball(tmp_path) if design is None else design
    folder = tmp_path / "out"
    with pytest.raises(InputError, match=rf"{why}.*Export it as stl or 3mf"):
        exports.make([PAPER, design], ["stl", "svg"], folder, lambda *_: None)
    assert not folder.exists()


def test_exports_lie_as_they_print(tmp_path):
    stl, _ = exports.make([DISC], ["stl", "3mf"], tmp_path, lambda *_: None).files
    found = trimesh.load_mesh(io.BytesIO(stl.read_bytes()), file_type="stl")
    assert found.is_volume
    assert found.bounds[0][2] == 0.0
    assert found.extents == pytest.approx(np.ptp(printed(DISC).vertices, axis=0), abs=1e-5)


def test_a_single_walker_has_points_with_bounds_and_no_curve(tmp_path):
    runner = CliRunner()
    path = tmp_path / "two.toml"
    path.write_text(
        '[[legs]]\nkind = "braced"\ntilt_deg = 0\nalong_mm = -6.5\nfriction = 0.1\n'
        '[[legs]]\nkind = "braced"\ntilt_deg = 0\nalong_mm = 6.5\nfriction = 0.6\n'
    )
    out = tmp_path / "out"
    result = runner.invoke(command_line, ["family", str(path), "--out", str(out), "--json"])
    assert result.exit_code == 0, result.output
    (row,) = json.loads(result.stdout)["rows"]
    assert row["legs"] == "braced"
    page = (out / "family.md").read_text()
    assert "balanced factor" in page
    assert "mean factor" not in page
    assert (out / "speed.png").is_file()
    manifest = json.loads((out / "manifest.json").read_text())
    assert manifest["body"] == {"sha256": "", "changes": []}
    assert "mean factor" in speed_table.caption(PAPER, SCENE, "coulomb")


def test_curves_are_drawn_only_where_walkers_can_be_built(monkeypatch):
    members = PAPER.members([5.0, 10.0], ["flexible"])
    family = families.FamilyInputs(PAPER, members, [1, 1], SCENE, MK3S, {}, None, [])
    built = [solids.build(one) for one in members]
    made = list(predictions.predict_members(members, built, SCENE, "coulomb"))
    monkeypatch.setattr(families.prediction, "predict_curve", lambda *asked: asked[-2:])
    assert families._curves(family, "coulomb", made) == {"flexible": (5.0, 10.0)}
    assert families._curves(family, "coulomb", made[:1]) == {"flexible": (-5.0, 15.0)}  # alone: and around it

    def refuse(*_):
        raise GeometryError("a hole in between")

    monkeypatch.setattr(families.prediction, "predict_curve", refuse)
    assert families._curves(family, "coulomb", made) == {}
    figure = figures.speed_figure([one.row for one in made], ChartData({}), "points")
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["flexible, 68 and 95 %"]
    alone = figures.speed_figure([made[0].row], ChartData({}), "a point")
    low, high = alone.axes[0].get_xlim()
    assert (low, high) == (0.0, 10.0)


def test_check_tells_the_orientation(tmp_path):
    path = tmp_path / "disc.toml"
    path.write_text('[body]\noutline = "disc"\nlength_mm = 20\n[legs]\nwidth_mm = 4\ncontact_spacing_mm = 10\n')
    result = CliRunner().invoke(command_line, ["check", str(path), "--tilt", "10", "--json"])
    assert result.exit_code == 0, result.exception
    assert json.loads(result.stdout)["orientations"] == [f"{print_sheet.LEGS_UP_TEXT}, no supports"]
    (place,) = plates.layout_without_plates([DISC], [solids.build(DISC)], [1], MK3S).parts
    assert place.height == pytest.approx(2.0 + 7.5 * math.cos(math.radians(10.0)))
