"""Bodies from mesh files: sound ones are read unchanged, every fault is refused by its name."""

import io
import itertools
import math
import time

import hostile_meshes as hostile
import manifold3d
import numpy as np
import pytest
import trimesh
from mesh_checks import to_trimesh

from walkergen.core.errors import GeometryError, InputError
from walkergen.core.shapes import joining, modeller, stl
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import mass, solids
from walkergen.core.walker.design import Design
from walkergen.readers.drawings import crossings
from walkergen.readers.meshes import faults, repairs
from walkergen.readers.walkers import body_mesh
from walkergen.readers.walkers.body_mesh import ReadOptions
from walkergen.readers.walkers.footing import find_footing, first_hit

DUCK = hostile.duck()
BOX = hostile.box()


def refusal_of(path, **keys):
    """Return the one line of the refusal of a file."""
    with pytest.raises(InputError) as refusal:
        body_mesh.read_body(path, ReadOptions(**keys))
    (line,) = str(refusal.value).splitlines()
    assert line.startswith("body.mesh")
    return line


@pytest.mark.parametrize("kind", ["stl", "stl_ascii", "obj", "ply", "off", "3mf", "glb"])
def test_every_format_gives_the_same_body(tmp_path, kind):
    """Text formats keep eight digits, binary ones 24 bits: 1e-6 of the volume is ten times that."""
    path = tmp_path / f"duck.{kind.removesuffix('_ascii')}"
    path.write_bytes(_export_mesh(to_trimesh(DUCK), kind))
    found = body_mesh.read_body(path)
    assert found.changes == ()
    assert len(found.mesh.triangles) == len(DUCK.triangles)
    mine, theirs = mass.weigh(found.mesh, 1.0), mass.weigh(DUCK, 1.0)
    assert mine.volume == pytest.approx(theirs.volume, rel=1e-6)
    np.testing.assert_allclose(np.linalg.eigvalsh(mine.tensor), np.linalg.eigvalsh(theirs.tensor), rtol=1e-5)


def _export_mesh(mesh, kind):
    if kind == "glb":  # metres, by its standard
        mesh.apply_scale(1e-3)
    data = mesh.export(file_type=kind)
    return data.encode() if isinstance(data, str) else data


def test_axes_of_the_file_become_ours(tmp_path):
    """The duck looks forward and its head is up, whichever way the file has them."""
    path = hostile.to_stl(tmp_path / "duck.stl", DUCK)
    upright = body_mesh.read_body(path).mesh.vertices
    low, high = upright.min(axis=0), upright.max(axis=0)
    np.testing.assert_allclose(low[:2], -high[:2], atol=1e-5)
    assert low[2] == 0.0
    size = DUCK.vertices.max(axis=0) - DUCK.vertices.min(axis=0)
    np.testing.assert_allclose(high - low, size[[0, 2, 1]], rtol=1e-6)
    head = upright[np.argmax(upright[:, 1])]
    assert head[0] > 0.2 * size[0]
    fallen = DUCK.vertices[:, [2, 0, 1]]  # y is forward, x is up
    other = hostile.to_stl(tmp_path / "fallen.stl", Mesh(fallen, DUCK.triangles))
    turned = body_mesh.read_body(other, ReadOptions(up="x", forward="y")).mesh
    np.testing.assert_allclose(sorted(turned.vertices.tolist()), sorted(upright.tolist()), atol=1e-5)
    for up, forward in (("z", "x"), ("-y", "x"), ("x", "-z"), ("-z", "-y")):
        turn = body_mesh.rotation(up, forward, "key")
        assert np.linalg.det(turn) == 1.0
        np.testing.assert_array_equal(turn @ turn.T, np.eye(3))
    assert "are one axis" in refusal_of(path, up="z", forward="-z")
    assert "must be one of x, -x" in refusal_of(path, up="top")


def test_the_name_may_lead_anywhere_and_the_hash_is_the_files(tmp_path):
    hostile.to_stl(tmp_path / "duck.stl", DUCK)
    (tmp_path / "below").mkdir()
    here, there = (body_mesh.read_body(tmp_path / name) for name in ("duck.stl", "below/../duck.stl"))
    assert here.sha256 == there.sha256
    assert len(here.sha256) == 64


