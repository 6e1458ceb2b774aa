"""What `walkergen app` hands out and shows is what its commands make and print, to the byte."""

import contextlib
import io
import itertools
import json
import shlex
import shutil
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import file_faults as system
import pytest
import trimesh
from app_doors import PAPER, Doors, document

from walkergen.app import document as documents
from walkergen.app import sentences

CHANGED = document(
    legs__tilt_deg=12.5,
    legs__kind="braced",
    body__length_mm=30.0,
    description='a "b" \x7f é',
    scene__contact__friction=0.3,
    scene__run__seconds=1.0,
    scene__run__runs=2,
    printer__line_width_mm=0.42,
)
DRAWING = (
    b'<svg xmlns="http://www.w3.org/2000/svg" width="30mm" height="10mm" viewBox="0 0 30 10">'
    b'<path d="M0 0H30V10H0Z"/></svg>'
)
LISTED = PAPER | {"walker": "unequal-legs", "scene": "lane-90hz"}


@pytest.fixture
def doors(tmp_path, monkeypatch):
    (tmp_path / "page").mkdir()
    monkeypatch.chdir(tmp_path / "page")
    return Doors(Path())


def command(folder, words):
    """What a command line prints that runs in a folder and succeeds."""
    done = subprocess.run([sys.executable, "-m", "walkergen", *words], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def uploaded(doors, kind):
    """Document whose body was dropped as a file."""
    box = trimesh.creation.box((30.0, 10.0, 4.0)).export(file_type="stl")
    data = DRAWING if kind == "svg" else box
    name = doors.ask("upload", data, query=f"kind={kind}").json["file"]
    body = {"outline": name, "thickness_mm": 3.0} if kind == "svg" else {"mesh": name}
    return document(body=body)


def taken(doors, chosen, what):
    """Files by their names, as the page hands them out, and the lines for a shell it shows."""
    answer = doors.make_files({"document": chosen, "what": what, "copies": 2})
    assert answer.status == 200, answer.body
    name = answer.headers["content-disposition"].split('"')[1]
    entries = {name: answer.body}
    if name.endswith(".zip"):
        with contextlib.closing(zipfile.ZipFile(io.BytesIO(answer.body))) as archive:
            entries = {each: archive.read(each) for each in archive.namelist()}
    return entries, json.loads(answer.headers["walkergen-shell"])


def made(folder, doors, lines):
    """Files that lines for a shell make in a folder, from files that were dropped, by name."""
    if doors.server.page_files.uploads.exists():
        shutil.copytree(doors.server.page_files.uploads, folder / "out" / "app" / "uploads")
    for line in lines:
        first, *words = shlex.split(line)
        assert first == "walkergen"
        command(folder, words)
    (target,) = (each for each in (folder / "out" / "app").iterdir() if each.name != "uploads")
    return target


def timeless(folder):
    """Files of a folder by name, without those that say when they were made."""
    contents = system.tree(folder)
    return {name: data for name, data in contents.items() if not name.rpartition("/")[2].startswith(".")}


BY_DAY = ("changed-stl", "changed-page", "stl-3mf", "svg-plate")
FILES = [
    pytest.param(chosen, what, id=f"{chosen}-{what}", marks=by_day if f"{chosen}-{what}" in BY_DAY else by_night)
    for by_day, by_night in [(pytest.mark.slow, pytest.mark.nightly)]
    for chosen, what in itertools.product(("changed", "listed", "stl", "svg"), ("stl", "3mf", "plate", "page"))
]


@pytest.mark.parametrize(("chosen", "what"), FILES)
def test_files_equal_those_of_the_lines_for_a_shell(doors, tmp_path, what, chosen):
    documents = {"changed": CHANGED, "listed": LISTED}
    document = documents[chosen] if chosen in documents else uploaded(doors, chosen)
    entries, lines = taken(doors, document, what)
    again = tmp_path / "again"
    again.mkdir()
    folder = made(again, doors, lines)
    (own,) = (each for each in doors.folder.iterdir() if each.name != "uploads")
    assert timeless(own) == timeless(folder)
    for name, data in entries.items():
        (path,) = own.rglob(name) if len(entries) == 1 else [own / name]
        assert path.read_bytes() == data


@pytest.mark.slow
def test_an_archive_holds_all_that_its_lines_make(doors, tmp_path):
    entries, lines = taken(doors, CHANGED, "zip")
    again = tmp_path / "again"
    again.mkdir()
    folder = made(again, doors, lines)
    (own,) = (each for each in doors.folder.iterdir() if each.is_dir())
    (own,) = (each for each in doors.folder.iterdir() if each.is_dir())
    ours = timeless(own)
    assert set(ours) == set(entries)
    settings = {name: ours.pop(name) for name in entries if name.startswith("settings/")}
    assert set(settings) == {f"settings/{each}.toml" for each in ("walker", "scene", "printer")}
    assert ours == timeless(folder)


@pytest.mark.slow
def test_an_archive_of_fewer_plates_keeps_none_of_the_earlier(doors):
    many = doors.make_files({"document": PAPER, "what": "plate", "copies": 300})
    few = doors.make_files({"document": PAPER, "what": "plate", "copies": 2})
    names = [
        [name for name in zipfile.ZipFile(io.BytesIO(each.body)).namelist() if name.endswith(".3mf")]
        for each in (many, few)
    ]
    assert len(names[0]) > 1
    assert len(names[1]) == 1


@pytest.mark.parametrize("chosen", ["changed", pytest.param("stl", marks=pytest.mark.slow)])
def test_lines_of_python_make_the_same_part_and_speed(doors, tmp_path, chosen):
    document = CHANGED if chosen == "changed" else uploaded(doors, chosen)
    (part,) = taken(doors, document, "stl")[0].values()
    lines = doors.ask("outlook", {"document": document}).json["python"]
    if chosen == "stl":  # whose speed is that of a run of seconds
        lines = "\n".join(line for line in lines.splitlines() if "predict" not in line)
    done = subprocess.run([sys.executable, "-c", lines], cwd=tmp_path / "page", capture_output=True, text=True)
    facts = json.loads(doors.ask("walker", {"document": document}).body.split(b"\n")[0])
    assert (done.stdout, done.stderr) == ("" if chosen == "stl" else f"{facts['speed']}\n", "")
    assert (tmp_path / "page" / "walker.stl").read_bytes() == part


@pytest.mark.slow
@pytest.mark.parametrize("chosen", [CHANGED], ids=["changed"])
def test_numbers_equal_those_of_predict(doors, tmp_path, chosen):
    facts = json.loads(doors.ask("walker", {"document": chosen}).body.split(b"\n")[0])
    shares = doors.ask("shares", {"document": chosen}).json["shares"]
    words = documents.arguments(documents.from_message(chosen, doors.server.page_files), "predict")
    (row,) = json.loads(command(tmp_path, [*words, "--uncertain", "--json"]))["rows"]
    first = {sentences.format_name(share["name"]): max(share["first"], 0.0) for share in row["shares"]}
    assert {share["name"]: share["part"] for share in shares if share["name"] in first} == first
    assert sum(share["part"] for share in shares) == pytest.approx(1.0, abs=0.1)
    assert {key: row[key] for key in facts["row"]} == facts["row"]


@pytest.mark.slow
def test_a_walker_that_only_runs_know_has_the_number_of_predict(doors, tmp_path):
    restitution = 0.2 + 1e-6 * (time.time_ns() // 1000 % 100_000)  # in nobody's store
    chosen = document(scene__contact__friction=0.8, scene__contact__restitution=restitution)
    assert not json.loads(doors.ask("walker", {"document": chosen}).body.split(b"\n")[0])["sentence"]["sure"]
    events = doors.ask("run", {"document": chosen, "short": True}, leave_s=300.0).events
    assert [event for event in events if event.keys() != {"progress"}] == [{"predicted": True}]
    facts = json.loads(doors.ask("walker", {"document": chosen}).body.split(b"\n")[0])
    words = documents.arguments(documents.from_message(chosen, doors.server.page_files), "predict", "--json")
    (row,) = json.loads(command(tmp_path, words))["rows"]
    assert facts["sentence"]["sure"]
    assert {key: row[key] for key in facts["row"]} == facts["row"]


@pytest.mark.slow
def test_numbers_of_a_run_equal_those_of_simulate(doors, tmp_path):
    *before, event = doors.ask("run", {"document": CHANGED}).events
    shares = [each["progress"][1] for each in before if "progress" in each]
    assert shares == sorted(shares)  # one bar, whose parts follow one another
    words = documents.arguments(documents.from_message(CHANGED, doors.server.page_files), "simulate", "--json")
    clocks = {"wall_s": 0.0, "cpu_s": 0.0}
    printed = json.loads(command(tmp_path, words))
    assert event["facts"] | clocks == printed | clocks


@pytest.mark.slow
@pytest.mark.parametrize("chosen", ["changed", "listed", "stl", "svg"])
def test_settings_taken_from_a_page_are_its_walker(doors, tmp_path, chosen):
    chosen = {"changed": CHANGED, "listed": LISTED}.get(chosen) or uploaded(doors, chosen)
    entries, _ = taken(doors, chosen, "toml")
    for name, data in entries.items():
        (tmp_path / "settings").mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(data)
    words = ["predict", "walker.toml", "--scene", "scene.toml", "--model", "theory", "--json"]
    printed = command(tmp_path / "settings", words)
    facts = json.loads(doors.ask("walker", {"document": chosen}).body.split(b"\n")[0])
    (row,) = json.loads(printed)["rows"]
    by_numbers = "mesh" in chosen["values"].get("body", {})  # a mesh's legs, found on the page, are numbers in the file
    for key in ("M_g", "J_g_mm2", "m_g", "j_g_mm2", "theory_mm_s", "factor_back", "tilt_deg"):
        value = facts["row"][key]
        assert row[key] == (pytest.approx(value, rel=5e-3) if by_numbers and value is not None else value)
    if by_numbers:
        return
    again = Doors(tmp_path / "settings", own=str(tmp_path / "settings" / "walker.toml"))
    own = chosen | {
        "walker": str(tmp_path / "settings" / "walker.toml"),
        "values": {key: each for key, each in chosen["values"].items() if key.startswith("scene.")},
    }
    assert again.ask("walker", {"document": own}).body == doors.ask("walker", {"document": chosen}).body
