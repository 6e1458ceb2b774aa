"""The command line as a user meets it: every command, every kind of bad input."""

import contextlib
import json
import os
import re
import subprocess
import sys
import time

import pytest
from command_checks import refusal_of

from walkergen.cli import main
from walkergen.core.scene import Scene
from walkergen.core.walker import names
from walkergen.core.walker.design import Design
from walkergen.files import templates

COLUMNS = [
    "tilt_deg",
    "legs",
    "total_g",
    "M_g",
    "J_g_mm2",
    "m_g",
    "j_g_mm2",
    "nominal_mm_s",
    "nominal_low_95_mm_s",
    "nominal_high_95_mm_s",
    "speed_mm_s",
    "speed_sd_mm_s",
    "speed_low_68_mm_s",
    "speed_high_68_mm_s",
    "speed_low_95_mm_s",
    "speed_high_95_mm_s",
    "speed_by",
    "falls",
    "theory_mm_s",
    "factor_back",
    "factor_front",
    "factor_mean",
    "mode",
    "theory_note",
    "note",
]


def test_predict_json_has_the_named_columns(run):
    result = run("predict", "koumakis2016", "--tilt", "10", "--restitution", "0.8", "--friction", "0.25", "--json")
    (row,) = json.loads(result.stdout)["rows"]
    assert list(row) == COLUMNS
    assert row["tilt_deg"] == 10.0
    assert row["factor_mean"] == pytest.approx(4.248, abs=1e-3)
    assert row["mode"] == "coulomb"


def test_predict_table_fits_eighty_columns(run):
    result = run("predict", "--tilt", "0:45:5", "--legs", "flexible,braced")
    assert result.exit_code == 0
    assert max(len(line) for line in result.stdout.splitlines()) <= 80
    assert "…" not in result.stdout
    assert "table" not in result.stdout  # where all speeds come from, in family.csv
    assert "stand" in result.stdout


def test_the_theory_alone_is_a_table_of_what_it_takes_and_gives(run):
    """M, J, m and j in, eq. 15 out, with a note only where another mode has another speed."""
    result = run(
        "predict",
        "koumakis2016",
        *("--tilt", "5,10", "--model", "theory"),
        *("--restitution", "0.8", "--friction", "0.25"),
    )
    rows = [line.split() for line in result.stdout.splitlines() if " flexible " in line]
    assert rows[1] == ["10", "flexible", "0.8333", "55.07", "0.02976", "0.1399", "4.443", "4.053", "59.7"]
    assert rows[0][-2:] == ["68.1", "[1]"]
    assert "[1] friction can hold the feet" in result.stdout
    assert "your print" not in result.stdout
    one = run("predict", "--tilt", "10", "--model", "theory", "--restitution", "0.8", "--friction", "0.25")
    assert "tilt 10 deg: 59.7 mm/s in the paper's theory" in one.stdout


def test_family_writes_a_folder_and_json(run, tmp_path):
    result = run("family", "koumakis2016", "--tilt", "5,10", "--out", "here", "--json")
    assert result.exit_code == 0
    assert len(json.loads(result.stdout)["rows"]) == 4
    assert len(list((tmp_path / "here" / "stl").iterdir())) == 4
    assert (tmp_path / "here" / "preview.png").is_file()


def test_family_quiet_prints_nothing(run, tmp_path):
    result = run("family", "--tilt", "5", "--quiet", "--no-pictures")
    assert (result.exit_code, result.output) == (0, "")
    assert not (tmp_path / "out" / "koumakis2016" / "preview.png").exists()


def test_export_writes_both_formats(run, tmp_path):
    run("templates", "copy", "koumakis2016", "my.toml")
    result = run("export", "my.toml", "--tilt", "12", "--format", "stl,3mf", "--json")
    files = json.loads(result.stdout)["files"]
    assert files == [f"out/my/{form}/walker_t12.0_flexible_s0.40.{form}" for form in ("stl", "3mf")]
    assert all((tmp_path / name).stat().st_size > 500 for name in files)


SWEEP = """design = "koumakis2016"

[grid]
"legs.tilt_deg" = [10.0, 84.0]
"legs.length_mm" = [8.0, 9.0]
"""