def test_files_without_a_mesh_are_refused(tmp_path):
    def file(name, data):
        (tmp_path / name).write_bytes(data)
        return tmp_path / name

    with pytest.raises(InputError, match="no such file"):
        body_mesh.read_body(tmp_path / "none.stl")
    assert "'.step'. Give a mesh: stl, obj" in refusal_of(file("a.step", b"ISO-10303-21;"))
    assert "is no binary STL file of" in refusal_of(file("empty.stl", b""))
    assert "is no binary STL file of 0 triangles" in refusal_of(file("zero.stl", bytes(84)))
    huge = file("huge.stl", bytes(80) + (2**32 - 1).to_bytes(4, "little") + bytes(501))
    assert "of 4294967295 triangles" in refusal_of(huge)
    garbage = np.random.default_rng(1).bytes(3000)
    for kind in ("stl", "obj", "ply", "off", "3mf", "glb"):
        line = refusal_of(file(f"garbage.{kind}", garbage))
        assert "no" in line
    assert "contains no triangles" in refusal_of(file("points.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n"))
    assert "contains no triangles" in refusal_of(file("words.stl", b"solid nothing\nendsolid nothing\n"))
    ply = b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nelement face 0\n"
    assert "is no sound PLY file: it breaks off" in refusal_of(file("claims.ply", ply + b"end_header\n1234"))
    text = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    text += b"property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    line = refusal_of(file("index.ply", text + b"0 0 0\n9 0 0\n0 9 0\n3 0 1 7\n"))
    assert "corner that does not exist" in line


def test_each_fault_is_named_with_its_numbers(tmp_path):
    def save_mesh(mesh, name="fault.stl"):
        return hostile.to_stl(tmp_path / name, mesh)

    opened = Mesh(BOX.vertices, BOX.triangles[1:])
    assert "is open: 3 edges" in refusal_of(save_mesh(opened))
    disagreeing = np.vstack([BOX.triangles[:1, ::-1], BOX.triangles[1:]])
    assert "inside out: at 3 edges" in refusal_of(save_mesh(Mesh(BOX.vertices, disagreeing)))
    assert "is inside out: its volume is -960 mm^3" in refusal_of(save_mesh(hostile.invert_mesh(BOX)))
    two = hostile.together(BOX, hostile.box(5.0, 5.0, 5.0, middle=(0.0, 20.0, 0.0)))
    assert "holds 2 bodies of 960, 125 mm^3" in refusal_of(save_mesh(two))
    edge = hostile.box(middle=(20.0, 6.0, 0.0))  # two boxes that share an edge
    assert "2 bodies" in _fault(hostile.together(BOX, edge))
    assert "belong to three triangles or more" in refusal_of(save_mesh(hostile.together(BOX, edge)))
    assert "crosses itself" in refusal_of(save_mesh(hostile.bow()))
    flat = Mesh(BOX.vertices * (1.0, 1e-12, 1.0), BOX.triangles)
    assert "encloses nothing" in refusal_of(save_mesh(flat)) or "no area" in refusal_of(save_mesh(flat))
    pointed = Mesh(BOX.vertices, np.vstack([BOX.triangles, [[0, 0, 1]]]))
    assert body_mesh.read_body(save_mesh(pointed)).changes == ("left out 1 triangle without area",)
    assert "1 triangles have no area" in _fault(pointed)
    torn = BOX.vertices.copy()
    torn[3, 1] = np.nan
    corners = torn[BOX.triangles]
    (tmp_path / "nan.stl").write_bytes(stl.pack(corners, "nan"))
    assert "a corner is not finite" in refusal_of(tmp_path / "nan.stl")
    (tmp_path / "nan.off").write_bytes(b"OFF\n3 1 0\n0 0 nan\n9 0 0\n0 inf 0\n3 0 1 2\n")
    assert "2 of 3 vertices are not finite" in refusal_of(tmp_path / "nan.off")


