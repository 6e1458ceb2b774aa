"""Sweeps: a table that survives, is taken up again, shares points, and trusts no edited row."""

import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time

import pytest
from command_checks import rows_of
from typer.testing import CliRunner

import walkergen as wg
from walkergen.cli import command_line
from walkergen.core.errors import InputError
from walkergen.core.files.output import Folder
from walkergen.core.files.progress import silent
from walkergen.core.scene import Scene
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.sweep import axes, make, table
from walkergen.guests.sweep.request import SweepRequest
from walkergen.guests.sweep.sweep_points import SweepPoints
from walkergen.points import model_kinds
from walkergen.points import speed_prediction as speeds
from walkergen.points.store import Store

TILTS = "legs.tilt_deg=2:20:2"
GAMMAS = "scene.drive.gamma=1.5,1.8,2.2"
SHELL, BARE = (SweepRequest.from_values({"pictures": pictures}, shell=True) for pictures in (True, False))


def swept(*arguments, code=0):
    """Result of a sweep by the command line, without pictures."""
    found = CliRunner().invoke(command_line, ["sweep", *arguments, "--no-pictures"])
    assert found.exit_code == code, found.output
    return found


def points_of(*texts, **choices):
    design = templates.load("koumakis2016", "walkers", Design)
    scene = templates.load("lane-90hz", "scenes", Scene)
    return SweepPoints(design, scene, axes.Space(tuple(map(axes.parse, texts))), **choices)


def test_the_table_holds_the_predictions(home):
    swept(
        "--set", TILTS, "--set", GAMMAS, *shlex.split("--keep speed,masses,printability --printer prusa-mk3s --out map")
    )
    rows = rows_of(home / "map" / "table.csv")
    assert len(rows) == 30
    one = points_of().point({"legs.tilt_deg": 14, "scene.drive.gamma": 1.8})
    expected = speeds.predict(one.design, solids.mass_of(one.design), one.scene, model="known")
    key = ("14", "1.8")
    (row,) = [r for r in rows if (r["legs.tilt_deg"], r["scene.drive.gamma"]) == key]
    assert float(row["speed_mm_s"]) == expected.speed.value
    assert float(row["M_g"]) == expected.M_g
    assert row["print_errors"] == "0"


def test_a_finished_sweep_is_not_run_again_and_an_extended_one_runs_what_is_new(home, monkeypatch):
    swept("--set", TILTS, "--out", "one")
    first = (home / "one" / "table.csv").read_bytes()
    counted = []
    real = model_kinds.evaluate
    monkeypatch.setattr("walkergen.guests.sweep.evaluation.evaluate", lambda p: counted.append(p) or real(p))
    answered = swept("--set", TILTS, "--out", "one").output
    assert answered.startswith("10 points. Fastest: 53.7 mm/s (95 %: 36.5 to 75.7) at legs.tilt_deg = 12")
    assert "all points were stored before" in answered
    swept("--set", "legs.tilt_deg=2:30:2", "--out", "one")
    assert [one.design.tilt_deg for one in counted] == [22, 24, 26, 28, 30]
    assert (home / "one" / "table.csv").read_bytes()[: len(first)] == first
    counted.clear()
    swept("--set", "legs.tilt_deg=20,4,40", "--out", "two")  # shared with another sweep
    assert [one.design.tilt_deg for one in counted] == [40]


def test_no_number_is_believed_because_a_table_says_so(home):
    """A row whose check sum fits, in a folder of a stranger, is computed here all the same."""
    swept("--set", TILTS, "--out", "one")
    path = home / "one" / "table.csv"
    first = path.read_bytes()
    lines = path.read_text().splitlines(keepends=True)
    cells = lines[3].split(",")
    line = ",".join([cells[0], "9999.0", *cells[2:-1]])
    lines[3] = f"{line},{table.row_checksum(line)}\n"
    path.write_text("".join(lines))
    (home / "one" / "manifest.json").unlink()
    (home / "cache").rename(home / "another")  # the stranger's machine has its own
    assert "table.edited.csv" in swept("--set", TILTS, "--out", "one").stderr
    assert path.read_bytes() == first
    swept("--set", TILTS, "--out", "two")
    assert (home / "two" / "table.csv").read_bytes() == first


