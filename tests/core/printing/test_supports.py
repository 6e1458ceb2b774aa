"""Supports and brim: one decision for sheet, settings and findings, and what PrusaSlicer makes of it."""

import io
import json
import math
import zipfile
from xml.etree import ElementTree

import maker_profile
import numpy as np
import pytest
import trimesh
from slicing import slice_model

from walkergen.core.printing import checks, plates, slicer, supports
from walkergen.core.printing.printers import Printer
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates

MK3S = templates.load("prusa-mk3s", "printers", Printer)
HEART = "M15 27C0 15 0 0 8 1 12 1 15 5 15 7 15 5 18 1 22 1 30 0 30 15 15 27Z"
TEE = [[-14.0, -1.5], [14.0, -1.5], [14.0, 1.5], [3.0, 1.5], [3.0, 8.0], [-3.0, 8.0], [-3.0, 1.5], [-14.0, 1.5]]


KINDS = ("duck", "tee", "letters", "heart")


def make_design(kind: str, folder) -> Design:
    """Return a walker with a body of this kind."""
    if kind == "letters":
        return Design.from_text("ANNA")
    if kind == "tee":
        return Design.model_validate({"name": kind, "body": {"profile_mm": TEE}})
    if kind == "heart":
        path = folder / "heart.svg"
        path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 30 28"><path d="{HEART}"/></svg>')
        return templates.load(path, "walkers", Design)
    path = folder / "duck.stl"
    body = trimesh.creation.icosphere(subdivisions=3, radius=8.0)
    body.apply_scale((1.6, 1.0, 0.8))
    head = trimesh.creation.icosphere(subdivisions=3, radius=4.0)
    head.apply_translation((11.0, 0.0, 7.0))
    trimesh.boolean.union([body, head], engine="manifold").export(path)
    return templates.load(path, "walkers", Design)


def write_plate(designs: list[Design], folder) -> tuple[plates.Layout, dict[str, bytes]]:
    """Write a plate with one copy of each design, and the maker's profile."""
    layout = plates.arrange(designs, [solids.build(design) for design in designs], [1] * len(designs), MK3S)
    files = dict(plates.layout_files(layout, "p", draw=None))
    for name, data in files.items():
        (folder / name).write_bytes(data)
    (folder / "yours.ini").write_text(maker_profile.ini(layout.printer))
    return layout, files


@pytest.mark.parametrize("kinds", [["duck"], ["tee"], ["letters"], ["heart"], ["heart", "duck"]])
def test_sheet_settings_and_findings_agree(tmp_path, kinds):
    layout, files = write_plate([make_design(kind, tmp_path) for kind in kinds], tmp_path)
    is_on = "duck" in kinds
    assert list(layout.supported) == [kind == "duck" for kind in kinds]
    sheet = files["p_prusa-mk3s.md"].decode()
    named = ", ".join(part.name for part, each in zip(layout.parts, layout.supported, strict=True) if each)
    assert ("| supports | none |" in sheet) != is_on
    assert (f"| supports | on, from the bed only: under {named} |" in sheet) == is_on
    assert ("supports from the bed under the body" in sheet) == is_on
    brim = "5" if is_on else "0"  # the duck lies on the top of its head
    for name in ("p_prusa-mk3s.ini", "p_prusa-mk3s_print.ini"):
        text = files[name].decode()
        assert f"\nsupport_material = {is_on:d}\n" in text
        assert "\nsupport_material_buildplate_only = 1\n" in text
        assert f"\nbrim_width = {brim}\n" in text
    orca = json.loads(files["p_prusa-mk3s_orca.json"])
    assert (orca["enable_support"], orca["support_on_build_plate_only"]) == (f"{is_on:d}", "1")
    assert (orca["brim_width"], orca["brim_type"]) == (brim, "outer_only" if is_on else "no_brim")
    over_air = [one for one in layout.findings if "over air" in one.what]
    assert [("from the bed" in one.change, "settings switch on" in one.change) for one in over_air] == [
        (True,) * 2
    ] * is_on


def test_a_brim_of_the_printer_is_kept(tmp_path):
    duck = make_design("duck", tmp_path)
    mesh = solids.orient_for_print(duck, solids.build(duck).walker)
    assert supports.contact_area(mesh, MK3S) < supports.MIN_CONTACT_MM2
    assert supports.add_brim(MK3S, [mesh], [True]).brim_width_mm == supports.BRIM_MM
    assert supports.add_brim(MK3S, [mesh], [False]) is MK3S
    wide = MK3S.model_copy(update={"brim_width_mm": 8.0})
    assert supports.add_brim(wide, [mesh], [True]) is wide


def test_a_single_change_is_no_plural(tmp_path):
    joined = Design.from_text("i")
    (repair,) = checks.check_part("i", joined, solids.orient_for_print(joined, solids.build(joined).walker), MK3S)[:1]
    assert "1 change, limit 0 changes" in repair.text