def _fault(mesh):
    with pytest.raises(InputError) as refusal:
        faults.check_solid(mesh, "mesh")
    return str(refusal.value)


def test_an_unlikely_size_is_refused_with_a_question_for_the_unit(tmp_path):
    def line(factor, **keys):
        mesh = Mesh(DUCK.vertices * factor, DUCK.triangles)
        return refusal_of(hostile.to_stl(tmp_path / "duck.stl", mesh), **keys)

    assert "micrometres: 28 mm, body.scale_mm = 0.001" in line(1000.0)
    told = line(1.0 / 40.0)  # both of two units that it may be in
    assert "read it in inches: 17.78 mm, body.scale_mm = 25.4" in told
    assert "centimetres: 7 mm" in told
    assert "metres: 28 mm, body.scale_mm = 1000" in line(0.001)
    assert "1..500 mm" in line(1e9)
    path = hostile.to_stl(tmp_path / "inch.stl", Mesh(DUCK.vertices / 25.4, DUCK.triangles))
    found = body_mesh.read_body(path, ReadOptions(scale_mm=25.4)).mesh
    assert mass.weigh(found, 1.0).volume == pytest.approx(mass.weigh(DUCK, 1.0).volume, rel=1e-5)


def test_a_shell_inside_a_body_is_a_cavity_and_one_outside_is_not():
    hollow = hostile.together(BOX, hostile.invert_mesh(hostile.box(2.0, 2.0, 2.0)))
    faults.check_solid(hollow, "hollow")
    assert mass.weigh(hollow, 1.0).volume == pytest.approx(952.0)
    assert modeller.count_bodies(hollow) == 1  # the check before printing
    beside = hostile.invert_mesh(hostile.box(2.0, 2.0, 2.0, middle=(30.0, 0.0, 0.0)))
    assert "second body, inside out" in _fault(hostile.together(BOX, beside))


def test_crossings_are_found_in_any_attitude_and_only_where_they_are():
    """Two boxes through each other, turned at random; depths on both sides of the tolerance."""
    rng = np.random.default_rng(5)
    for _ in range(20):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        apart = hostile.together(BOX, hostile.box(middle=(0.0, 6.0 + 1e-3, 0.0)))
        deep = hostile.together(BOX, hostile.box(15.0, 6.0, 5.0, (0.0, 6.0 - 1e-3, 0.0)))
        for mesh, crossing in ((apart, False), (deep, True)):
            vertices = mesh.vertices @ turn.T
            assert (crossings.find(vertices, mesh.triangles, 1e-5).number > 0) == crossing
            assert crossings.find(vertices, mesh.triangles, 1e-2).number == 0
    # Sides in one plane: no edge passes through a triangle, yet the boxes overlap
    aligned = hostile.together(BOX, hostile.box(middle=(7.0, 0.0, 0.0)))
    assert crossings.find(aligned.vertices, aligned.triangles, 1e-5).number > 0
    # An edge right through the diagonal of a side slips through neither of its triangles
    through = hostile.together(BOX, hostile.box(2.0, 30.0, 2.0, middle=(1.0, 0.0, 0.4)))
    assert crossings.find(through.vertices, through.triangles, 1e-5).number > 0


def test_crossings_agree_with_all_pairs():
    """Rival: every pair of triangles by a 2D-free test of edges against planes in numpy."""
    rng = np.random.default_rng(11)
    corners = rng.uniform(0.0, 10.0, (90, 1, 3)) + rng.uniform(-2.0, 2.0, (90, 3, 3))
    vertices, triangles = corners.reshape(-1, 3), np.arange(270).reshape(-1, 3)
    number = sum(
        _edges_pierce(corners[i], corners[j]) or _edges_pierce(corners[j], corners[i])
        for i in range(90)
        for j in range(i)
    )
    assert number > 10
    assert crossings.find(vertices, triangles, 1e-12).number == number


