"""What a real slicer makes of our files: PrusaSlicer's G-code, read line by line, and ADMesh.

Skipped where the programs are absent: see slicing.program.
"""

import re
import shlex
import subprocess
from typing import NamedTuple

import gcode
import maker_profile
import numpy as np
import pytest
from slicing import Walker, laid_out, print_of, program, slice_model, walkers_of

from walkergen.commands.export import make as exports
from walkergen.commands.plate import make as batch
from walkergen.commands.plate.request import PlateRequest
from walkergen.core.printing import checks, export, findings, plates, print_sheet, slicer, walls
from walkergen.core.printing.packing import Part, Placement, Plate
from walkergen.core.printing.printers import Printer
from walkergen.core.walker import mass, names, solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.sections import section_of
from walkergen.files import templates

pytestmark = [pytest.mark.slow, pytest.mark.programs]

PRINTERS = ["prusa-mk3s", "ender3", "replicator2x"]  # classic, arachne, origin in the middle
TILTS = (0.0, 8.0, 15.0, 40.0)
FLAT_BED = Printer(name="test", bed_width_mm=250.0, bed_depth_mm=210.0, height_mm=210.0)


class Batch(NamedTuple):
    """A family's plate as made, and as sliced."""

    members: list[Design]
    rows: list[plates.CopyPosition]
    printed: gcode.Printed
    walkers: list[Walker | None]
    printer: Printer
    text: str
    """G-code."""
    sheet: str


@pytest.fixture(scope="module", params=PRINTERS)
def sliced_family(request, tmp_path_factory) -> Batch:
    program("prusa-slicer")
    folder = tmp_path_factory.mktemp("plates")
    printer = templates.load(request.param, "printers", Printer)
    paper = templates.load("koumakis2016", "walkers", Design)
    members = paper.members(TILTS, ["flexible", "braced"])
    inputs = batch.PlateInputs(members, [2] * len(members), [printer], "walker")
    report = batch.make(PlateRequest(out=folder, pictures=False), inputs, lambda *step: None)
    rows, files = report.places, report.files
    (model,) = [path for path in files if path.suffix == ".3mf"]
    (model.parent / "yours.ini").write_text(maker_profile.ini(printer))
    printed = print_of(model, model.with_name(f"plate_{printer.name}_print.ini"))
    number = {names.part_name(member): index for index, member in enumerate(members)}
    where = [Placement(number[row.name], row.copy, row.x_mm, row.y_mm) for row in rows]
    walkers = walkers_of(printed, members, where, printer)
    text = model.with_suffix(".gcode").read_text()
    sheet = model.with_name(f"plate_{printer.name}.md").read_text(encoding="utf-8")
    return Batch(members, rows, printed, walkers, printer, text, sheet)


def test_every_walker_is_printed_at_its_place_under_its_name(sliced_family):
    rows, printed = sliced_family.rows, sliced_family.printed
    assert len(printed.items) == len(rows) == 4 * len(TILTS)
    assert sorted(name for name, _ in printed.items) == sorted(row.name for row in rows)
    assert None not in sliced_family.walkers
    assert [walker.name for walker in sliced_family.walkers] == [row.name for row in rows]


def test_every_leg_has_plastic_in_every_layer(sliced_family):
    for walker in sliced_family.walkers:
        legs = walker.legs
        assert legs.shape == (40, 2)
        # The first layers differ by their fill's direction only.
        assert legs.min() > 0.9 * legs.mean()


def test_legs_get_the_plastic_that_the_checks_promise(sliced_family):
    for walker in sliced_family.walkers:
        mesh = mass.weigh(solids.build(walker.design).legs[0], 1.0).volume
        promised = walls.leg_plastic_ratio(walker.limb, walker.printer)
        tolerance = section_of(walker.limb).PLASTIC_TOLERANCE
        assert walker.legs.sum(axis=0) / mesh == pytest.approx([promised] * 2, abs=tolerance)


def test_bodies_get_the_plastic_of_their_mesh(sliced_family):
    for walker in sliced_family.walkers:
        mesh = mass.weigh(solids.build(walker.design).body, 1.0).volume
        plastic = walker.lines.volume.sum() - walker.legs.sum()
        assert plastic / mesh == pytest.approx(1.0, abs=0.015)  # infill overlap 25 %: 1.04 to 1.05


