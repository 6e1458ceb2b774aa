"""Printability checks: each finds what it is for, and passes what is just inside its limit."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from walkergen.core.errors import PrintabilityError
from walkergen.core.printing import checks, findings, slicer, walls
from walkergen.core.printing import packing as plate
from walkergen.core.printing.findings import About
from walkergen.core.printing.packing import Part, Placement, Plate
from walkergen.core.printing.printers import Printer
from walkergen.core.shapes import modeller
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import sections, solids
from walkergen.core.walker.design import Design
from walkergen.files import templates

MK3S = templates.load("prusa-mk3s", "printers", Printer)
ENDER = templates.load("ender3", "printers", Printer)


def design_of(**legs):
    body = {key: legs.pop(key) for key in ("depth_mm", "thickness_mm") if key in legs}
    return Design.model_validate({"legs": legs, "body": body})


def find(design, printer=MK3S, mesh=None):
    mesh = solids.build(design).walker if mesh is None else mesh
    return checks.check_part("it", design, mesh, printer)


def level_and_text(design, printer=MK3S):
    """Level and first words of each finding."""
    return [(one.level, one.what) for one in find(design, printer)]


def levels(found):
    return {finding.level for finding in found}


@pytest.mark.parametrize("printer", templates.names("printers"))
@pytest.mark.parametrize("walker", templates.names("walkers"))
def test_shipped_walkers_print_on_shipped_printers(walker, printer):
    members = templates.load(walker, "walkers", Design).members()
    machine = templates.load(printer, "printers", Printer)
    meshes = [solids.build(member).walker for member in members]
    parts = [Part.from_mesh(f"part{index}", mesh, 3) for index, mesh in enumerate(meshes)]
    plates = plate.pack(parts, machine)
    every = checks.check_batch(members, meshes, parts, plates, machine)
    assert "error" not in levels(every)
    findings.check_printable(every, strict=False)


@pytest.mark.parametrize(
    ("lines", "level"),
    [(0.74, "error"), (0.76, None), (1.44, None), (1.46, "warning"), (1.74, "warning"), (1.76, None), (1.94, None)],
)
def test_legs_in_printed_lines(lines, level):
    legs = design_of(flexible_thickness_mm=lines * MK3S.line_width_mm)
    seen = {one.level for one in find(legs) if "leg" in one.what and one.level != "advice"}
    assert seen == ({level} if level else set())


def test_a_warning_holds_the_deviation_that_the_flow_model_expects():
    (warning,) = [one for one in find(design_of(), ENDER) if one.level == "warning"]
    assert warning.seen == pytest.approx(100 * walls.plastic_deviation(0.4, ENDER))
    assert warning.seen == pytest.approx(-10.7, abs=0.1)  # measured: -10.7, layers of 0.2 mm
    assert (warning.limit, warning.unit) == (10.0, "%")
    assert "0.43 mm would do" in warning.change


@pytest.mark.parametrize("thickness", [0.34, 0.4, 0.45])
def test_legs_of_a_line_and_less_vanish_unless_thin_walls_are_detected(thickness):
    """The issue's measurement: with lines of 0.45 mm, 0.45 mm and less get no plastic."""
    blind = MK3S.model_copy(update={"thin_walls": False})
    legs = design_of(flexible_thickness_mm=thickness)
    ((level, what),) = [one for one in level_and_text(legs, blind) if one[0] == "error"]
    assert (level, what) == ("error", "the leg gets no plastic, thin walls not being detected")
    assert walls.printed_thickness(thickness, blind) == 0.0
    arachne = blind.model_copy(update={"wall_generator": "arachne"})
    assert "error" not in levels(find(legs, arachne))


CHANGES = st.fixed_dictionaries(
    {
        "line_width_mm": st.floats(0.3, 0.8),
        "layer_height_mm": st.floats(0.05, 0.3),
        "wall_generator": st.sampled_from(["classic", "arachne"]),
        "thin_walls": st.booleans(),
    }
)
"""Keys of any printer that matter to a wall."""