def test_crossings_at_a_crowded_corner_agree_with_all_pairs():
    """Rival: of two triangles on one corner, one's far edge passes through the other; others as above."""
    rng = np.random.default_rng(7)
    ends = rng.normal(size=(80, 1, 3)) + rng.uniform(-0.3, 0.3, (80, 2, 3))
    loose = (rng.uniform(-1.0, 1.0, (40, 1, 3)) + rng.uniform(-0.4, 0.4, (40, 3, 3))).reshape(-1, 3)
    vertices = np.vstack([[[0.3, 0.2, 0.1]], ends.reshape(-1, 3), loose])
    star = np.array([(0, 2 * k + 1, 2 * k + 2) for k in range(80)])
    triangles = rng.permutation(np.vstack([star, np.arange(161, 281).reshape(-1, 3)]))
    number = 0
    for i, j in itertools.combinations(range(len(triangles)), 2):
        pair = vertices[triangles[i]], vertices[triangles[j]]
        if triangles[i].min() == triangles[j].min() == 0:
            far = [np.roll(vertices[triangle], 2 - triangle.argmin(), axis=0) for triangle in triangles[[i, j]]]
            number += _edges_pierce(far[0], pair[1], 1) or _edges_pierce(far[1], pair[0], 1)
        else:
            number += _edges_pierce(*pair) or _edges_pierce(*pair[::-1])
    assert number > 50
    assert crossings.find(vertices, triangles, 1e-12).number == number


def test_slivers_in_one_corner_cost_no_square_of_their_number():
    """Lids of a cylinder of 2 000 and 16 000 sections: of the square 64 times, of n log n 11 times."""

    def seconds(sections):
        mesh = hostile.slivers(sections)
        times = []
        for _ in range(3):
            start = time.process_time()
            assert crossings.find(mesh.vertices, mesh.triangles, 1e-5).number == 0
            times.append(time.process_time() - start)
        return min(times)

    assert seconds(16_000) < 25.0 * seconds(2_000)


def _edges_pierce(one, other, edges=3):
    for start, end in list(zip(one, np.roll(one, -1, axis=0), strict=True))[:edges]:
        sides = np.column_stack([end - start, other[0] - other[1], other[0] - other[2]])
        share, u, v = np.linalg.solve(sides, other[0] - start)
        if 0.0 <= share <= 1.0 and u >= 0.0 and v >= 0.0 and u + v <= 1.0:
            return True
    return False


def test_repair_reports_its_changes(tmp_path):
    def repair_mesh(mesh):
        path = hostile.to_stl(tmp_path / "broken.stl", mesh)
        with pytest.raises(InputError):
            body_mesh.read_body(path)
        found = body_mesh.read_body(path, ReadOptions(repair=True))
        faults.check_solid(found.mesh, "repaired")
        return "; ".join(found.changes), mass.weigh(found.mesh, 1.0).volume

    told, volume = repair_mesh(hostile.invert_mesh(BOX))
    assert told == "turned 12 of 12 triangles; volume -960 -> 960 mm^3"
    assert volume == pytest.approx(960.0)
    told, volume = repair_mesh(Mesh(DUCK.vertices, DUCK.triangles[1:]))
    assert told.startswith("filled holes of 3 open edges by 1 triangle; volume (open) -> 1530")
    half = len(DUCK.triangles) // 2
    mixed = np.vstack([DUCK.triangles[:half, ::-1], DUCK.triangles[half:]])
    told, volume = repair_mesh(Mesh(DUCK.vertices, mixed))
    assert f"of {len(DUCK.triangles)} triangles" in told
    assert volume == pytest.approx(mass.weigh(DUCK, 1.0).volume, rel=1e-6)
    doubled = Mesh(BOX.vertices, np.vstack([BOX.triangles, BOX.triangles[4:6], [[1, 1, 2]]]))
    told, volume = repair_mesh(doubled)
    assert told.startswith("left out 1 triangle without area; dropped 2 doubled")
    crumb = hostile.box(1.0, 1.0, 1.0, middle=(0.0, 20.0, 0.0))
    told, volume = repair_mesh(hostile.together(BOX, crumb))
    assert told.startswith("dropped 1 body of 1 mm^3")
    told, volume = repair_mesh(hostile.together(BOX, hostile.box(4.0, 20.0, 4.0)))
    assert told.startswith("united 2 bodies to 1")
    assert volume == pytest.approx(960.0 + 4.0 * 14.0 * 4.0, rel=1e-6)
    torn = BOX.vertices[BOX.triangles]  # every triangle on its own, a ten-thousandth of a mm off
    torn = torn + np.random.default_rng(2).uniform(-3e-5, 3e-5, torn.shape)
    told, volume = repair_mesh(Mesh(torn.reshape(-1, 3), np.arange(36).reshape(-1, 3)))
    assert told.startswith("merged ")
    assert volume == pytest.approx(960.0, rel=1e-5)


