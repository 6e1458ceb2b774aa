"""Writing files so that none is ever half-written, and folders that record what they hold.

A file whose name walkergen chooses is written only if there is none, or an unchanged one that walkergen wrote. Any
other file is left alone, and an error names it after all else is done. A file that a user names is replaced.
"""

import contextlib
import hashlib
import os
import platform
import re
import secrets
import stat
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Self

from walkergen import __version__
from walkergen.core.errors import OutputError
from walkergen.core.files import ledger
from walkergen.core.files.ledger import Ledger, hash_file, open_flags, try_lock

MANIFEST = "manifest.json"
LEDGER = ".walkergen"
"""Hidden file with the hashes of what was written into a folder that has no manifest."""

LIBRARIES = ("numpy", "manifold3d", "lib3mf", "matplotlib", "pydantic")

TEMPORARY_NAME = re.compile(r"\..*\.walkergen-[0-9a-f]{16}", re.DOTALL)
NOT_OURS_MESSAGE = "not as walkergen wrote it: left alone. Move it away, or give another ‹out›"
MAX_SEALED_BYTES = 500_000_000
"""Largest file that can be sealed, bytes."""

MAX_NAMED_FILES = 5
"""Most files that are named as left alone; the others are counted."""


def describe_wrong_ending(path: Path, endings: Iterable[str], note: str = "") -> str:
    """Return a message on a file name that has none of these endings, or has nothing before it. `note` ends it."""
    if path.name.lower() in endings:
        return f"the name before the ending is missing. Write for example run{path.name}"
    return f"must end in one of {', '.join(endings)}{note}"


def write(path: Path, data: bytes, lasting: bool = True) -> None:
    """Write a file completely or not at all: a temporary name in the same folder, then a rename.

    A `lasting` file is on the disk on return and survives a power cut. Other files reach the disk later, which saves a
    wait of milliseconds each.

    The temporary file is new and has an unpredictable name, so that no prepared link can redirect it. Parent folders
    are made. Raises OutputError. On any exception the temporary file is removed.
    """
    try:
        # Of long names the beginning: the whole must not exceed what a folder holds
        temporary = path.with_name(f".{path.name[:40]}.walkergen-{secrets.token_hex(8)}")
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            _create(temporary, data, lasting)
            temporary.replace(path)
        except BaseException:
            with contextlib.suppress(OSError):
                temporary.unlink()
            raise
    except (OSError, ValueError) as error:  # ValueError: a path that holds NUL or has no name
        raise write_error(path, error) from None


def _create(path: Path, data: bytes, lasting: bool) -> None:
    """Write all data to a new file, which is locked meanwhile. Raises OSError if anything of this name exists.

    With `lasting`, wait until the data are on the disk: a full disk may be noticed only then, or on closing.
    """
    file = os.open(path, open_flags(os.O_WRONLY | os.O_CREAT | os.O_EXCL), 0o666)
    try:
        try_lock(file)
        rest = memoryview(data)
        while rest:
            rest = rest[os.write(file, rest) :]
        if lasting:
            os.fsync(file)
    finally:
        os.close(file)


def _remove_leftovers(folder: Path) -> None:
    """Remove temporary files that killed processes left in a folder. Running processes have theirs locked."""
    try:
        names = [entry.name for entry in os.scandir(folder) if TEMPORARY_NAME.fullmatch(entry.name)]
    except OSError:
        return  # there is no such folder yet
    for name in names:
        with contextlib.suppress(OSError):  # another process has removed it, or only its owner may
            file = os.open(folder / name, open_flags(os.O_WRONLY))
            try:
                if try_lock(file):
                    (folder / name).unlink()
            finally:
                os.close(file)


def rewrite_sealed(path: Path, data: bytes) -> None:
    """Write data that end in a seal (`ledger.add_seal`). Raises OutputError for a file that a user wrote or changed."""
    check_overwritable(path)
    write(path, data)


def check_overwritable(path: Path) -> None:
    """Raise OutputError if there is a file that is neither empty nor unchanged since walkergen sealed it."""
    try:
        status = path.lstat()
    except (OSError, ValueError):  # the write reports the failure
        return
    if _is_empty(status):
        return
    with contextlib.suppress(OSError), os.fdopen(os.open(path, open_flags(os.O_RDONLY)), "rb") as stream:
        plain = stat.S_ISREG(os.fstat(stream.fileno()).st_mode)
        if plain and ledger.is_sealed(stream.read(MAX_SEALED_BYTES)):
            return
    raise OutputError(f"{str(path)!r}: {NOT_OURS_MESSAGE}")