@settings(max_examples=200, deadline=None, derandomize=True)
@given(st.floats(0.01, 4.0), CHANGES)
def test_recommended_changes_resolve_the_finding(thickness, changes):
    printer = MK3S.model_copy(update=changes)
    finding = checks.check_wall(walls.Wall("leg", thickness, 1.0, 8.0), printer, 0.02)
    if finding is None or " mm would do" not in finding.change:
        return
    better = float(finding.change.split(" mm would do")[0].split()[-1])
    again = checks.check_wall(walls.Wall("leg", better, 1.0, 8.0), printer, 0.02)
    assert again is None or again.level == "advice"


@settings(max_examples=200, deadline=None, derandomize=True)
@given(st.floats(0.01, 4.0), CHANGES)
def test_plastic_is_none_or_near_the_wall(thickness, changes):
    printed = walls.printed_thickness(thickness, MK3S.model_copy(update=changes))
    assert printed == 0.0 or abs(printed - thickness) <= changes["line_width_mm"]


def test_a_brace_that_vanishes_is_an_error():
    braced = design_of(kind="braced", brace_thickness_mm=0.3, tilt_deg=20.0)
    assert ("error", "the brace is thinner than 0.75 printed lines") in level_and_text(braced)
    assert "error" not in levels(find(design_of(brace_thickness_mm=0.3)))  # flexible: no brace


def test_gaps_narrower_than_a_line_fuse():
    def window(tilt):
        braced = design_of(kind="braced", tilt_deg=tilt)
        warned = "the window between leg and brace may fuse" in [what for _, what in level_and_text(braced)]
        return warned, sections.window_width(braced.limbs[0])

    assert window(5.0)[0] is False  # leg and brace overlap
    assert window(5.0)[1] < 0.0
    warned, width = window(8.0)
    assert (warned, 0.0 < width < 0.45) == (True, True)
    assert window(10.0)[0] is False
    assert window(10.0)[1] > 0.45
    close = design_of(contact_spacing_mm=0.8, tilt_deg=0.0, length_mm=5.0)
    assert ("warning", "the two legs may fuse") in level_and_text(close)


def test_marks_finer_than_a_line_may_close_up():
    for line, advised in ((0.4, True), (0.45, False)):
        marks = {"kind": "digits", "line_mm": line}
        design = Design.model_validate({"marks": marks, "body": {"thickness_mm": 4.0}})
        assert any("digits" in one.what for one in find(design)) == advised
    assert not any("close up" in one.what for one in find(design_of()))  # no marks


def test_window_and_clearance_are_those_of_the_solid():
    braced = design_of(kind="braced", tilt_deg=20.0)
    vertices = solids.build(braced).walker.vertices
    at_bottom = np.unique(np.round(vertices[np.abs(vertices[:, 1] + 1.5) < 1e-9, 0], 9))
    gaps = np.diff(at_bottom[np.abs(at_bottom) < 13.9])  # without the body's own corners
    assert np.isclose(gaps, sections.window_width(braced.limbs[0])).any()
    assert np.isclose(gaps, sections.leg_clearance(braced.limbs)).any()


@pytest.mark.parametrize(
    ("changes", "level"),
    [
        ({"layer_height_mm": 0.32}, None),
        ({"layer_height_mm": 0.33}, "warning"),
        ({"layer_height_mm": 0.41}, "error"),
        ({"line_width_mm": 0.2}, "error"),
        ({"line_width_mm": 0.3}, None),
    ],
)
def test_layers_against_nozzle_and_line(changes, level):
    seen = levels(checks.check_printer(MK3S.model_copy(update=changes)))
    assert seen == ({level} if level else set())


@pytest.mark.parametrize(("depth", "level"), [(8.0, None), (7.8, None), (8.1, "warning"), (0.1, "error"), (0.2, None)])
def test_the_depth_is_a_whole_number_of_layers(depth, level):
    seen = {one.level for one in find(design_of(depth_mm=depth)) if "depth" in one.what}
    assert seen == ({level} if level else set())


def test_a_brim_is_advised_for_unstable_parts_until_there_is_one():
    def brim_advice(design, printer=MK3S):
        return [one.what for one in find(design, printer) if "brim" in one.change]

    assert brim_advice(design_of()) == []
    assert brim_advice(design_of(depth_mm=12.0)) == ["the leg prints high and thin: height over thickness"]
    small = Design.model_validate({"body": {"length_mm": 17.0, "thickness_mm": 1.0}})
    assert brim_advice(small) == ["little of it holds on to the bed"]
    (seen,) = [one.seen for one in find(small) if "bed" in one.what]
    assert seen == pytest.approx(17.0 + 2 * 7.5 * 0.4, rel=1e-9)  # the profile's area
    assert brim_advice(small, MK3S.model_copy(update={"brim_width_mm": 3.0})) == []


