"""Folders in the user's cache, for files that can be made again at any time.

Kernels lie there as code that is run when it is read: a folder that anybody else can write to, or
owns, is not used.
"""

import atexit
import os
import shutil
import stat
import tempfile
import time
from pathlib import Path

FORGOTTEN_DAYS = 30
"""Days after which what an edited walkergen, or an older one, has left is removed."""


def home() -> Path:
    """Folder of walkergen in the platform's cache. Raises OSError for a user without a home."""
    from platformdirs import user_cache_path

    found = user_cache_path("walkergen", appauthor=False)
    if not found.is_absolute():
        raise OSError(f"no cache folder: {found} is not absolute")
    return found


def folder(name: str) -> Path:
    """Writable folder of this name in the user's cache, for the user alone.

    Without a home, or with one that cannot be written or is another's: a folder that is new, and
    goes when the process ends.
    """
    try:
        found = home() / name
        found.parent.parent.mkdir(parents=True, exist_ok=True)
        for one in (found.parent, found):
            one.mkdir(mode=0o700, exist_ok=True)
            _check(one)
        with tempfile.TemporaryFile(dir=found):
            return found
    except OSError:
        found = Path(tempfile.mkdtemp(prefix=f"walkergen-{name}-"))
        atexit.register(shutil.rmtree, found, ignore_errors=True)
        return found


def _check(path: Path) -> None:
    """Raise OSError for a folder that is another's, or that others may write to."""
    if not hasattr(os, "getuid"):
        return  # Windows: a profile's folders are its user's
    found = path.stat()
    if found.st_uid != os.getuid() or found.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        raise OSError(f"{path} is not the user's alone")


def versioned(name: str, version: str) -> Path:
    """Writable folder for one version of what is kept; those long unused are removed."""
    found = folder(f"{name}-{version}")
    try:
        os.utime(found)  # in use
        oldest = time.time() - FORGOTTEN_DAYS * 86400
        for other in found.parent.glob(f"{name}-*"):
            if other.stat().st_mtime < oldest:
                shutil.rmtree(other, ignore_errors=True)
    except OSError:
        pass  # another process has removed it, or the clock cannot be set: nothing depends on it
    return found


def size() -> int:
    """Size of all that walkergen keeps in the user's cache, bytes."""
    found = 0
    for path in home().rglob("*"):
        try:
            found += path.lstat().st_size
        except OSError:  # removed meanwhile
            continue
    return found