FACES = [np.roll(np.eye(3), k, axis=1) @ np.diag([sign, 1.0, sign]) for k in range(3) for sign in (1.0, -1.0)]
"""Rotations that lay each of the six sides of a part on the bed."""


@pytest.mark.parametrize("kind", ["duck", "tee", "letters", "heart", *templates.names("walkers")])
def test_supports_are_on_only_where_no_side_of_six_prints_without(tmp_path, kind):
    """A walker lies on its side or upside down. Where that needs supports, each of the six sides would need more."""
    design = make_design(kind, tmp_path) if kind in KINDS else templates.load(kind, "walkers", Design)
    mesh = solids.build(design).walker
    lying = solids.orient_for_print(design, mesh)
    if supports.is_needed(design, lying):
        for face in FACES:
            assert np.linalg.det(face) == pytest.approx(1.0)
            assert steep_area(mesh._replace(vertices=mesh.vertices @ face.T)) > 10.0 * supports.MIN_OVERHANG_MM2
    elif not design.parts:  # rims of pockets are bridges
        assert steep_area(lying) < 10.0 * supports.MIN_OVERHANG_MM2


def steep_area(mesh) -> float:
    """Area of the faces over air that look down by more than 45 deg, mm^2."""
    corners = mesh.vertices[mesh.triangles]
    normals = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas, down = np.linalg.norm(normals, axis=1), -normals[:, 2]
    in_air = corners[:, :, 2].max(axis=1) > mesh.vertices[:, 2].min() + 0.02
    return float(areas[in_air & (down > 1.0001 * areas * math.sqrt(0.5))].sum())


def count_support_blocks(folder) -> int:
    """Slice the plate with the print settings next to it, and count the blocks of support."""
    result = slice_model(folder / "p_prusa-mk3s_1.3mf", folder / "p_prusa-mk3s_print.ini")
    assert result.returncode == 0, result.stdout + result.stderr
    return (folder / "p_prusa-mk3s_1.gcode").read_text().count(";TYPE:Support")


@pytest.mark.slow
@pytest.mark.programs
@pytest.mark.parametrize("kind", ["duck", "tee", "letters", "heart"])
def test_the_slicer_prints_supports_where_the_sheet_says_so(tmp_path, kind):
    layout, files = write_plate([make_design(kind, tmp_path)], tmp_path)
    assert (count_support_blocks(tmp_path) > 0) == ("| supports | on" in files["p_prusa-mk3s.md"].decode())
    # those that need none get none on a plate with another part that needs them
    (tmp_path / "p_prusa-mk3s_print.ini").write_bytes(slicer.prusaslicer_print(layout.printer, has_supports=True))
    assert (count_support_blocks(tmp_path) > 0) == any(layout.supported)


@pytest.mark.slow
@pytest.mark.programs
@pytest.mark.parametrize("kind", ["duck", "tee"])
def test_the_3mf_alone_switches_supports_on(tmp_path, kind):
    """Whatever the print settings say: a maker who keeps a preset of the slicer's own has them too."""
    layout = write_plate([make_design(kind, tmp_path)], tmp_path)[0]
    (tmp_path / "p_prusa-mk3s_print.ini").write_bytes(slicer.prusaslicer_print(layout.printer, has_supports=False))
    assert (count_support_blocks(tmp_path) > 0) == (kind == "duck")


@pytest.mark.parametrize("prusaslicer", [False, True])
def test_the_3mf_names_the_parts_with_supports(tmp_path, prusaslicer):
    designs = [make_design(kind, tmp_path) for kind in ("heart", "duck")]
    layout = plates.arrange(designs, [solids.build(design) for design in designs], [1, 2], MK3S)
    files = dict(plates.layout_files(layout, "p", None, prusaslicer))
    with zipfile.ZipFile(io.BytesIO(files["p_prusa-mk3s_1.3mf"])) as archive:
        orca, prusa = (
            ElementTree.fromstring(archive.read(f"Metadata/{name}.config"))
            for name in ("model_settings", "Slic3r_PE_model")
        )
    found = [{each.get("key"): each.get("value") for each in one.findall("metadata")} for one in orca.findall("object")]
    assert [one["name"].partition("_")[0] for one in found] == ["heart", "duck", "duck"]
    assert [one.get("enable_support") for one in found] == [None, "1", "1"]
    (duck,) = prusa.findall("object")  # a solid with two copies
    settings = {each.get("key"): each.get("value") for each in duck.findall("metadata")}
    assert settings == {"name": layout.parts[1].name, "support_material": "1", "support_material_buildplate_only": "1"}
    assert duck.find("volume").get("lastid") == str(len(layout.meshes[1].triangles) - 1)
