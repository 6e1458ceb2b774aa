"""Mesh files as programs write them: every spelling of a solid gives its volume, any other file one true line."""

import io
import struct

import numpy as np
import pytest
import trimesh

from walkergen.commands.check.weighing import weigh
from walkergen.core.errors import InputError

HEIGHT = 3.0
L_SHAPE = [(0, 0), (28, 0), (28, 4), (8, 4), (8, 8), (0, 8)]
U_SHAPE = [(0, 0), (28, 0), (28, 8), (24, 8), (24, 3), (4, 3), (4, 8), (0, 8)]
KEYHOLE = [(0, 0), (28, 0), (28, 8), (0, 8), (0, 0), (2, 2), (2, 6), (26, 6), (26, 2), (2, 2)]
COMB = [(0, 0), (28, 0), *((x + dx, y) for x in range(26, 0, -4) for dx, y in ((2, 8), (0, 8), (0, 2), (-2, 2)))]
STAR = [(14 + r * np.cos(a), 4 + r * np.sin(a)) for a, r in zip(np.arange(10) * np.pi / 5, [4, 1.5] * 5, strict=True)]
SHAPES = {"l": L_SHAPE, "u": U_SHAPE, "keyhole": KEYHOLE, "comb": COMB, "star": STAR}


def area(ring):
    x, y = np.array(ring, float).T
    return 0.5 * float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())


def prism(ring, turn=0, tilted=False):
    """Vertices, and polygons of an extruded ring: two lids of all its corners, and four-cornered sides."""
    ring = ring[turn:] + ring[:turn]
    places = list(dict.fromkeys(ring))
    index = [places.index(corner) for corner in ring]
    count = len(places)
    vertices = np.array([(*corner, z) for z in (0.0, HEIGHT) for corner in places], float)
    faces = [index[::-1], [at + count for at in index]]
    walls = [(a, b) for a, b in zip(index, [*index[1:], index[0]], strict=True)]
    faces += [[a, b, b + count, a + count] for a, b in walls if (b, a) not in walls]
    if tilted:  # no face lies along an axis
        vertices = vertices @ trimesh.transformations.euler_matrix(0.3, 0.7, 0.1)[:3, :3]
    return vertices, faces


def volume_of(folder, name, data):
    path = folder / name
    path.write_bytes(data)
    weighed = weigh(path, 1.0, 1.0)
    return weighed.total.volume_mm3, weighed.notes


BOX = trimesh.creation.box((28.0, 8.0, 3.0))
CORNERS = [tuple(map(tuple, triangle)) for triangle in BOX.triangles.tolist()]


def text_stl(name=b"part", number="{:g}", between="\n", end="\n", last="endsolid part", first=b"solid "):
    """STL of the box as text. `between`: lines. `first` and `last`: what is before the name, and after the facets."""
    lines = [first + name]
    for triangle in CORNERS:
        lines += [b"facet normal 0 0 0", b"outer loop"]
        lines += [f"vertex {' '.join(map(number.format, corner))}".encode() for corner in triangle]
        lines += [b"endloop", b"endfacet"]
    return between.encode().join([*lines, last.encode()] if last else lines) + end.encode()


def fortran_stl():
    """STL with numbers as Fortran writes them: 1.40000000D+01."""
    return text_stl(number="{:.8e}").replace(b"e+", b"D+").replace(b"e-", b"D-")


def with_facet(*corners):
    """STL with one triangle more."""
    corners = [f"vertex {corner}" for corner in corners]
    lines = ["facet normal 0 0 0", "outer loop", *corners, "endloop", "endfacet", "endsolid"]
    return text_stl().replace(b"endsolid", "\n".join(lines).encode())


