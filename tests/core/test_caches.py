"""Folders in the cache: the user's alone, of the version in use, never in the way."""

import os
import stat
import subprocess
import sys
import time
from pathlib import Path

import pytest

from walkergen.core import caches

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="owners and modes of POSIX")


@pytest.fixture
def home(monkeypatch, tmp_path):
    monkeypatch.setattr(caches, "home", lambda: tmp_path / "cache" / "walkergen")
    return tmp_path / "cache" / "walkergen"


@POSIX
def test_folders_are_for_the_user_alone(home):
    found = caches.folder("points")
    assert found == home / "points"
    for one in (home, found):
        assert stat.S_IMODE(one.stat().st_mode) == 0o700


@POSIX
@pytest.mark.parametrize("at", [".", "points"])
@pytest.mark.parametrize("mode", [0o770, 0o707, 0o777])
def test_a_folder_that_others_may_write_to_is_not_used(home, at, mode):
    (home / "points").mkdir(parents=True)
    (home / at).chmod(mode)
    found = caches.folder("points")
    assert home not in found.parents
    assert stat.S_IMODE(found.stat().st_mode) == 0o700


@POSIX
def test_a_folder_of_another_user_is_not_used(home, monkeypatch):
    caches.folder("points")
    monkeypatch.setattr(os, "getuid", lambda: 12345)
    assert home not in caches.folder("points").parents


def test_a_home_that_cannot_be_written_is_no_obstacle(home):
    home.parent.write_text("no folder")
    assert caches.folder("points").is_dir()


def test_caches_of_old_versions_are_removed_unless_in_use(home):
    old, young, other = (caches.folder(name) for name in ("numba-a", "numba-b", "points"))
    then = time.time() - (caches.MAX_UNUSED_DAYS + 1) * 86400
    for path in (old, other):
        (path / "index").write_text("1")
        os.utime(path, (then, then))
    found = caches.prepare_version_folder("numba", "c")
    assert [path.name for path in sorted(home.iterdir())] == ["numba-b", "numba-c", "points"]
    os.utime(found, (then, then))
    assert caches.prepare_version_folder("numba", "c").stat().st_mtime > then  # used again
    assert young.is_dir()


def test_the_cache_is_in_the_platform_folder_and_its_size_is_reported(tmp_path):
    asked = [sys.executable, "-m", "walkergen", "--version", "--verbose"]
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path), "LOCALAPPDATA": str(tmp_path)}
    caches.folder("here")
    told = subprocess.run(asked, env=environment, capture_output=True, text=True, check=True)
    lines = told.stdout.splitlines()
    assert [line.split()[0] for line in lines] == ["walkergen", "Python", "numba", "cache"]
    if sys.platform == "linux":
        assert lines[3].startswith(f"cache {tmp_path / 'walkergen'}, 0.0 MB")
        (tmp_path / "walkergen" / "points").mkdir(parents=True)
        Path(tmp_path, "walkergen", "points", "one").write_bytes(bytes(2_000_000))
        told = subprocess.run(asked, env=environment, capture_output=True, text=True, check=True)
        assert "2.0 MB" in told.stdout


def test_a_cache_home_that_is_no_full_path_is_not_used(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", "beside")
    caches.folder("points")
    assert not list(tmp_path.iterdir())


@pytest.fixture
def kernels(tmp_path):
    """Cache files of a kernel, as numba makes them, and what an entry of it is found by."""
    from numba.core import caching

    def open_index(stamp=(1.0, 2)):
        plain = caching.IndexDataCacheFile
        if plain.__name__ == "Checked":  # as in a process that has made kernels
            plain = plain.__mro__[1]
        return caches.add_checksums(plain)(str(tmp_path), "f-1.py311", stamp)

    open_index().save("int", {"code": b"\x01" * 1000})
    return open_index


DAMAGES = {
    "emptied": lambda path: path.write_bytes(b""),
    "cut short": lambda path: path.write_bytes(path.read_bytes()[: -caches.TRAILER_BYTES - 1]),
    "half": lambda path: path.write_bytes(path.read_bytes()[: path.stat().st_size // 2]),
    "a bit": lambda path: path.write_bytes(bytes(byte ^ (at == 40) for at, byte in enumerate(path.read_bytes()))),
    "text": lambda path: path.write_text("no pickle"),
    "of others": lambda path: path.write_bytes(b"\x80\x04cnosuchmodule\nx\n."),
    "a folder": lambda path: (path.unlink(), path.mkdir(), (path / "x").touch()),
    "gone": Path.unlink,
    "a pipe": lambda path: (path.unlink(), os.mkfifo(path)),
    "a loop": lambda path: (path.unlink(), path.symlink_to(path)),
}


@POSIX
@pytest.mark.parametrize("end", ["nbi", "nbc"])
@pytest.mark.parametrize("spoil", DAMAGES.values(), ids=DAMAGES)
def test_a_damaged_cache_entry_is_compiled_again(kernels, tmp_path, end, spoil):
    (path,) = tmp_path.glob(f"*.{end}")
    spoil(path)
    assert kernels().load("int") is None
    kernels().save("int", "anew")
    assert kernels().load("int") == "anew"


def test_a_valid_cache_entry_is_read_with_or_without_a_checksum(kernels, tmp_path):
    assert kernels().load("int") == {"code": b"\x01" * 1000}
    assert kernels().load("float") is None
    assert kernels((3.0, 2)).load("int") is None  # of another source
    for path in tmp_path.iterdir():
        path.write_bytes(path.read_bytes()[: -caches.TRAILER_BYTES])
    assert kernels().load("int") == {"code": b"\x01" * 1000}


@POSIX
def test_compilation_is_announced_once_with_its_time_unless_quiet(tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(caches.COMPILE_TIMES_S, "another", 17)
    place = tmp_path / caches.cache_subpath(caches.PACKAGE_FOLDER / "another")
    with caches.suppress_compile_notice():
        caches.announce_compilation(place)
    caches.announce_compilation(tmp_path / "elsewhere_0123")  # no model: a second or two
    assert capsys.readouterr().err == ""
    for _ in range(2):
        caches.announce_compilation(place)
    (line,) = capsys.readouterr().err.splitlines()
    assert "about 17 s" in line
    assert "once" in line


def test_a_kernel_that_cannot_be_cached_still_runs(kernels, tmp_path, monkeypatch):
    monkeypatch.setattr(os, "replace", lambda *_: (_ for _ in ()).throw(OSError(28, "full")))
    kernels().save("float", "code")
    assert kernels().load("float") is None