def test_an_unrepairable_mesh_is_refused_with_the_attempts(tmp_path):
    path = hostile.to_stl(tmp_path / "bow.stl", hostile.bow())
    assert "crosses itself" in refusal_of(path, repair=True)
    floating = hostile.together(BOX, hostile.box(middle=(40.0, 0.0, 40.0)))
    with pytest.raises(GeometryError, match=r"^body\.base = true: 1 pieces float above the plate"):
        body_mesh.read_body(hostile.to_stl(tmp_path / "b.stl", floating), ReadOptions(repair=True, base=True))
    sound = body_mesh.read_body(hostile.to_stl(tmp_path / "box.stl", BOX), ReadOptions(repair=True))
    assert sound.changes == ()


def test_bodies_apart_are_joined_by_a_plate_or_the_largest_is_taken(tmp_path):
    small = hostile.box(5.0, 5.0, 8.0, middle=(0.0, 20.0, 0.0))
    path = hostile.to_stl(tmp_path / "two.stl", hostile.together(BOX, small))
    joined = body_mesh.read_body(path, ReadOptions(repair=True, base=None))
    faults.check_solid(joined.mesh, "joined")
    assert joined.changes == ("joined 2 bodies by a base plate",)
    alone = body_mesh.read_body(path, ReadOptions(repair=True))
    assert alone.changes == ("left out 1 body other than the largest",)
    assert mass.weigh(alone.mesh, 1.0).volume == pytest.approx(960.0)
    assert mass.weigh(joined.mesh, 1.0).volume > 960.0 + 200.0


def test_a_mesh_is_scaled_to_a_length_and_mirrored(tmp_path):
    path = hostile.to_stl(tmp_path / "duck.stl", DUCK)
    plain, turned = (
        body_mesh.read_body(path, ReadOptions(length_mm=40.0, mirror=mirror)).mesh for mirror in (False, True)
    )
    assert np.ptp(plain.vertices[:, 0]) == pytest.approx(40.0)
    np.testing.assert_allclose(np.sort(-plain.vertices[:, 0]), np.sort(turned.vertices[:, 0]), atol=1e-9)
    faults.check_solid(turned, "turned")


TILT = 0.3
ALONG = np.array([1.0, 0.0, 0.0])
UPWARD = np.array([math.sin(TILT), math.cos(TILT), 0.0])


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_a_leg_on_a_flat_face_against_closed_forms(scale):
    """The modeller's tolerance is relative: the same digits at any scale."""
    foot = scale * np.array([1.23, -8.0, 0.1])
    body = hostile.box(scale * 20.0, scale * 6.0, scale * 8.0)
    found = find_footing(joining.prepare_body(body), foot, UPWARD, scale * 0.4, scale * 7.0)
    rise = scale * 5.0
    expected = foot + rise / math.cos(TILT) * UPWARD
    np.testing.assert_allclose(found.anchor, expected, rtol=1e-12, atol=1e-12 * scale)
    higher = rise / math.cos(TILT) + 0.5 * scale * 0.4 * math.tan(TILT)
    assert found.reach == pytest.approx(higher, rel=1e-12)
    leg = joining.leg_prism(foot, UPWARD, scale * 0.4, scale * 7.0, found.reach + scale)
    outside, whole = (
        joining.cut_flush(leg, joining.prepare_body(body)),
        joining.unite_with_legs(joining.prepare_body(body), [leg]),
    )
    parts = [mass.weigh(mesh, 1.0).volume for mesh in (body, outside, whole)]
    assert parts[1] == pytest.approx(rise / math.cos(TILT) * 0.4 * 7.0 * scale**2, rel=1e-11)
    assert parts[2] == pytest.approx(parts[0] + parts[1], rel=1e-13)


