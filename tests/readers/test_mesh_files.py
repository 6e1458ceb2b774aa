"""Mesh files as people's programs write them: the right volume, notes on omitted parts, refused zip bombs."""

import json
import time
import zipfile

import numpy as np
import pytest
import trimesh

from walkergen.commands.check.weighing import weigh
from walkergen.core.errors import InputError
from walkergen.readers.meshes import meshes, polygons

BOX = trimesh.creation.box((28.0, 8.0, 3.0))
VOLUME = 672.0
MODEL = (
    '<?xml version="1.0" encoding="UTF-8"?><model unit="millimeter" '
    'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources>{}</resources>'
    "<build>{}</build></model>"
)
TYPES = (
    '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" '
    'ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" '
    'ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
)
RELATIONS = (
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship '
    'Target="/3D/3dmodel.model" Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>'
    "</Relationships>"
)


MICROSOFT = "http://schemas.microsoft.com/3dmanufacturing/"


def mesh_xml(*solids):
    whole = trimesh.util.concatenate(solids)
    corners = "".join(f'<vertex x="{x!r}" y="{y!r}" z="{z!r}"/>' for x, y, z in whole.vertices.tolist())
    faces = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in whole.faces.tolist())
    return f"<mesh><vertices>{corners}</vertices><triangles>{faces}</triangles></mesh>"


def archive(folder, objects, items, **notes):
    path = folder / "part.3mf"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as written:
        written.writestr("[Content_Types].xml", TYPES)
        written.writestr("_rels/.rels", RELATIONS)
        written.writestr("3D/3dmodel.model", MODEL.format(objects, items))
        for name, text in notes.items():
            written.writestr(f"Metadata/{name}.config", text)
    return path


def volume_note(kind, first, last):
    return (
        f'<volume firstid="{first}" lastid="{last}"><metadata type="volume" key="volume_type" value="{kind}"/></volume>'
    )


POST = trimesh.creation.box((4.0, 4.0, 3.0))
THROUGH = trimesh.creation.box((4.0, 4.0, 40.0))


@pytest.mark.parametrize(
    ("kind", "expected", "note"),
    [
        ("NegativeVolume", VOLUME - 48.0, "cut 1 negative volumes away"),
        ("ParameterModifier", VOLUME, "left out 1 part that does not print"),
        ("SupportEnforcer", VOLUME, "left out 1 part that does not print"),
    ],
)
def test_volumes_that_slicers_note_are_not_printed(tmp_path, kind, expected, note):
    config = f'<config><object id="1">{volume_note("ModelPart", 0, 11)}{volume_note(kind, 12, 23)}</object></config>'
    shapes = f'<object id="1" type="model">{mesh_xml(BOX, THROUGH)}</object>'
    path = archive(tmp_path, shapes, '<item objectid="1"/>', Slic3r_PE_model=config)
    weighed = weigh(path, 1.24, 1.0)
    assert weighed.total.volume_mm3 == pytest.approx(expected, rel=1e-6)  # 32-bit floats
    assert weighed.notes == (note,)


def test_parts_of_bambu_are_cut_away(tmp_path):
    parts = [f'<object id="{at}" type="model">{mesh_xml(solid)}</object>' for at, solid in ((1, BOX), (2, THROUGH))]
    both = '<component objectid="1"/><component objectid="2"/>'
    whole = f'<object id="3" type="model"><components>{both}</components></object>'
    kinds = '<part id="1" subtype="normal_part"/><part id="2" subtype="negative_part"/>'
    config = f'<config><object id="3">{kinds}</object></config>'
    path = archive(tmp_path, "".join(parts) + whole, '<item objectid="3"/>', model_settings=config)
    assert weigh(path, 1.24, 1.0).total.volume_mm3 == pytest.approx(VOLUME - 48.0, rel=1e-6)


