"""Files for slicers: print settings that touch nothing else, names of copies, dates of archives."""

import io
import json
import re
import zipfile
from xml.etree import ElementTree

import maker_profile
import numpy as np
import pytest
import threemf
import trimesh

from walkergen.core.files import formatting
from walkergen.core.printing import export, plates, print_sheet, slicer
from walkergen.core.printing import packing as plate
from walkergen.core.printing.printers import Printer
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates

PRINTERS = [templates.load(name, "printers", Printer) for name in templates.names("printers")]
MK3S = templates.load("prusa-mk3s", "printers", Printer)
PAPER = templates.load("koumakis2016", "walkers", Design)
CORE = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"

every_printer = pytest.mark.parametrize("printer", PRINTERS, ids=lambda printer: printer.name)


def files_of(printer: Printer = MK3S, copies: tuple[int, int] = (2, 3), **more: bool):
    members = PAPER.members((5.0, 10.0), ["flexible"])
    built = [solids.build(design) for design in members]
    made = plates.arrange(members, built, copies, printer)
    return made, dict(plates.layout_files(made, "p", draw=None, **more))


@every_printer
def test_a_bundle_holds_print_settings_and_to_load_printer_and_filament_too(printer):
    head, section = slicer.prusaslicer_bundle(printer, PAPER.material).decode().split("\n\n")
    title, *told = section.strip().splitlines()
    assert title == f"[print:walkergen {printer.name}]"
    settings = slicer.prusaslicer_settings(printer)
    assert settings_of(told) == settings
    assert settings.keys().isdisjoint(maker_profile.profile(printer))
    loaded = settings_of(head.splitlines())
    owned = {key: loaded.pop(key) for key in loaded.keys() - settings.keys()}
    assert loaded == settings
    # the settings that a user's own profile would have, and nothing else
    assert owned.keys() <= maker_profile.profile(printer).keys()
    same = ("bed_shape", "max_print_height", "nozzle_diameter", "filament_density")
    assert {key: owned[key] for key in same} == {key: maker_profile.profile(printer)[key] for key in same}


@every_printer
def test_print_settings_alone_leave_printer_and_filament(printer):
    lines = slicer.prusaslicer_print(printer).decode().splitlines()
    assert settings_of(lines) == slicer.prusaslicer_settings(printer)


def settings_of(lines: list[str]) -> dict[str, str]:
    return dict(line.split(" = ") for line in lines if not line.startswith("#"))


@every_printer
def test_a_process_preset_is_one_that_every_printer_takes(printer):
    preset = json.loads(slicer.orca_json(printer))
    assert (preset["type"], preset["from"], preset["inherits"]) == ("process", "User", "")
    assert preset["name"] == preset["print_settings_id"] == f"walkergen {printer.name}"
    assert re.fullmatch(r"1\.\d+\.\d+\.\d+", preset["version"])
    assert all(isinstance(value, str) for value in preset.values())
    assert not any(key.startswith(("compatible", "printer", "filament", "nozzle")) for key in preset)


# What both programs call the same thing, from the lists of their print options.
ORCA_NAMES = {
    "layer_height": "layer_height",
    "first_layer_height": "initial_layer_print_height",
    "extrusion_width": "line_width",
    "external_perimeter_extrusion_width": "outer_wall_line_width",
    "perimeter_extrusion_width": "inner_wall_line_width",
    "infill_extrusion_width": "sparse_infill_line_width",
    "solid_infill_extrusion_width": "internal_solid_infill_line_width",
    "top_infill_extrusion_width": "top_surface_line_width",
    "first_layer_extrusion_width": "initial_layer_line_width",
    "perimeter_generator": "wall_generator",
    "thin_walls": "detect_thin_wall",
    "min_bead_width": "min_bead_width",
    "min_feature_size": "min_feature_size",
    "perimeters": "wall_loops",
    "fill_density": "sparse_infill_density",
    "infill_overlap": "infill_wall_overlap",
    "brim_width": "brim_width",
    "skirts": "skirt_loops",
    "skirt_distance": "skirt_distance",
    "skirt_height": "skirt_height",
    "elefant_foot_compensation": "elefant_foot_compensation",
    "xy_size_compensation": "xy_contour_compensation",
    "raft_layers": "raft_layers",
    "support_material": "enable_support",
    "support_material_buildplate_only": "support_on_build_plate_only",
    "support_material_threshold": "support_threshold_angle",
}
OTHER_SETTINGS = {
    "gap_fill_enabled",
    "fill_pattern",
    "brim_type",
    "min_skirt_length",
    "complete_objects",
    "gcode_label_objects",
}


@pytest.mark.parametrize("changes", [{}, {"brim_width_mm": 3.0, "skirt_loops": 2}])
@every_printer
def test_all_slicers_get_the_same_settings(printer, changes):
    printer = printer.model_copy(update=changes)
    prusa, orca = slicer.prusaslicer_settings(printer), slicer.orca_settings(printer)
    assert {ours: orca[theirs] for ours, theirs in ORCA_NAMES.items()} == {ours: prusa[ours] for ours in ORCA_NAMES}
    assert set(prusa) == set(ORCA_NAMES) | OTHER_SETTINGS
    # of their own: two walls on top as everywhere
    assert (orca["only_one_wall_top"], orca["top_one_wall_type"]) == ("0", "not apply")
    assert orca["sparse_infill_pattern"] == "zig-zag"
    assert orca["brim_type"] == ("outer_only" if changes else "no_brim")


