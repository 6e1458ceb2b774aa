"""Kernels that came compiled: used where all they depend on is the same, and else never read."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import hatch_build
from walkergen.core import caches
from walkergen.core.numerics import kernels, shipped_kernels
from walkergen.core.numerics.shipped_kernels import Kind

OWN = Kind("0123", "0.68.1", "cpython-311", "linux-x86_64", "x86-64-v3")
POSIX = pytest.mark.skipif(not hasattr(os, "getuid"), reason="owners and modes of POSIX")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    for name in ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"):
        monkeypatch.delenv(name, raising=False)
    place = tmp_path / "kernels"
    place.mkdir(mode=0o755)
    (place / shipped_kernels.MANIFEST).write_text(json.dumps(OWN._asdict() | {"files": {}}))
    return place


def test_kernels_of_the_same_kind_are_used(folder):
    assert shipped_kernels.mismatch_reason(shipped_kernels.read_manifest(folder), OWN, folder) == ""


@pytest.mark.parametrize(
    ("field", "told"),
    [
        ("sources", "edited sources"),
        ("numba", "numba other, this is 0.68.1"),
        ("python", "python other, this is cpython-311"),
        ("machine", "machine other, this is linux-x86_64"),
        ("cpu", "cpu other"),
    ],
)
def test_kernels_of_another_kind_are_refused_by_name(folder, field, told):
    made = shipped_kernels.read_manifest(folder) | {field: "other"}
    assert told in shipped_kernels.mismatch_reason(made, OWN, folder)


def test_a_requested_or_too_old_cpu_compiles_its_own_kernels(folder, monkeypatch):
    made = shipped_kernels.read_manifest(folder)
    assert "another kind" in shipped_kernels.mismatch_reason(made, OWN._replace(cpu=""), folder)
    monkeypatch.setenv("NUMBA_CPU_NAME", "skylake")
    assert "another kind" in shipped_kernels.mismatch_reason(made, OWN, folder)


@POSIX
@pytest.mark.parametrize("mode", [0o757, 0o777])
def test_a_folder_that_others_may_write_to_is_not_read(folder, mode):
    folder.chmod(mode)
    assert "written by others" in shipped_kernels.mismatch_reason(shipped_kernels.read_manifest(folder), OWN, folder)


@POSIX
def test_a_link_in_the_folder_is_not_followed(folder, tmp_path):
    (folder / "space").symlink_to(tmp_path)
    assert "written by others" in shipped_kernels.mismatch_reason(shipped_kernels.read_manifest(folder), OWN, folder)


@pytest.mark.parametrize("text", [None, "", "{", "[1]", "\x00"])
def test_an_invalid_manifest_means_no_shipped_kernels(folder, text):
    path = folder / shipped_kernels.MANIFEST
    path.unlink()
    if text is not None:
        path.write_text(text)
    assert shipped_kernels.read_manifest(folder) is None


def test_the_kind_of_this_machine_depends_on_the_sources():
    here = shipped_kernels.machine_kind(kernels.source_digest())
    assert here.sources == kernels.source_digest()
    assert here.cpu in ("x86-64-v3", "generic", "")


class Plain:
    """What numba's files of a function's entries do, with names in place of pickles."""

    def __init__(self, cache_path, filename_base, source_stamp):
        self._cache_path, self._index_name = cache_path, f"{filename_base}.nbi"

    def load(self, key):
        return self._load_data(self._load_index()[key]) if self._load_index() else None

    def _load_index(self):
        path = Path(self._cache_path) / self._index_name
        return json.loads(path.read_text()) if path.exists() else {}

    def _load_data(self, name):
        return (Path(self._cache_path) / name).read_text()


def test_shipped_entries_come_first_and_only_with_their_sums(folder, tmp_path):
    room = folder / "theory"
    room.mkdir()
    (room / "f.nbi").write_text('{"int": "f.1.nbc"}')
    (room / "f.1.nbc").write_text("shipped")
    sums = {f"theory/{path.name}": shipped_kernels.file_checksum(path) for path in room.iterdir()}
    own = tmp_path / caches.cache_subpath(caches.PACKAGE_FOLDER / "theory")
    own.mkdir()
    read = shipped_kernels.add_shipped_files(Plain, sums, folder)
    assert read(str(own), "f", b"").load("int") == "shipped"
    assert read(str(own), "g", b"").load("int") is None  # none came: what is compiled here
    (own / "g.nbi").write_text('{"int": "g.1.nbc"}')
    (own / "g.1.nbc").write_text("compiled here")
    assert read(str(own), "g", b"").load("int") == "compiled here"
    (room / "f.1.nbc").write_text("forged")
    with pytest.raises(FileNotFoundError):  # numba takes this for an entry that is gone
        read(str(own), "f", b"").load("int")
    (room / "f.nbi").write_text('{"int": "g.1.nbc"}')
    assert read(str(own), "f", b"").load("int") is None


@pytest.mark.slow
@pytest.mark.parametrize("words", hatch_build.MORE, ids=lambda words: " ".join(words[:3]))
def test_commands_run_with_the_kernels_of_a_wheel(words, tmp_path):
    # a process of its own, which checks what the cache holds: entries of types that only tests have are in it
    own = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    done = subprocess.run(
        [sys.executable, "-m", "walkergen", *words], cwd=tmp_path, env=own, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