STL = {
    "unix": text_stl(),
    "windows": text_stl(between="\r\n", end="\r\n"),
    "old mac": text_stl(between="\r", end="\r"),
    "no line at the end": text_stl(end=""),
    "one line": text_stl(between=" ", end=""),
    "tabs": text_stl(between="\n\t\t"),
    "blank lines": text_stl(between="\n\n"),
    "end solid": text_stl(last="end solid part"),
    "no endsolid": text_stl(last=""),
    "no endsolid, no line end": text_stl(last="", end=""),
    "no name": text_stl(name=b"", last="endsolid"),
    "no solid": text_stl(first=b"", name=b"", last=""),
    "upper case": text_stl().upper(),
    "exponents": text_stl(number="{:.7e}"),
    "upper exponents": text_stl(number="{:.7E}"),
    "plus": text_stl(number="{:+.4f}"),
    "no leading zero": text_stl(number="{:.1f}").replace(b"0.", b"."),
    "fortran": fortran_stl(),
    "small fortran": fortran_stl().lower(),
    "comment": b"# written by hand\n" + text_stl(),
    "c comment": b"// made on Monday\r\n" + text_stl(),
    "semicolon": b"; a facet comment\n" + text_stl(),
    "blank before": b"\n\n  " + text_stl(),
    "latin-1": text_stl(name="Käfer für Öl".encode("latin-1")),
    "cp1252": text_stl(name="“Prüfkörper” – 1 €".encode("cp1252")),
    "gbk": text_stl(name="机器人行走器".encode("gbk")),
    "shift-jis": text_stl(name="歩くロボット".encode("shift_jis")),
    "koi8": text_stl(name="ходок".encode("koi8-r")),
    "any bytes": text_stl(name=bytes(range(128, 256))),
    "utf-8 mark": b"\xef\xbb\xbf" + text_stl(),
    "utf-16": text_stl().decode().encode("utf-16"),
    "utf-16 big": b"\xfe\xff" + text_stl().decode().encode("utf-16-be"),
    "words of the format as the name": text_stl(name=b"facet vertex solid loop"),
    "several solids": text_stl().replace(b"facet normal", b"endsolid a\nsolid b\nfacet normal", 4),
    "long name": text_stl(name=b"n" * 5000),
    "colour after": text_stl().replace(b"endloop", b"endloop\ncolor 0.5 0.5 0.5"),
    "wide loop": text_stl().replace(b"outer loop", b"outer \t loop"),
    "normal not a number": text_stl().replace(b"normal 0 0 0", b"normal nan -nan(ind) inf"),
    "no normal": text_stl().replace(b" normal 0 0 0", b""),
    "flat triangle": with_facet("14 4 1.5", "14 4 1.5", "14 -4 1.5"),
    "flat triangle along an edge": with_facet("14 4 1.5", "0 4 1.5", "-14 4 1.5"),
    "binary": BOX.export(file_type="stl"),
    "binary that begins with solid": b"solid facet " + BOX.export(file_type="stl")[12:],
}


@pytest.mark.parametrize("kind", STL)
def test_text_stl_of_any_program_is_read(tmp_path, kind):
    volume, notes = volume_of(tmp_path, "part.stl", STL[kind])
    assert volume == pytest.approx(672.0, rel=1e-6)
    assert notes == (("left out 1 triangle without area",) if kind.startswith("flat") else ())


def test_loops_of_more_corners_are_cut(tmp_path):
    vertices, faces = prism(U_SHAPE)
    lines = ["solid u"]
    for face in faces:
        lines += ["facet normal 0 0 0", "outer loop", *("vertex {} {} {}".format(*vertices[at]) for at in face)]
        lines += ["endloop", "endfacet"]
    assert volume_of(tmp_path, "u.stl", "\n".join(lines).encode())[0] == pytest.approx(area(U_SHAPE) * HEIGHT)


TYPES = {"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I", "float": "f", "double": "d"}
TYPES |= {"uint8": "B", "int32": "i", "float64": "d"}
FORMS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


def ply(solid, form="ascii", size="uchar", corner="int", real="float", name="vertex_indices", newline="\n", more=False):
    """PLY of a solid. `more`: faces first, with colours, other lists and edges."""

    def write(types, *values):
        if FORMS[form]:
            return struct.pack(FORMS[form] + "".join(TYPES[each] for each in types), *values)
        return (" ".join(f"{value:.9g}" for value in values) + newline).encode()

    vertices, faces = solid
    before, after = (["uchar"], ["uchar", "float", "float", "int"]) if more else ([], [])
    rings = b"".join(
        write(
            [*before, size, *[corner] * len(face), *after],
            *[7][: len(before)],
            len(face),
            *face,
            *[2, 0.25, 0.75, -3][: len(after)],
        )
        for face in faces
    )
    colours = ["uchar", "float"][: 2 * more]
    points = b"".join(write([real] * 3 + colours, *place, *[200, 0.5][: len(colours)]) for place in vertices.tolist())
    face = [f"element face {len(faces)}", *["property uchar flags"][:more], f"property list {size} {corner} {name}"]
    face += ["property list uchar float texcoord", "property int group"][: 2 * more]
    vertex = [f"element vertex {len(vertices)}", *(f"property {real} {axis}" for axis in "xyz")]
    vertex += ["property uchar red", "property float quality"][: 2 * more]
    edge = ["element edge 1", "property int vertex1", "property int vertex2"][: 3 * more]
    body = rings + points + write(["int", "int"], 0, 1) if more else points + rings
    parts = [*face, *vertex, *edge] if more else [*vertex, *face]
    return newline.join(["ply", f"format {form} 1.0", "comment für", *parts, "end_header", ""]).encode("latin-1") + body


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("shape", SHAPES)
def test_ply_with_concave_faces(tmp_path, shape, form):
    for turn in range(0, len(SHAPES[shape]) if shape != "keyhole" else 1, 2):
        volume, _ = volume_of(tmp_path, "part.ply", ply(prism(SHAPES[shape], turn), form))
        assert volume == pytest.approx(area(SHAPES[shape]) * HEIGHT, rel=1e-6)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(
    "options",
    [
        *({"size": size, "corner": corner} for size in TYPES for corner in ("int", "uint", "short", "uchar", "double")),
        {"real": "double"},
        {"real": "float64", "name": "vertex_index"},
        {"newline": "\r\n"},
        {"newline": "\r"},
        {"more": True},
        {"more": True, "newline": "\r\n"},
    ],
)
def test_ply_of_any_types_is_read(tmp_path, form, options):
    volume, _ = volume_of(tmp_path, "part.ply", ply(prism(U_SHAPE), form, **options))
    assert volume == pytest.approx(area(U_SHAPE) * HEIGHT, rel=1e-6)


