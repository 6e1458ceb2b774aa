"""Plates as files: maps that agree with the 3MF, equal bytes, one command for two printers."""

import csv
import io
import json
import os
import re
import shutil
import subprocess
import zipfile

import executed_lines
import pytest
import threemf
from command_checks import rows_of

from walkergen.commands.plate import make as batch
from walkergen.commands.plate.request import PlateRequest
from walkergen.core.errors import PlateError
from walkergen.core.printing import plates
from walkergen.core.printing.printers import Printer
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.sheets import plate_map

PAPER = templates.load("koumakis2016", "walkers", Design)
PRINTERS = [templates.load(name, "printers", Printer) for name in ("prusa-mk3s", "replicator2x")]


def layout_of(printer: Printer, tilts=(5.0, 10.0), copies=(40, 60), **limits) -> plates.Layout:
    members = PAPER.members(tilts, ["flexible"])
    built = [solids.build(design) for design in members]
    return plates.arrange(members, built, copies, printer, **limits)


def png_size(data: bytes) -> tuple[int, int]:
    assert data.startswith(b"\x89PNG")
    return int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")


@pytest.mark.parametrize("printer", PRINTERS, ids=lambda printer: printer.name)
def test_the_map_shows_the_place_of_every_part_in_the_3mf_file(printer):
    files = dict(plates.layout_files(layout_of(printer), "plate", draw=None))
    rows = list(csv.DictReader(io.StringIO(files[f"plate_{printer.name}.csv"].decode())))
    assert list(rows[0]) == list(plates.CopyPosition._fields)
    centred = printer.origin == "centre"
    left, front = (-0.5 * printer.bed_width_mm, -0.5 * printer.bed_depth_mm) if centred else (0.0, 0.0)
    seen = 0
    for name, data in files.items():
        if name.endswith(".3mf"):
            number = name.removesuffix(".3mf").rsplit("_", 1)[1]
            own = {row["item"]: row for row in rows if row["plate"] == number}
            items = threemf.read_3mf(data).items
            assert [item.part_number for item in items] == list(own)
            for item in items:
                row = own[item.part_number]
                low = left + float(row["x_mm"]), front + float(row["y_mm"]), 0.0
                # 32-bit floats below 256 mm and six decimals in the file: 2e-5 mm
                assert item.low == pytest.approx(low, abs=2e-5)
                high = low[0] + float(row["width_mm"]), low[1] + float(row["depth_mm"])
                assert item.high[:2] == pytest.approx(high, abs=2e-5)
            seen += len(items)
    assert seen == len(rows) == 100


def test_a_thumbnail_is_in_the_package_and_nowhere_without_pictures():
    layout = layout_of(PRINTERS[0], copies=(2, 2))
    files = dict(plates.layout_files(layout, "plate", draw=plate_map.draw_pictures))
    assert list(files) == [
        f"plate_prusa-mk3s{end}" for end in (".csv", ".md", ".ini", "_print.ini", "_orca.json", "_1.png", "_1.3mf")
    ]
    archive = zipfile.ZipFile(io.BytesIO(files["plate_prusa-mk3s_1.3mf"]))
    assert png_size(archive.read("Metadata/thumbnail.png")) == (256, 215)
    assert b"metadata/thumbnail" in archive.read("_rels/.rels")
    threemf.read_3mf(files["plate_prusa-mk3s_1.3mf"])
    plain = dict(plates.layout_files(layout, "plate", draw=None))
    assert len(plain) == 6
    bare = zipfile.ZipFile(io.BytesIO(plain["plate_prusa-mk3s_1.3mf"])).namelist()
    assert not any("thumbnail" in name for name in bare)


def test_equal_orders_give_equal_bytes():
    first, second = (
        dict(plates.layout_files(layout_of(PRINTERS[1], copies=(3, 3)), "plate", draw=plate_map.draw_pictures))
        for _ in range(2)
    )
    assert first == second


def test_one_mesh_serves_all_copies():
    files = [
        dict(plates.layout_files(layout_of(PRINTERS[0], copies=copies), "p", draw=None))
        for copies in ((1, 1), (50, 50))
    ]
    one, two = (threemf.read_3mf(each["p_prusa-mk3s_1.3mf"]) for each in files)
    assert one.names == two.names
    assert len(two.items) > len(one.items) == 2


@pytest.mark.slow
def test_two_hundred_walkers_go_to_two_printers_with_one_command(run, tmp_path):
    quota = "5:50,10:50,15:50,20:50"
    result = run("plate", "koumakis2016", "--copies", quota, "--printer", "prusa-mk3s,replicator2x", "--json")
    assert result.exit_code == 0
    found = json.loads(result.stdout)
    for printer in ("prusa-mk3s", "replicator2x"):
        own = [row for row in found["rows"] if row["printer"] == printer]
        assert len({row["item"] for row in own}) == len(own) == 200
        assert [sum(row["tilt_deg"] == t for row in own) for t in (5, 10, 15, 20)] == [50] * 4
    assert all((tmp_path / name).is_file() for name in found["files"])
    kinds = [name.rsplit(".", 1)[1] for name in found["files"]]
    assert (kinds.count("csv"), kinds.count("png"), kinds.count("3mf")) == (3, 5, 5)
    template = (tmp_path / "out" / "koumakis2016" / "weights.csv").read_text().splitlines()
    assert len(template) == 201
    assert template[1] == "walker_t05.0_flexible_s0.40-1,,,"