@pytest.mark.parametrize(
    "edit",
    [
        lambda data: data + b"# my note\n",
        lambda data: data + b"# my note",
        lambda data: data.replace(b"speed_mm_s", b"speed", 1),
        lambda data: data + b"\x00\x00",
        lambda data: data.replace(b"\n", b"\r\n"),
    ],
    ids=["note", "note without an end", "header", "NULs", "CRLF"],
)
def test_whatever_somebody_changed_is_kept(home, edit):
    swept("--set", TILTS, "--out", "one")
    path = home / "one" / "table.csv"
    mine = edit(path.read_bytes())
    path.write_bytes(mine)
    assert "changed by hand" in swept("--set", "legs.tilt_deg=2:30:2", "--out", "one").stderr
    assert (home / "one" / "table.edited.csv").read_bytes() == mine


def test_a_table_cut_by_a_full_disk_is_made_anew(home):
    swept("--set", TILTS, "--out", "one")
    path = home / "one" / "table.csv"
    first = path.read_bytes()
    (home / "one" / "manifest.json").unlink()
    (home / "one" / ".manifest.json.walkergen").write_text('["table.csv", "growing"]\n')
    for cut in (0, 40, len(first) - 30):
        path.write_bytes(first[:cut])
        swept("--set", TILTS, "--out", "one")
        assert path.read_bytes() == first
        assert not (home / "one" / "table.edited.csv").exists()
        (home / "one" / "manifest.json").unlink()
        (home / "one" / ".manifest.json.walkergen").write_text('["table.csv", "growing"]\n')


def test_an_edited_row_is_named_kept_and_not_trusted(home, monkeypatch):
    swept("--set", TILTS, "--out", "one")
    path = home / "one" / "table.csv"
    first = path.read_text()
    lines = first.splitlines(keepends=True)
    speed = lines[3].split(",")[1]
    lines[3] = lines[3].replace(speed, "99.0")
    path.write_text("".join(lines))
    monkeypatch.setenv("XDG_CACHE_HOME", str(home / "another"))
    told = swept("--set", TILTS, "--out", "one")
    assert "changed by hand in line 4" in told.stderr
    assert path.read_text() == first
    assert "99.0" in (home / "one" / "table.edited.csv").read_text()


def test_a_walker_that_stands_as_built_is_turned_anew_at_every_point(home):
    built = ("--set", "stance=as built", "--set", "legs[1].foot=square", "--set", "legs[2].foot=square")
    swept("unequal-legs", *built, "--set", "legs[1].length_mm=6,9", "--out", "one")
    for row in rows_of(home / "one" / "table.csv"):
        length = f"legs[1].length_mm={row['legs[1].length_mm']}"
        words = ["predict", "unequal-legs", *built, "--set", length, "--model", "theory", "--json"]
        (expected,) = json.loads(CliRunner().invoke(command_line, words).stdout)["rows"]
        assert float(row["theory_mm_s"]) == expected["theory_mm_s"]


def test_a_person_s_own_table_is_left_alone(home):
    (home / "one").mkdir()
    (home / "one" / "table.csv").write_text("speed,notes\n1,mine\n")
    assert "is not a table of a sweep" in str(swept("--set", TILTS, "--out", "one", code=1).exception)
    assert (home / "one" / "table.csv").read_text() == "speed,notes\n1,mine\n"


def test_points_that_cannot_be_are_rows_with_a_reason(home):
    answered = swept("--set", "legs.tilt_deg=10,80,-90", "--out", "one").output
    assert answered.startswith("2 of 3 points have no speed: ")
    good, steep, beyond = rows_of(home / "one" / "table.csv")
    assert good["status"] == "ok"
    assert steep["status"].startswith("refused:")
    assert beyond["speed_mm_s"] == ""