def _is_empty(status: os.stat_result) -> bool:
    """Return whether a file is regular and empty, so that nothing could be lost."""
    return stat.S_ISREG(status.st_mode) and status.st_size == 0


def write_error(path: Path, error: Exception) -> OutputError:
    """Return a readable error for a file or folder that the system does not allow to be written."""
    reason = getattr(error, "strerror", None) or str(error)
    return OutputError(f"{str(path)!r}: cannot be written: {reason}. Try another ‹out›")


GROWING_HASH = "growing"
"""Replaces the hash in a ledger for a file that is written row by row."""


class Folder:
    """An output folder that records which of its files walkergen wrote; a context for writing to it.

    A folder with several makers has one manifest each, under its own name. The manifest is written
    at the end; until then no other process may write there. Without a manifest ("") any number of
    processes may add files. Every call raises OutputError for failed writes and for a manifest
    changed since walkergen wrote it, and InputError while another process writes.
    """

    def __init__(self, path: Path, manifest: str = MANIFEST) -> None:
        self.path = path
        self.manifest = manifest
        self.hashes: dict[str, str] = {}
        self.left: list[str] = []
        """Files that walkergen did not write and left unchanged."""
        self._ledger: Ledger | None = None
        self._listed: dict[str, str] = {}  # hashes in the manifest of an earlier run, by file name
        self._tidied: set[Path] = set()  # folders without temporary files of killed processes

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if self._ledger is not None:
            with contextlib.suppress(OSError):  # a ledger may stay: it is of use to the next run
                self._ledger.close()
        if kind is None:
            self._report_left_files()

    def claim(self) -> None:
        """Make the folder, lock it against other processes and read its manifest, as every write does first."""
        if self._ledger is not None:
            return
        hidden = f".{self.manifest}.walkergen" if self.manifest else LEDGER
        path = self.path
        try:
            path.mkdir(parents=True, exist_ok=True)
            path = self.path / hidden
            opened = Ledger(path, exclusive=bool(self.manifest))
        except (OSError, ValueError) as error:
            raise write_error(path, error) from None
        try:
            self._listed = _listed_hashes(self.earlier_manifest())
        except BaseException:
            opened.close()
            raise
        self._ledger = opened

    def write(self, name: str, data: bytes) -> bool:
        """Write a file by its name relative to the folder, and return True. Keep a user's file, and return False."""
        self.claim()
        assert self._ledger is not None
        path, digest = self.path / name, hashlib.sha256(data).hexdigest()
        if path.parent not in self._tidied:
            _remove_leftovers(path.parent)
            self._tidied.add(path.parent)
        if not self._can_overwrite(name, digest):
            if name not in self.left:
                self.left.append(name)
            return False
        try:
            self._ledger.append_hash(name, digest)
        except OSError as error:
            raise write_error(path, error) from None
        write(path, data, lasting=False)  # of many: the manifest, which is last, lists those that are
        self.hashes[name] = digest
        return True

    def start_growing_file(self, name: str) -> None:
        """Record that other code is about to write a file in this folder bit by bit, such as row by row."""
        self.claim()
        assert self._ledger is not None
        try:
            self._ledger.append_hash(name, GROWING_HASH)
        except OSError as error:
            raise write_error(self.path / name, error) from None

    def add_grown_file(self, name: str) -> None:
        """Record the hash of a file in this folder that other code has finished writing."""
        digest = self._hash(name)
        if digest is None:
            raise OutputError(f"{str(self.path / name)!r}: was removed while it was written")
        self.hashes[name] = digest

    def finish(self, facts: dict[str, Any]) -> None:
        """Write the manifest, after removing files of an earlier run that this run did not make.

        Removes only unchanged files that the earlier manifest lists or that a killed run wrote.
        Raises OutputError, when all is done, for files left alone.
        """
        self.claim()
        assert self._ledger is not None
        for name in sorted({*self._ledger.digests, *self._listed} - {*self.hashes}):
            if self._is_ours(name):
                try:
                    (self.path / name).unlink()
                except OSError as error:
                    raise write_error(self.path / name, error) from None
        files = dict(sorted(self.hashes.items()))
        write(self.path / self.manifest, ledger.encode_manifest({**facts, "files": files}))
        try:
            self._ledger.close(remove=True)
        except OSError as error:
            raise write_error(self._ledger.path, error) from None
        self._ledger = None
        self._report_left_files()

    def earlier_manifest(self) -> dict[str, Any]:
        """Read the manifest of an earlier run, empty if there is none.

        Raises OutputError for one that is not as we wrote it: nothing in its folder is touched.
        """
        if not self.manifest:
            return {}
        path = self.path / self.manifest
        try:
            with os.fdopen(os.open(path, open_flags(os.O_RDONLY)), "rb") as stream:
                data = stream.read(ledger.MAX_BYTES)
        except FileNotFoundError:
            return {}
        except (OSError, ValueError) as error:
            raise _manifest_error(path, getattr(error, "strerror", None) or str(error)) from None
        facts = ledger.decode_manifest(data)
        if facts is None:
            raise _manifest_error(path, "is not as walkergen wrote it")
        for name in _listed_hashes(facts):
            if not _is_inside(self.path, name):
                raise _manifest_error(path, "names files outside its folder")
        return facts

    def is_unchanged(self) -> bool:
        """Return whether all files in the manifest of an earlier run are unchanged; False without such files."""
        listed = _listed_hashes(self.earlier_manifest())
        return bool(listed) and all(self._hash(name) == digest for name, digest in listed.items())

    def is_file_unchanged(self, name: str) -> bool:
        """Return whether a file is unchanged since an earlier run, or was growing when that run was ended."""
        self.claim()
        assert self._ledger is not None
        growing = GROWING_HASH in self._ledger.digests.get(name, ())
        return growing or self._listed.get(name) == self._hash(name)

    def _is_ours(self, name: str) -> bool:
        """Return whether walkergen wrote a file in the folder and it is unchanged since."""
        assert self._ledger is not None
        digests = {*self._ledger.digests.get(name, ()), self._listed.get(name)} - {None}
        return bool(digests) and _is_inside(self.path, name) and self._hash(name) in digests

    def _can_overwrite(self, name: str, digest: str) -> bool:
        """Return whether the file `name` is missing, empty, ours, or of this hash, so that nothing is lost."""
        path = self.path / name
        try:
            status = path.lstat()
        except (OSError, ValueError):  # the write reports the failure
            return True
        return _is_empty(status) or self._hash(name) == digest or self._is_ours(name)

    def _hash(self, name: str) -> str | None:
        """Return the SHA-256 of a plain file in the folder, in hexadecimal digits, or None for anything else."""
        try:
            return hash_file(self.path / name)
        except OSError as error:
            raise write_error(self.path / name, error) from None

    def _report_left_files(self) -> None:
        """Raise OutputError for the files that were left alone, a line each."""
        if not self.left:
            return
        lines = [f"{str(self.path / name)!r}: {NOT_OURS_MESSAGE}" for name in self.left[:MAX_NAMED_FILES]]
        more = len(self.left) - MAX_NAMED_FILES
        self.left = []
        raise OutputError("\n".join(lines + ([f"and {more} more files"] if more > 0 else [])))


