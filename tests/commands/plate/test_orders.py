"""Order lists: several designs on one plate, told apart everywhere; bytes of one design stay."""

import csv
import hashlib
import io
import itertools
import json

import numpy as np
import pytest
import threemf

from walkergen.commands.family import preview
from walkergen.commands.plate import order_list
from walkergen.core.errors import InputError
from walkergen.core.printing import checks, packing, plates
from walkergen.core.printing.printers import Printer
from walkergen.core.walker import names, solids, weighed_masses
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.sheets import plate_map

PAPER = templates.load("koumakis2016", "walkers", Design)
LARGE = templates.load("maker-large", "walkers", Design)
PRINTER = templates.load("prusa-mk3s", "printers", Printer)
HEADER = "design,tilt_deg,legs,copies\n"
DUCK = """\
[body]
length_mm = 22.0
depth_mm = 6.1
[legs]
length_mm = 6.0
contact_spacing_mm = 9.0
[marks]
kind = "notches"
"""


@pytest.fixture
def lists(tmp_path):
    """Folder of lists, beside a design of one's own."""
    (tmp_path / "duck.toml").write_text(DUCK)
    folder = tmp_path / "lists"
    folder.mkdir()
    return folder


def files_below(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_rows_name_walkers_by_template_or_path_and_equal_rows_add_up(lists):
    path = lists / "orders.csv"
    path.write_text(
        HEADER + "koumakis2016,5,,6\n../duck.toml, 15 ,braced,2\n\nkoumakis2016,,,1\n"
        f"koumakis2016,-0,braced,3\n{lists.parent / 'duck.toml'},15.0,braced,2\n"
        "koumakis2016,0,braced,4\nkoumakis2016,10,flexible,2\n"
    )
    duck = templates.load(str(lists.parent / "duck.toml"), "walkers", Design)
    wanted = [
        (PAPER.variant(tilt_deg=5.0), 6),
        (duck.variant(tilt_deg=15.0, kind="braced"), 4),
        (PAPER, 3),  # blank cells: the design's own 10 deg on flexible legs
        (PAPER.variant(tilt_deg=0.0, kind="braced"), 7),
    ]
    assert list(zip(*order_list.read_orders(path), strict=True)) == wanted


def test_a_list_of_one_design_makes_the_bytes_of_the_command_line(run, lists, tmp_path):
    path = lists / "orders.csv"
    path.write_text(HEADER + "koumakis2016,5,flexible,3\nkoumakis2016,10,flexible,4\n")
    words = ("--printer", "ender3", "--quiet", "--out")
    assert run("plate", "--orders", str(path), *words, "listed").exit_code == 0
    assert run("plate", "--copies", "5:3,10:4", *words, "plain").exit_code == 0
    plain = files_below(tmp_path / "plain")
    assert len(plain) == 9
    assert files_below(tmp_path / "listed") == plain


def test_designs_share_plates_and_stay_apart_in_every_file(run, lists, tmp_path):
    path = lists / "June's orders.csv"
    path.write_text(HEADER + "../duck.toml,10,,40\nmaker-large,,braced,9\nkoumakis2016,10,,40\n../duck.toml,20,,1\n")
    result = run("plate", "--orders", str(path), "--no-pictures", "--json")
    assert result.exit_code == 0, result.exception
    assert all("duck_t10" in line for line in result.stderr.splitlines())  # by its own design
    assert "the depth is not a whole number of layers" in result.stderr
    folder = tmp_path / "out" / "June-s-orders"
    rows = json.loads(result.stdout)["rows"]
    items = [row["item"] for row in rows]
    assert len({item.casefold() for item in items}) == len(items) == 90
    assert {row["name"] for row in rows} == {
        "duck_t10.0_flexible_s0.40",
        "maker-large_t10.0_braced_s2.00",
        "koumakis2016_t10.0_flexible_s0.40",
        "duck_t20.0_flexible_s0.40",
    }
    assert max(row["plate"] for row in rows) == 1
    found = threemf.read_3mf((folder / "plates" / "plate_prusa-mk3s_1.3mf").read_bytes())
    assert found.sound
    assert [item.part_number for item in found.items] == items
    # Heights (z) in the file are each design's own depth.
    assert {(one.part_number.split("_")[0], round(one.high[2], 4)) for one in found.items} == {
        ("duck", 6.1),
        ("maker-large", 16.0),
        ("koumakis2016", 8.0),
    }
    gap = packing.spacing(PRINTER) - 2e-5  # 32-bit floats below 256 mm
    for one, other in itertools.combinations(found.items, 2):
        ways = [one.low[k] - other.high[k] for k in (0, 1)]
        back = [other.low[k] - one.high[k] for k in (0, 1)]
        assert max(*ways, *back) >= gap
    sheet = (folder / "plates" / "plate_prusa-mk3s.md").read_text()
    assert "| A | duck |\n| B | maker-large |\n| C | koumakis2016 |" in sheet
    assert "Marks of duck. Notches" in sheet
    assert "| `plate_prusa-mk3s_1.3mf` | `duck_t20.0_flexible_s0.40` | 1 |" in sheet
    assert "`weights_DESIGN.csv`" in sheet
    forms = {name: text for name, text in files_below(folder).items() if "weights" in name}
    assert sorted(forms) == [f"weights_{d}.csv" for d in ("duck", "koumakis2016", "maker-large")]
    told = [row["part"] for text in forms.values() for row in csv.DictReader(io.StringIO(text.decode()))]
    assert sorted(told) == sorted(items)


def test_a_design_reads_its_own_form_back(run, lists, tmp_path):
    path = lists / "orders.csv"
    path.write_text(HEADER + "../duck.toml,10,,2\nkoumakis2016,10,,2\n")
    words = ("plate", "--orders", str(path), "--no-pictures", "--quiet", "--out", "here")
    assert run(*words).exit_code == 0
    form = tmp_path / "here" / "weights_duck.csv"
    filled = form.read_text().replace("-1,,,", "-1,0.5,,").replace("-2,,,", "-2,0.6,,")
    form.write_text(filled)
    duck = templates.load(str(tmp_path / "duck.toml"), "walkers", Design)
    (weighings,) = weighed_masses.read_masses(form, [duck]).values()
    assert weighings.grams is not None
    assert weighings.grams.value == pytest.approx(0.55)
    assert run(*words).exit_code == 0
    assert form.read_text() == filled  # what somebody weighed is kept
    with pytest.raises(
        InputError, match=r"part 'duck_t10\.0_flexible_s0\.40-1': is not among the parts that tilt and legs select"
    ):
        weighed_masses.read_masses(form, [PAPER])


def test_checks_of_a_mixed_plate_are_those_of_each_design_alone():
    members = [PAPER, LARGE.variant(kind="braced"), PAPER.variant(tilt_deg=30.0)]
    built = [solids.build(one) for one in members]
    mixed = plates.arrange(members, built, [3, 2, 4], PRINTER)
    for design, one, name in zip(members, built, names.part_names(members), strict=True):
        alone = checks.check_part(name, design, one.walker, PRINTER)
        assert [found for found in mixed.findings if found.where == name] == alone
    assert any(found.where.startswith("maker-large") for found in mixed.findings)


def test_letters_count_on_and_the_picture_names_those_of_its_plate(monkeypatch):
    members = [PAPER.model_copy(update={"name": f"d{k}"}) for k in range(28)]
    letters = names.design_letters(members)
    assert [letters[f"d{k}"] for k in (0, 1, 25, 26, 27)] == ["A", "B", "Z", "AA", "AB"]
    assert names.design_letters(members[:1]) == {}
    drawn = []
    monkeypatch.setattr(plate_map.figures, "png", lambda figure, dpi: drawn.append(figure) or b"")
    built = [solids.build(PAPER)] * 28
    layout = plates.arrange(members, built, [1] * 28, PRINTER, max_parts=14)
    for one in layout.plates:
        plate_map.draw_map(PRINTER, members, layout.meshes, one, "p")
    (first,), (second,) = (figure.axes for figure in drawn)
    assert [text.get_text() for text in second.texts][-2:] == ["AA10-1", "AB10-1"]
    lines = first.get_xlabel().splitlines()
    assert lines[1:3] == ["A: d0", "B: d1"]
    assert lines[-2:] == ["L: d11", "and 2 more: see the print sheet"]
    assert second.get_xlabel().splitlines()[1] == "O: d14"


@pytest.mark.parametrize("copies", [1, 40], ids=["a part of the bed", "all of it"])
@pytest.mark.parametrize("name", ["b", "a-name-as-long-as-names-may-be" + "-x" * 17])
def test_no_word_around_a_map_is_cut_off(monkeypatch, copies, name):
    drawn = []
    monkeypatch.setattr(plate_map.figures, "png", lambda figure, dpi: drawn.append(figure) or b"")
    members = [PAPER.model_copy(update={"name": one}) for one in ("a", "c", name)]
    layout = plates.arrange(members, [solids.build(PAPER)] * 3, [copies] * 3, PRINTER)
    plate_map.draw_map(PRINTER, members, layout.meshes, layout.plates[0], "orders_prusa-mk3s_1")
    (figure,) = drawn
    figure.draw_without_rendering()
    (axes,) = figure.axes
    words = [
        axes.xaxis.label,
        axes.yaxis.label,
        axes.title,
        *axes.get_yticklabels(),
        *figure.legends,
        *(one.title for one in axes.child_axes),
    ]
    for one in words:
        box = one.get_window_extent()
        assert 0.0 <= box.x0 <= box.x1 <= figure.bbox.x1, one
        assert 0.0 <= box.y0 <= box.y1 <= figure.bbox.y1, one
    assert axes.xaxis.label.get_text().endswith(f"C: {name}")
    assert bool(axes.child_axes) is (copies == 1)


@pytest.mark.parametrize(("copies", "whole"), [(1, False), (20, False), (100, True)])
def test_the_map_fills_its_frame_with_parts(monkeypatch, copies, whole):
    drawn = []
    monkeypatch.setattr(plate_map.figures, "png", lambda figure, dpi: drawn.append(figure) or b"")
    layout = plates.arrange([PAPER], [solids.build(PAPER)], [copies], PRINTER)
    plate_map.draw_map(PRINTER, [PAPER], layout.meshes, layout.plates[0], "p")
    (axes,) = drawn[0].axes
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    points = np.concatenate([path.vertices for shapes in axes.collections for path in shapes.get_paths()])
    assert left <= points[:, 0].min() <= points[:, 0].max() <= right
    assert low <= points[:, 1].min() <= points[:, 1].max() <= high
    assert bool(left < 0.0) is whole  # then it shows the bed's edges
    assert bool(axes.child_axes) is not whole  # else, where on the bed
    if not whole:
        taken = max(np.ptp(points[:, 0]) / (right - left), np.ptp(points[:, 1]) / (high - low))
        assert taken > 0.6
        assert 0.0 <= left < right <= PRINTER.bed_width_mm
        assert 0.0 <= low < high <= PRINTER.bed_depth_mm


def test_how_many_of_each_walker_of_a_list_fit(run, lists, tmp_path):
    path = lists / "orders.csv"
    path.write_text(HEADER + "maker-large,,,1\nkoumakis2016,10,,1\n")
    result = run("plate", "--orders", str(path), "--how-many", "--json")
    rows = json.loads(result.stdout)["rows"]
    assert [(row["name"], row["fit"]) for row in rows] == [
        (
            "maker-large_t10.0_flexible_s0.80",
            packing.capacity(packing.Part.from_mesh("x", solids.build(LARGE).walker), PRINTER),
        ),
        ("koumakis2016_t10.0_flexible_s0.40", 105),
    ]
    assert not (tmp_path / "out").exists()


def test_every_mistake_is_told_at_its_line_up_to_a_number(lists):
    path = lists / "orders.csv"
    path.write_text(HEADER + "koumakis2016,10,,0\n" * 50)
    with pytest.raises(InputError) as caught:
        order_list.read_orders(path)
    lines = str(caught.value).splitlines()
    assert lines[-1] == f"{path}: and 30 more mistakes"
    assert [line.split(":")[1] for line in lines[:-1]] == [str(2 + k) for k in range(20)]


@pytest.mark.parametrize("name", ["koumakis2016", "KOUMAKIS2016"])
def test_two_designs_of_one_name_are_refused_unless_they_are_the_same(lists, name):
    """Names that differ by case alone are one file on some file systems."""
    path = lists / "orders.csv"
    path.write_text(HEADER + "koumakis2016,10,,1\nmine.toml,15,,1\n")
    shipped = (templates.folder() / "walkers" / "koumakis2016.toml").read_text()
    (lists / "mine.toml").write_text(f'name = "{name}"\n[body]\nlength_mm = 30.0\n')
    with pytest.raises(InputError, match=f":3: design 'mine.toml' is called {name}, and line 2 "):
        order_list.read_orders(path)
    (lists / "mine.toml").write_text(shipped)  # a copy of the template is the template
    members, copies = order_list.read_orders(path)
    assert [names.part_name(one, one.name) for one in members] == [
        "koumakis2016_t10.0_flexible_s0.40",
        "koumakis2016_t15.0_flexible_s0.40",
    ]
    assert copies == [1, 1]


def test_each_printer_has_a_manifest_that_sweeps_up_its_own_plates_alone(run, lists, tmp_path):
    path, folder = lists / "orders.csv", tmp_path / "here" / "plates"
    path.write_text(HEADER + "../duck.toml,10,,3\nkoumakis2016,10,braced,3\n")
    words = ("plate", "--orders", str(path), "--no-pictures", "--quiet", "--out", "here")
    for printer in ("ender3", "prusa-mk3s"):
        assert run(*words, "--printer", printer, "--max-parts", "2").exit_code == 0
    assert run(*words, "--printer", "ender3").exit_code == 0
    ends = {".csv", ".ini", "_print.ini", ".json", ".md", "_orca.json"}
    assert set(files_below(folder)) == {
        *(f"plate_ender3{end}" for end in (*ends, "_1.3mf")),
        *(f"plate_prusa-mk3s{end}" for end in (*ends, "_1.3mf", "_2.3mf", "_3.3mf")),
    }
    for printer in ("ender3", "prusa-mk3s"):
        manifest = json.loads((folder / f"plate_{printer}.json").read_text())
        assert manifest["printer"]["name"] == printer
        assert manifest["members"] == ["duck_t10.0_flexible_s0.40", "koumakis2016_t10.0_braced_s1.00"]
        assert manifest["copies"] == [3, 3]
        assert {name: one["body"]["length_mm"] for name, one in manifest["designs"].items()} == {
            "duck": 22.0,
            "koumakis2016": 28.0,
        }
        assert manifest["files"] == {
            name: hashlib.sha256(data).hexdigest()
            for name, data in files_below(folder).items()
            if name.startswith(f"plate_{printer}") and name != f"plate_{printer}.json"
        }
    assert [finding["where"] for finding in manifest["print"]["findings"]]


def test_a_list_from_a_spreadsheet_has_a_byte_order_mark_and_its_own_line_ends(lists):
    path = lists / "orders.csv"
    path.write_bytes(b"\xef\xbb\xbf" + (HEADER + '"koumakis2016",5,,2\n').replace("\n", "\r\n").encode())
    assert order_list.read_orders(path) == ([PAPER.variant(tilt_deg=5.0)], [2])


def test_map_preview_and_sheet_say_where_each_walker_runs(monkeypatch):
    """On its side and upside down x stays, so that forward is to the right; a walker that turns has no direction."""
    drawn = []
    monkeypatch.setattr(plate_map.figures, "png", lambda figure, dpi: drawn.append(figure) or b"")
    rotator = templates.load("rotator", "walkers", Design)
    letters = Design.from_text("NA")
    members = [PAPER.variant(tilt_deg=tilt) for tilt in (-10.0, 0.0, 10.0)] + [letters, rotator]
    assert [one.run_direction for one in members] == [-1, 0, 1, 1, 0]
    assert PAPER.variant(kind="braced").run_direction == 0
    layout = plates.arrange(members, [solids.build(one) for one in members], [1] * 5, PRINTER)
    plate_map.draw_map(PRINTER, members, layout.meshes, layout.plates[0], "p")
    arrows = drawn[0].axes[0].collections[-1].get_paths()
    placed = [one for one in layout.plates[0].placements if members[one.part].run_direction]
    for one, path in zip(placed, arrows, strict=True):
        part, (tail, tip, _, *_) = layout.parts[one.part], path.vertices
        forward = members[one.part].run_direction > 0
        assert (tip[0] > tail[0] > one.x + part.width) if forward else (tip[0] < tail[0] < one.x)
        assert tip[1] == pytest.approx(one.y + 0.5 * part.depth)
    assert "runs this way" in drawn[0].axes[0].get_title()
    sheet = dict(plates.layout_files(layout, "p", draw=None))["p_prusa-mk3s.md"].decode()
    assert [sheet.count(f"| {words} |") for words in ("to the left, -x on the bed", "in no direction")] == [1, 2]
    parts = [
        preview.Part(one, one_built.walker, way=one.run_direction)
        for one, one_built in zip(members, layout.built, strict=True)
    ]
    (axes,) = preview.preview_figure(parts, "all").axes
    assert [part.arrow.shape for part in parts] == [(2, 3), (0, 3), (2, 3), (2, 3), (0, 3)]
    assert len(axes.patches) == 3
    assert axes.texts[-1].get_text().endswith("arrows: where they run")
