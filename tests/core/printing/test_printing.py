"""Files for printing: closed, equal byte for byte, readable by others, whole or absent."""

import io
import time
import xml.etree.ElementTree as ElementTree
import zipfile

import lib3mf
import numpy as np
import pytest
import threemf
import trimesh

from walkergen.core.errors import SolidError
from walkergen.core.printing import export
from walkergen.core.printing import packing as plate
from walkergen.core.printing.export import Item, Solid
from walkergen.core.printing.packing import Part
from walkergen.core.printing.printers import Printer
from walkergen.core.shapes import stl
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker.mass import weigh

MK3S = Printer(name="mk3s", bed_width_mm=250.0, bed_depth_mm=210.0, height_mm=210.0)

L_SHAPE = np.array([(0.0, 0.0), (6.0, 0.0), (6.0, 1.0), (2.0, 1.0), (2.0, 5.0), (0.0, 5.0)])
L_TRIANGLES = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
L_AREA = 6.0 * 1.0 + 2.0 * 4.0


def prism(shift: tuple[float, float, float] = (0.0, 0.0, 0.0), height: float = 3.0) -> Mesh:
    """An L extruded along z, its corner at `shift`."""
    count = len(L_SHAPE)
    floor = np.column_stack([L_SHAPE, np.zeros(count)])
    bottom = np.array(L_TRIANGLES)
    here = np.arange(count)
    there = (here + 1) % count
    walls = np.concatenate(
        [np.column_stack([here, there, there + count]), np.column_stack([here, there + count, here + count])]
    )
    vertices = np.concatenate([floor, floor + np.array([0.0, 0.0, height])]) + shift
    return Mesh(vertices, np.concatenate([bottom[:, ::-1], bottom + count, walls]))


def read_stl(data: bytes) -> trimesh.Trimesh:
    mesh = trimesh.load_mesh(io.BytesIO(data), file_type="stl", process=False)
    mesh.merge_vertices()
    return mesh


# STL


def test_stl_is_closed_and_keeps_the_volume() -> None:
    mesh = prism(shift=(-3.0, 40.0, 7.0))
    read = read_stl(export.stl_bytes(mesh, "an L"))
    assert read.is_watertight
    assert read.is_winding_consistent
    # 32-bit floats near 45 mm are 4e-6 mm apart; the L has 80 mm^2 of surface.
    assert read.volume == pytest.approx(L_AREA * 3.0, abs=80 * 4e-6)
    assert read.volume == pytest.approx(weigh(mesh, 1.0).volume, abs=80 * 4e-6)


def test_stl_normals_are_unit_and_point_outwards() -> None:
    mesh = prism()
    data = export.stl_bytes(mesh, "an L")
    records = np.frombuffer(data, stl.TRIANGLE, offset=84)
    assert np.allclose(np.linalg.norm(records["normal"], axis=1), 1.0, atol=1e-6)  # 32-bit floats
    below = records["corners"][:, :, 2].max(axis=1) == 0.0
    assert (records["normal"][below] == (0.0, 0.0, -1.0)).all()
    assert below.sum() == len(L_TRIANGLES)


def test_a_triangle_without_area_has_no_normal_and_no_warning() -> None:
    flat = Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]]))
    record = np.frombuffer(export.stl_bytes(flat, ""), stl.TRIANGLE, offset=84)
    assert (record["normal"] == 0.0).all()


@pytest.mark.parametrize("header", ["", "solid", "walker_t10.0", "é" * 200, "x" * 79 + "é"])
def test_stl_has_the_standard_length_and_is_never_taken_for_text(header: str) -> None:
    mesh = prism()
    data = export.stl_bytes(mesh, header)
    assert len(data) == 84 + 50 * len(mesh.triangles)
    assert int.from_bytes(data[80:84], "little") == len(mesh.triangles)
    assert not data.lstrip().lower().startswith(b"solid")
    assert data[:80].isascii()


def test_stl_gives_its_corners_back() -> None:
    mesh = prism(shift=(0.1, 0.2, 0.3))
    found, note = stl.unpack(export.stl_bytes(mesh, "an L"), "l.stl")
    assert note == ""
    assert (found == mesh.vertices[mesh.triangles].astype("f4")).all()


def test_equal_meshes_give_equal_stl_for_any_memory_layout() -> None:
    mesh = prism()
    other = Mesh(np.asfortranarray(mesh.vertices), mesh.triangles.astype(np.int32))
    assert export.stl_bytes(mesh, "L") == export.stl_bytes(other, "L")


# 3MF


def test_3mf_is_read_back_by_lib3mf() -> None:
    solids = [Solid("long", prism(shift=(5.0, -9.0, 2.0))), Solid("tall", prism(height=4.0))]
    items = [Item(0, "long-1", 10.0, 20.0), Item(1, "tall-1", 0.5, 0.25), Item(0, "long-2", 7, 8)]
    read = threemf.read_3mf(export.threemf_bytes(solids, items, "two shapes"))
    assert read.unit == lib3mf.ModelUnit.MilliMeter
    assert read.metadata == {"Title": "two shapes", "Application": "walkergen"}
    assert read.names == ["long", "tall"]
    assert read.sound
    assert [item.part_number for item in read.items] == ["long-1", "tall-1", "long-2"]
    moved = [item.moved for item in read.items]
    assert moved == [(10.0, 20.0, 0.0), (0.5, 0.25, 0.0), (7.0, 8.0, 0.0)]
    assert [item.low for item in read.items] == moved  # the corner of the box lies at the item