def test_parts_that_bambu_cuts_away_may_be_of_the_type_other(tmp_path):
    """As BambuStudio and OrcaSlicer write it: the type of all that is no part of the model."""
    parts = (
        f'<object id="1" type="model">{mesh_xml(BOX)}</object><object id="2" type="other">{mesh_xml(THROUGH)}</object>'
    )
    whole = '<object id="3"><components><component objectid="1"/><component objectid="2"/></components></object>'
    for kind, expected in (("negative_part", VOLUME - 48.0), ("modifier_part", VOLUME)):
        config = f'<config><object id="3"><part id="1"/><part id="2" subtype="{kind}"/></object></config>'
        path = archive(tmp_path, parts + whole, '<item objectid="3"/>', model_settings=config)
        assert weigh(path, 1.24, 1.0).total.volume_mm3 == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("name", ["support_mesh", "infill_mesh", "cutting_mesh", "anti_overhang_mesh"])
@pytest.mark.parametrize(("word", "printed"), [("True", 1), ("False", 2)])
def test_settings_of_cura_mark_parts_that_are_not_printed(tmp_path, name, word, printed):
    for note in (
        f'<metadatagroup><metadata name="cura:{name}" type="xs:boolean">{word}</metadata></metadatagroup>',
        f'<settings xmlns="cura"><setting key="{name}">{word}</setting></settings>',
    ):
        shapes = f'<object id="1">{mesh_xml(BOX)}</object><object id="2">{note}{mesh_xml(BOX)}</object>'
        weighed = weigh(archive(tmp_path, shapes, '<item objectid="1"/><item objectid="2"/>'), 1.24, 1.0)
        assert weighed.total.volume_mm3 == pytest.approx(printed * VOLUME, rel=1e-6)


@pytest.mark.parametrize(
    ("attributes", "told"),
    [
        ('xmlns:x="http://x/production/2015/06" requiredextensions="x"', "requires 'http://x/production/2015/06'"),
        (f'xmlns:d="{MICROSOFT}displacement/2023/10" requiredextensions="d"', "displacement/2023/10', which walkergen"),
        (f'xmlns:m="{MICROSOFT}material/2099/01" requiredextensions="m"', "material/2099/01', which walkergen"),
        ('xmlns:b="http://x/beamlattice/2017/02" requiredextensions="b"', "requires 'http://x/beamlattice/2017/02'"),
        ('requiredextensions="q"', "requires 'q'"),
        *(
            (f'xmlns:p="{MICROSOFT}{name}" requiredextensions="p"', None)
            for name in ("production/2015/06", "material/2015/02", "slice/2015/07", "trianglesets/2021/07")
        ),
    ],
)
def test_extensions_that_change_meshes_are_named(tmp_path, monkeypatch, attributes, told):
    monkeypatch.setitem(globals(), "MODEL", MODEL.replace("<model ", f"<model {attributes} "))
    path = archive(tmp_path, f'<object id="1">{mesh_xml(BOX)}</object>', '<item objectid="1"/>')
    if told:
        with pytest.raises(InputError, match=told):
            meshes.read_mesh(path, "part")
    else:
        assert weigh(path, 1.24, 1.0).total.volume_mm3 == pytest.approx(VOLUME, rel=1e-6)


def test_lattices_and_units_that_differ_are_named(tmp_path):
    beams = mesh_xml(BOX).replace("</mesh>", '<beamlattice><beams><beam v1="0" v2="1"/></beams></beamlattice></mesh>')
    path = archive(tmp_path, f'<object id="1">{beams}</object>', '<item objectid="1"/>')
    with pytest.raises(InputError, match="holds a lattice of beams"):
        meshes.read_mesh(path, "part")
    placed = '<object id="1"><components><component path="/3D/o.model" objectid="7" x:path="/3D/o.model" xmlns:x="x"/>'
    path = archive(tmp_path, f"{placed}</components></object>", '<item objectid="1"/>')
    with zipfile.ZipFile(path, "a") as more:
        inner = MODEL.format(f'<object id="7">{mesh_xml(BOX)}</object>', "")
        more.writestr("3D/o.model", inner.replace("millimeter", "inch"))
    with pytest.raises(InputError, match=r"'3d/o\.model' is in inch, the model that places it in millimeter"):
        meshes.read_mesh(path, "part")


