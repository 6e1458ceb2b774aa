"""A mesh that has legs stands on them: in any position of the file, and a mesh without legs gets some, as before."""

import itertools
import math

import hostile_meshes as hostile
import manifold3d
import numpy as np
import pytest

import walkergen as wg
from walkergen.core.errors import GeometryError, InputError
from walkergen.core.shapes import joining, modeller
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import solids
from walkergen.core.walker.body import Body
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.readers.walkers.body_mesh import rotation
from walkergen.readers.walkers.own_legs import find_own_legs

AXES = ("x", "-x", "y", "-y", "z", "-z")
ORIENTATIONS = [(up, forward) for up, forward in itertools.product(AXES, ("x", "y", "z")) if up[-1] != forward]


def save(folder, mesh, up="y", forward="x"):
    """Write a mesh (y up, x forward) as a file in which other axes point up and forward."""
    turn = rotation(up, forward, "key")
    path = folder / f"part{len(list(folder.iterdir()))}.stl"  # shapes are cached by their names
    return str(hostile.to_stl(path, Mesh(mesh.vertices @ turn, mesh.triangles)))


def table(tops=(20.0, 2.0, 12.0), leg=(1.0, 5.0, 2.0), spots=((-8, -4), (-8, 4), (8, -4), (8, 4))):
    """Table with its legs below, y up."""
    top, height = hostile.box(*tops), leg[1]
    legs = [hostile.box(leg[0], height + 0.4, leg[2], (x, -0.5 * (tops[1] + height) + 0.2, z)) for x, z in spots]
    return joining.unite_with_legs(joining.prepare_body(top), legs)


def same_walker(one, other, rel=1e-3):
    mine, theirs = solids.mass_of(one), solids.mass_of(other)
    assert float(mine.total) == pytest.approx(float(theirs.total), rel=rel)
    assert float(mine.J) == pytest.approx(float(theirs.J), rel=rel)
    places = [sorted((limb.along, limb.across, limb.tilt, limb.length) for limb in d.limbs) for d in (one, other)]
    np.testing.assert_allclose(*places, rtol=rel, atol=2e-3)


@pytest.mark.parametrize(("up", "forward"), ORIENTATIONS)
@pytest.mark.parametrize("kind", ["flexible", "braced"])
def test_an_exported_walker_is_the_same_in_any_position(tmp_path, kind, up, forward):
    design = Design().variant(tilt_deg=10.0, kind=kind)
    found = wg.load(save(tmp_path, solids.build(design).walker, up, forward))
    assert (found.body.up, found.body.forward, found.kind) == (up, forward, kind)
    assert found.body.legs_below_mm == pytest.approx(7.5 * math.cos(math.radians(10.0)), abs=2e-3)
    same_walker(design, found)


@pytest.mark.parametrize("tilt", [-20.0, 0.0, 3.0, 30.0])
@pytest.mark.parametrize("foot", ["flat", "square", "round"])
def test_tilts_and_feet_are_found(tmp_path, tilt, foot):
    design = Design.model_validate({"legs": {"foot": foot}}).variant(tilt_deg=tilt)
    found = wg.load(save(tmp_path, solids.build(design).walker))
    assert len(found.limbs) == 2
    assert found.body.forward == "x"
    if foot == "flat":
        same_walker(design, found)


@pytest.mark.parametrize(
    "name", ["bristle", "bristlebot", "coinbot", "maker-large", "rotator", "spinner", "unequal-legs"]
)
def test_templates_come_back_from_their_meshes(tmp_path, name):
    design = wg.load(name)
    found = wg.load(save(tmp_path, solids.build(design).walker))
    assert (len(found.limbs), found.kind, found.body.up) == (len(design.limbs), design.kind, "y")
    if not design.parts:
        same_walker(design, found)


def test_predicted_speeds_agree(tmp_path):
    """The speed of the paper's walker, and of what its file holds: the same within 1 %."""
    for kind in ("flexible", "braced"):
        design = Design().variant(tilt_deg=10.0, kind=kind)
        found = wg.load(save(tmp_path, solids.build(design).walker))
        mine, theirs = (wg.predict(each, model="known") for each in (design, found))
        assert mine.speed.number == pytest.approx(theirs.speed.number, rel=0.01)
        np.testing.assert_allclose(mine.speed.ends, theirs.speed.ends, rtol=0.01)


@pytest.mark.parametrize("up", AXES)
def test_a_table_has_four_legs_and_runs_along_its_length(tmp_path, up):
    forward = "y" if up[-1] == "x" else "x"
    found = wg.load(save(tmp_path, table(), up, forward))
    assert (found.body.up, found.body.forward, len(found.limbs)) == (up, forward, 4)
    assert found.body.legs_below_mm == pytest.approx(5.0, abs=2e-3)
    assert found.kind == "braced"
    (note,) = found.notes
    assert f"the mesh has 4 braced legs, below legs_below_mm = {found.body.legs_below_mm:g} (up = {up}" in note


