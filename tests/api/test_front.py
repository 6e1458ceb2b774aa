"""walkergen from Python, as a notebook uses it: the same numbers as the commands, and types."""

import ast
import importlib
import json
import math
import os
import pkgutil
import runpy
import shlex
import subprocess
import sys
import types
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import walkergen as wg
from walkergen import request
from walkergen.cli import command_line
from walkergen.command_table import COMMANDS
from walkergen.core.errors import InputError, WalkergenError
from walkergen.core.printing.printers import Printer
from walkergen.core.scene import Scene
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.files.report import Table

ROOT = Path(__file__).parents[2]
PAPER = wg.load("koumakis2016", "walker")
LANE = wg.load("lane-90hz", "scene")
STUB = runpy.run_path(str(ROOT / "packaging" / "stub.py"))
SHORT = {"seconds": 0.2, "runs": 4}
SHORT_FLAGS = ("--seconds", "0.2", "--runs", "4")


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def call(*words):
        result = CliRunner().invoke(command_line, list(words), catch_exceptions=False)
        assert result.exit_code == 0
        return result.stdout

    return call


@pytest.fixture(scope="module")
def runs():
    return wg.simulate(PAPER, LANE, tilt=10, **SHORT)


def test_names_are_sorted_lazy_and_typed():
    assert wg.__all__ == sorted(set(wg.__all__))
    tree = ast.parse((ROOT / "walkergen" / "__init__.pyi").read_text(encoding="utf-8"))
    functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    assert functions == {name for name in wg.__all__ if name in COMMANDS and name != "templates"}
    assert ast.dump(tree) == ast.dump(ast.parse(STUB["make_stub"]()))  # else: python packaging/stub.py
    assert set(wg.__all__) <= set(dir(wg))
    assert [name for name in wg.__all__ if getattr(wg, name) is None] == []  # each loads
    submodules = {found.name for found in pkgutil.iter_modules(wg.__path__)}
    for name in submodules & set(wg.__all__):  # a room of that name does not take the function's place
        importlib.import_module(f"walkergen.{name}")
        assert not isinstance(getattr(wg, name), types.ModuleType)
    assert (ROOT / "walkergen" / "py.typed").exists()
    with pytest.raises(AttributeError, match="no attribute 'nope'"):
        _ = wg.nope


def test_the_import_itself_brings_nothing_heavy():
    code = (
        "import sys; before = set(sys.modules); import walkergen as wg; "
        "print(sorted(set(sys.modules) - before)); wg.load; print('numpy' in sys.modules)"
    )
    words = [sys.executable, "-c", code]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    found = subprocess.run(words, env=environment, capture_output=True, text=True, check=True)
    assert found.stdout.splitlines() == ["['walkergen']", "True"]


def test_walkers_scenes_and_printers_load_by_name():
    assert isinstance(wg.load("koumakis2016"), Design)
    assert isinstance(wg.load("plane-90hz"), Scene)
    assert isinstance(wg.load("ender3"), Printer)
    assert PAPER == templates.load("koumakis2016", "walkers", Design)
    listed = wg.templates()
    assert len(listed) == sum(len(templates.all_names(kind)) for kind in templates.KINDS)
    assert {row["kind"] for row in listed} == set(templates.KINDS)
    with pytest.raises(InputError, match=r"'nix': no such template\. Known: bristle, .*ender3"):
        wg.load("nix")
    with pytest.raises(InputError, match="kind='walkers': must be one of 'walker', 'scene', 'pri"):
        wg.load("koumakis2016", "walkers")
    with pytest.raises(InputError, match=r"no such template\. Known walkers: bristle"):
        wg.load("lane-90hz", "walker")
    with pytest.raises(InputError, match=r"'walker': no such kind .* walkers, scenes, printers"):
        templates.load("koumakis2016", "walker", Design)


