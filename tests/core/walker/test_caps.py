"""Caps: markers that a camera reads, masses that count, files to print and to glue."""

import io
import zipfile
from pathlib import Path

import cv2
import numpy as np
import pytest
import shapely
from PIL import Image

from walkergen.commands.family import preview
from walkergen.core.errors import GeometryError
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.shapes import modeller
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import mass, solids, weighed_masses
from walkergen.core.walker.design import Design
from walkergen.core.walker.fittings import Cap
from walkergen.readers.walkers import caps
from walkergen.sheets import cap_sheet


def capped_design(kind="engraved", **keys):
    return Design().variant(**{"cap.kind": kind, **{f"cap.{key}": keys[key] for key in keys}})


def detector():
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_100)
    return cv2.aruco.ArucoDetector(dictionary)


def from_above(mesh, level):
    """Picture of the faces of a mesh at a height, black, seen from above; front to the right."""
    picture = np.full((700, 900), 255, np.uint8)
    corners = mesh.vertices[mesh.triangles]
    for face in corners[(np.abs(corners[..., 1] - level) < 1e-9).all(axis=1)]:
        places = np.column_stack([450.0 + 30.0 * face[:, 0], 350.0 + 30.0 * (face[:, 2] - 4.0)])
        cv2.fillPoly(picture, [np.round(16.0 * places).astype(int)], 0, shift=4)
    return picture


def test_codes_are_those_of_opencv():
    for name in ("DICT_4X4_50", "DICT_4X4_100"):
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
        for number in range(len(dictionary.bytesList)):
            drawn = dictionary.generateImageMarker(number, caps.MARKER_CELLS)
            assert (caps.white_cells(number) == (drawn > 0)).all()


def test_a_mirrored_marker_is_invalid_or_the_same():
    """What is read in the mirror is a fault of film or print, never another walker."""
    codes = {np.rot90(caps.white_cells(number), turn).tobytes(): number for number in range(100) for turn in range(4)}
    read = {number: codes.get(caps.white_cells(number)[:, ::-1].tobytes()) for number in range(100)}
    same = {number for number, seen in read.items() if seen is not None}
    assert all(read[number] == number for number in same)
    assert same == caps.symmetric_numbers() == {8, 9, 17, 47, 58, 59, 63}


@pytest.mark.parametrize("number", [0, 7, 49])
@pytest.mark.parametrize("kind", ["engraved", "raised"])
def test_a_cap_on_its_walker_is_read_from_above_with_its_front_ahead(kind, number):
    cap = solids.build(capped_design(kind, number=number)).cap
    top = cap.vertices[:, 1].max()
    level = top if kind == "raised" else top - Cap().relief_mm
    corners, numbers, _ = detector().detectMarkers(from_above(cap, level))
    assert numbers.ravel().tolist() == [number]
    first, second, third, _ = corners[0][0]
    assert first[0] == pytest.approx(450.0 + 15.0 * 7.2, abs=1.0)  # a pixel; the front is right
    assert second[0] == pytest.approx(first[0], abs=1.0)
    assert second[1] - first[1] == pytest.approx(30.0 * 7.2, abs=2.0)
    assert third[0] < second[0]


@pytest.mark.parametrize("kind", ["engraved", "raised"])
def test_every_cap_is_one_closed_body(kind):
    for number in range(100):
        assert modeller.count_bodies(caps.build_tile(Cap(kind=kind, dictionary="4x4_100", number=number))) == 1


def test_the_mass_of_a_tile_is_that_of_its_cells():
    """Counted in cells: 64 of the tile, less half a cell of notch, less or more its black."""
    for number in (0, 10, 42):
        cell = Cap().cell
        black = float((~caps.white_cells(number)).sum())
        for kind, cells in (("engraved", 63.75 * 1.0 - 0.4 * black), ("raised", 63.75 * 1.0 + 0.4 * black)):
            volume = mass.weigh(caps.build_tile(Cap(kind=kind, number=number)), 1.0).mass
            # cells of the code overlap others by 2 % of a side: at most 16 of 0.08 cells each
            assert volume == pytest.approx(cells * cell**2, abs=0.4 * 16 * 0.08 * cell**2)
        paper = mass.weigh(caps.build_tile(Cap(kind="paper")), 1.0).mass
        assert paper == pytest.approx(63.75 * cell**2 * 0.1, rel=1e-12)