def test_the_slicer_takes_every_setting_of_the_profile(sliced_family):
    wanted = slicer.prusaslicer_settings(sliced_family.printer)
    assert {key: sliced_family.printed.settings.get(key) for key in wanted} == wanted


def test_printer_and_filament_stay_the_makers_own(sliced_family):
    """Bed 60 C and nozzle 215 C, density and start code are her profile's, not our settings'."""
    text, settings = sliced_family.text, sliced_family.printed.settings
    wanted = maker_profile.profile(sliced_family.printer)
    assert {key: settings.get(key) for key in wanted} == wanted
    heating = re.findall(r"^(M1(?:04|09|40|90) S\d+)", text, re.MULTILINE)
    assert heating == ["M104 S215", "M140 S60", "M190 S60", "M109 S215", "M104 S210", "M104 S0", "M140 S0"]
    assert 'M862.3 P "MK3S"' in text
    assert slicer.prusaslicer_settings(sliced_family.printer).keys().isdisjoint(wanted)


def write_plates(design: Design, copies: int, printer: Printer, folder) -> None:
    """Write plates of copies of a design."""
    request = PlateRequest(design=design, copies=copies, printer=printer, out=folder, pictures=False)
    request.run(lambda *step: None)


def compare_with_the_slicer(sheet: str, text: str) -> None:
    """The sheet's only plate against G-code: masses within 1 %, which the infill overlap allows."""
    row = re.search(r"\| `plate_\S+` \| ([\d.]+) \| ([\d.]+) \| (\d+) \| .*\| ([\d.]+) (h|min) \|", sheet)
    grams, metres, layers = float(row[1]), float(row[2]), int(row[3])
    minutes = float(row[4]) * (60.0 if row[5] == "h" else 1.0)

    def header_value(what: str) -> str:
        return re.search(rf"^; {what} = (.*)$", text, re.MULTILINE)[1]

    assert grams == pytest.approx(float(header_value(r"total filament used \[g\]")), rel=0.01)
    assert metres == pytest.approx(1e-3 * float(header_value(r"filament used \[mm\]")), rel=0.01)
    assert layers == len(np.unique(gcode.read_gcode(text).lines.z))
    words = header_value(r"estimated printing time \(normal mode\)").split()
    length = {"h": 60.0, "m": 1.0, "s": 1.0 / 60.0}
    theirs = sum(float(word[:-1]) * length[word[-1]] for word in words)
    assert minutes == pytest.approx(theirs, rel=print_sheet.TIME_TOLERANCE)


def test_plastic_and_time_of_the_print_sheet_are_the_slicers(sliced_family):
    compare_with_the_slicer(sliced_family.sheet, sliced_family.text)


@pytest.mark.nightly
@pytest.mark.parametrize("name", templates.names("walkers"))
def test_plastic_and_time_of_every_shipped_walker_are_the_slicers(tmp_path, name):
    printer = templates.load("prusa-mk3s", "printers", Printer)
    design = templates.load(name, "walkers", Design)
    write_plates(design, 3, printer, tmp_path)
    folder = tmp_path / "plates"
    (folder / "yours.ini").write_text(maker_profile.ini(printer))
    model = folder / "plate_prusa-mk3s_1.3mf"
    result = slice_model(model, folder / "plate_prusa-mk3s_print.ini")
    assert result.returncode == 0, result.stdout + result.stderr
    sheet = (folder / "plate_prusa-mk3s.md").read_text(encoding="utf-8")
    compare_with_the_slicer(sheet, model.with_suffix(".gcode").read_text())


def test_the_command_on_the_print_sheet_runs_as_shown(tmp_path):
    program("prusa-slicer")
    printer = templates.load("ender3", "printers", Printer)
    write_plates(Design(), 2, printer, tmp_path)
    folder = tmp_path / "plates"
    sheet = (folder / "plate_ender3.md").read_text(encoding="utf-8")
    (folder / "yours.ini").write_text(maker_profile.ini(printer))
    commands = re.findall(r"^prusa-slicer .*$", sheet, re.MULTILINE)
    assert len(commands) == 2
    target = folder / "plate_ender3_1.gcode"
    for command in commands:
        subprocess.run(shlex.split(command), cwd=folder, capture_output=True, check=True)
        assert len(gcode.read_gcode(target.read_text()).items) == 2
        target.unlink()