def test_files_load_by_path_and_their_keys_tell_what_they_are(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for kind, name in (("walkers", "rotator"), ("scenes", "plane-noisy"), ("printers", "ender3")):
        Path(f"{kind}.toml").write_bytes((templates.folder() / kind / f"{name}.toml").read_bytes())
        assert wg.load(Path(f"{kind}.toml")) == wg.load(f"{kind}.toml") == wg.load(name)
    for kind, (name, model) in {"walkers": ("rotator", Design)}.items():
        assert templates.load(Path(f"{kind}.toml"), kind, model).name == name
    Path("thin.toml").write_text("[legs]\nflexible_thickness_mm = 0.3\n", encoding="utf-8")
    assert wg.load("thin.toml").legs.flexible_thickness_mm == 0.3
    Path("name.toml").write_text('name = "x"\n', encoding="utf-8")
    with pytest.raises(InputError, match=r"name.toml.*Give kind='walker' or kind='scene'"):
        wg.load("name.toml")
    assert wg.load("name.toml", "scene").name == "x"
    with pytest.raises(InputError, match=r"koumakis2016: .*"):
        wg.load(Path("koumakis2016"))  # a path is a file, never a template


def test_a_walker_with_a_motor_runs_on_a_table_where_no_scene_is_named():
    carrier, paper = wg.load("coinbot"), wg.load("koumakis2016")
    assert request.choose_scene(None, [paper]) == "lane-90hz"
    assert request.choose_scene(None, [paper, carrier], request.PLANE_SCENE) == "table-motor"
    assert request.choose_scene("plane-90hz", [carrier]) == "plane-90hz"
    here, named = (wg.predict("coinbot", model="theory", **on) for on in ({}, {"scene": "table-motor"}))
    assert here.facts == named.facts
    with pytest.raises(InputError, match="scene=lane-90hz"):
        wg.predict("coinbot", gamma=2.0)


def test_a_variant_is_what_the_file_with_these_lines_would_be(tmp_path):
    path = tmp_path / "koumakis2016.toml"
    path.write_text("[legs]\nflexible_thickness_mm = 0.3\nlength_mm = 9.0\n", encoding="utf-8")
    written = wg.load(path, "walker")
    keys = {"legs.flexible_thickness_mm": np.float64(0.3), "legs.length_mm": np.int64(9)}
    assert PAPER.variant(**keys).legs == written.legs
    assert PAPER.variant(tilt_deg=np.float32(12.0), **keys) == PAPER.variant(**keys).variant(**{"legs.tilt_deg": 12.0})
    assert PAPER.variant() == PAPER
    assert LANE.variant(**{"drive.gamma": 2}).drive.peak_gamma == pytest.approx(2.0)
    assert LANE.variant(**{"drive.gamma": 2}).drive.frequency == pytest.approx(90.0)
    two = wg.load("two-materials", "walker").variant(**{"legs[2].friction": 0.3})
    assert two.limbs[1].friction == 0.3


def test_a_variant_takes_the_words_of_the_commands():
    assert PAPER.variant(tilt=1) == PAPER.variant(tilt_deg=1)
    assert PAPER.variant(tilt=1, legs="braced") == PAPER.variant(tilt_deg=1, kind="braced")
    listed = wg.load("two-materials", "walker")
    assert listed.variant(legs=listed.model_dump(exclude_unset=True)["legs"]) == listed
    named = PAPER.variant(text="ANNA", tilt=5)
    assert named.name == "ANNA"
    assert (named.body.text, named.tilt_deg) == ("ANNA", 5.0)
    assert PAPER.variant(tilt=None) == PAPER


def test_a_design_says_what_it_is_in_a_line():
    assert repr(PAPER) == str(PAPER) == "<Design koumakis2016: 2 flexible legs, tilt 10 deg, body 28 x 8 x 3 mm>"
    assert "bristle: 18 flexible legs" in repr(wg.load("bristle"))


def test_a_prediction_is_the_commands(run):
    (row,) = json.loads(run("predict", "koumakis2016", "--tilt", "10", "--json"))["rows"]
    found = wg.predict("koumakis2016", tilt=10)
    assert found.row.columns() == row
    assert found.speed.value == row["speed_mm_s"]
    assert found.speed.se == row["speed_sd_mm_s"]
    bounds = found.speed.low_95, found.speed.high_95
    assert bounds == (row["speed_low_95_mm_s"], row["speed_high_95_mm_s"])
    assert str(found.speed).endswith(f"{found.speed.low_95:.1f} to {found.speed.high_95:.1f}")
    assert "your print: " in found._repr_html_()
    several = wg.predict(PAPER, LANE, tilt=(5, 10), legs=("flexible", "braced")).table
    assert several["legs"].tolist() == ["flexible", "flexible", "braced", "braced"]
    assert several["speed_mm_s"][1] == row["speed_mm_s"]
    assert several.to_dataframe().speed_mm_s.tolist() == several["speed_mm_s"].tolist()


def test_a_simulation_is_the_commands(run, runs):
    files = ("--trajectory", "all.csv", "--rate-hz", "50")
    told = json.loads(run("simulate", "koumakis2016", "--tilt", "10", *SHORT_FLAGS, *files, "--json"))
    assert runs.summary.numbers["impacts_per_s"].value == pytest.approx(told["impacts_per_s"], rel=0.2)
    plain = json.loads(run("simulate", "koumakis2016", "--tilt", "10", *SHORT_FLAGS, "--json"))
    assert runs.speed.value == plain["speed_mm_s"]
    assert (runs.speed.refused, plain["orbit"]) == ("", None)
    bounds = runs.speed.low_95, runs.speed.high_95
    assert bounds == (plain["speed_low_95_mm_s"], plain["speed_high_95_mm_s"])
    found, (first, *_) = runs.trajectory(50), Path("all.csv").read_text().splitlines()
    assert list(found.keys) == first.split(",")
    rows = np.loadtxt("all.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(np.array(found.rows), rows)
    frame = runs.to_dataframe()
    assert frame["speed_mm_s"].tolist() == [runs.speed.value]
    assert frame["outcomes.ok"].tolist() == [4]


def test_a_simulation_shows_itself(runs):
    page = runs._repr_html_()
    assert f"<td>mean speed</td><td>{runs.speed.value:.0f}"[:-1] in page
    assert "tips of 5 um" in page
    assert runs.plot()._repr_png_().startswith(b"\x89PNG")
    assert len(runs.plot().axes[0].lines) == 4
    with pytest.raises(InputError, match=r"rate_hz=0: must be a number >= 0\.001"):
        runs.trajectory(0)


def test_a_simulation_says_how_far_it_is():
    seen = []
    words = {**SHORT, "seconds": 0.05, "runs": 1}
    one = wg.simulate(PAPER, LANE, **words, progress=lambda *step: seen.append(step))
    assert seen[-1] == ("runs", 100, 100)  # percent
    assert one.speed.se is None
    assert str(one.speed).endswith("mm/s, too few data for an error bar")


def film():
    rng = np.random.default_rng(3)
    frames, particles = np.arange(200), range(9)
    return {
        "frame": np.concatenate([frames for _ in particles]),
        "particle": np.repeat(particles, len(frames)),
        "x": np.concatenate([frames * 3.0 + rng.normal(0, 0.5, len(frames)) for _ in particles]),
        "y": rng.normal(0, 0.5, len(frames) * len(particles)),
    }


def test_tracks_are_analysed_from_a_file_a_frame_and_columns(run, tmp_path):
    pandas = pytest.importorskip("pandas")
    columns, units = film(), {"fps": 100, "mm_per_px": 0.1}
    frame = pandas.DataFrame(columns)
    frame.to_csv("film.csv", index=False)
    words = ("film.csv", "--fps", "100", "--mm-per-px", "0.1", "--no-pictures", "--out", "told")
    told = json.loads(run("analyse", *words, "--json"))
    found = wg.analyse(Path("film.csv"), **units, out="found", pictures=False)
    assert (found.speed.value, found.speed.se) == (told["speed_mm_s"], told["speed_se_mm_s"])
    assert found.speed.value == pytest.approx(30.0, abs=1.0)
    rows = Table("film", list(zip(*columns.values(), strict=True)), list(columns))
    for same in (frame, columns, rows):
        assert wg.analyse(same, **units).estimates == found.estimates
    told_files = sorted((tmp_path / "told" / "analysis").iterdir())
    assert [path.name for path in told_files] == sorted(path.name for path in found.folder.iterdir())
    for path in told_files:
        assert (found.folder / path.name).read_bytes() == path.read_bytes()
    assert found.plot("msd")._repr_png_().startswith(b"\x89PNG")
    assert "<td>speed_mm_s</td><td>" in found._repr_html_()
    row = found.to_dataframe().set_index("quantity").loc["speed_mm_s"]
    assert row["value"] == found.speed.value


def test_plots_that_are_not_there_are_named():
    found = wg.analyse(film(), fps=100, mm_per_px=0.1)
    with pytest.raises(InputError, match="plot 'speed': must be one of 'trajectories', 'walkers', 'msd'"):
        found.plot("speed")


SPEEDS = "tilt_deg,speed_mm_s,speed_se_mm_s\n5,60,1\n10,62,1\n20,25,1\n30,8,1\n"


FORM = """part,measured,reading,error,unloaded_mm,weight_g,at_mm
strip_1,thickness_mm,0.8,0.02,,,
strip_1,width_mm,5,0.05,,,
strip_1,free_length_mm,60,0.5,,,
strip_1,swings_20_s,0.33,0.01,,,
block,slides_deg,14,1,,,
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("call", "known"),
    [(wg.fit, {}), (wg.fit, {"model": "theory", "fix": {"restitution": 0.8}}), (wg.calibrate, {"by": "ring"})],
)
def test_what_was_measured_has_the_scene_that_it_writes(tmp_path, call, known):
    (tmp_path / "in.csv").write_text(FORM if "by" in known else SPEEDS, encoding="utf-8")
    found = call(tmp_path / "in.csv", **known, out=tmp_path / "out", pictures=False)
    assert found.scene.contact == wg.load(found.folder / "scene.toml", "scene").contact


def test_a_sweep_is_the_commands(run, tmp_path):
    words = ("--set", "legs.tilt_deg=5,10", "--set", "scene.contact.restitution=0.7,0.8", "--no-pictures")
    run("sweep", "koumakis2016", *words, "--out", "told")
    values = {"legs.tilt_deg": [5, 10], "scene.contact.restitution": np.array([0.7, 0.8])}
    found = wg.sweep(PAPER, LANE, values)
    lines = (tmp_path / "told" / "table.csv").read_text().splitlines()
    speed = lines[0].split(",").index("speed_mm_s")
    speeds = found.table["speed_mm_s"].tolist()
    assert speeds == [float(line.split(",")[speed]) for line in lines[1:]]
    assert [row["legs.tilt_deg"] for row in found.table] == [5, 5, 10, 10]
    assert speeds[3] == wg.predict(PAPER, LANE, tilt=10).speed.value
    assert found.plot()._repr_png_().startswith(b"\x89PNG")
    assert repr(found).startswith("koumakis2016 (lane-90hz, predicted)\ntable: 4 rows\n")
    again = wg.sweep(PAPER, LANE, values, out="found")
    assert again.table["speed_mm_s"].tolist() == speeds
    assert (tmp_path / "found" / "table.csv").exists()


def test_a_sweep_simulates():
    scene = LANE.variant(**{"run.seconds": 0.05, "run.runs": 4})
    found = wg.sweep(PAPER, scene, {"legs.tilt_deg": range(8, 11, 2)}, model="space", error="50%")
    assert found.table["status"].tolist() == ["ok", "ok"]
    assert (found.table["se_mm_s"] >= 0).all()


def test_a_family_and_a_file_are_the_commands(run, tmp_path):
    run("family", "koumakis2016", "--tilt", "5,10", "--legs", "flexible", "--no-pictures", "--out", "told", "--quiet")
    found = wg.family(PAPER, tmp_path / "found", tilt=[5, 10], legs="flexible", pictures=False)
    hashes = [json.loads((tmp_path / name / "manifest.json").read_text())["files"] for name in ("told", "found")]
    assert hashes[0] == hashes[1]
    assert found.table["tilt_deg"].tolist() == [5.0, 10.0]
    assert "walker_t05.0_flexible_s0.40" in found._repr_html_()
    for form in ("stl", "3mf", "svg", "dxf"):
        run("export", "koumakis2016", "--format", form, "--out", "parts", "--quiet")
        (told,) = (tmp_path / "parts" / form).iterdir()
        (path,) = wg.export(PAPER, tmp_path / f"walker.{form}").files
        assert path.read_bytes() == told.read_bytes()
    run(*shlex.split("export koumakis2016 --tilt 12 --scene plane-90hz --format mjcf --out parts --quiet"))
    (path,) = wg.export(PAPER.variant(tilt_deg=12.0), tmp_path / "moving" / "it.xml", scene="plane-90hz").files
    for file in (tmp_path / "parts" / "mjcf").iterdir():
        named = path if file.suffix == ".xml" else path.with_name(file.name)
        assert named.read_bytes() == file.read_bytes()
    assert len(list(path.parent.iterdir())) == 4
    with pytest.raises(InputError, match=r"must end in one of \.stl, \.3mf.* \.xml"):
        wg.export(PAPER, tmp_path / "core.walker.step")


def test_a_family_takes_copies_weights_and_measured_speeds_as_the_command(run, tmp_path, monkeypatch):
    for name in ("files.figures.png", "files.figures.pdf", "commands.family.preview.preview_figure"):
        monkeypatch.setattr(f"walkergen.{name}", lambda *_, **__: b"undrawn")  # which takes long
    names = ["walker_t05.0_flexible_s0.40", "walker_t10.0_flexible_s0.40"]
    Path("weights.csv").write_text(f"part,body_g,leg_g\n{names[0]},0.81,0.012\nwalker_t30.0_flexible_s0.40,0.8,\n")
    Path("speeds.csv").write_text("tilt_deg,speed_mm_s\n10,58\n10,1e9\n")
    words = "family koumakis2016 --copies 5:2,10:3 --legs flexible --weights weights.csv --measured speeds.csv"
    run(*shlex.split(f"{words} --out told --quiet --max-parts 4 --prusaslicer"))
    found = wg.family(
        PAPER,
        tmp_path / "found",
        copies={5: 2, np.float64(10): np.int64(3)},
        legs="flexible",
        weights="weights.csv",
        measured=Path("speeds.csv"),
        max_parts=4,
        prusaslicer=True,
    )
    told, made = (json.loads((tmp_path / name / "manifest.json").read_text()) for name in ("told", "found"))
    assert told["files"] == made["files"]
    assert made["copies"] == [2, 3]
    assert "plates/family_prusa-mk3s_2.3mf" in made["files"]
    assert "\nmeasured,flexible,10.0,58.0," in (tmp_path / "found" / "speed.csv").read_text()
    assert [member.name for member in found.members] == names
    assert found.table["mass_g"][0] == pytest.approx(0.81 + 2 * 0.012)
    assert [one for one in found.warnings if "weights.csv: ignored rows of other walkers (1)" in one]
    assert [one for one in found.warnings if one.startswith("speeds.csv: ")]


REFUSED = {
    "variant": (
        lambda words: PAPER.variant(**words),
        [
            ({"legs.flexible_thickness_mm": -0.5}, r"koumakis2016: .* = -0.5: must be a number"),
            ({"legs.flexible_thicknes": 1}, r"Did you mean legs.flexible_thickness_mm\?"),
            ({"legs[1].tilt_deg": 1}, "legs is not a list"),
            ({"legs[x]": 1}, r"'legs\[x\]': must be a key of the TOML file"),
            ({"": 1}, "must be a key of the TOML file"),
            ({"tilt_deg": 5, "legs.tilt_deg": 5}, "legs.tilt_deg: given twice"),
            ({"tilt": 5, "tilt_deg": 6}, "tilt_deg: given twice"),
            ({"legs": "wooden"}, "legs.kind = 'wooden': must be one of"),
            ({"legs.tilt_deg": "steep"}, "legs.tilt_deg = 'steep': must be a number"),
            ({"legs.contact_spacing_mm": 500.0}, "koumakis2016: .*a leg extends beyond the body"),
        ],
    ),
    "variant of a scene": (
        lambda words: LANE.variant(**words),
        [
            ({"drive.gamma": float("nan")}, "drive.gamma = nan: must be"),
            ({"gamma": 2}, r"gamma: unknown key. Did you mean drive.gamma\?"),
        ],
    ),
    "predict": (
        lambda words: wg.predict(PAPER, **words),
        [
            ({"scene": PAPER}, "scene: Design seen: must be a Scene, the name of a template"),
            ({"tilt": 200}, "^tilt=200:"),
        ],
    ),
    "simulate": (
        lambda words: wg.simulate(PAPER, LANE, **{**SHORT, **words}),
        [({"runs": 0}, "^runs=0: must be"), ({"error": "5%"}, r"^seconds=0\.2: cannot be combined with error")],
    ),
    "analyse": (
        lambda tracks: wg.analyse(tracks, fps=100, mm_per_px=1),
        [
            ({"frame": [0, 1], "x": [0.0, 1.0]}, "^tracks: no column 'y'"),
            ({"frame": [0, 1], "x": [0.0]}, "^tracks: columns must be of one length, seen frame 2, x"),
            (7, "^tracks: int seen: must be the path of a CSV file"),
            ({"a": [1]}, "^tracks: no column 'x'. Rename the one"),
        ],
    ),
    "family": (
        lambda words: wg.family(PAPER, "out", pictures=False, **words),
        [
            *(
                ({"copies": copies}, "^copies=")
                for copies in (0, True, 2.5, 10**9, {}, {10: -1}, {"x": 1}, {math.nan: 1})
            ),
            ({"copies": {10: 1}, "tilt": [5]}, "^tilt=5: copies has the tilts already. Remove one of them."),
        ],
    ),
    "sweep": (
        lambda words: wg.sweep(PAPER, LANE, **words),
        [({"set": {"legs[x]": [1]}}, r"'legs\[x\]': must be a key"), ({"set": {"legs.tilt_deg": []}}, "has no values")],
    ),
}
"""Values that only Python can give: what takes them, and what names the mistake. refusals.toml has all others."""


@pytest.mark.parametrize(
    ("call", "given", "told"),
    [
        pytest.param(call, *row, id=f"{door}-{number}")
        for door, (call, rows) in REFUSED.items()
        for number, row in enumerate(rows)
    ],
)
def test_what_means_nothing_is_one_line_and_writes_nothing(tmp_path, monkeypatch, call, given, told):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in.csv").write_text(SPEEDS, encoding="utf-8")
    with pytest.raises(WalkergenError, match=told) as caught:
        call(dict(given) if isinstance(given, dict) else given)
    assert "\n" not in str(caught.value)
    assert [path.name for path in tmp_path.iterdir()] == ["in.csv"]


def test_tables_escape_count_and_need_pandas(monkeypatch):
    rows = [*((number, None) for number in range(29)), (29, "<i>")]
    table = Table("t", rows, ("a", "b"), (), "<b>", ["x & y"])
    page = table._repr_html_()
    assert "<b>" not in page
    assert "&lt;b&gt;" in page
    assert "x &amp; y" in page
    assert "and 10 more rows" in page
    assert table["a"].dtype == np.int64
    assert np.isnan(Table("t", [(1.5,), (None,)], ["c"])["c"][1])
    with pytest.raises(KeyError, match="no column 'd'; columns: a, b"):
        _ = table["d"]
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(InputError, match=r"pandas is not installed.*table\['a'\]"):
        table.to_dataframe()


NOTEBOOKS = sorted((ROOT / "examples").glob("*.ipynb"))


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_the_notebooks_run_as_shown(path, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    notebook = json.loads(path.read_text(encoding="utf-8"))
    assert notebook["nbformat"] == 4
    space = {}
    shown = []
    for cell in notebook["cells"]:
        if cell["cell_type"] != "code":
            continue
        assert cell["outputs"] == []
        assert cell["execution_count"] is None
        tree = ast.parse("".join(cell["source"]))
        last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
        exec(compile(tree, path.name, "exec"), space)
        if last is not None:
            shown.append(eval(compile(ast.Expression(last.value), path.name, "eval"), space))
    pages = [one for one in shown if hasattr(one, "_repr_html_") or hasattr(one, "_repr_png_")]
    assert len(pages) >= 3
    told = capsys.readouterr().out
    if path.stem == "design-a-walker":
        assert "legs.flexible_thickness_mm = -0.5: must be" in told
        assert (tmp_path / "thin.stl").stat().st_size > 500
    else:
        assert abs(float(told.split("apart by ")[1].split()[0])) < 5


def test_there_are_two_notebooks():
    assert [path.stem for path in NOTEBOOKS] == ["design-a-walker", "film-meets-simulation"]


SCRIPT = """
import walkergen as wg

design = wg.load("koumakis2016", "walker").variant(tilt_deg=12.0)
speed: float = wg.predict(design, "lane-90hz").speed.number
many = wg.predict(design, tilt=[5.0, 10.0]).table["speed_mm_s"]
bar: float | None = wg.simulate(design, runs=4).speed.se
"""


@pytest.mark.slow
def test_types_reach_a_users_script(tmp_path):
    (tmp_path / "good.py").write_text(SCRIPT, encoding="utf-8")
    (tmp_path / "bad.py").write_text(SCRIPT + "wg.predict(design, nope=1)\n", encoding="utf-8")
    environment = {**os.environ, "MYPYPATH": str(ROOT)}
    flags = ("--strict", "--follow-imports=silent", "--no-error-summary")
    words = [sys.executable, "-m", "mypy", *flags, "good.py", "bad.py"]
    found = subprocess.run(words, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    told = [line for line in found.stdout.splitlines() if ": error:" in line]
    assert {line.partition(": ")[0] for line in told} == {"bad.py:8"}
    assert 'Unexpected keyword argument "nope" for "predict"' in told[-1]
