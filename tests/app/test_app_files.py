"""Files of `walkergen app`: those that are dropped onto its page, and those that it writes."""

import errno
import os

import file_faults as system
import hostile_inputs
import pytest
from app_doors import PAPER, Doors, document, faults, files


@pytest.fixture
def doors(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return Doors(tmp_path)


@pytest.mark.parametrize("kind", ["stl", "obj", "ply", "off", "svg", "dxf"])
def test_a_dropped_file_becomes_the_body_or_is_refused_in_words(doors, kind):
    source = hostile_inputs.SOLIDS[f"b.{kind}" if f"b.{kind}" in hostile_inputs.SOLIDS else f"d.{kind}"]
    for data in (source, source[: len(source) // 2], b"", b"\0" * 100, b"\xff" * 5000):
        kept = doors.ask("upload", data, query=f"kind={kind.upper()}")
        assert (kept.status, faults(kept)) == (200, [])
        body = {"outline" if kind in ("svg", "dxf") else "mesh": kept.json["file"]}
        body |= {"thickness_mm": 3.0} if "outline" in body else {}
        assert kept.json["key"] in {f"body.{key}" for key in body}
        assert faults(doors.ask("walker", {"document": document(body=body)})) == []
    assert doors.ask("upload", source, query=f"kind={kind}").json["file"] in {
        path.name for path in doors.server.page_files.uploads.iterdir()
    }


@pytest.mark.parametrize("kind", ["", "toml", "exe", "../stl", "stl/../../x", "st%00l", "x" * 9000])
def test_files_of_other_kinds_are_not_kept(doors, tmp_path, kind):
    answer = doors.ask("upload", b"data", query=f"kind={kind}")
    assert (answer.status, faults(answer)) == (422, [])
    assert files(tmp_path) == set()


def test_a_file_over_the_limit_is_refused_and_not_kept(doors, tmp_path, monkeypatch):
    monkeypatch.setattr("walkergen.app.server.MAX_UPLOAD_BYTES", 1000)
    assert doors.ask("upload", b"x" * 1000, query="kind=stl").status == 200
    before = files(tmp_path)
    answer = doors.ask("upload", b"x" * 1001, query="kind=stl")
    assert (answer.status, answer.refused) == (422, "more than 0.001 MB")
    answer = doors.ask("keep", b" " * 1_000_001)
    assert (answer.status, answer.refused) == (422, "more than 1 MB")
    assert files(tmp_path) == before


def test_the_oldest_of_the_files_that_were_dropped_go(doors, monkeypatch):
    monkeypatch.setattr("walkergen.app.server.MAX_UPLOAD_FOLDER_BYTES", 2500)
    names = []
    for number in range(4):
        names.append(doors.ask("upload", bytes([number]) * 1000, query="kind=stl").json["file"])
        path = doors.server.page_files.uploads / names[-1]
        os.utime(path, (number, number) if number < 3 else None)
    assert {path.name for path in doors.server.page_files.uploads.glob("*.stl")} == set(names[2:])


def test_a_dropped_file_that_somebody_changed_is_left_alone(doors):
    data = hostile_inputs.SOLIDS["b.stl"]
    name = doors.ask("upload", data, query="kind=stl").json["file"]
    (doors.server.page_files.uploads / name).write_bytes(b"mine")
    answer = doors.ask("upload", data, query="kind=stl")
    assert (answer.status, faults(answer)) == (422, [])
    assert "left alone" in answer.refused
    assert (doors.server.page_files.uploads / name).read_bytes() == b"mine"


def test_all_that_pages_write_lies_in_one_folder(doors, tmp_path):
    changed = document(legs__tilt_deg=12.0)
    doors.ask("keep", {"document": changed})
    doors.ask("upload", hostile_inputs.SOLIDS["b.stl"], query="kind=stl")
    for what in ("stl", "toml"):
        assert doors.make_files({"document": changed, "what": what}).status == 200
    names = files(tmp_path)
    assert len(names) >= 7
    assert all(name.startswith("out/app/") for name in names)
    assert not any(".walkergen-" in name for name in names)


def test_files_that_are_not_ours_are_left_alone(doors):
    asked = {"document": PAPER, "what": "stl"}
    assert doors.make_files(asked).status == 200
    (part,) = doors.folder.rglob("*.stl")
    part.write_bytes(b"mine")
    answer = doors.make_files(asked)
    assert (answer.status, faults(answer)) == (422, [])
    assert "left alone" in answer.refused
    assert part.read_bytes() == b"mine"
    kept = doors.folder / "kept.json"
    kept.write_bytes(b"{}")
    answer = doors.ask("keep", {"document": PAPER})
    assert "left alone" in answer.refused
    assert kept.read_bytes() == b"{}"
    assert doors.ask("start", {}).json["document"]["walker"] == PAPER["walker"]


def test_a_kept_document_opens_the_next_page(doors, tmp_path):
    changed = document(legs__tilt_deg=12.0)
    assert doors.ask("keep", {"document": changed}).status == 200
    again = Doors(tmp_path)
    assert again.ask("start", {}).json["document"] == changed
    other = Doors(tmp_path, own="mine.toml")  # another walker than that of the command line
    assert other.ask("start", {}).json["document"] != changed


@pytest.mark.parametrize("data", [b"", b"{", b"[]", b"[" * 99_999, b'{"document": 3}', b"\xff"])
def test_whatever_was_kept_a_page_opens(doors, data):
    doors.folder.mkdir(parents=True)
    (doors.folder / "kept.json").write_bytes(data)
    assert doors.ask("start", {}).status == 200


@pytest.mark.parametrize("call", ["open", "write", "fsync", "replace", "mkdir"])
def test_a_full_disk_refuses_in_words_and_leaves_no_half_file(doors, tmp_path, call):
    asked = {"upload": hostile_inputs.SOLIDS["b.stl"], "keep": {"document": PAPER}}
    for door, message in asked.items():
        before = files(tmp_path)
        fault = system.broken(errno.ENOSPC)
        with system.failing(doors.folder, call, 1, fault) as calls:
            answer = doors.ask(door, message, query="kind=stl")
        if calls:
            assert (answer.status, faults(answer)) == (422, [])
            assert "No space left" in answer.refused
        left = files(tmp_path) - before
        assert not [name for name in left if ".walkergen-" in name]
        assert all(name.endswith(".walkergen") for name in left) or not calls


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="whom permissions stop")
def test_a_folder_that_cannot_be_written_refuses_in_words(doors, tmp_path):
    tmp_path.chmod(0o500)
    try:
        answer = doors.ask("keep", {"document": PAPER})
        assert (answer.status, faults(answer)) == (422, [])
        assert "cannot be written" in answer.refused
    finally:
        tmp_path.chmod(0o700)


def test_a_file_where_the_folder_should_be_refuses_in_words(doors, tmp_path):
    (tmp_path / "out").write_text("mine")
    for door, message in (
        ("keep", {"document": PAPER}),
        ("upload", b"x"),
        ("taken", {"document": PAPER, "what": "stl"}),
    ):
        answer = doors.make_files(message) if door == "taken" else doors.ask(door, message, query="kind=stl")
        assert (answer.status, faults(answer)) == (422, [])
        assert "cannot be written" in answer.refused