PETG = {"density_g_cm3": 1.27, "nozzle_deg_c": 240, "bed_deg_c": 85}


@pytest.mark.parametrize("material", [{}, PETG], ids=["PLA", "PETG"])
@pytest.mark.parametrize("name", templates.names("printers"))
def test_the_bundle_alone_has_the_heat_and_density_of_the_material(tmp_path, name, material):
    program("prusa-slicer")
    printer = templates.load(name, "printers", Printer)
    design = Design.model_validate({"material": material})
    write_plates(design, 2, printer, tmp_path)
    folder = tmp_path / "plates"
    sheet = (folder / f"plate_{name}.md").read_text(encoding="utf-8")
    alone = re.findall(r"^prusa-slicer .*$", sheet, re.MULTILINE)[1]
    subprocess.run(shlex.split(alone), cwd=folder, capture_output=True, check=True)
    text = (folder / f"plate_{name}_1.gcode").read_text()
    nozzle, bed = design.material.nozzle_deg_c, design.material.bed_deg_c
    heating = re.findall(r"^(M1(?:04|09|40|90) S\d+)", text, re.MULTILINE)
    assert sorted(heating) == sorted([f"M190 S{bed}", f"M104 S{nozzle}", f"M109 S{nozzle}", "M104 S0", "M140 S0"])
    compare_with_the_slicer(sheet, text)


THICKNESSES = tuple(round(0.16 + 0.04 * step, 2) for step in range(38))


@pytest.mark.parametrize(("line", "layer"), [(0.4, 0.1), (0.45, 0.3)])
@pytest.mark.parametrize(("generator", "thin"), [("classic", False), ("classic", True), ("arachne", False)])
def test_walls_get_the_plastic_of_the_flow_model(tmp_path, generator, thin, line, layer):
    changes = {"wall_generator": generator, "thin_walls": thin, "line_width_mm": line, "layer_height_mm": layer}
    printer = FLAT_BED.model_copy(update=changes)
    designs = [
        Design.model_validate({"legs": {"flexible_thickness_mm": one}, "body": {"depth_mm": 0.6}})
        for one in THICKNESSES
    ]
    where, model = laid_out(designs, printer, tmp_path)
    printed = print_of(model, model.with_suffix(".ini"))
    for walker in walkers_of(printed, designs, where, printer):
        thickness = walker.limb.thickness
        edges = [walls.printed_thickness(f * thickness, printer) for f in (0.97, 1.03)]
        if max(edges) - min(edges) > 0.07 * thickness:
            continue  # within 3 % of a step, where rounding decides
        low, high = walker.foot + 2.0, walker.bottom - 2.0
        drawn = thickness / np.cos(walker.limb.tilt) * (high - low) * walker.limb.width
        seen = walker.plastic_between(low, high).sum() / (2 * drawn)
        assert seen - 1.0 == pytest.approx(walls.plastic_deviation(thickness, printer), abs=0.01), thickness


def worst(design: Design, printer: Printer) -> str:
    mesh = solids.build(design).walker
    found = [*checks.check_part("it", design, mesh, printer), *checks.check_printer(printer)]
    return findings.group_findings(found)[0].level


def test_legs_that_the_checks_refuse_vanish_there_silently(tmp_path):
    """The issue's case: 0.45 mm and less, thin walls not detected."""
    printer = templates.load("prusa-mk3s", "printers", Printer)
    printer = printer.model_copy(update={"thin_walls": False})
    designs = [Design.model_validate({"legs": {"flexible_thickness_mm": t}}) for t in (0.4, 0.44)]
    assert [worst(design, printer) for design in designs] == ["error"] * 2
    where, model = laid_out(designs, printer, tmp_path)
    result = slice_model(model, model.with_suffix(".ini"))
    assert result.returncode == 0
    assert "warning" not in (result.stdout + result.stderr).lower()
    printed = gcode.read_gcode(model.with_suffix(".gcode").read_text())
    corner = np.array([where[0].x, where[0].y])
    low = solids.build(designs[0]).walker.vertices.min(axis=0)[:2]
    lowest = np.minimum(printed.lines.start, printed.lines.end)[:, 1].min()
    assert lowest - corner[1] + low[1] > -0.5 * designs[0].body.thickness_mm  # bodies alone