def test_export_writes_the_walkers_of_a_sweep_by_the_numbers_of_its_rows(run, tmp_path):
    (tmp_path / "sweep.toml").write_text(SWEEP)
    result = run("export", "--sweep", "sweep.toml", "--out", "out", "--format", "stl,3mf")
    assert result.exit_code == 0
    assert "2 of 4 walkers cannot be made" in result.stderr
    assert sorted(path.name for path in (tmp_path / "out").glob("*/*")) == [
        f"koumakis2016_{number}.{form}" for number in (1, 2) for form in ("3mf", "stl")
    ]
    header, *rows = (tmp_path / "out" / "parts.csv").read_text().splitlines()
    assert header == "number,legs.tilt_deg,legs.length_mm,refused"
    assert rows[:2] == ["1,10.0,8.0,", "2,10.0,9.0,"]
    assert "tilt" in rows[2]
    run("export", "--set", "legs.length_mm=9", "--out", "alone")
    alone = (tmp_path / "alone" / "stl" / "walker_t10.0_flexible_s0.40.stl").read_bytes()
    assert (tmp_path / "out" / "stl" / "koumakis2016_2.stl").read_bytes()[80:] == alone[80:]


def test_plate_places_every_copy(run, tmp_path):
    result = run("plate", "koumakis2016", "--tilt", "5,10,15", "--copies", "8", "--printer", "prusa-mk3s", "--json")
    found = json.loads(result.stdout)
    assert len(found["rows"]) == 24
    assert len({row["name"] for row in found["rows"]}) == 3
    assert all((tmp_path / name).is_file() for name in found["files"])


def test_a_plate_that_does_not_fit_says_how_many_would(run, tmp_path):
    words = ("plate", "--max-plates", "1", "--no-pictures", "--quiet", "--copies")
    room = int(re.search(r"holds (\d+)", refusal_of(run, *words, "500"))[1])
    assert f"holds {room}." in refusal_of(run, *words, str(room + 1))
    assert not (tmp_path / "out").exists()
    assert run(*words, str(room)).exit_code == 0


def test_templates_are_listed_shown_and_copied(run, tmp_path):
    listed = json.loads(run("templates", "--json").stdout)["rows"]
    assert {(row["kind"], row["name"]) for row in listed} >= {
        ("walkers", "koumakis2016"),
        ("walkers", "maker-large"),
        ("scenes", "lane-90hz"),
        ("scenes", "lane-90hz-fitted"),
        ("printers", "replicator2x"),
        ("printers", "prusa-mk3s"),
        ("printers", "bambu-x1"),
        ("printers", "ender3"),
    }
    assert "[legs]" in run("templates", "show", "koumakis2016").stdout
    run("templates", "copy", "maker-large")
    assert (tmp_path / "maker-large.toml").read_text().startswith("#")
    assert "already exists" in refusal_of(run, "templates", "copy", "maker-large")
    source = (templates.folder() / "scenes" / "lane-90hz.toml").read_text()
    for name, file in (("my-shaker", "my-shaker.toml"), ("a-b", "_a b.toml")):
        assert run("templates", "copy", "lane-90hz", file).stdout == f"{file}\n"
        copied = (tmp_path / file).read_text()
        assert copied == source.replace('name = "lane-90hz"', f'name = "{name}"', 1) != source
        assert templates.load(file, "scenes", Scene).name == name
    assert "cannot be copied" in refusal_of(run, "templates", "copy", "../x")


@pytest.mark.parametrize("name", ["maker-large", "koumakis2016"])
def test_every_walker_template_makes_its_family(run, tmp_path, name):
    assert run("family", name, "--no-pictures", "--quiet", "--model", "known").exit_code == 0
    members = templates.load(name, "walkers", Design).members()
    made = {path.stem for path in (tmp_path / "out" / name / "stl").iterdir()}
    assert made == {names.part_name(member) for member in members}


def test_a_folder_that_cannot_be_written_is_one_clear_line(run, tmp_path):
    message = refusal_of(run, "family", "--out", "x" * 300)
    assert "cannot be written" in message
    assert not list(tmp_path.iterdir())


def test_main_prints_the_error_and_exits_with_2(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["walkergen", "predict", "--tilt", "nan"])
    with pytest.raises(SystemExit) as caught:
        main()
    captured = capsys.readouterr()
    assert caught.value.code == 2
    assert captured.err.startswith("error: --tilt 'nan'")
    assert captured.out == ""


def test_an_interrupted_family_keeps_what_is_whole(run, monkeypatch, tmp_path):
    from walkergen.core.printing import export

    written = []

    def interrupt(mesh, header, genuine=export.stl_bytes):
        if len(written) == 2:
            raise KeyboardInterrupt
        written.append(header)
        return genuine(mesh, header)

    monkeypatch.setattr(export, "stl_bytes", interrupt)
    result = run("family", "--tilt", "5,10,15")
    assert result.exit_code == 130
    assert len(list((tmp_path / "out" / "koumakis2016" / "stl").iterdir())) == 2