@pytest.mark.parametrize("resolution", ["", 's:meshresolution="lowres"', 's:meshresolution="fullres"'])
def test_slices_beside_a_stand_in_are_refused(tmp_path, resolution):
    """Official samples state no resolution, and their meshes are boxes around the slices."""
    slices = f'xmlns:s="{MICROSOFT}slice/2015/07" s:slicestackid="1" {resolution}'
    shapes = f'<object id="2" name="ball" {slices}>{mesh_xml(BOX)}</object><object id="3">{mesh_xml(POST)}</object>'
    whole = archive(tmp_path, shapes, '<item objectid="2"/>')
    if "fullres" in resolution:
        assert weigh(whole, 1.24, 1.0).total.volume_mm3 == pytest.approx(VOLUME, rel=1e-6)
    else:
        with pytest.raises(InputError, match="object 2 'ball' is given by slices, its mesh may be a stand-in"):
            meshes.read_mesh(whole, "part")
    unused = archive(tmp_path, shapes, '<item objectid="3"/>')
    assert weigh(unused, 1.24, 1.0).total.volume_mm3 == pytest.approx(48.0, rel=1e-6)


def test_supports_are_not_weighed(tmp_path):
    shapes = (
        f'<object id="1" type="model">{mesh_xml(BOX)}</object><object id="2" type="support">{mesh_xml(POST)}</object>'
    )
    weighed = weigh(archive(tmp_path, shapes, '<item objectid="1"/><item objectid="2"/>'), 1.24, 1.0)
    assert weighed.total.volume_mm3 == pytest.approx(VOLUME, rel=1e-6)
    assert weighed.notes == ("left out 1 part that does not print",)


@pytest.mark.parametrize("word", ["0", "false"])
def test_items_that_are_switched_off_are_not_weighed(tmp_path, word):
    shapes = "".join(f'<object id="{at}">{mesh_xml(solid)}</object>' for at, solid in ((1, BOX), (2, POST)))
    items = f'<item objectid="1" printable="1"/><item objectid="2" printable="{word}"/>'
    weighed = weigh(archive(tmp_path, shapes, items), 1.24, 1.0)
    assert weighed.total.volume_mm3 == pytest.approx(VOLUME, rel=1e-6)
    assert weighed.notes == ("left out 1 part that does not print",)


def write_nested_mesh(folder, levels, written="{}"):
    """3MF of a post in a component, ten times in another, and so on."""
    objects = [f'<object id="1" type="model">{mesh_xml(POST)}</object>']
    for level in range(2, levels + 2):
        inner = f'<component objectid="{written.format(level - 1)}"/>' * 10
        objects.append(f'<object id="{level}" type="model"><components>{inner}</components></object>')
    return archive(folder, "".join(objects), f'<item objectid="{written.format(levels + 1)}"/>')


def test_components_within_components_are_read(tmp_path):
    assert weigh(write_nested_mesh(tmp_path, 2), 1.0, 1.0).total.volume_mm3 == pytest.approx(100.0 * 48.0)


@pytest.mark.parametrize(
    ("levels", "written", "reason"),
    [
        *((7, written, "places more than 10000 meshes") for written in ("{}", "0{}", "+{}", " {}")),
        (20, "{}", "more than 16 deep"),
    ],
)
def test_bombs_are_refused_before_they_are_placed(tmp_path, levels, written, reason):
    path = write_nested_mesh(tmp_path, levels, written)
    begun = time.process_time()
    with pytest.raises(InputError, match=reason):
        meshes.read_mesh(path, "bomb")
    assert time.process_time() - begun < 5.0  # the meshes themselves would take minutes


def test_items_are_counted_and_must_exist(tmp_path):
    shape = f'<object id="1" type="model">{mesh_xml(POST)}</object>'
    with pytest.raises(InputError, match="places more than 10000 meshes"):
        meshes.read_mesh(archive(tmp_path, shape, '<item objectid="1"/>' * 20_000), "items")
    with pytest.raises(InputError, match="an object 7 that it does not hold"):
        meshes.read_mesh(archive(tmp_path, shape, '<item objectid="7"/>'), "items")
    path = archive(tmp_path, shape, '<item objectid="1"/>' * 2000)
    with pytest.raises(InputError, match="places 24000 triangles, at most 20000"):
        meshes.threemf.read_parts(path.read_bytes(), "items", 20_000)