def test_a_mesh_that_is_open_or_in_pieces_is_refused():
    design = design_of()
    mesh = solids.build(design).walker
    opened = Mesh(mesh.vertices, mesh.triangles[1:])
    apart = Mesh(
        np.vstack([mesh.vertices, mesh.vertices + np.array([40.0, 0.0, 0.0])]),
        np.vstack([mesh.triangles, mesh.triangles + len(mesh.vertices)]),
    )
    inside_out = Mesh(mesh.vertices, mesh.triangles[:, ::-1])
    for bad, bodies in ((opened, 0), (apart, 2), (inside_out, 0)):
        (error,) = [one for one in find(design, mesh=bad) if one.level == "error"]
        assert (error.what, error.seen) == ("the mesh is not one closed body", bodies)
    assert modeller.count_bodies(mesh) == 1


def test_a_part_larger_than_the_printer_is_an_error_in_every_direction():
    tiny = MK3S.model_copy(update={"height_mm": 5.0, "bed_width_mm": 50.0, "margin_mm": 15.0})
    errors = [one for one in find(design_of(), tiny) if one.level == "error"]
    assert [one.what.split()[1] for one in errors] == ["width", "height"]
    assert [one.limit for one in errors] == [20.0, 5.0]


BOX = [Part("box", 20.0, 10.0, 8.0, 2)]


def check_places(*places, **changes):
    one = Plate(tuple(Placement(0, copy, x, y) for copy, (x, y) in enumerate(places, start=1)))
    printer = MK3S.model_copy(update=changes)
    return [(f.level, f.where, f.what) for f in checks.check_plate("p", one, BOX, printer)]


def test_parts_brims_and_skirts_off_the_bed_are_errors():
    assert check_places((0.0, 0.0)) == []
    assert check_places((-0.1, 0.0)) == [("error", "p: box-1", "the part leaves the bed")]
    assert check_places((231.0, 0.0)) == [("error", "p: box-1", "the part leaves the bed")]
    assert check_places((100.0, 200.1)) == [("error", "p: box-1", "the part leaves the bed")]
    near = ((50.0, 50.0), (4.0, 50.0))
    assert check_places(*near, brim_width_mm=4.0) == []
    assert check_places(*near, brim_width_mm=4.1) == [("error", "p: box-2", "its brim leaves the bed")]
    assert check_places(*near, skirt_loops=2, skirt_distance_mm=2.8) == []
    assert check_places(*near, skirt_loops=2, skirt_distance_mm=2.9) == [
        ("error", "p: box-2", "the skirt around it leaves the bed")
    ]


def test_parts_too_close_or_overlapping():
    assert check_places() == []
    assert check_places((10.0, 10.0), (33.0, 10.0)) == []
    assert check_places((10.0, 10.0), (32.9, 10.0)) == [("warning", "p: box-1", "is closer than the gap to box-2")]
    assert check_places((10.0, 10.0), (29.9, 19.9))[0][0] == "error"
    assert check_places((10.0, 10.0), (33.0, 10.0), brim_width_mm=1.0)[0][0] == "warning"
    assert check_places((10.0, 10.0), (33.0, 10.0), brim_width_mm=1.6)[0][0] == "error"


def test_one_filament_prints_a_batch():
    """Settings that are loaded alone hold one density: that of the first part."""
    pla, petg = (Design.model_validate({"material": {"density_g_cm3": rho}}) for rho in (1.24, 1.27))
    meshes = [solids.orient_for_print(pla, solids.build(pla).walker)] * 3
    parts = [Part.from_mesh(name, mesh, 1) for name, mesh in zip("abc", meshes, strict=True)]
    assert not checks.check_batch([pla] * 3, meshes, parts, [], MK3S)
    (finding,) = checks.check_batch([pla, petg, petg], meshes, parts, [], MK3S)
    assert (finding.level, finding.where) == ("warning", "b")
    assert (finding.seen, finding.limit, finding.unit) == (1.27, 1.24, "g/cm3")


