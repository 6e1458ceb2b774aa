"""Folders in the user's cache, for files that can be made again at any time.

Compiled kernels (functions that numba has compiled) are kept there. Loading one runs its code, so a folder that
another user owns or can write to is not used.
"""

import atexit
import contextlib
import hashlib
import io
import os
import shutil
import stat
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

MAX_UNUSED_DAYS = 30
"""Days without use after which the folder of another version is removed."""

KERNEL_FOLDER = "numba"
"""Name of the folders of compiled kernels."""

CHECKSUM_MARK = b"walkergen sha256"
CHECKSUM_BYTES = hashlib.sha256().digest_size
TRAILER_BYTES = len(CHECKSUM_MARK) + CHECKSUM_BYTES
"""Length of the end of a cached kernel's file: a mark, and the checksum of all before it. Unpickling ignores both."""


def home() -> Path:
    """Return the path of walkergen's folder in the user's cache, which may not exist. Raises OSError without a home."""
    from platformdirs import user_cache_path

    found = user_cache_path("walkergen", appauthor=False)
    if not found.is_absolute():
        raise OSError(f"no cache folder: {found} is not absolute")
    return found


def folder(name: str) -> Path:
    """Create the folder `name` in walkergen's cache, if it does not exist, and return its path.

    The folder is writable and private to the user. If none can be, for example without a home, the path is that of a
    temporary folder, which is removed when the process ends.
    """
    try:
        found = home() / name
        found.parent.parent.mkdir(parents=True, exist_ok=True)
        for path in (found.parent, found):
            path.mkdir(mode=0o700, exist_ok=True)
            _check_private(path)
        with tempfile.TemporaryFile(dir=found):
            return found
    except OSError:
        found = Path(tempfile.mkdtemp(prefix=f"walkergen-{name}-"))
        atexit.register(shutil.rmtree, found, ignore_errors=True)
        return found


def _check_private(path: Path) -> None:
    """Raise OSError for a folder that belongs to another user, or that others may write to."""
    if not hasattr(os, "getuid"):
        return  # Windows: a profile's folders are its user's
    found = path.stat()
    if found.st_uid != os.getuid() or found.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        raise OSError(f"{path} is not the user's alone")


PACKAGE_FOLDER = Path(__file__).parents[1]
COMPILE_TIMES_S = {"core/simulation/space": 50, "guests/crowd/space": 100, "readers/drawings": 6}
"""Time that the kernels of a folder of the package take to compile on an idle core, s. Others take a second or two."""

_announced: set[str] = set()


@contextlib.contextmanager
def suppress_compile_notice() -> Iterator[None]:
    """Print no notice about the compilation of kernels while a block runs."""
    before = set(_announced)
    _announced.update(COMPILE_TIMES_S)
    try:
        yield
    finally:
        _announced.intersection_update(before)


def cache_subpath(source_folder: Path) -> str:
    """Return the name, not the path, of the folder in which numba caches the functions of a source folder."""
    from numba.core.caching import _CacheLocator

    return str(_CacheLocator.get_suitable_cache_subpath(str(source_folder / "x.py")))


def announce_compilation(numba_folder: Path) -> None:
    """Print a notice that kernels are being compiled, once for each folder of sources in COMPILE_TIMES_S.

    `numba_folder` is numba's cache, named after the folder of sources. Child processes of a pool print nothing.
    """
    from multiprocessing import parent_process

    name = next((name for name in COMPILE_TIMES_S if cache_subpath(PACKAGE_FOLDER / name) == numba_folder.name), "")
    if not name or name in _announced or parent_process():
        return
    _announced.add(name)
    print(
        f"compiling kernels ({name}): about {COMPILE_TIMES_S[name]} s of CPU time, once for this version",
        file=sys.stderr,
        flush=True,
    )


def add_checksums(base: Any) -> Any:
    """Return a subclass of `base`, numba's class of cache files, whose files end in a checksum of their content.

    An entry (the code of one signature) that is unreadable, or does not match its checksum, counts as absent. It is
    compiled again and replaced. Entries of older versions have no checksum. A failed write of an entry is ignored.
    """

    class Checked(base):  # type: ignore[misc]
        """Cached entries of one compiled function."""

        def load(self, key: Any) -> Any:
            """Load an entry. Announce its compilation if there is none."""
            entry = super().load(key)
            if entry is None:
                announce_compilation(Path(self._cache_path))
            return entry

        def save(self, key: Any, data: Any) -> None:
            """Save an entry, if its file can be written."""
            with contextlib.suppress(OSError):
                super().save(key, data)

        def _load_index(self) -> Any:
            """Load the index of the entries; empty if its file is damaged."""
            try:
                return super()._load_index() if _is_intact(Path(self._index_path)) else {}
            except Exception:  # a damaged pickle may raise any error
                return {}

        def _load_data(self, name: str) -> Any:
            """Load the code of an entry. Raises FileNotFoundError if its file is damaged."""
            if _is_intact(Path(self._data_path(name))):
                try:
                    return super()._load_data(name)
                except Exception:
                    pass
            raise FileNotFoundError(name)

        @contextlib.contextmanager
        def _open_for_write(self, filepath: str) -> Iterator[io.BytesIO]:
            """Collect what is written in the block, then save it with its checksum."""
            buffer = io.BytesIO()
            yield buffer
            if Path(filepath).is_dir():
                shutil.rmtree(filepath)
            with super()._open_for_write(filepath) as stream:
                data = buffer.getvalue()
                stream.write(data + CHECKSUM_MARK + hashlib.sha256(data).digest())

    return Checked


def _is_intact(path: Path) -> bool:
    """Return whether a path is a regular file that matches the checksum at its end, or that has no checksum."""
    try:
        if not stat.S_ISREG(path.stat().st_mode):
            return False
        data = path.read_bytes()
    except OSError:
        return False
    content, mark, digest = data[:-TRAILER_BYTES], data[-TRAILER_BYTES:-CHECKSUM_BYTES], data[-CHECKSUM_BYTES:]
    return mark != CHECKSUM_MARK or hashlib.sha256(content).digest() == digest


def _configure_numba_cache(cache_folder: Path) -> None:
    """Import numba with its cache in a folder, from which it then reads intact entries only."""
    os.environ["NUMBA_CACHE_DIR"] = str(cache_folder)
    from numba.core import caching

    caching.IndexDataCacheFile = add_checksums(caching.IndexDataCacheFile)


def prepare_version_folder(name: str, version: str) -> Path:
    """Return the path of the folder NAME-VERSION in walkergen's cache, created if needed. Remove versions long unused.

    A folder of KERNEL_FOLDER becomes the cache of numba, which is imported, unless numba was imported before.
    """
    found = folder(f"{name}-{version}")
    try:
        os.utime(found)  # in use
        oldest = time.time() - MAX_UNUSED_DAYS * 86400
        for other in found.parent.glob(f"{name}-*"):
            if other.stat().st_mtime < oldest:
                shutil.rmtree(other, ignore_errors=True)
    except OSError:
        pass  # another process has removed it, or the clock cannot be set: nothing depends on it
    if name == KERNEL_FOLDER and "numba" not in sys.modules:  # the folder becomes numba's cache
        _configure_numba_cache(found)
    return found


def size() -> int:
    """Return the size of walkergen's files in the user's cache, bytes."""
    found = 0
    for path in home().rglob("*"):
        try:
            found += path.lstat().st_size
        except OSError:  # removed meanwhile
            continue
    return found