def ball(*scale):
    return manifold3d.Manifold.sphere(1.0, 32).scale(scale)


def upright(solid):
    """Mesh with y up of a solid with z up."""
    return modeller.to_mesh(solid.rotate((-90.0, 0.0, 0.0)))


@pytest.mark.parametrize(
    "mesh",
    [
        upright(modeller.to_solid(hostile.duck())),
        upright(ball(14, 7, 5)),
        upright(ball(8, 5, 5).translate((-7, 0, 0)) + ball(8, 5, 5).translate((7, 0, 0))),  # two bumps
        upright(ball(9, 5, 5) + ball(3, 3, 9)),
        hostile.box(28.0, 3.0, 8.0),
        table(leg=(3.0, 0.5, 3.0)),  # stand-offs
        table(tops=(28.0, 6.0, 10.0), leg=(20.0, 1.0, 2.0), spots=((0, -3), (0, 3))),  # rails
        table(leg=(1.0, 8.0, 1.0), spots=((7, -4), (7, 4))),  # it falls over on these
    ],
)
def test_bodies_without_legs_have_none(tmp_path, mesh):
    body = Body(mesh=save(tmp_path, mesh, "z", "x"))
    assert find_own_legs(body.cache_key) == ()
    assert not wg.load(body.mesh).is_complete_mesh


def test_a_duck_on_legs_stands_on_them(tmp_path):
    turn = rotation("z", "x", "key")
    duck = Mesh(hostile.duck().vertices @ turn.T, hostile.duck().triangles)
    legs = [hostile.box(0.5, 8.0, 1.0, (x, -6.0, z)) for x in (-4.0, 4.0) for z in (-2.0, 2.0)]
    mesh = joining.unite_with_legs(joining.prepare_body(duck), legs)
    for up in ("y", "z", "-z", "-x"):
        found = wg.load(save(tmp_path, mesh, up, "y" if up == "-x" else "x"))
        assert (found.body.up, len(found.limbs)) == (up, 4)
        assert found.body.legs_below_mm == pytest.approx(5.0, abs=0.05)  # its belly is 5 mm above the feet


def test_legs_of_the_design_need_a_word(tmp_path):
    """Tilts or lengths of legs are of legs to be added: the mesh has some already, so this is asked."""
    path = save(tmp_path, solids.build(Design()).walker)
    with pytest.raises(InputError) as refusal:
        wg.load(path).variant(**{"legs.placement": None, "body.legs_below_mm": None, "legs.tilt_deg": 12.0})
    data = {"body": {"mesh": path}, "legs": {"tilt_deg": 12.0}}
    with pytest.raises(InputError) as refusal:
        Design.model_validate(data)
    assert "the mesh already stands on 2 legs. What helps: use its 2 legs" in str(refusal.value)
    own, added = refusal.value.remedies
    assert own.values["body.up"] == "y"
    assert own.values["body.legs_below_mm"] == pytest.approx(7.386)
    assert own.values["legs.kind"] == "flexible"
    assert added.values == {"legs.placement": "auto"}
    keys = {key.removeprefix("body."): value for key, value in own.values.items() if key.startswith("body.")}
    used = Design.model_validate({"body": {"mesh": path, **keys}, "legs": {"kind": own.values["legs.kind"]}})
    assert used.is_complete_mesh
    more = wg.load(path).variant(**{"legs.placement": "auto", "body.up": "y"})
    assert not more.is_complete_mesh
    assert more.has_automatic_legs


def test_a_frame_that_stands_on_any_side_is_asked(tmp_path):
    """It stands on legs as it lies in the file, or it is not known how it stands."""
    both = joining.unite_with_legs(
        joining.prepare_body(hostile.box(20.0, 2.0, 12.0)),
        [hostile.box(1.0, 12.0, 2.0, (x, 0.0, z)) for x in (-8.0, 8.0) for z in (-4.0, 4.0)],
    )
    assert wg.load(save(tmp_path, both, "z", "x")).body.up == "z"
    with pytest.raises(GeometryError, match=r"already stands on 4 legs. What helps: use its 4 legs, body.up = -?y"):
        wg.load(save(tmp_path, both, "y", "x"))


def test_a_file_in_inches_is_cut_at_its_scale(tmp_path):
    walker = solids.build(Design()).walker
    path = save(tmp_path, Mesh(walker.vertices / 25.4, walker.triangles))
    found = Design.model_validate({"body": {"mesh": path, "scale_mm": 25.4}})
    assert found.body.legs_below_mm == pytest.approx(7.386, abs=2e-3)
    same_walker(Design(), found)


def test_a_copied_file_has_its_keys(tmp_path):
    path = save(tmp_path, solids.build(Design()).walker)
    text = templates.to_toml(wg.load(path), "a walker", every=False)
    copy = tmp_path / "copy.toml"
    copy.write_text(text, encoding="utf-8")
    assert "legs_below_mm = 7.386" in text
    same_walker(wg.load(str(copy)), Design())
