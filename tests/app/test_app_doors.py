"""Doors of `walkergen app`: who may open them, and what they refuse."""

import json
import os
import shlex
import subprocess
import sys
import time

import hostile_inputs
import pytest
from app_doors import HOST, MAKING, PAPER, QUICK, Doors, faults, files, messages

from walkergen.app import sentences

SEED = int(os.environ.get("WALKERGEN_HOSTILE_SEED", "16"))


@pytest.fixture
def doors(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return Doors(tmp_path)


def test_every_door_opens_to_a_page_of_this_server(doors):
    for door in ("start", "walker", "outlook", "form", "keep"):
        assert doors.ask(door, {"document": PAPER}, origin=f"http://{HOST}").status == 200
    for name in ("", "main.js", "app.css", "viewer.js", "picture/koumakis2016.svg"):
        answer = doors.ask(name, method="GET")
        assert answer.status == 200
        assert "default-src 'none'" in answer.headers["content-security-policy"]


@pytest.mark.parametrize(
    "headers",
    [
        {"host": "evil.example"},
        {"host": "evil.example:8765"},
        {"host": "127.0.0.1"},
        {"host": "localhost:1"},
        {"host": ""},
        {"origin": "http://evil.example"},
        {"origin": "null"},
        {"origin": f"https://{HOST}"},
        {"origin": "http://127.0.0.1:1"},
        {"host": "evil.example:8765", "origin": "http://evil.example:8765"},  # its name led here
    ],
)
def test_pages_of_elsewhere_open_no_door(doors, headers):
    for door in (*QUICK, *MAKING):
        answer = doors.ask(door, {"document": PAPER}, **headers)
        assert (answer.status, answer.refused) == (403, "This server answers only its own pages.")
    assert doors.ask("", method="GET", **headers).status == 403


def test_without_the_secret_there_are_no_doors(doors):
    for path in ("/", "/walker", "/x/walker", f"/{doors.server.secret[:-1]}/walker", "/once/x"):
        for method in ("GET", "POST"):
            answer = doors.request(path, method=method)
            assert answer.status in (404, 405)
            assert doors.server.secret not in answer.body.decode()
            assert answer.refused


def test_a_person_at_the_bare_address_reads_what_to_do(doors):
    answer = doors.request("/", method="GET", accept="text/html,*/*")
    assert (answer.status, answer.headers["content-type"]) == (404, "text/html; charset=utf-8")
    assert "terminal" in answer.body.decode()
    assert doors.server.secret not in answer.body.decode()


def test_the_key_of_a_refusal_is_a_key(doors):
    text = {"walker": "name", "values": {"body.text": "\u0001"}}
    far = {"values": {"legs": [{"along_mm": 0.0}, {"along_mm": 90.0}], "leg_tilt_deg": 10.0}}
    for changed in (text, far, {"values": {"legs.contact_spacing_mm": 100.0}}, {"values": {"body.length_mm": -1.0}}):
        for line in doors.ask("walker", {"document": PAPER | changed}).json["refused"]:
            assert line["key"] == "" or line["key"].startswith(("body", "legs"))


@pytest.mark.parametrize("door", [*QUICK, *MAKING])
def test_doors_are_not_opened_by_links(doors, door):
    answer = doors.ask(door, {"document": PAPER}, method="GET")
    assert (answer.status, faults(answer)) == (405, [])


def test_an_address_for_another_device_works_once(tmp_path):
    doors = Doors(tmp_path, away=True)
    assert doors.request("/once/guess", method="GET").status == 410
    first = doors.request(f"/once/{doors.server.once}", method="GET")
    assert (first.status, first.headers["location"]) == (303, f"/{doors.server.secret}/")
    again = doors.request(f"/once/{doors.server.once}", method="GET")
    assert again.status == 410
    assert "Start walkergen app again" in again.refused


@pytest.mark.parametrize(
    "values",
    [
        {key: name}
        for name in (
            "b.stl",
            "../b.stl",
            "{folder}/b.stl",
            "out/app/uploads/b.stl",
            "disc",
            "/dev/zero",
            "0123456789abcdef.stl",
            "\ud800",
            "a\0b",
        )
        for key in ("body.mesh", "walker.mesh", "body.outline")
        if (key, name) != ("body.outline", "disc")
    ]
    + [
        {"body": {"mesh": "b.stl"}},
        {"body": {"outline": "d.svg", "thickness_mm": 3}},
        {"body.mesh": ["b.stl"]},
        {"body": {"mesh": ["b.stl"]}},
        {"body": [{"mesh": "b.stl"}]},
        {"walker": {"mesh": "b.stl"}},
        {"body.mesh ": "b.stl"},
        {"body .mesh": "b.stl"},
        {"body.mesh[1]": "b.stl"},
        {"body": {"mesh": {"mesh": "b.stl"}}},
        {"legs": [{"mesh": "b.stl"}]},
        {"scene.mesh": "b.stl"},
        {"scene.x=1 --set body.mesh": "b.stl"},
        {"printer.outline": "b.stl"},
        {"family.mesh": "b.stl"},
        {"body.text": "A", "body.mesh": "b.stl"},
    ],
)
def test_no_path_of_a_file_comes_from_a_page(doors, tmp_path, monkeypatch, values):
    (tmp_path / "b.stl").write_bytes(hostile_inputs.SOLIDS["b.stl"])
    (tmp_path / "d.svg").write_bytes(hostile_inputs.SOLIDS["d.svg"])
    opened = watched(monkeypatch, (tmp_path / "b.stl", tmp_path / "d.svg"))
    values = json.loads(json.dumps(values).replace("{folder}", str(tmp_path)))
    for door in ("walker", "outlook", "form", "run", "make"):
        message = {"document": PAPER | {"values": values}, "what": "stl"}
        answer = doors.ask(door, message)
        if not answer.body.startswith(b'{"refused"'):
            assert door in ("run", "make")  # a key of a scene goes to the child, which refuses it
            (event,) = [each for each in answer.events if "progress" not in each]
            assert event["refused"]
        assert faults(answer) == []
    assert opened == []


def watched(monkeypatch, paths):
    """List of those paths that this process opens from now on."""
    opened, true = [], os.open

    def open_(path, *more, **options):
        if not isinstance(path, int) and os.path.abspath(path) in map(str, paths):  # noqa: PTH100
            opened.append(path)
        return true(path, *more, **options)

    monkeypatch.setattr(os, "open", open_)
    return opened


@pytest.mark.parametrize("name", ["../x", "/etc/passwd", "x.toml", "koumakis2016.toml", "", "A" * 99])
@pytest.mark.parametrize("kind", ["walker", "scene", "printer"])
def test_walkers_scenes_and_printers_are_named_not_located(doors, tmp_path, kind, name):
    (tmp_path / "x.toml").write_text("nothing")
    for door in ("walker", "form", "keep", "run", "crowd", "nearest", "make", "effects", "effects_drawn"):
        answer = doors.ask(door, {"document": PAPER | {kind: name}, "what": "stl", "speed": 60})
        assert (answer.status, faults(answer)) == (422, [])


def test_only_the_own_file_of_the_command_line_is_read(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("mine", "other"):
        (tmp_path / f"{name}.toml").write_text("[legs]\ntilt_deg = 17.0\n")
    doors = Doors(tmp_path, own="mine.toml")
    answer = doors.ask("walker", {"document": PAPER | {"walker": "mine.toml"}})
    assert json.loads(answer.body.split(b"\n")[0])["tilt_deg"] == 17.0
    for name in ("other.toml", "./mine.toml", str(tmp_path / "mine.toml")):
        assert doors.ask("walker", {"document": PAPER | {"walker": name}}).status == 422


def test_a_picture_is_of_a_template_alone(doors):
    for name in ("x", "..%2fx", "koumakis2016.toml", "../scenes/lane-90hz"):
        assert doors.ask(f"picture/{name}.svg", method="GET").status == 404


def judged(doors, door, tries, leave_s=None):
    """Faults of the answers of a door, with what was asked."""
    found = []
    for number, message in enumerate(tries):
        begun = time.monotonic()
        answer = doors.ask(door, message, leave_s, query="kind=stl")
        wrong = faults(answer)
        if time.monotonic() - begun > 30.0:
            wrong.append("takes long")
        if wrong:
            found.append((number, wrong, message[:500]))
    return found


@pytest.mark.parametrize("door", [*QUICK, *MAKING])
def test_a_few_hostile_messages_are_answered_or_refused(doors, door):
    assert judged(doors, door, messages(SEED, 20), leave_s=0.2) == []


MANY = [
    *(pytest.param(door, 60, marks=pytest.mark.slow) for door in (*QUICK, *MAKING)),
    *(pytest.param(door, 1000, marks=pytest.mark.nightly) for door in (*QUICK, *MAKING)),
]


@pytest.mark.parametrize(("door", "count"), MANY)
def test_many_hostile_messages_are_answered_or_refused(doors, tmp_path, door, count):
    assert judged(doors, door, messages(SEED + 1, count), leave_s=0.2) == []
    assert all(name.startswith("out/app/") for name in files(tmp_path))


@pytest.mark.parametrize(
    "asked",
    [
        {"what": []},
        {"what": {}},
        {"what": None},
        {"what": "exe"},
        {"copies": 0},
        {"copies": True},
        {"copies": 1.5},
        {"copies": 10**9},
        {"copies": "4"},
        {"copies": None},
    ],
)
def test_files_are_asked_for_by_name_and_number(doors, asked):
    answer = doors.ask("take", {"document": PAPER, "what": "plate"} | asked)
    assert (answer.status, faults(answer)) == (422, [])
    assert next(iter(asked)) in answer.refused


@pytest.mark.parametrize(
    "asked", [{}, {"speed": None}, {"speed": True}, {"speed": "60"}, {"speed": 1e300}, {"speed": 10**400}]
)
def test_a_wished_speed_is_a_number(doors, asked):
    answer = doors.ask("nearest", {"document": PAPER} | asked)
    assert faults(answer) == []
    assert answer.status == 422 or answer.events[-1]["refused"]


def test_a_wished_speed_finds_walkers_that_have_it(doors):
    answer = doors.ask("nearest", {"document": PAPER | {"values": {"legs.tilt_deg": 44}}, "speed": 20})
    row = json.loads(answer.events[-1]["output"])["nearest"][0]
    assert row["predicted_low_95_mm_s"] < row["speed_mm_s"] < row["predicted_high_95_mm_s"]
    assert row["speed_mm_s"] == pytest.approx(20.0, rel=0.05)
    assert row["print_errors"] == 0


@pytest.mark.slow
def test_a_wished_speed_of_many_legs_is_simulated(doors):
    short = {"scene.run.seconds": 0.2, "scene.run.runs": 2}
    answer = doors.ask("nearest", {"document": PAPER | {"walker": "bristle", "values": short}, "speed": 20})
    row = json.loads(answer.events[-1]["output"])["nearest"][0]
    assert row["leg_tilt_deg"] > 20
    assert row["model"] == "space"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("scene.run.seconds", 2e7),
        ("scene.run.runs", 100_001),
        ("scene.run.step_us", 1e-3),
        ("scene.run.runs", 10**30),
        ("scene.run.seed", -1),
    ],
)
def test_a_page_starts_what_the_command_line_starts_and_no_more(doors, key, value):
    answer = doors.ask("run", {"document": PAPER | {"values": {key: value}}})
    (line,) = answer.events[-1]["refused"]
    assert key not in line
    words = [
        sys.executable,
        *shlex.split("-m walkergen simulate koumakis2016 --scene plane-90hz --json --set"),
        f"{key}={value}",
    ]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 2
    assert sentences.to_plain_text(done.stderr.split(": ", 2)[-1].strip()) in line
