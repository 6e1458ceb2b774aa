"""Files are written whole or not at all."""

import sys
from pathlib import Path

import pytest

from walkergen.core.errors import OutputError
from walkergen.core.files import output


def test_a_file_is_written_with_its_folders_and_replaced_whole(tmp_path: Path) -> None:
    path = tmp_path / "new" / "folder" / "walker.stl"
    output.write(path, b"first")
    output.write(path, b"second")
    assert path.read_bytes() == b"second"
    assert [entry.name for entry in path.parent.iterdir()] == ["walker.stl"]


@pytest.mark.parametrize("broken", ["pathlib.Path.replace", "walkergen.core.files.output._create"])
@pytest.mark.parametrize(
    ("raised", "seen"),
    [(OSError(28, "No space left on device"), OutputError), (KeyboardInterrupt(), KeyboardInterrupt)],
)
def test_an_interrupted_write_keeps_the_old_file_and_leaves_no_temporary(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, broken: str, raised: BaseException, seen: type[BaseException]
) -> None:
    path = tmp_path / "walker.stl"
    path.write_bytes(b"old")
    temporaries = []

    def fail(first: Path, *_: object) -> None:
        with first.open("wb") as half:
            half.write(b"ne")
        temporaries.append(first)
        raise raised

    monkeypatch.setattr(broken, fail)
    with pytest.raises(seen) as caught:
        output.write(path, b"new")
    monkeypatch.undo()
    assert [entry.name for entry in tmp_path.iterdir()] == ["walker.stl"]
    assert path.read_bytes() == b"old"
    assert temporaries[0].parent == tmp_path
    assert temporaries[0].name.startswith(".")
    if seen is OutputError:
        assert str(caught.value).startswith(f"{str(path)!r}: cannot be written: No space left")


@pytest.mark.parametrize("name", ["", "a\x00b", "x" * 300, "file/below", "."])
def test_a_path_that_cannot_be_written_is_one_line(tmp_path: Path, name: str) -> None:
    (tmp_path / "file").write_bytes(b"in the way")
    with pytest.raises(OutputError) as caught:
        output.write(tmp_path / name, b"data")
    assert len(str(caught.value).splitlines()) == 1
    assert [entry.name for entry in tmp_path.iterdir()] == ["file"]


@pytest.mark.skipif(sys.platform == "win32", reason="links need rights there")
def test_no_link_next_to_a_file_redirects_the_writing(tmp_path):
    """The temporary name is random and new, so no link can be prepared for it."""
    victim = tmp_path / "victim"
    victim.write_text("mine")
    (tmp_path / ".family.csv.part").symlink_to(victim)
    output.write(tmp_path / "family.csv", b"ours")
    assert victim.read_text() == "mine"
    assert (tmp_path / "family.csv").read_bytes() == b"ours"
    (tmp_path / "family.csv").unlink()
    (tmp_path / "family.csv").symlink_to(victim)  # the rename replaces the link itself
    output.write(tmp_path / "family.csv", b"ours")
    assert victim.read_text() == "mine"
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == [".family.csv.part", "family.csv", "victim"]


def test_the_longest_name_that_a_folder_takes_can_be_written(tmp_path):
    output.write(tmp_path / ("n" * 255), b"1")
    assert [len(path.name) for path in tmp_path.iterdir()] == [255]


def test_of_a_folder_only_the_manifest_waits_for_the_disk(tmp_path, monkeypatch):
    waits = []
    monkeypatch.setattr(output.os, "fsync", waits.append)
    with output.Folder(tmp_path) as folder:
        for name in ("one.stl", "two.stl", "three.stl"):
            folder.write(name, b"solid")
        assert not waits
        folder.finish({})
    assert len(waits) == 1
