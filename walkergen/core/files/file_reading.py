"""Reading of files that people write: every failure to read a file is an InputError of one line.

Only regular files of up to a stated size are read. A pipe could wait for ever, a device never end, and a file named as
a table may be a disk image. Messages name the required format, such as "a CSV file".
"""

import codecs
import io
import json
import logging
import os
import re
import stat
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from walkergen.core.errors import InputError, WalkergenError

MAX_BYTES = 1_000_000_000
"""Largest file that is read, unless its reader allows less."""

MAX_LINE_LENGTH = 1_000_000
"""Longest line of a file that is read line by line."""

OPEN_FLAGS = (
    os.O_RDONLY
    | getattr(os, "O_NONBLOCK", 0)
    | getattr(os, "O_NOCTTY", 0)
    | getattr(os, "O_CLOEXEC", 0)
    | getattr(os, "O_BINARY", 0)
)
"""Modes of opening: without waiting for a pipe's writer, which a name may have become meanwhile."""

CONTROL_CHARACTERS = re.compile("[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")
"""Letters that steer a terminal or turn the direction of writing, and halves of letters."""

CODE_PAGE = "walkergen-code-page-1252"
"""Handler of bytes that are not UTF-8, for `read_lines`."""


def _decode_code_page(error: UnicodeError) -> tuple[str, int]:
    """Return the letters of code page 1252 for bytes that are not UTF-8, and the position after them."""
    assert isinstance(error, UnicodeDecodeError)
    return error.object[error.start : error.end].decode("cp1252", "replace"), error.end


codecs.register_error(CODE_PAGE, _decode_code_page)


def read_start(path: Path, count: int, format: str) -> bytes:
    """Read the first `count` bytes of a file. Raises InputError, which names the required `format`, on failure."""
    with _open_regular_file(path, format, None) as stream:
        return stream.read(count) or b""


def read_bytes(path: Path, most_bytes: int = MAX_BYTES, format: str = "a file") -> bytes:
    """Return all bytes of a file. Raises InputError when it cannot be read or exceeds `most_bytes`."""
    with _open_regular_file(path, format, most_bytes) as stream:
        data = stream.read(most_bytes + 1)
        if data is None:  # what the kernel shows as a file, and fills as it likes
            raise InputError(f"{path}: does not end. Give {format} that is stored on a disk")
    if len(data) > most_bytes:  # it grew, or its file system reports no sizes
        raise _size_error(path, len(data), most_bytes)
    return data


def read_json(path: Path, most_bytes: int = MAX_BYTES) -> Any:
    """Return the value in a JSON file. Raises InputError when it is unreadable, exceeds `most_bytes` or is no JSON."""
    try:
        data = json.loads(read_bytes(path, most_bytes, "a JSON file"))
        json.dumps(data, ensure_ascii=False, allow_nan=False).encode()  # NaN, halves of letters
        return data
    except (ValueError, RecursionError) as error:
        reason = "nested too deeply" if isinstance(error, RecursionError) else "it contains NaN or Infinity"
        if isinstance(error, json.JSONDecodeError):
            reason = f"line {error.lineno}, column {error.colno}: {error.msg.removesuffix(' starting at')}"
        elif isinstance(error, UnicodeError):
            reason = "it is not UTF-8"
        raise InputError(f"{path}: not valid JSON ({reason}). Correct it, or write the file again.") from None


def check_readable(path: Path, format: str) -> None:
    """Raise InputError, which names the required `format`, unless a file can be read and is not empty."""
    with _open_regular_file(path, format, None) as stream:
        if not stream.read(1):
            raise InputError(f"{path}: is empty. Give {format}")


@contextmanager
def translate_library_errors(source: str, kind: str) -> Iterator[None]:
    """Turn any error of a third-party library into an InputError, while it reads a user's file in the `with` block.

    The message begins with `source` and states that the file is no sound one of its `kind`, such as "SVG". Warnings
    and logs of the library are not shown.
    """
    disabled = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except WalkergenError:
        raise
    except Exception as error:
        raise InputError(f"{source}: is no sound {kind} file: {describe_error(error)}") from None
    finally:
        logging.disable(disabled)