def test_a_thousand_million_points_ask_first(home):
    axes_ = [f"scene.contact.{key}=0:1:0.001" for key in ("restitution", "friction", "friction_sd")]
    given = [part for text in axes_ for part in ("--set", text)]
    found = str(swept(*given, "--out", "one", code=1).exception)
    assert "1.003e+09 points" in found
    assert "Give --yes" in found
    assert not (home / "one").exists()


def test_two_sweeps_do_not_write_one_folder(home):
    with Folder(home / "one") as folder:
        folder.claim()
        found = swept("--set", TILTS, "--out", "one", code=1)
    assert "another walkergen writes there" in str(found.exception)


def test_samples_are_the_same_for_a_seed(home):
    for name in ("one", "two"):
        swept("--set", "legs.tilt_deg=2:40", "--set", "legs.length_mm=5:10", "--sample", "sobol:16", "--out", name)
    one, two = ((home / name / "table.csv").read_bytes() for name in ("one", "two"))
    assert one == two
    tilts = [float(row["legs.tilt_deg"]) for row in rows_of(home / "one" / "table.csv")]
    assert len(tilts) == 16
    # Of a Sobol sequence each half holds half of the points.
    assert sum(tilt < 21.0 for tilt in tilts) == 8


def test_parquet_holds_the_table(home):
    from pyarrow import parquet

    swept("--set", TILTS, "--set", "legs.kind=flexible,braced", "--out", "one")
    found = parquet.read_table(home / "one" / "table.parquet")
    rows = rows_of(home / "one" / "table.csv")
    assert found["legs.kind"].to_pylist() == [row["legs.kind"] for row in rows]
    assert found["speed_mm_s"].to_pylist() == [float(row["speed_mm_s"]) for row in rows]


@pytest.mark.slow
def test_a_full_disk_is_one_line_and_loses_no_point(home):
    program = "\n".join(
        [
            "import resource, signal, sys",
            "from walkergen.cli import main",
            "resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))",
            "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)",
            "sys.argv[1:] = ['sweep', '--set', 'legs.tilt_deg=0:40:0.1', '--no-pictures',",
            "                '--out', 'one']",
            "if __name__ == '__main__':",
            "    main()",
        ]
    )
    (home / "full.py").write_text(program)
    found = subprocess.run([sys.executable, "full.py"], capture_output=True, text=True, check=False)
    assert found.returncode == 1
    assert "Traceback" not in found.stderr
    *lines, error = found.stderr.splitlines()
    assert all(line.startswith("sweep: about ") for line in lines)  # a slow machine says first how long it will take
    assert error.startswith("error: ")
    assert "points.sqlite: the store o" in found.stderr or "File too large" in found.stderr
    swept("--set", "legs.tilt_deg=0:40:0.1", "--out", "one")
    assert len(rows_of(home / "one" / "table.csv")) == 401


ENDLESS_ENOUGH = "legs.tilt_deg=1:40:0.1"


def killed(folder, seconds):
    """A sweep in a process of its own, killed so long after its first rows; the rows it left."""
    path = folder / "table.csv"
    path.unlink(missing_ok=True)
    command = [
        sys.executable,
        *shlex.split("-m walkergen sweep --no-pictures --quiet --set"),
        ENDLESS_ENOUGH,
        "--out",
        str(folder),
    ]
    started = subprocess.Popen(command, start_new_session=True)
    until = time.monotonic() + 60.0
    while (not path.exists() or path.stat().st_size < 3000) and time.monotonic() < until:
        time.sleep(0.002)
    time.sleep(seconds)
    os.kill(started.pid, signal.SIGKILL)
    started.wait()
    return len(path.read_bytes().splitlines()) - 1


def ends_whole(folder, home, texts):
    """Assert that the sweep completes to the bytes of one that was never killed. Return its output."""
    told = swept("--set", texts, "--out", str(folder)).output
    swept("--set", texts, "--out", "never-killed")
    first, second = ((home / one / "table.csv").read_bytes() for one in (folder, "never-killed"))
    assert first == second
    return told