def test_numbers_beyond_their_limits_exit_with_2_and_write_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["walkergen", "plate", "--max-parts", "0"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "--max-parts 0" in line
    assert not list(tmp_path.iterdir())


def python(*words):
    return subprocess.run([sys.executable, *words], capture_output=True, text=True, check=False)


def test_python_m_walkergen_works():
    result = python("-m", "walkergen", "--version")
    assert (result.returncode, result.stdout.split()[0]) == (0, "walkergen")


def test_family_without_simulation_does_not_load_the_compiler(tmp_path):
    code = (
        "import sys; from walkergen.cli import command_line\n"
        f"words = ['family', '--tilt', '5', '--quiet', '--no-pictures', '--out', {str(tmp_path)!r}]"
        "\ntry: command_line(words)\nexcept SystemExit: pass\n"
        "print(sorted({'numba', 'matplotlib', 'trimesh'} & set(sys.modules)))"
    )
    assert python("-c", code).stdout.strip() == "[]"


SOME_NEED = (
    "scipy.stats",
    "scipy.optimize",
    "sklearn",
    "networkx",
    "trimesh",
    "ezdxf",
    "matplotlib",
    "pandas",
    "shapely",
    "lib3mf",
    "rich",
    "joblib",
    "walkergen.points.emulator",
)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "more"),
    [
        (("--help",), ("numpy", "numba", "scipy", "pydantic", "manifold3d")),
        (("predict", "--tilt", "10", "--json"), ("numba", "scipy")),
        (("simulate", "--tilt", "10", "--seconds", "0.05", "--runs", "1", "--json"), ()),
    ],
)
def test_a_command_loads_what_it_uses_and_no_more(words, more):
    code = (
        "import sys; from walkergen.__main__ import main; sys.argv[1:] = sys.argv[2:]\n"
        "try: main()\nexcept SystemExit: pass\n"
        f"print(sorted({{*{SOME_NEED + more!r}}} & set(sys.modules)), file=sys.stderr)"
    )
    assert python("-c", code, "walkergen", *words).stderr.splitlines()[-1] == "[]"


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_a_bar_on_a_terminal_is_drawn_with_its_control_sequences(tmp_path):
    words = ["simulate", "--seconds", "0.3", "--runs", "2"]
    shown = run_in_terminal([sys.executable, "-m", "walkergen", *words], tmp_path)
    assert b"\r\x1b[2K" in shown  # the bar was drawn over itself
    assert b"\\u001b" not in shown
    assert b"\\u000d" not in shown


def run_in_terminal(command, folder):
    """Run a command in a pseudo-terminal of 80 columns, and return the bytes that it writes."""
    import pty

    child, terminal = pty.fork()
    if child == 0:
        os.chdir(folder)
        os.execvpe(command[0], command, {**os.environ, "TERM": "xterm-256color", "COLUMNS": "80"})
    shown = b""
    with contextlib.suppress(OSError):  # Linux reports the end of a terminal as an error
        while data := os.read(terminal, 65536):
            shown += data
    os.waitpid(child, 0)
    return shown


def test_long_work_says_how_far_it_is_where_there_is_no_bar(monkeypatch, capsys):
    from walkergen.cli import console
    from walkergen.core.files.progress import Expected

    monkeypatch.setattr(console, "FIRST_LINE_S", 0.01)
    with console.progress("simulate", wanted=True) as update:
        update("runs", 1, 4)
        update("runs", 3, 4)
        for _ in range(500):  # 5 s: a busy machine
            time.sleep(0.01)
            line = capsys.readouterr().err
            if line:
                break
    assert line == "simulate: runs, 75 %, about 0 s left\n"
    expects = []
    with console.progress("accuracy", wanted=True, on_expected=expects.append) as update:
        expects[0](lambda: Expected(60.0, "5 % would take 9 s"))
        assert capsys.readouterr().err == "accuracy: about 60 s; 5 % would take 9 s\n"  # also when piped
        expects[0](lambda: pytest.fail("asked for twice"))
        update("runs", 3, 4)
        time.sleep(0.05)
        assert capsys.readouterr().err.startswith("accuracy: runs, 75 %, about 60 s left\n")
    with console.progress("simulate", wanted=False, on_expected=expects.append) as update:
        update("runs", 3, 4)
        time.sleep(0.05)
    assert len(expects) == 1
    assert capsys.readouterr().err == ""