@pytest.mark.parametrize(
    ("changes", "depth"),
    [({"layer_height_mm": 0.45}, 9.0), ({"line_width_mm": 0.2}, 8.0), ({}, 0.09)],
    ids=["layer above the nozzle", "line no wider than the layer", "depth below half a layer"],
)
def test_the_slicer_refuses_what_the_checks_call_an_error(tmp_path, changes, depth):
    printer = FLAT_BED.model_copy(update=changes)
    design = Design.model_validate({"body": {"depth_mm": depth}})
    assert worst(design, printer) == "error"
    _, model = laid_out([design, design], printer, tmp_path)
    assert slice_model(model, model.with_suffix(".ini")).returncode != 0


@pytest.mark.parametrize("depth", [8.1, 8.05])
def test_depths_come_out_in_whole_layers(tmp_path, depth):
    design = Design.model_validate({"body": {"depth_mm": depth}})
    assert worst(design, FLAT_BED) == "warning"
    _, model = laid_out([design, design], FLAT_BED, tmp_path)
    layers = np.unique(print_of(model, model.with_suffix(".ini")).lines.z)
    (told,) = [
        finding
        for finding in checks.check_part("", design, solids.build(design).walker, FLAT_BED)
        if finding.unit == "layers"
    ]
    assert len(layers) == told.limit
    assert f"{layers.max():g}, which is what prints" in told.change


def test_brim_and_skirt_reach_as_far_as_in_the_checks_and_no_slicer_stops_them(tmp_path):
    printer = FLAT_BED.model_copy(update={"brim_width_mm": 2.0, "skirt_loops": 2, "skirt_distance_mm": 3.0})
    designs = [Design(), Design()]
    one = Plate((Placement(0, 1, 5.0, 5.0), Placement(1, 1, 45.0, 5.0)))
    _, model = laid_out(designs, printer, tmp_path, one)
    parts = [Part.from_mesh("one", solids.build(design).walker) for design in designs]
    (said,) = checks.check_plate("plate 1", one, parts, printer)
    lines = print_of(model, model.with_suffix(".ini")).lines
    reach = 0.5 * printer.line_width_mm - np.minimum(lines.start, lines.end).min()
    assert (said.level, said.where) == ("error", "plate 1: one-1")
    assert "skirt" in said.what
    assert said.seen == pytest.approx(reach, abs=0.5 * printer.line_width_mm)


def test_one_kind_alone_on_its_plate_takes_the_name_of_the_file(tmp_path):
    """PrusaSlicer's rule for a 3MF of one object, which the print sheet states; places are kept."""
    one = Plate((Placement(0, 1, 5.0, 5.0), Placement(0, 2, 45.0, 5.0)))
    where, model = laid_out([Design()], FLAT_BED, tmp_path, one)
    printed = print_of(model, model.with_suffix(".ini"))
    assert [name for name, _ in printed.items] == ["unchecked"] * 2
    assert None not in walkers_of(printed, [Design()], where, FLAT_BED)
    model.write_bytes(export.declare_prusaslicer(model.read_bytes()))
    printed = print_of(model, model.with_suffix(".ini"))
    assert sorted(printed.items) == [("part0", "0.0"), ("part0", "0.1")]
    assert None not in walkers_of(printed, [Design()], where, FLAT_BED)


def test_admesh_finds_every_stl_sound(tmp_path):
    members = [
        member for name in templates.names("walkers") for member in templates.load(name, "walkers", Design).members()
    ]
    members += Design.model_validate({"legs": {"foot": "round"}}).members([0.0, 10.0, -30.0])
    seen = set()
    for index, path in enumerate(exports.make(members, ["stl"], tmp_path, lambda *told: None).files):
        # ADMesh prints the header beyond its end, where the number of facets is no text.
        result = subprocess.run(
            [program("admesh"), str(path)], capture_output=True, text=True, errors="replace", check=True
        )
        numbers = {
            key.strip(): int(value) for key, value in re.findall(r"^\s*([A-Za-z ]+?)\s*:\s+(\d+)", result.stdout, re.M)
        }
        assert numbers["Number of parts"] == 1, path
        repaired = [
            "Degenerate facets",
            "Edges fixed",
            "Facets removed",
            "Facets added",
            "Facets reversed",
            "Backwards edges",
        ]
        assert [numbers[key] for key in repaired] == [0] * 6, path
        seen.add(index)
    assert len(seen) == len(members)