def test_a_duck_on_legs():
    """Anchors on a slope: cut flush, nothing is lost or counted twice, and it stays one body."""
    turn = body_mesh.rotation("z", "x", "key")
    body = Mesh(DUCK.vertices @ turn.T, DUCK.triangles)
    legs = []
    for x, z in ((-6.0, 0.0), (4.0, 0.5)):
        foot = np.array([x, -10.0, z])
        found = find_footing(joining.prepare_body(body), foot, UPWARD, 0.8, 3.0)
        legs.append(joining.leg_prism(foot, UPWARD, 0.8, 3.0, found.reach + 0.5))
        assert first_hit(body.vertices[body.triangles], found.anchor + UPWARD, -UPWARD) is not None
    whole = joining.unite_with_legs(joining.prepare_body(body), legs)
    faults.check_solid(whole, "walker")
    volume = [mass.weigh(mesh, 1.0).volume for mesh in (body, whole)]
    outside = [joining.cut_flush(leg, joining.prepare_body(body)) for leg in legs]
    # Coordinates carry 16 digits; the volumes' sums lose two
    together = volume[0] + sum(mass.weigh(leg, 1.0).volume for leg in outside)
    assert volume[1] == pytest.approx(together, rel=1e-12)
    for leg in outside:
        assert leg.vertices[:, 1].min() == pytest.approx(-10.0 - 0.4 * math.sin(TILT), abs=1e-12)


@pytest.mark.parametrize("upward", [hostile.UP, UPWARD])
def test_a_leg_reaches_the_height_that_the_modeller_finds(upward):
    """Rival of the clipped triangles: what the modeller leaves of a leg below the body."""
    turn = body_mesh.rotation("z", "x", "key")
    body = joining.prepare_body(Mesh(DUCK.vertices @ turn.T, DUCK.triangles))
    foot = np.array([-3.0, -10.0, 0.3])
    found = find_footing(body, foot, upward, 0.8, 3.0)
    leg = joining.leg_prism(foot, upward, 0.8, 3.0, found.reach + 0.01)
    heights = (joining.cut_flush(leg, body).vertices - foot) @ upward
    assert heights.max() == pytest.approx(found.reach, abs=1e-9)
    assert math.isfinite(found.above)
    assert found.above > found.reach


def test_legs_that_do_not_stand_under_the_body_are_refused():
    foot, up = np.array([0.0, -8.0, 0.0]), hostile.UP
    ring = modeller.to_mesh(modeller.to_solid(BOX) - modeller.to_solid(hostile.box(3.0, 30.0, 3.0, (5.0, 0.0, 0.0))))
    with pytest.raises(GeometryError, match="misses the body"):
        find_footing(joining.prepare_body(ring), foot + 5.0 * ALONG, up, 1.0, 1.0)
    with pytest.raises(GeometryError, match="under a hole or beyond an edge"):
        find_footing(joining.prepare_body(ring), foot + 3.2 * ALONG, up, 1.0, 1.0)
    with pytest.raises(GeometryError, match="under a hole or beyond an edge"):
        find_footing(joining.prepare_body(ring), foot, up, 1.0, 9.0)
    with pytest.raises(GeometryError, match="begins within the body"):
        find_footing(joining.prepare_body(BOX), np.array([0.0, -1.0, 0.0]), up, 1.0, 1.0)
    apart = hostile.box(1.0, 4.0, 1.0, (0.0, -8.0, 0.0))
    with pytest.raises(GeometryError, match="are 2 pieces"):
        joining.unite_with_legs(joining.prepare_body(BOX), [apart])
    with pytest.raises(GeometryError, match="wholly within the body"):
        joining.cut_flush(hostile.box(1.0, 1.0, 1.0), joining.prepare_body(BOX))
    with pytest.raises(GeometryError, match=r"comes out of the body again by 4 mm\^3"):
        joining.cut_flush(hostile.box(1.0, 14.0, 1.0), joining.prepare_body(BOX))