UTF16 = MODEL.replace("UTF-8", "UTF-16")
IN_ITSELF = '<components><component objectid="1"/></components>'


@pytest.mark.parametrize(
    ("target", "model", "objects", "reason"),
    [
        ("3D/other.xml", MODEL, '<object id="1">{}</object>', ""),
        ("3D/3dmodel.model", UTF16, '<object id="1">{}</object>', ""),
        ("3D/gone.model", MODEL, "", "refers to '3d/gone.model', which it does not hold"),
        ("3D/3dmodel.model", "<!DOCTYPE model>" + MODEL[38:], "", "document type"),
        ("3D/3dmodel.model", MODEL.replace("millimeter", "parsec"), "", "unit 'parsec': must be one of micron"),
        ("3D/3dmodel.model", MODEL, '<object id="1"><components/></object>', "is no mesh"),
        ("3D/3dmodel.model", MODEL, '<object id="1">{0}</object><object id="1">{0}</object>', "two objects 1"),
        ("3D/3dmodel.model", MODEL, f'<object id="1">{IN_ITSELF}</object>', "more than 16 deep"),
        ("3D/3dmodel.model", MODEL, '<object id="x">{}</object>', "not a readable 3mf mesh"),
    ],
)
def test_models_of_any_archive_are_found_and_counted(tmp_path, target, model, objects, reason):
    """All paths lead through one reading: what it does not count is not placed."""
    path = tmp_path / "part.3mf"
    text = model.format(objects.format(mesh_xml(BOX)), '<item objectid="1"/>')
    with zipfile.ZipFile(path, "w") as written:
        written.writestr("_rels/.rels", RELATIONS.replace("3D/3dmodel.model", target))
        written.writestr(target.replace("gone", "3dmodel"), text.encode("utf-16" if model is UTF16 else "utf-8"))
    if reason:
        with pytest.raises(InputError, match=reason):
            meshes.read_mesh(path, "part")
    else:
        assert weigh(path, 1.24, 1.0).total.volume_mm3 == pytest.approx(VOLUME, rel=1e-12)


def test_glb_of_zeros_that_it_does_not_hold_is_refused(tmp_path):
    path = tmp_path / "zeros.glb"
    tree = b'{"accessors":[{"count":900000000,"componentType":5126,"type":"VEC3"}],"meshes":[],"nodes":[]}'
    tree += b" " * (-len(tree) % 4)
    sizes = [(20 + len(tree)).to_bytes(4, "little"), len(tree).to_bytes(4, "little")]
    path.write_bytes(b"glTF" + (2).to_bytes(4, "little") + sizes[0] + sizes[1] + b"JSON" + tree)
    with pytest.raises(InputError, match="300000000 triangles, at most"):
        meshes.read_mesh(path, "zeros")


BINARY, TEXT = BOX.export(file_type="stl"), trimesh.exchange.stl.export_stl_ascii(BOX).encode()


def binary_stl(count):
    return BINARY[:80] + count.to_bytes(4, "little") + BINARY[84:]


@pytest.mark.parametrize(
    ("data", "note"),
    [
        (BINARY, ()),
        (TEXT, ()),
        (b"\xef\xbb\xbf" + TEXT, ()),
        (TEXT.title(), ()),
        (BINARY + bytes(10), ("left out 10 bytes after its triangles",)),
        (binary_stl(0), ("its count of triangles is not filled in: 12 by its length",)),
        (binary_stl(2**32 - 1), ("its count of triangles is not filled in: 12 by its length",)),
        (b"solid of a program" + BINARY[18:], ()),
        (b"solid facet normal" + BINARY[18:] + bytes(3), ("left out 3 bytes after its triangles",)),
    ],
)
def test_stl_of_any_program(tmp_path, data, note):
    path = tmp_path / "box.stl"
    path.write_bytes(data)
    weighed = weigh(path, 1.24, 1.0)
    assert weighed.total.volume_mm3 == pytest.approx(VOLUME, rel=1e-12)
    assert weighed.notes == note


