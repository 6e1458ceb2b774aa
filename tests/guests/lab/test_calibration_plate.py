"""Calibration plate: strips of whole lines that fit the bed, a sheet, and a form that stays."""

import json

import maker_profile
import numpy as np
import pytest
import threemf
from command_checks import rows_of
from slicing import print_of, program

from walkergen.core.printing import walls
from walkergen.core.printing.printers import Printer
from walkergen.core.shapes import modeller
from walkergen.core.walker import mass
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.lab import beams
from walkergen.guests.lab.calibrate import form, parts, plate, sheet
from walkergen.guests.lab.calibrate.request import CalibrateRequest

PAPER = templates.load("koumakis2016", "walkers", Design)
PRINTERS = {name: templates.load(name, "printers", Printer) for name in templates.names("printers")}


@pytest.mark.parametrize("printer", PRINTERS.values(), ids=PRINTERS)
def test_strips_are_whole_lines_that_both_methods_can_measure(printer):
    drawn = parts.make_strips(PAPER, printer)
    thicknesses = [one.strip.thickness for one in drawn]
    assert len(set(thicknesses)) == 4
    assert PAPER.limbs[0].thickness in thicknesses
    lines = [
        (one - walls.line_rounding(printer)) / (printer.line_width_mm - walls.line_rounding(printer))
        for one in thicknesses
    ]
    assert lines == pytest.approx([1, 2, 3, 4], abs=0.15)
    for one in drawn:
        strip = one.strip
        assert 30.0 < one.ring_hz < 50.0  # three pictures and more a swing at 120 a second
        assert parts.HEAVY_BEND_RATIO * strip.length >= 5.0  # ten times a ruler's error
        assert one.heavy_g <= 20.0
        assert sheet.nearest_weight(one.heavy_g)
        stiff = beams.bending_stiffness(PAPER.material.youngs_modulus, strip)
        long = beams.effective_length(strip.length, strip)
        assert beams.deflection(one.heavy_g, long, stiff) == pytest.approx(parts.HEAVY_BEND_RATIO * long, rel=0.02)
        layers = strip.width / printer.layer_height_mm
        assert layers == pytest.approx(round(layers))


def test_meshes_are_closed_and_as_large_as_drawn():
    printer = PRINTERS["prusa-mk3s"]
    for one in parts.make_strips(PAPER, printer):
        mesh, strip = parts.strip_mesh(one), one.strip
        assert modeller.count_bodies(mesh) == 1
        long, deep = parts.CLAMP_MM
        whole = (long * deep + strip.length * strip.thickness) * strip.width
        volume = mass.weigh(mesh, 1.0).mass
        assert 0.97 * whole < volume < whole  # less the number on it
        assert np.ptp(mesh.vertices, axis=0) == pytest.approx((long + strip.length, deep, strip.width))
    block = parts.block_mesh(printer)
    assert modeller.count_bodies(block) == 1
    assert mass.weigh(block, 1.0).mass == pytest.approx(parts.block_volume(*parts.block_size(printer)), rel=1e-9)


def test_a_plate_comes_with_map_sheet_settings_and_form(run, tmp_path):
    words = ("calibrate", "plate", "--printer", "prusa-mk3s,ender3", "--no-pictures")
    result = run(*words, "--out", "a")
    assert result.exit_code == 0, result.output
    folder = tmp_path / "a" / "calibration"
    names = {path.name for path in folder.iterdir()}
    for printer in ("prusa-mk3s", "ender3"):
        start = f"calibration_{printer}"
        ends = (".csv", ".md", ".ini", "_print.ini", "_orca.json", "_1.3mf", "_stl", ".json")
        assert {f"{start}{end}" for end in ends} <= names
        stl = sorted(path.stem for path in (folder / f"{start}_stl").iterdir())
        assert stl == ["block", "strip_1", "strip_2", "strip_3", "strip_4", "walker"]
        text = (folder / f"{start}.md").read_text(encoding="utf-8")
        assert "swings_20_s" in text
        assert "Import Config Bundle" in text
        rows = rows_of(folder / f"{start}.csv")
        bed = PRINTERS[printer]
        for row in rows:
            right = float(row["x_mm"]) + float(row["width_mm"])
            assert right <= bed.bed_width_mm - bed.margin_mm + 1e-6
    found = threemf.read_3mf((folder / "calibration_prusa-mk3s_1.3mf").read_bytes())
    assert found.sound
    parts_of = [item.part_number.rpartition("-")[0] for item in found.items]
    assert parts_of == ["strip_1", "strip_2", "strip_3", "strip_4", "block", "walker"]
    assert form.is_filled(folder / form.FORM_FILE) is False
    assert "strip_2,air_percent,5.0,2.0" in (folder / form.FORM_FILE).read_text()
    assert run(*words, "--out", "b").exit_code == 0
    for path in folder.rglob("*"):
        if path.is_file():
            other = tmp_path / "b" / "calibration" / path.relative_to(folder)
            assert other.read_bytes() == path.read_bytes()