@pytest.mark.parametrize("kind", ["flexible", "braced"])
def test_a_cap_counts_in_mass_centre_and_inertia_as_a_part_of_the_body(kind):
    """Against one mesh of body and cap, weighed as a whole: exact up to rounding."""
    design = capped_design().variant(kind=kind)
    built = solids.build(design)
    whole = mass.weigh(
        Mesh(
            np.concatenate([built.body.vertices, built.cap.vertices]),
            np.concatenate([built.body.triangles, built.cap.triangles + len(built.body.vertices)]),
        ),
        1e-3 * design.material.density_g_cm3,
    )
    plain = mass.weigh(built.body, 1.0)
    own = solids.assemble(design, plain, built.legs, built.cap)
    body = solids.assemble(design.variant(kind="flexible"), plain, built.legs, built.cap)
    assert body.M == pytest.approx(whole.mass, rel=1e-12)
    assert body.J == pytest.approx(whole.inertia, rel=1e-12)
    assert body.spatial.body == pytest.approx(whole.tensor, rel=1e-9, abs=1e-9)
    O = np.array(design.limbs[0].anchor) - body.legs[0].anchor  # noqa: E741
    assert O == pytest.approx(whole.centre[:2], abs=1e-12)
    bare = solids.mass_of(Design().variant(kind=kind))
    assert own.total - bare.total == pytest.approx(0.0937, abs=1e-4)  # g, by the table of caps.csv
    assert solids.mass_of(design).J == own.J


def test_paper_weighs_as_paper_does():
    light = solids.mass_of(capped_design("paper")).total - solids.mass_of(Design()).total
    assert light == pytest.approx(80e-6 * 63.75 / 64.0 * 9.6**2, rel=1e-9)  # 80 g/m^2


def test_a_design_without_a_cap_is_written_without_its_keys():
    assert "cap" not in Design().model_dump()
    assert '"cap"' not in Design().variant(tilt_deg=5.0).model_dump_json()
    later = Design().variant(**{"cap.number": 3}).variant(**{"cap.kind": "paper"})
    assert (later.cap.number, later.cap.kind) == (3, "paper")
    data = capped_design(number=3).model_dump(mode="json")
    assert data["cap"]["number"] == 3
    assert Design.model_validate(data) == capped_design(number=3)


def test_a_walker_is_weighed_with_its_cap():
    design = capped_design()
    built = solids.build(design)
    heavier = weighed_masses.Weighings(grams=Quantity("mass", "g", 1.1))
    scaled = weighed_masses.apply_masses(design, built, heavier, "walker")
    assert float(solids.weigh(scaled, built).total) == pytest.approx(1.1, rel=1e-12)


@pytest.mark.slow
def test_plates_come_with_their_caps(run, tmp_path):
    done = run("plate", "koumakis2016", "--caps", "aruco", "--copies", "0:2,10:3", "--quiet")
    assert done.exit_code == 0, done.output
    folder = tmp_path / "out" / "koumakis2016" / "caps"
    assert sorted(path.name for path in folder.iterdir()) == [
        "caps.csv",
        "caps.json",
        "caps.pdf",
        "caps_1.png",
        "caps_prusa-mk3s_1.3mf",
    ]
    rows = [line.split(",") for line in (folder / "caps.csv").read_text().splitlines()]
    assert [row[0] for row in rows[1:]] == ["0", "1", "2", "3", "4"]
    assert rows[3][1] == "walker_t10.0_flexible_s0.40-1"
    model = zipfile.ZipFile(folder / "caps_prusa-mk3s_1.3mf").read("3D/3dmodel.model").decode()
    assert model.count('name="cap_') == 10  # each solid, and its copy with a name of its own
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert run("plate", "--caps", "aruco", "--copies", "0:2,10:3", "--quiet").exit_code == 0
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_plates_without_caps_do_not_mention_them(run, tmp_path):
    assert run("plate", "--copies", "2", "--quiet", "--no-pictures").exit_code == 0
    files = [path for path in (tmp_path / "out").rglob("*") if path.is_file()]
    assert not [path for path in files if "cap" in path.name]
    assert not [path for path in files if b'"cap"' in path.read_bytes()]