def test_3mf_is_read_back_by_trimesh() -> None:
    data = export.threemf_bytes([Solid("L", prism())], [Item(0, "L-1", 0.0, 0.0), Item(0, "L-2", 30.0, 0.0)], "twice")
    scene = trimesh.load_scene(io.BytesIO(data), file_type="3mf")
    assert scene.units == "millimeter"
    assert list(scene.geometry) == ["L"]
    assert len(scene.graph.nodes_geometry) == 2
    assert scene.geometry["L"].is_watertight
    assert scene.bounds.tolist() == [[0.0, 0.0, 0.0], [36.0, 5.0, 3.0]]
    # lib3mf writes six decimals: whole millimetres survive exactly.
    assert scene.geometry["L"].volume == pytest.approx(L_AREA * 3.0, rel=1e-12)


def test_one_part_stands_at_the_origin_of_its_file() -> None:
    (item,) = threemf.read_3mf(export.part_3mf(prism(shift=(-50.0, -60.0, -70.0)), "L")).items
    assert item.low == (0.0, 0.0, 0.0)
    assert item.part_number == "L"


def test_identifiers_differ_within_a_file() -> None:
    solids = [Solid("same", prism()), Solid("same", prism(height=2.0))]
    items = [Item(index % 2, "same", 10.0 * index, 0.0) for index in range(6)]
    found = threemf.read_3mf(export.threemf_bytes(solids, items, "same")).identifiers
    assert len(set(found)) == len(found) == 1 + 2 + 6


def test_plates_of_one_title_are_different_builds() -> None:
    solids = [Solid("L", prism())]
    files = [export.threemf_bytes(solids, [Item(0, f"L-{k}", 0.0, 0.0)], "t") for k in (1, 2)]
    first, second = (threemf.read_3mf(data).identifiers[0] for data in files)
    assert first != second


def test_bytes_are_equal_at_another_time_in_another_time_zone(monkeypatch: pytest.MonkeyPatch) -> None:
    def files() -> tuple[bytes, bytes]:
        mesh = prism()
        return export.part_3mf(mesh, "L"), export.stl_bytes(mesh, "L")

    monkeypatch.setenv("TZ", "UTC")
    time.tzset()
    first = files()
    time.sleep(2.1)  # zip archives count time in steps of two seconds
    monkeypatch.setenv("TZ", "Pacific/Kiritimati")
    time.tzset()
    try:
        assert files() == first
    finally:
        monkeypatch.undo()
        time.tzset()


HOSTILE = ["../../etc/passwd", "a\x00b", "<b>&\"'", "a\tb\nc", "\x1b[2J", "\ud800", "\ufffe", "é€😀", ""]


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_names_stay_text(name: str) -> None:
    data = export.threemf_bytes([Solid(name, prism())], [Item(0, name, 0.0, 0.0)], name)
    archive = zipfile.ZipFile(io.BytesIO(data))
    assert sorted(archive.namelist()) == ["3D/3dmodel.model", "[Content_Types].xml", "_rels/.rels"]
    root = ElementTree.fromstring(archive.read("3D/3dmodel.model"))
    core = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
    read = root.find(f".//{core}object").get("name", "")
    assert len(read) == len(name)
    assert all(seen in (meant, "_") for seen, meant in zip(read, name, strict=True))
    if name.isprintable():
        assert read == name
    threemf.read_3mf(data)


def test_a_mesh_that_lib3mf_refuses_is_named() -> None:
    broken = Mesh(prism().vertices, np.array([[0, 1, 99]]))
    with pytest.raises(SolidError, match="broken: lib3mf refuses the mesh"):
        export.part_3mf(broken, "broken")


# A plate as 3MF


@pytest.mark.parametrize("origin", ["corner", "centre"])
def test_a_plate_file_holds_each_part_at_its_place_on_the_bed(origin: str) -> None:
    printer = MK3S.model_copy(update={"origin": origin})
    meshes = [prism(shift=(-3.0, 7.0, -2.0)), prism(shift=(100.0, 0.0, 5.0), height=4.0)]
    parts = [Part.from_mesh("short", meshes[0], 3), Part.from_mesh("tall", meshes[1], 2)]
    (one,) = plate.pack(parts, printer)
    read = threemf.read_3mf(plate.plate_3mf(one, parts, meshes, printer, "plate 1"))
    copies = ["short-1", "short-2", "short-3", "tall-1", "tall-2"]
    assert [item.part_number for item in read.items] == copies
    assert read.names == ["short", "tall"]
    left, front = (-125.0, -105.0) if origin == "centre" else (0.0, 0.0)
    for item, placement in zip(read.items, one.placements, strict=True):
        low = (left + placement.x, front + placement.y, 0.0)
        size = parts[placement.part][1:4]
        # 32-bit floats below 256 mm and six decimals in the file: 2e-5 mm
        assert item.low == pytest.approx(low, abs=2e-5)
        assert item.high == pytest.approx(np.add(low, size), abs=2e-5)
        assert item.low[2] == 0.0


def test_a_plate_file_holds_only_the_parts_on_that_plate() -> None:
    mesh = prism()
    parts = [Part.from_mesh("first", mesh), Part.from_mesh("second", mesh)]
    (full,) = plate.pack(parts, MK3S)
    for placements, names in [(full.placements[1:], ["second"]), (full.placements, ["first", "second"])]:
        data = plate.plate_3mf(plate.Plate(placements), parts, [mesh, mesh], MK3S, "")
        assert threemf.read_3mf(data).names == names