@pytest.mark.parametrize("form", FORMS)
def test_broken_ply_is_named(tmp_path, form):
    whole = ply(prism(U_SHAPE), form)
    header = whole.index(b"end_header")
    for data, told in (
        (whole[: len(whole) - 9], "it breaks off|requires a buffer|is no sound PLY"),
        (whole[: header - 10], "is no sound PLY|breaks off|contains no faces"),
        (whole.replace(b"element face", b"element tristrips"), "contains no faces"),
        (whole.replace(b"element vertex 16", b"element vertex 4000000000"), "breaks off|is no sound PLY"),
        (whole.replace(b"element face 10", b"element face 2000000000"), "2000000000 triangles, at most"),
        (whole.replace(b"property list uchar", b"property list quad"), "is no sound PLY"),
        (whole.replace(b"format", b"shape"), "is no sound PLY"),
    ):
        with pytest.raises(InputError, match=told):
            volume_of(tmp_path, "part.ply", data)


def off(solid, word="OFF", counts="\n", colours="", comment="", more="", newline="\n"):
    vertices, faces = solid
    lines = [f"{word}{counts}{len(vertices)} {len(faces)} 0{comment}"] if word else [f"{len(vertices)} {len(faces)} 0"]
    lines += [" ".join(f"{value:.9g}" for value in place) + more + comment for place in vertices.tolist()]
    lines += [" ".join(map(str, [len(face), *face])) + colours for face in faces]
    return newline.join(lines).encode()


OFF = {
    "plain": {},
    "counts behind the word": {"counts": " "},
    "no word": {"word": ""},
    "comments": {"comment": "  # corner"},
    "comment first": {"counts": "\n# written by hand\n\n"},
    "colours": {"colours": " 255 0 0"},
    "real colours": {"colours": " 0.5 0.5 0.5 1.0"},
    "colour map": {"colours": "  7"},
    "colours of corners": {"word": "COFF", "more": " 255 0 0 255"},
    "normals": {"word": "NOFF", "more": " 0 0 1"},
    "normals and colours": {"word": "CNOFF", "more": " 0 0 1 0.1 0.2 0.3 1"},
    "textures": {"word": "STOFF", "more": " 0.5 0.5"},
    "windows": {"newline": "\r\n"},
    "old mac": {"newline": "\r"},
    "one line": {"newline": " ", "counts": " "},
    "latin-1": {"counts": "\n# für\n"},
}


@pytest.mark.parametrize("kind", OFF)
@pytest.mark.parametrize("shape", ["l", "keyhole", "comb"])
def test_off_of_any_kind_is_read(tmp_path, shape, kind):
    volume, _ = volume_of(tmp_path, "part.off", off(prism(SHAPES[shape]), **OFF[kind]))
    assert volume == pytest.approx(area(SHAPES[shape]) * HEIGHT, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "data", "told"),
    [
        ("part.stl", text_stl()[:700], "loops begin and"),
        ("part.stl", text_stl().replace(b"vertex 14 4 1.5", b"vertex 14 4", 1), "is no sound STL file"),
        (
            "part.stl",
            text_stl().replace(b"vertex 14 4 1.5", b"vertex 14 4 1,5", 1),
            "could not convert string to float: b'1,5'",
        ),
        ("part.stl", text_stl().replace(b"vertex 14 4 1.5", b"vertex 14 4 nan", 1), "are not finite numbers"),
        ("part.stl", b"solid part\nendsolid part\n", "contains no triangles"),
        ("part.stl", b"solid part", "contains no triangles"),
        ("part.stl", b"", "is no binary STL file"),
        ("part.stl", b"hello", "is no binary STL file"),
        ("part.off", off(prism(L_SHAPE), word="4OFF"), "is not OFF as text"),
        ("part.off", off(prism(L_SHAPE), word="OFF BINARY"), "is not OFF as text"),
        ("part.off", off(prism(L_SHAPE), word="nOFF"), "is not OFF as text"),
        ("part.off", off(prism(L_SHAPE))[:-30], "is no sound OFF file"),
        ("part.off", b"OFF\n3 2000000000 0\n", "2000000000 triangles"),
        ("part.off", b"", "is no sound OFF file"),
        ("part.off", b"OFF", "is no sound OFF file"),
    ],
)
def test_broken_stl_and_other_off_are_named(tmp_path, name, data, told):
    with pytest.raises(InputError, match=told):
        volume_of(tmp_path, name, data)