def test_corners_that_differ_in_the_last_bit_are_one(tmp_path):
    corners = np.asarray(BOX.triangles, np.float32)
    random = np.random.default_rng(1)
    corners = np.where(random.random(corners.shape) < 0.5, np.nextafter(corners, np.float32(99.0)), corners)
    loose = trimesh.Trimesh(corners.reshape(-1, 3), np.arange(36).reshape(-1, 3), process=False)
    path = tmp_path / "box.stl"
    path.write_bytes(loose.export(file_type="stl"))
    weighed = weigh(path, 1.24, 1.0)
    assert weighed.total.volume_mm3 == pytest.approx(VOLUME, rel=1e-6)
    assert "differ by rounding alone" in weighed.notes[0]


@pytest.mark.parametrize("start", range(8))
def test_concave_faces_are_cut_as_they_lie(tmp_path, start):
    outline = [(0, 0), (28, 0), (28, 8), (24, 8), (24, 3), (4, 3), (4, 8), (0, 8)]
    outline = outline[start:] + outline[:start]
    lines = [f"v {x} {y} {z}" for z in (0, 3) for x, y in outline]
    lines.append("f " + " ".join(str(at) for at in range(8, 0, -1)))
    lines.append("f " + " ".join(f"{at}/1/1" for at in range(-8, 0)))
    lines += [f"f {at + 1} {(at + 1) % 8 + 1} {(at + 1) % 8 + 9} {at + 9}" for at in range(8)]
    path = tmp_path / "u.obj"
    path.write_text("\n".join(lines))
    assert weigh(path, 1.24, 1.0).total.volume_mm3 == pytest.approx(372.0, rel=1e-12)


@pytest.mark.parametrize(
    "written", ["f {} {} {} # a", " f  {} {} {}", "f\t{}\t{}/1 {}", "f {} \\\n{} {}", "f {}//1 {}//1 {}//1"]
)
@pytest.mark.parametrize("corner", ["v {} {} {}", "v\t{} {} {} 1.0", "  v {} {} {} # corner"])
def test_lines_of_obj_are_read_however_they_are_spaced(tmp_path, written, corner):
    """Rules of the format; trimesh ignores such lines silently."""
    lines = [corner.format(*place) for place in BOX.vertices.tolist()]
    lines += [written.format(*(at + 1 for at in face)) for face in BOX.faces.tolist()]
    path = tmp_path / "box.obj"
    path.write_text("\n".join(lines))
    assert weigh(path, 1.24, 1.0).total.volume_mm3 == pytest.approx(VOLUME, rel=1e-12)


def test_glb_is_in_metres(tmp_path):
    path = tmp_path / "box.glb"
    scene = trimesh.Scene(trimesh.Trimesh(BOX.vertices / 1000.0, BOX.faces, process=False))
    path.write_bytes(scene.export(file_type="glb"))
    assert weigh(path, 1.24, 1.0).total.volume_mm3 == pytest.approx(VOLUME, rel=1e-6)


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ({"extensionsUsed": ["KHR_draco_mesh_compression"]}, "is packed by KHR_draco_mesh_compression"),
        ({"extensionsRequired": ["EXT_mesh_gpu_instancing"]}, "is packed by EXT_mesh_gpu_instancing"),
        ({"nodes": [{"mesh": 0, "skin": 0}]}, "has a skeleton"),
        ({"nodes": [{"mesh": 0, "weights": [0.0, 1.0]}]}, "is morphed"),
    ],
)
def test_glb_that_is_more_than_plain_meshes_is_named(tmp_path, more, told):
    data = trimesh.Scene(BOX).export(file_type="glb")
    size = int.from_bytes(data[12:16], "little")
    tree = json.dumps(json.loads(data[20 : 20 + size]) | more).encode()
    tree += b" " * (-len(tree) % 4)
    rest = data[20 + size :]
    whole = [one.to_bytes(4, "little") for one in (20 + len(tree) + len(rest), len(tree))]
    path = tmp_path / "box.glb"
    path.write_bytes(data[:8] + whole[0] + whole[1] + b"JSON" + tree + rest)
    with pytest.raises(InputError, match=told):
        meshes.read_mesh(path, "box")