def test_a_filled_form_is_left_alone_and_an_earlier_plate_is_not(run, tmp_path):
    words = ("calibrate", "plate", "--out", "a", "--no-pictures", "--quiet")
    assert run(*words).exit_code == 0
    path = tmp_path / "a" / "calibration" / form.FORM_FILE
    text = path.read_text().replace("strip_1,thickness_mm,,", "strip_1,thickness_mm,0.41,", 1)
    path.write_text(text)
    assert run(*words, "--tilt", "15").exit_code == 0
    assert path.read_text() == text
    manifest = json.loads((path.parent / "calibration_prusa-mk3s.json").read_text())
    assert manifest["design"]["legs"]["tilt_deg"] == 15.0
    told = run("calibrate", "plate", "--out", "a", "--no-pictures").stderr
    assert "keeps its contents, because it was edited" in told


def test_ordinary_weights_are_near_what_they_say():
    for _, grams in sheet.HOUSEHOLD_WEIGHTS:
        assert sheet.nearest_weight(grams)
    a4 = 21.0 * 29.7 * 0.008
    assert sheet.HOUSEHOLD_WEIGHTS[0][1] == pytest.approx(a4 / 29.7, rel=1e-2)
    assert sheet.nearest_weight(1e3) == ""


@pytest.mark.slow
@pytest.mark.programs
@pytest.mark.parametrize("name", ["prusa-mk3s", "ender3"])
def test_strips_slice_to_their_lines_and_the_block_to_its_volume(tmp_path, name):
    program("prusa-slicer")
    printer = PRINTERS[name]
    request = CalibrateRequest(what="plate", pictures=False)
    rows = plate.make_plate(request, PAPER, [printer], tmp_path, lambda *_: None, lambda _: None).table.rows
    model = tmp_path / "calibration" / f"calibration_{name}_1.3mf"
    (model.parent / "yours.ini").write_text(maker_profile.ini(printer))
    lines = print_of(model, model.with_name(f"calibration_{name}_print.ini")).lines
    start, end = lines.start - printer.bed_corner, lines.end - printer.bed_corner
    middle = 0.5 * (start + end)
    for row, one in zip(rows[:4], parts.make_strips(PAPER, printer), strict=True):
        at = row.x_mm + parts.CLAMP_MM[0] + 0.5 * one.strip.length
        across = (start[:, 0] - at) * (end[:, 0] - at) < 0.0
        across &= (middle[:, 1] > row.y_mm) & (middle[:, 1] < row.y_mm + row.depth_mm)
        layers = len(set(lines.z[across]))
        assert layers == round(one.strip.width / printer.layer_height_mm)
        assert across.sum() == layers * int(one.name[-1])  # lines in every layer
        along = np.abs(end - start)[across, 0]
        plastic = (lines.volume[across] / along).sum() / one.strip.width
        air = 0.01 * parts.air_percent(one, printer)
        assert plastic == pytest.approx((1.0 - air) * one.strip.thickness, rel=2e-3)
    row = rows[4]
    corner = np.array([row.x_mm, row.y_mm])
    size = np.array([row.width_mm, row.depth_mm])
    inside = ((middle > corner - 0.5) & (middle < corner + size + 0.5)).all(axis=1)
    drawn = parts.block_volume(*parts.block_size(printer))
    assert lines.volume[inside].sum() == pytest.approx(drawn, rel=0.01)