def test_the_first_hit_slips_through_no_edge():
    """Rays at the diagonals and corners of a box's lower face."""
    for x in np.linspace(-10.0, 10.0, 41):
        start = np.array([x, -9.0, 0.4 * x])
        assert first_hit(BOX.vertices[BOX.triangles], start, hostile.UP) == pytest.approx(6.0, abs=1e-12)
    assert first_hit(BOX.vertices[BOX.triangles], np.array([11.0, -9.0, 0.0]), hostile.UP) is None


def test_trimesh_agrees_on_soundness():
    """Rival: trimesh calls closed and outward what is accepted here."""
    for mesh in (BOX, DUCK, hostile.tube([(0, 0, 0), (5, 1, 0), (9, 4, 0)])):
        faults.check_solid(mesh, "mesh")
        other = trimesh.load_mesh(io.BytesIO(stl.pack(mesh.vertices[mesh.triangles], "")), "stl")
        assert other.is_volume
        assert other.body_count == 1


def test_sound_unions_of_anything_stay_sound_in_32_bits(tmp_path):
    """What a modeller makes and STL rounds is never refused: 118 of 118 in a longer run."""
    rng = np.random.default_rng(0)
    for _ in range(15):
        parts = []
        for _ in range(4):
            shape = manifold3d.Manifold.sphere(1.0, int(rng.integers(8, 40)))
            if rng.random() < 0.5:
                shape = manifold3d.Manifold.cube((1.5, 1.5, 1.5), True)
            turned = rng.uniform(0.0, 360.0, 3) if rng.random() < 0.7 else np.zeros(3)
            shape = shape.scale(tuple(rng.uniform(5.0, 8.0, 3))).rotate(tuple(turned))
            parts.append(shape.translate(tuple(np.round(rng.uniform(-2.0, 2.0, 3)))))
        whole = manifold3d.Manifold.batch_boolean(parts, manifold3d.OpType.Add)
        assert len(whole.decompose()) == 1  # they all hold the origin
        found = body_mesh.read_body(hostile.to_stl(tmp_path / "union.stl", modeller.to_mesh(whole)))
        assert mass.weigh(found.mesh, 1.0).volume == pytest.approx(whole.volume(), rel=1e-6)


@pytest.mark.parametrize("dropped", [[0, 1, 2], [5, 6, 7, 8, 9, 40], list(range(30, 60))])
@pytest.mark.parametrize("turned", [None, 100])
def test_holes_that_touch_are_filled_each(dropped, turned):
    ball = trimesh.creation.icosphere(subdivisions=3, radius=10.0)
    triangles = np.delete(np.asarray(ball.faces, np.int64), dropped, axis=0)
    if turned is not None:
        triangles[turned] = triangles[turned][::-1]
    mesh, changes = repairs.repair(Mesh(np.asarray(ball.vertices), triangles))
    faults.check_solid(mesh, "ball")
    assert "filled holes" in "; ".join(changes)
    assert faults.shells(mesh).volumes.sum() == pytest.approx(ball.volume, rel=0.005)


def test_bodies_that_are_not_united_weigh_the_same(tmp_path):
    """A page shows a body and its legs side by side: masses and enclosed volumes are the walker's."""
    path = hostile.to_stl(tmp_path / "duck.stl", DUCK)
    design = Design.model_validate({"body": {"mesh": str(path), "length_mm": 40.0}, "legs": {"placement": "auto"}})
    united, beside = (solids.build(design, united=united) for united in (True, False))
    for one, other in zip(solids.weigh(design, united)[:2], solids.mass_of(design)[:2], strict=True):
        assert one == other
    volumes = [mass.weigh(built.walker, 1.0).volume for built in (united, beside)]
    assert volumes[0] == pytest.approx(volumes[1], rel=1e-9)