def test_caps_of_numbered_copies_have_their_numbers(run, tmp_path):
    words = ("plate", "--caps", "aruco", "--copies", "3", "--serial", "17", "--quiet")
    assert run(*words).exit_code == 0
    text = Path("out/koumakis2016/caps/caps.csv").read_text().splitlines()[1:]
    assert [line.split(",")[:2] for line in text] == [
        [str(number), f"walker_t10.0_flexible_s0.40-{number}"] for number in (17, 18, 19)
    ]


def test_exported_walkers_come_with_their_caps(run, tmp_path):
    assert run("export", "--caps", "aruco", "--tilt", "5,10", "--out", "e").exit_code == 0
    assert sorted(path.name for path in (tmp_path / "e" / "stl").iterdir()) == [
        "walker_t05.0_flexible_s0.40.stl",
        "walker_t05.0_flexible_s0.40_cap00.stl",
        "walker_t10.0_flexible_s0.40.stl",
        "walker_t10.0_flexible_s0.40_cap01.stl",
    ]
    assert (tmp_path / "e" / "caps" / "caps.pdf").is_file()


@pytest.mark.slow
def test_a_sheet_is_read_and_in_true_size():
    markers = [Cap(kind="paper", number=number) for number in range(5)]
    (page,) = cap_sheet.draw_pages(markers)
    image = Image.open(io.BytesIO(cap_sheet.pngs([page])[0]))
    assert np.array(image.info["dpi"]) == pytest.approx(600.0, abs=0.01)
    grey = np.array(image.convert("L"))
    corners, numbers, _ = detector().detectMarkers(grey[: grey.shape[0] // 3])
    assert sorted(numbers.ravel().tolist()) == list(range(5))
    for square in corners:
        side = np.linalg.norm(np.roll(square[0], 1, axis=0) - square[0], axis=1)
        assert side == pytest.approx(7.2 / 25.4 * 600.0, abs=2.0)  # a pixel at either end
        ahead = square[0][:2].mean(axis=0) - square[0].mean(axis=0)
        assert ahead[1] < -80.0  # fronts point up
    assert cap_sheet.pdf([page]) == cap_sheet.pdf(cap_sheet.draw_pages(markers))
    assert len(cap_sheet.draw_pages([Cap(kind="paper", marker_mm=120.0)] * 2)) == 2


def test_a_cap_that_the_body_does_not_hold_is_refused():
    with pytest.raises(GeometryError, match=r"cap.marker_mm = 30: 14 % of the cap's 40 mm square"):
        solids.mass_of(capped_design(marker_mm=30.0))


def test_cells_finer_than_lines_are_reported(run):
    done = run("plate", "--caps", "aruco", "--set", "cap.marker_mm=3")
    assert done.exit_code == 0
    assert "cells of the caps may close up" in done.output


@pytest.mark.parametrize("kind", ["engraved", "paper"])
def test_pictures_of_families_show_caps_in_place(kind):
    """Against the mesh of the cap, and the marker's black cells by their area."""
    design = capped_design(kind, number=5)
    part = preview.Part(design, solids.build(design).walker)
    tile, squares = part.cap
    whole = solids.build(design).cap.vertices
    assert tile.min(axis=0) == pytest.approx(whole.min(axis=0), abs=1e-9)
    assert tile.max(axis=0) == pytest.approx(whole.max(axis=0), abs=1e-9)
    area = shapely.union_all([shapely.Polygon(square[:, [0, 2]]) for square in squares]).area
    cells = int((~caps.white_cells(5)).sum())
    assert area == pytest.approx(cells * design.cap.cell**2, rel=1e-6)
    bare = preview.Part(Design(), solids.build(Design()).walker)
    assert bare.cap is None
    shown, without = (preview.preview_figure([one], "it").axes[0] for one in (part, bare))
    assert len(shown.collections) == len(without.collections) + 1