def test_equal_findings_are_reported_once_and_errors_first():
    one = findings.make_finding(About.LEGS, "warning", "x", 1.0, 2.0, "mm", "y")._replace(where="a")
    every = [one, one._replace(where="b"), one._replace(level="error", where="c")]
    merged = findings.group_findings(every)
    assert [(finding.level, finding.where) for finding in merged] == [("error", "c"), ("warning", "a and 1 more")]
    with pytest.raises(PrintabilityError) as caught:
        findings.check_printable(every, strict=True)
    assert str(caught.value).splitlines() == ["c: x: 1 mm, limit 2 mm: y", "a and 1 more: x: 1 mm, limit 2 mm: y"]


# The command line


@pytest.fixture
def run(run, tmp_path):
    (tmp_path / "thin.toml").write_text("[legs]\nflexible_thickness_mm = 0.2\n")
    return run


def test_check_reports_and_writes_nothing(run, tmp_path):
    result = run("check", "koumakis2016", "--printer", "ender3", "--copies", "3")
    assert result.exit_code == 0
    assert "60 parts on 1 plate of ender3: 0 errors, 1 warning" in result.stdout
    strict = run("check", "koumakis2016", "--printer", "ender3", "--strict")
    assert strict.exit_code == 2
    (line,) = strict.stderr.splitlines()
    assert line.startswith("error: ")
    assert "0.43 mm would do" in line
    assert [path.name for path in tmp_path.iterdir()] == ["thin.toml"]


def test_check_in_json(run):
    result = run("check", "--printer", "ender3", "--tilt", "10", "--legs", "flexible", "--json")
    data = json.loads(result.stdout)
    assert data["walls"][0] == {
        "wall": "leg",
        "thickness_mm": 0.4,
        "lines": 1.0,
        "plastic_percent": pytest.approx(-10.73, abs=0.01),
    }
    assert [one["level"] for one in data["findings"]] == ["warning"]
    assert (data["parts"], data["plates"]) == (1, 1)


@pytest.mark.parametrize("command", ["plate", "family", "check"])
def test_errors_are_one_line_each_and_nothing_is_written(run, tmp_path, command):
    result = run(command, "thin.toml", "--tilt", "5,10", "--legs", "flexible")
    if command == "check":  # shows the walls all the same
        assert result.exit_code == 2
        (line,) = result.stderr.splitlines()
        line = line.removeprefix("error: ")
    else:
        assert isinstance(result.exception, PrintabilityError)
        (line,) = str(result.exception).splitlines()
    assert line.startswith("walker_t05.0_flexible_s0.20 and 1 more: the leg is thinner than 0.75")
    assert [path.name for path in tmp_path.iterdir()] == ["thin.toml"]


def test_with_several_printers_a_warning_names_its_own(run):
    result = run("plate", "--printer", "prusa-mk3s,ender3", "--no-pictures")
    (line,) = result.stderr.splitlines()
    assert line.startswith("warning: ender3: walker_t10.0_flexible_s0.40: plastic in the leg")


@pytest.mark.parametrize("command", ["plate", "family"])
def test_warnings_are_printed_and_kept_on_the_sheet(run, tmp_path, command):
    words = (command, "--tilt", "10", "--legs", "flexible", "--printer", "ender3", "--no-pictures")
    quiet = run(*words, "--quiet")
    assert (quiet.exit_code, quiet.stdout) == (0, "")
    result = run(*words)
    assert result.exit_code == 0
    assert quiet.stderr == result.stderr
    assert result.stderr.startswith("warning: walker_t10.0_flexible_s0.40: plastic in the leg")
    folder = tmp_path / "out" / "koumakis2016"
    sheet = (folder / "plates" / f"{command}_ender3.md").read_text(encoding="utf-8")
    assert result.stderr.removeprefix("warning: ").strip() in sheet
    assert "| wall generator | arachne |" in sheet
    ini = (folder / "plates" / f"{command}_ender3.ini").read_text(encoding="utf-8")
    assert "perimeter_generator = arachne\n" in ini
    if command == "family":
        kept = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))["print"]
        assert [one["level"] for one in kept["findings"]] == ["warning"]
        assert kept["prusaslicer"] == slicer.prusaslicer_settings(ENDER)
    assert isinstance(run(*words, "--strict").exception, PrintabilityError)
