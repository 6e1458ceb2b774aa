"""Reading of files that people write: whatever keeps a file from being read is one InputError line.

The format that is asked for, such as "a CSV file", stands in what a person is told to give instead.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from walkergen.errors import InputError


def content(path: Path, most_bytes: int | None = None) -> bytes:
    """Bytes of a file, whatever its format.

    Raises InputError when it cannot be read or exceeds `most_bytes`.
    """
    with _explained(path, "a file", most_bytes):
        return path.read_bytes()


def check(path: Path, format: str) -> None:
    """Raise InputError unless a file can be read and is not empty; for formats that others read."""
    with _explained(path, format), path.open("rb") as stream:
        if not stream.read(1):
            raise InputError(f"{path}: is empty; give {format}")


def lines(path: Path, format: str, most_bytes: int | None = None) -> Iterator[str]:
    r"""Lines of a UTF-8 file, each with its "\n", read as they are asked for.

    Every line end is "\n" and a byte order mark is left out. Raises InputError, when the first line
    is asked for or a later one, if the file cannot be read, is not UTF-8 or exceeds `most_bytes`.
    """
    with _explained(path, format, most_bytes), path.open(encoding="utf-8-sig") as stream:
        yield from stream


@contextmanager
def _explained(path: Path, format: str, most_bytes: int | None = None) -> Iterator[None]:
    """Guard of the reading of a file; raises InputError, in words, for whatever stops it."""
    try:
        if path.is_dir():
            raise InputError(f"{path}: is a folder; give {format}")
        if most_bytes is not None and (size := path.stat().st_size) > most_bytes:
            raise InputError(f"{path}: {size} bytes, more than {most_bytes}: is it the right file?")
        yield
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except UnicodeDecodeError as error:
        seen = f"byte 0x{error.object[error.start]:02x}"
        raise InputError(f"{path}: not {format} in UTF-8: {seen}; save it as UTF-8") from None
    except (OSError, ValueError) as error:  # ValueError: a name that no file can have
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{str(path)[:80]!r}: cannot be read: {reason}") from None