def _listed_hashes(facts: dict[str, Any]) -> dict[str, str]:
    """Return the hashes of the files that a manifest lists, by their names."""
    files = facts.get("files")
    return files if isinstance(files, dict) else {}


def _manifest_error(path: Path, reason: str) -> OutputError:
    return OutputError(f"{str(path)!r}: {reason}: all files there are left alone. Move it away, or give another ‹out›")


def _is_inside(folder: Path, name: str) -> bool:
    """Return whether a name leads to a path inside the folder after all its links."""
    try:
        return folder.resolve() in (folder / name).resolve().parents
    except (OSError, ValueError, RuntimeError):  # a loop of links, a NUL
        return False


def versions() -> dict[str, str]:
    """Return the versions of walkergen, Python and the libraries that affect the files."""
    by_library = {"walkergen": __version__, "python": platform.python_version()}
    for library in LIBRARIES:
        try:
            by_library[library] = version(library)
        except PackageNotFoundError:  # vendored without metadata, as in some distributions
            by_library[library] = "unknown"
    return by_library


def result_folder(path: Path, out: Path | None, what: str) -> Path:
    """Return the folder for a command's results on the file `path`: OUT/WHAT, or without `out` out/STEM/WHAT.

    STEM is that of the file. Each command has its own `what`, so that results of other commands stay.
    """
    return (out or Path("out") / safe_folder_name(path)) / what


def safe_folder_name(path: Path) -> str:
    """Return a folder name for the results of a file: the stem of the file's name, in safe letters."""
    return re.sub(r"[^A-Za-z0-9_-]+", "-", path.stem).strip("-")[:64] or "results"