def describe_error(error: Exception) -> str:
    """Describe a library's error on a file. An error that concerns only the library's own code has a general text."""
    is_internal = isinstance(error, (AttributeError, LookupError, NameError, TypeError)) or "unpack" in str(error)
    text = " ".join(str(error).split())[:100]
    return "it is incomplete, or its parts contradict each other" if is_internal or not text else text


def read_lines(
    path: Path, format: str, most_bytes: int = MAX_BYTES, newline: str | None = None, errors: str = "strict"
) -> Iterator[str]:
    r"""Yield the lines of a UTF-8 file, each with its "\n", reading the file as needed.

    Every line end is "\n", unless `newline` is "", and a byte order mark is left out. Raises
    InputError, at the first or a later line, if the file cannot be read, is not UTF-8, exceeds
    `most_bytes` or has a line longer than MAX_LINE_LENGTH. With `errors` CODE_PAGE, bytes that are not UTF-8 are
    letters of code page 1252, as older spreadsheets write them.
    """
    with (
        _open_regular_file(path, format, most_bytes) as stream,
        io.TextIOWrapper(stream, encoding="utf-8-sig", errors=errors, newline=newline) as text,
    ):
        read = 0
        while line := text.readline(MAX_LINE_LENGTH + 1):
            if not read and "\0" in line:  # UTF-16 without its mark
                raise UnicodeDecodeError("utf-8", b"\0", 0, 1, "no letter of a text")
            read += len(line)  # letters, of one byte at least each
            if len(line) > MAX_LINE_LENGTH:
                raise InputError(f"{path}: a line of more than {MAX_LINE_LENGTH} letters. Is it the right file?")
            if read > most_bytes:
                raise _size_error(path, read, most_bytes)
            yield line


def has_safe_name(path: Path) -> bool:
    """Return whether a path can be written in text files: it has no control characters and no lone surrogates."""
    return not CONTROL_CHARACTERS.search(str(path))


@contextmanager
def _open_regular_file(path: Path, format: str, most_bytes: int | None) -> Iterator[BinaryIO]:
    """Open a regular file of at most `most_bytes` (None: any size). Raises InputError for every failure to read it."""
    if not has_safe_name(path):
        raise InputError(
            f"{str(path)[-80:]!r}: its name holds control characters, or bytes that are not UTF-8: rename it"
        )
    try:
        _check_regular_file(path, path.stat(), format, most_bytes)  # opening a device may move it
        descriptor = os.open(path, OPEN_FLAGS)
        with os.fdopen(descriptor, "rb") as stream:
            _check_regular_file(path, os.fstat(descriptor), format, most_bytes)
            yield stream
    except FileNotFoundError:
        raise InputError(f"{path}: no such file. Check the path.") from None
    except UnicodeDecodeError as error:
        seen = f"byte 0x{error.object[error.start]:02x}"
        raise InputError(f"{path}: not {format} in UTF-8: {seen}. Save it as UTF-8") from None
    except (OSError, ValueError) as error:  # ValueError: a name that no file can have
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{str(path)[:80]!r}: cannot be read: {reason}") from None


def _check_regular_file(path: Path, status: os.stat_result, format: str, most_bytes: int | None) -> None:
    """Raise InputError for a folder, a device, a pipe or a socket, and for too large a file."""
    if stat.S_ISDIR(status.st_mode):
        raise InputError(f"{path}: is a folder. Give {format}")
    if not stat.S_ISREG(status.st_mode):
        raise InputError(f"{path}: is a pipe or a device. Give {format} that lies on a disk")
    if most_bytes is not None and status.st_size > most_bytes:
        raise _size_error(path, status.st_size, most_bytes)


def _size_error(path: Path, size: int, most_bytes: int) -> InputError:
    return InputError(f"{path}: {size} bytes, more than {most_bytes}: is it the right file?")