def test_an_unlikely_size_is_reported_when_a_mesh_is_weighed(tmp_path):
    path = tmp_path / "box.stl"
    path.write_bytes(trimesh.Trimesh(BOX.vertices / 1000.0, BOX.faces).export(file_type="stl"))
    assert weigh(path, 1.24, 1000.0).notes == ()
    assert weigh(path, 1.24, 1.0).notes == (
        "The longest side is 0.028 mm. It would be 28 mm in metres (‹scale=›1000).",
    )
    path.write_bytes(trimesh.Trimesh(BOX.vertices / 25.4, BOX.faces).export(file_type="stl"))
    assert "It would be 28 mm in inches (‹scale=›25.4), or 11.02 mm in centimetres" in weigh(path, 1.24, 1.0).notes[-1]
    assert weigh(path, 1.24, 25.4).notes == ()


def boxes(*places, sizes=None):
    sizes = sizes or [1.0] * len(places)
    solids = [trimesh.creation.box((4.0 * size, 4.0 * size, 4.0 * size)) for size in sizes]
    for solid, place in zip(solids, places, strict=True):
        solid.apply_translation(place)
    return solids


@pytest.mark.parametrize(
    ("solids", "volume", "note"),
    [
        (boxes((0, 0, 0), (9, 0, 0)), 128.0, "2 bodies"),
        (boxes(*((9 * x, 9 * y, 0) for x in range(5) for y in range(4))), 20 * 64.0, "20 bodies"),
        (boxes((0, 0, 0), (4, 4, 0)), 128.0, None),  # they share an edge, which four triangles have
        (boxes((0, 0, 0), (4, 4, 4)), 128.0, "2 bodies"),  # they share a corner
        (boxes((0, 0, 0), (2, 2, 2)), 128.0, "What overlaps counts twice."),
    ],
)
def test_closed_meshes_of_several_bodies_are_weighed(tmp_path, solids, volume, note):
    path = tmp_path / "several.stl"
    path.write_bytes(trimesh.util.concatenate(solids).export(file_type="stl"))
    weighed = weigh(path, 1.24, 1.0)
    assert weighed.total.volume_mm3 == pytest.approx(volume, rel=1e-6)
    assert any(note in each for each in weighed.notes) if note else weighed.notes == ()


def test_cavities_count_for_the_body_around_them(tmp_path):
    outer, cavity, inner, beside = boxes((0, 0, 0), (0, 0, 0), (0, 0, 0), (30, 0, 0), sizes=(3.0, 2.0, 1.0, 1.0))
    cavity.invert()
    path = tmp_path / "nested.stl"

    def read(*solids):
        path.write_bytes(trimesh.util.concatenate(solids).export(file_type="stl"))
        return weigh(path, 1.24, 1.0)

    assert read(outer, cavity).total.volume_mm3 == pytest.approx(64.0 * 19.0)
    nested = read(beside, inner, cavity, outer)  # a ball in a rattle
    assert nested.total.volume_mm3 == pytest.approx(64.0 * 21.0)
    assert "3 bodies" in nested.notes
    with pytest.raises(InputError, match="holds a body within another at"):
        read(outer, inner)
    beside.invert()
    with pytest.raises(InputError, match="holds a second body, inside out, at"):
        read(outer, beside)
    open_box = trimesh.Trimesh(outer.vertices, outer.faces[1:], process=False)
    with pytest.raises(InputError, match="is open: 3 edges"):
        read(open_box, inner)


def test_too_many_triangles_are_refused_before_reading(tmp_path, monkeypatch):
    monkeypatch.setattr(polygons, "MAX_TRIANGLES", 11)
    for kind in ("stl", "stl_ascii", "obj", "ply", "off", "glb"):
        path = tmp_path / f"box.{kind.removesuffix('_ascii')}"
        written = BOX.export(file_type=kind)
        path.write_bytes(written if isinstance(written, bytes) else written.encode())
        monkeypatch.setattr(meshes, "_clean_part", lambda *_: pytest.fail("was read"))
        with pytest.raises(InputError, match="12 triangles, at most 11"):
            meshes.read_mesh(path, "box")