@pytest.mark.slow
def test_a_killed_sweep_goes_on(home):
    assert 0 < (rows := killed(home / "one", 0.0)) < 391
    told = ends_whole("one", home, ENDLESS_ENOUGH)
    assert rows <= int(re.search(r"(\d+) of the points were stored before", told)[1]) < 391


def test_memory_does_not_grow_with_the_points():
    space = axes.Space(tuple(axes.parse(f"scene.{key}=0:1:0.001") for key in ("a", "b", "c")))
    rows = space.rows()
    assert space.point_count == 1001**3
    assert next(rows) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("tilts", ["5"])
def test_there_is_no_figure_where_nothing_can_be_compared(home, tilts):
    points = points_of(f"legs.tilt_deg={tilts}")
    made = make.make_sweep(SHELL, points, home / "one", Store(home / "points"), None, silent)
    assert len(made.table) == len(tilts.split(","))
    assert not (home / "one" / "sweep.png").exists()
    with pytest.raises(InputError, match="the report has no figure"):
        made.plot()


def test_rows_are_kept_for_pictures_and_for_python_alone(home):
    store, points, python = Store(home / "points"), points_of(TILTS), SweepRequest(pictures=False)
    bare = make.make_sweep(BARE, points, home / "one", store, None, silent)
    whole = make.make_sweep(python, points, home / "one", store, None, silent)
    found = make.evaluate_all(python, points, store, None, silent)
    assert len(bare.table) == 0
    assert bare.facts["points"] == len(whole.table) == 10
    assert whole.table.rows == found.table.rows
    assert list(whole["table"]) == list(found["table"])
    assert whole.facts["files"] == [str(home / "one" / "table.csv"), str(home / "one" / "table.parquet")]


def test_a_job_reports_its_progress(home):
    told = []
    store = Store(home / "points")
    make.make_sweep(BARE, points_of(TILTS), home / "one", store, None, lambda *one: told.append(one))
    assert told[-1] == ("points", 10, 10)


def test_a_wished_speed_lists_the_nearest_points_and_leaves_the_table(home):
    wished = swept("--set", TILTS, "--set", GAMMAS, "--wish", "20", "--json", "--out", "one")
    plain = swept("--set", TILTS, "--set", GAMMAS, "--out", "two")
    assert "nearest" not in plain.output
    assert (home / "one" / "table.csv").read_bytes() == (home / "two" / "table.csv").read_bytes()
    nearest = json.loads(wished.stdout)["nearest"]
    rows = rows_of(home / "one" / "table.csv")
    speeds = [float(row["speed_mm_s"]) for row in rows if row["speed_mm_s"]]
    expected = sorted(speeds, key=lambda speed: abs(speed - 20.0))[:5]
    assert [row["speed_mm_s"] for row in nearest] == expected
    assert all(row["low_95_mm_s"] < row["speed_mm_s"] < row["high_95_mm_s"] for row in nearest)
    told = swept("--set", TILTS, "--set", GAMMAS, "--wish", "20", "--out", "one").output
    assert "95 %" in told
    assert f"{expected[0]:.4g}" in told


def test_points_that_do_not_print_are_never_the_nearest(home):
    words = ("--keep", "speed,printability", "--printer", "ender3", "--json")
    thin = swept("--set", "legs.flexible_thickness_mm=0.2:0.5:0.05", "--wish", "200", *words)
    rows = json.loads(thin.stdout)["nearest"]
    assert 0 < len(rows) < 7
    assert not any(row["print_errors"] for row in rows)


def test_from_python_the_first_row_is_the_nearest(home):
    table = wg.sweep(set={"legs.tilt_deg": [5, 10, 15, 20]}, wish=1000.0).table
    speeds = table["speed_mm_s"]
    assert list(speeds) == sorted(speeds, reverse=True)
