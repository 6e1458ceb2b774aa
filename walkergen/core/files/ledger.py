"""Hashes of the files that walkergen wrote last, which distinguish its files from a user's own.

A ledger is a file next to the files that it names. A line is added before its file is written. After a run was killed,
the files that it wrote are therefore still recognized. A seal is a file's hash at the end of the file itself.
"""

import contextlib
import errno
import hashlib
import json
import os
import re
import stat
import sys
from pathlib import Path
from typing import Any

from walkergen.core.errors import InputError

MAX_BYTES = 50_000_000
"""Largest ledger or manifest that is read: of a hundred thousand files."""

MAX_HASHED_BYTES = 4_000_000_000
"""Largest file that can be ours, bytes."""

NOT_OURS_ERRNOS = {
    errno.ENOENT,
    errno.ENOTDIR,
    errno.EISDIR,
    errno.EACCES,
    errno.ELOOP,
    errno.ENXIO,
    errno.ENAMETOOLONG,
}
"""Errors of opening a file that show that it is missing or not ours."""

BLANK_SEAL = b"0" * 64
"""Seal that is to be made."""

SEAL_PATTERN = re.compile(rb'[0-9a-f]{64}(?=(?:"\n}| -->)\n\Z)')
"""Seal at the end of JSON or HTML."""

Digests = dict[str, set[str]]
"""Hashes that files of ours had, by their names."""


class Ledger:
    """File of names and hashes, to which lines are appended; if `exclusive`, no other process may have it open.

    Raises OSError where the file cannot be made or read, InputError where another process has it.
    """

    def __init__(self, path: Path, exclusive: bool) -> None:
        self.path, self.digests, self._exclusive = path, Digests(), exclusive
        self._file = _open_locked(path) if exclusive else _open_ledger(path, create=False)
        if self._file is not None:
            self._read_lines(self._file)

    def _read_lines(self, file: int) -> None:
        """Add the hashes in a file, by its descriptor, to `digests`, without lines that a killed process cut short."""
        if os.fstat(file).st_size > MAX_BYTES:
            return  # not written by us: nothing is known of any file
        data = b""
        while piece := os.read(file, 1 << 20):
            data += piece
        for line in data.splitlines():
            try:
                name, digest = json.loads(line)
            except (ValueError, TypeError, RecursionError):
                continue
            if isinstance(name, str) and isinstance(digest, str):
                self.digests.setdefault(name, set()).add(digest)

    def append_hash(self, name: str, digest: str) -> None:
        """Append the name and hash of a file that is about to be written. Raises OSError."""
        if digest in self.digests.get(name, ()):
            return
        if self._file is None:
            self._file = _open_ledger(self.path, create=True)
            assert self._file is not None
        line = f"\n{json.dumps([name, digest])}\n".encode()  # after a line that was cut short
        if os.write(self._file, line) != len(line):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))  # a disk that is full takes a part of it
        self.digests.setdefault(name, set()).add(digest)

    def close(self, remove: bool = False) -> None:
        """Close and unlock the file. Delete it with `remove`, or if it was opened exclusively and is empty."""
        if self._file is None:
            return
        try:
            if remove or (self._exclusive and not os.fstat(self._file).st_size):
                self.path.unlink(missing_ok=True)
        finally:
            os.close(self._file)
            self._file = None


def _open_locked(path: Path) -> int:
    """Open and lock a ledger, and return its descriptor. Raises OSError, and InputError if it is locked already."""
    while True:
        file = _open_ledger(path, create=True)
        assert file is not None
        try:
            if not try_lock(file):
                raise InputError(
                    f"{str(path.parent)!r}: another walkergen writes there; wait for it, or give "
                    "another folder by ‹out›"
                )
            with contextlib.suppress(FileNotFoundError):  # its last user has just removed it
                if os.path.samestat(os.fstat(file), path.lstat()):
                    return file
        except BaseException:
            os.close(file)
            raise
        os.close(file)


def _open_ledger(path: Path, create: bool) -> int | None:
    """Open a ledger and return its descriptor. A missing file is made with `create`, else None. Raises OSError."""
    try:
        file = os.open(path, open_flags(os.O_RDWR | os.O_APPEND | (os.O_CREAT if create else 0)), 0o666)
    except FileNotFoundError:
        if create:
            raise
        return None
    if stat.S_ISREG(os.fstat(file).st_mode):
        return file
    os.close(file)
    raise OSError(errno.EINVAL, "is no plain file")


def open_flags(mode: int) -> int:
    """Return the flags of os.open for a mode such as os.O_RDONLY, so that it follows no links and never waits."""
    for name in ("O_NOFOLLOW", "O_NONBLOCK", "O_CLOEXEC", "O_BINARY"):
        mode |= getattr(os, name, 0)  # each system has some of them
    return mode


def try_lock(file: int) -> bool:
    """Lock a file, by its descriptor, until it is closed or the process ends. Return False if it is locked already."""
    try:
        if sys.platform == "win32":
            import msvcrt

            os.lseek(file, MAX_BYTES * 2, os.SEEK_SET)  # what is locked there cannot be read
            msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
            os.lseek(file, 0, os.SEEK_SET)
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if isinstance(error, (BlockingIOError, PermissionError)):
            return False
        raise
    return True


def hash_file(path: Path) -> str | None:
    """Return the SHA-256 (hexadecimal digits) of a plain file. None for links and all else that walkergen never writes.

    Raises OSError for a file that cannot be read to its end.
    """
    try:
        file = os.open(path, open_flags(os.O_RDONLY))
    except ValueError:  # a NUL in its name
        return None
    except OSError as error:
        if error.errno in NOT_OURS_ERRNOS:
            return None
        raise
    try:
        status = os.fstat(file)
        if not stat.S_ISREG(status.st_mode) or status.st_size > MAX_HASHED_BYTES:
            return None
        with open(file, "rb", closefd=False) as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    finally:
        os.close(file)


def add_seal(data: bytes) -> bytes:
    """Return a file's data with their hash, the seal, in place of BLANK_SEAL in the last value or comment."""
    match = SEAL_PATTERN.search(data)
    assert match is not None
    assert match[0] == BLANK_SEAL
    seal = hashlib.sha256(data).hexdigest().encode()
    return data[: match.start()] + seal + data[match.end() :]


def is_sealed(data: bytes) -> bool:
    """Return whether data are what `add_seal` returned, byte for byte."""
    match = SEAL_PATTERN.search(data)
    if match is None:
        return False
    blank = data[: match.start()] + BLANK_SEAL + data[match.end() :]
    return hashlib.sha256(blank).hexdigest().encode() == match[0]


def encode_manifest(facts: dict[str, Any]) -> bytes:
    """Encode facts as JSON with a seal as its last value."""
    text = json.dumps({**facts, "sealed": BLANK_SEAL.decode()}, indent=2, ensure_ascii=False, allow_nan=False)
    return add_seal(f"{text}\n".encode("utf-8", "backslashreplace"))  # what UTF-8 has not, as in JSON


def decode_manifest(data: bytes) -> dict[str, Any] | None:
    """Return the facts of a manifest that is unchanged since it was sealed, or None otherwise."""
    if not is_sealed(data):
        return None
    try:
        facts = json.loads(data)
    except (ValueError, RecursionError):
        return None
    return facts if isinstance(facts, dict) else None