def test_how_many_fit_is_answered_without_writing(run, tmp_path):
    both = "prusa-mk3s,ender3"
    result = run("plate", "--tilt", "10,45", "--how-many", "--printer", both, "--json")
    rows = json.loads(result.stdout)["rows"]
    assert [(row["printer"], row["fit"]) for row in rows] == [
        ("prusa-mk3s", 105),
        ("prusa-mk3s", 119),
        ("ender3", 90),
        ("ender3", 108),
    ]
    assert not list(tmp_path.iterdir())
    limited = run("plate", "--how-many", "--max-parts", "40").stdout
    assert " prusa-mk3s   40  walker_t10.0_flexible_s0.40 \n" in limited
    for row in rows:  # the answer is what a plate really holds
        tilt = row["name"].split("_")[1].removeprefix("t")
        words = ("plate", "--tilt", tilt, "--printer", row["printer"], "--no-pictures", "--quiet")
        assert run(*words, "--copies", str(row["fit"]), "--max-plates", "1").exit_code == 0
        more = run(*words, "--copies", str(row["fit"] + 1), "--max-plates", "1")
        assert isinstance(more.exception, PlateError)


def test_a_thousand_parts_are_planned_in_one_pass_over_solids_built_once(tmp_path, monkeypatch):
    members = PAPER.members([5.0, 10.0], ["flexible"])
    genuine, built, plans = solids.build, [], []

    def build(design, *more):
        built.append(design)
        return genuine(design, *more)

    def plan(copies):
        inputs, steps = batch.PlateInputs(members, [copies, copies], PRINTERS[:1], "walker"), []
        request = PlateRequest(out=tmp_path / str(copies), pictures=False)
        made = batch.make(request, inputs, lambda *step: steps.append(step[1:]))
        plans.append((made, steps))

    monkeypatch.setattr(solids, "build", build)
    half, whole = (executed_lines.lines(lambda copies=copies: plan(copies)) for copies in (250, 500))
    assert built == [*members, *members]
    assert whole < 2.1 * half  # no part is compared with those of another plate: 1.96 measured
    report, steps = plans[1]
    assert len(report.places) == 1000
    own = len(report.files) - 1  # the form for weighing is next to the plates, and is no step
    assert steps == [(k, own) for k in range(1, own + 1)]


def test_one_command_makes_a_family_of_many_copies_with_its_legend(run, tmp_path):
    (tmp_path / "my.toml").write_text('[marks]\nkind = "notches"\n')
    result = run("family", "my.toml", "--copies", "5:3,10:4", "--legs", "flexible", "--no-pictures", "--max-parts", "5")
    assert result.exit_code == 0, result.exception
    folder = tmp_path / "out" / "my"
    rows = rows_of(folder / "plates" / "family_prusa-mk3s.csv")
    assert [row["plate"] for row in rows] == ["1"] * 5 + ["2"] * 2
    assert {row["mark"] for row in rows} == {"### # # ## #", "### # # ## ##"}
    told = run("plate", "my.toml", "--copies", "5:1,10:1", "--no-pictures").stdout
    assert " 1       walker_t10.0_flexible_s0.40  ### # # ## ## \n" in told
    assert "read from the start" in told
    page = (folder / "family.md").read_text()
    assert "| 10 | `### # # ## ##` |" in page
    assert "read from the start, ### (2.4 mm wide" in page


def test_weighed_masses_change_the_family_and_stay(run, tmp_path):
    words = ("family", "--copies", "8:2,9:2", "--legs", "flexible", "--no-pictures", "--quiet", "--out", "here")
    assert run(*words).exit_code == 0
    path = tmp_path / "here" / "weights.csv"
    path.write_text(path.read_text().replace("s0.40,,,", "s0.40,,,0.04"))
    text = path.read_text()
    assert run(*words, "--weights", str(path)).exit_code == 0
    assert run(*words).exit_code == 0  # and a print without it does not sweep it away
    assert path.read_text() == text
    assert run(*words, "--weights", str(path)).exit_code == 0
    rows = rows_of(tmp_path / "here" / "family.csv")
    for row in rows:
        assert float(row["m_g"]) == 0.04
        assert row["speed_mm_s"] != row["speed_mesh_mm_s"]  # by 0.5 %: tips take the landing, for any mass of the leg
    assert "## Weighed" in (tmp_path / "here" / "family.md").read_text()
    manifest = json.loads((tmp_path / "here" / "manifest.json").read_text())
    assert manifest["weighed"]["walker_t08.0_flexible_s0.40"]["leg_g"]["mean"] == 0.04
    assert manifest["copies"] == [2, 2]
    shown = run("predict", "--tilt", "8,9", "--weights", str(path)).stdout
    assert "mesh's" in shown
    assert max(len(line) for line in shown.splitlines()) <= 80
    told = json.loads(run("predict", "--tilt", "8,9", "--weights", str(path), "--json").stdout)
    speed = told["rows"][0]["speed_mm_s"]
    assert told["rows"][0]["speed_mesh_mm_s"] != speed
    assert told["rows"][0]["speed_mesh_mm_s"] == pytest.approx(speed, rel=0.05)