def archive_of(data: bytes) -> zipfile.ZipFile:
    return zipfile.ZipFile(io.BytesIO(data))


def pairs(element) -> dict[str, str]:
    return {one.get("key"): one.get("value") for one in element.findall("metadata")}


def test_copies_and_plates_have_names_in_orca_slicer_and_bambu_studio():
    made, files = files_of()
    archive = archive_of(files["p_prusa-mk3s_1.3mf"])
    wanted = [row.item for row in plates.list_copy_positions(made)]
    assert wanted[1] == "walker_t05.0_flexible_s0.40-2"
    told = ElementTree.fromstring(archive.read("Metadata/model_settings.config"))
    model = ElementTree.fromstring(archive.read("3D/3dmodel.model"))
    objects = {one.get("id"): one for one in model.iter(f"{CORE}object")}
    built = [item.get("objectid") for item in model.iter(f"{CORE}item")]
    named = told.findall("object")
    assert [pairs(one)["name"] for one in named] == wanted
    assert [one.get("id") for one in named] == built  # the item's own object, in the map's order
    assert [objects[number].get("name") for number in built] == wanted
    for one in named:
        (component,) = objects[one.get("id")].iter(f"{CORE}component")
        (part,) = one.findall("part")
        assert part.get("id") == component.get("objectid")
        assert pairs(part)["name"] == objects[part.get("id")].get("name")
    (one,) = told.findall("plate")
    assert pairs(one) == {"plater_id": "1", "plater_name": "p_prusa-mk3s_1", "locked": "false"}
    listed = [pairs(each) for each in one.findall("model_instance")]
    assert [each["object_id"] for each in listed] == built
    assert b'Extension="config"' in archive.read("[Content_Types].xml")


@pytest.mark.parametrize("name", ["<b>&\"'", "a\x00b\ud800", "é€😀"])
def test_hostile_names_stay_text_in_the_settings_too(name):
    solid = export.Solid(name, solids.build(PAPER).walker)
    items = [export.Item(0, f"{name}-{copy}", 40.0 * copy, 0.0) for copy in (1, 2)]
    data = export.threemf_bytes([solid], items, name)
    told = ElementTree.fromstring(archive_of(data).read("Metadata/model_settings.config"))
    meant = export.INVALID_XML.sub("_", name)
    assert [pairs(one)["name"] for one in told.findall("object")] == [f"{meant}-1", f"{meant}-2"]
    assert pairs(told.find("plate"))["plater_name"] == meant
    threemf.read_3mf(data)


@pytest.mark.parametrize("prusaslicer", [False, True])
def test_every_file_in_an_archive_has_a_date_that_exists(prusaslicer):
    _, files = files_of(prusaslicer=prusaslicer)
    data = files["p_prusa-mk3s_1.3mf"]
    entries = archive_of(data).infolist()
    earliest = (1980, 1, 1, 0, 0, 0)
    assert {entry.date_time for entry in entries} == {earliest}
    assert {entry.create_system for entry in entries} == {0}  # equal bytes on every system
    assert archive_of(export.part_3mf(solids.build(PAPER).walker, "one")).infolist()[0].date_time == earliest
    assert data == files_of(prusaslicer=prusaslicer)[1]["p_prusa-mk3s_1.3mf"]


def test_the_sheet_states_how_to_load_the_settings_and_the_plastic_of_a_plate():
    made, files = files_of()
    told = files["p_prusa-mk3s.md"].decode()
    for word in (
        "Import Config Bundle",
        "`p_prusa-mk3s.ini`",
        "`p_prusa-mk3s_orca.json`",
        "`walkergen prusa-mk3s`",
        "not Import Config",
    ):
        assert word in told
    assert all(name in files for name in re.findall(r"`(p_[\w-]+\.\w+)`", told) if ".gc" not in name)
    (one,) = made.plates
    weighed = [print_sheet.expected_masses("", *each, MK3S) for each in zip(made.members, made.built, strict=True)]
    found = print_sheet.plate_totals(one, made.parts, [each.load for each in weighed], MK3S)
    grams = 2 * weighed[0].load.grams + 3 * weighed[1].load.grams
    assert found.grams == pytest.approx(grams)
    # 1.75 mm filament: 2.4053 mm^2
    assert found.metres == pytest.approx(grams / PAPER.material.density_g_cm3 / 2.4053, rel=1e-4)
    assert found.layers == 40  # 8 mm of 0.2 mm
    row = f"| `p_prusa-mk3s_1.3mf` | {found.grams:.2f} | {found.metres:.2f} | 40 |"
    assert row in told


def test_sides_are_a_bodys_outline_times_its_height():
    box = mesh_of_box(28.0, 3.0, 8.0)
    assert print_sheet.side_area(box) == pytest.approx(2.0 * (28.0 + 3.0) * 8.0)


def mesh_of_box(*lengths: float) -> Mesh:
    box = trimesh.creation.box(lengths)
    return Mesh(np.array(box.vertices), np.array(box.faces))


def test_half_a_layer_prints_as_one():
    part = plate.Part("flat", 10.0, 10.0, 0.5, 1)
    (one,) = plate.pack([part], MK3S)
    assert print_sheet.plate_totals(one, [part], [print_sheet.Load(1.0, 1.24, 9.0)], MK3S).layers == 3


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(4.94, "4.9 s"), (119.0, "120 s"), (121.0, "2 min"), (6900.0, "120 min"), (7200.0, "2 h"), (400000.0, "4.6 days")],
)
def test_times_have_two_digits_and_a_unit(seconds, words):
    assert formatting.format_duration(seconds) == words