@pytest.mark.parametrize("tilted", [False, True])
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("write", ["{0}", "{0}/{0}", "{0}//{0}", "{0}/{0}/{0}", "negative", "late"])
def test_obj_with_concave_faces(tmp_path, shape, write, tilted):
    vertices, faces = prism(SHAPES[shape], tilted=tilted)
    count = len(vertices)
    points = [f"v {x:.12g} {y:.12g} {z:.12g} 0.5 0.5 0.5" for x, y, z in vertices.tolist()]
    lines = ["# f 1 2 3", "mtllib für.mtl", "o part", "vn 0 0 1", "vt 0 0", *points, "s off", "g lid", "usemtl a"]
    if write == "late":  # corners are numbered from the end while more follow
        half = [face for face in faces if max(face) < count]
        lines += ["f " + " ".join(str(at - count) for at in face) for face in half] + ["v 9 9 9", "l 1 2", "p 1"]
    else:
        form = "{1}" if write == "negative" else write
        lines += ["f " + " ".join(form.format(at + 1, at - count) for at in face) for face in faces]
    for newline in ("\n", "\r\n", "\r"):
        volume, _ = volume_of(tmp_path, "part.obj", newline.join(lines).encode("latin-1"))
        assert volume == pytest.approx(area(SHAPES[shape]) * HEIGHT, rel=1e-6)


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        (["v 0 0 0", "v 1 0 0", "v 0 1 0", "f 1 2 4"], "a corner that does not exist"),
        (["v 0 0 0", "v 1 0 0", "v 0 1 0", "f 0 1 2"], "a corner that does not exist"),
        (["v 0 0 0", "v 1 0 0", "v 0 1 0", "f -4 1 2"], "a corner that does not exist"),
        (["v 0 0 0", "v 1 0 0", "v 0 1", "f 1 2 3"], "is no sound OBJ file"),
        (["v 0 0 0", "v 1 0 0", "v 0 1 zero", "f 1 2 3"], "is no sound OBJ file"),
        (["v 0 0 0", "cstype bspline", "surf 0 1 0 1 1"], "contains curved surfaces"),
        (["v 0 0 0", "l 1 1"], "contains no triangles"),
    ],
)
def test_broken_obj_is_named(tmp_path, lines, told):
    with pytest.raises(InputError, match=told):
        volume_of(tmp_path, "part.obj", "\n".join(lines).encode())


@pytest.mark.parametrize("kind", ["stl", "stl_ascii", "obj", "ply", "ply_ascii", "off", "glb", "3mf"])
def test_what_trimesh_writes_is_read(tmp_path, kind):
    for solid in (BOX, trimesh.creation.icosphere(3, 14.0), trimesh.creation.annulus(5.0, 12.0, 4.0)):
        written = solid.copy()
        if kind == "glb":
            written.apply_scale(1e-3)
        options = {"encoding": "ascii"} if kind == "ply_ascii" else {}
        data = written.export(file_type=kind.removesuffix("_ascii") if kind != "stl_ascii" else kind, **options)
        path = f"part.{kind.removesuffix('_ascii')}"
        volume, _ = volume_of(tmp_path, path, data if isinstance(data, bytes) else data.encode())
        assert volume == pytest.approx(solid.volume, rel=1e-5)


def test_a_rival_reads_the_same_triangles(tmp_path):
    """Rival of the readers: trimesh, on files of triangles, which it reads rightly."""
    solid = trimesh.creation.icosphere(2, 14.0)
    for kind in ("ply", "off", "obj"):
        data = solid.export(file_type=kind)
        data = data if isinstance(data, bytes) else data.encode()
        rival = trimesh.load_mesh(io.BytesIO(data), kind)
        assert volume_of(tmp_path, f"part.{kind}", data)[0] == pytest.approx(rival.volume, rel=1e-9)