def test_a_file_for_prusaslicer_holds_the_same_parts():
    layout = layout_of(PRINTERS[0], copies=(2, 3))
    plain, own = (
        dict(plates.layout_files(layout, "p", plate_map.draw_pictures, prusaslicer))["p_prusa-mk3s_1.3mf"]
        for prusaslicer in (False, True)
    )
    one, other = threemf.read_3mf(plain), threemf.read_3mf(own)
    assert other.metadata == one.metadata | {"Version3mf": "1"}
    assert (one.names, one.items, one.identifiers) == (other.names, other.items, other.identifiers)
    assert own == dict(plates.layout_files(layout, "p", plate_map.draw_pictures, True))["p_prusa-mk3s_1.3mf"]


@pytest.mark.slow
@pytest.mark.programs
@pytest.mark.parametrize("printer", PRINTERS, ids=lambda printer: printer.name)
def test_prusaslicer_numbers_the_copies_as_the_map_does(tmp_path, printer):
    """Label `copy k` is copy k + 1 of the map, where the map says, and each part is one object."""
    program = shutil.which("prusa-slicer")
    if program is None:
        assert os.environ.get("CI") != "true", "CI installs PrusaSlicer"
        pytest.skip("prusa-slicer is not installed (Debian: apt-get install prusa-slicer)")
    layout = layout_of(printer, copies=(5, 4))
    data = dict(plates.layout_files(layout, "p", None, True))[f"p_{printer.name}_1.3mf"]
    path = tmp_path / "p.3mf"
    path.write_bytes(data)
    bed = printer.bed_width_mm, printer.bed_depth_mm
    left, front = (-0.5 * bed[0], -0.5 * bed[1]) if printer.origin == "centre" else (0.0, 0.0)
    shape = ",".join(f"{left + x}x{front + y}" for x, y in ((0, 0), (bed[0], 0), bed, (0, bed[1])))
    options = f"--export-gcode --dont-arrange --gcode-label-objects --bed-shape {shape} --output p.gcode p.3mf"
    subprocess.run([program, *options.split()], cwd=tmp_path, check=True, capture_output=True, timeout=100)
    found: dict[str, list[tuple[float, float]]] = {}
    label = None
    for line in (tmp_path / "p.gcode").read_text().splitlines():
        if line.startswith("; printing object "):
            label = line.removeprefix("; printing object ")
        elif line.startswith("; stop printing"):
            label = None
        elif label and (move := re.match(r"G1 X([-\d.]+) Y([-\d.]+) E\d", line)):
            found.setdefault(label, []).append((float(move[1]), float(move[2])))
    rows = plates.list_copy_positions(layout)
    names = list(dict.fromkeys(row.name for row in rows))
    wanted = {f"{row.name} id:{names.index(row.name)} copy {row.copy - 1}": row for row in rows}
    assert set(found) == set(wanted)
    for name, row in wanted.items():
        xs, ys = zip(*found[name], strict=True)
        middle = 0.5 * (min(xs) + max(xs)) - left, 0.5 * (min(ys) + max(ys)) - front
        # lines lie half a width inside on every side; thin feet may end a line early
        assert middle[0] == pytest.approx(row.x_mm + 0.5 * row.width_mm, abs=0.1)
        assert middle[1] == pytest.approx(row.y_mm + 0.5 * row.depth_mm, abs=0.5)


def test_a_second_order_removes_the_plates_of_the_first_and_keeps_a_users_files(run, tmp_path):
    words = ("plate", "--no-pictures", "--quiet", "--out", "here")
    assert run(*words, "--tilt", "5", "--copies", "3", "--max-parts", "1").exit_code == 0
    folder = tmp_path / "here" / "plates"
    (folder / "notes.txt").write_text("mine")
    (folder / "plate_prusa-mk3s_2.3mf").write_bytes(b"arranged by hand")
    assert run(*words, "--tilt", "10").exit_code == 0
    ends = (".csv", ".ini", "_print.ini", ".json", ".md", "_1.3mf", "_2.3mf", "_orca.json")
    assert {path.name for path in folder.iterdir()} == {"notes.txt", *(f"plate_prusa-mk3s{end}" for end in ends)}
    assert (folder / "plate_prusa-mk3s_2.3mf").read_bytes() == b"arranged by hand"
