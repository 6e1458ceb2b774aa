"""Folders of pictures as films: each picture is a frame, in the order of the numbers in their names."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from walkergen.core.errors import InputError

SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp")


def list_pictures(folder: Path) -> tuple[Path, ...]:
    """Return the pictures of a folder in the order of their numbers, 2 before 10.

    Raises InputError where there are none, or they differ in kind or size.
    """
    from PIL import Image

    try:
        pictures = [path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES and path.is_file()]
    except OSError as error:
        raise InputError(f"{folder}: cannot be read: {error.strerror}") from None
    if not pictures:
        raise InputError(f"{folder}: a folder without pictures: give a film, or a folder of {', '.join(SUFFIXES)}")
    _check_same(folder, "kinds of pictures", Counter(path.suffix.lower() for path in pictures))
    sizes: Counter[str] = Counter()
    for path in pictures:
        try:
            with Image.open(path) as picture:
                sizes["{} x {} pixels".format(*picture.size)] += 1
        except (OSError, Image.DecompressionBombError) as error:  # Pillow's "cannot identify" is an OSError
            raise InputError(f"{path}: cannot be read as a picture: {error}") from None
    _check_same(folder, "sizes", sizes)
    return tuple(sorted(pictures, key=_number_key))


def _check_same(folder: Path, quality: str, counts: Counter[str]) -> None:
    """Raise InputError if pictures differ in a `quality`, such as "sizes". `counts`: number of pictures by value."""
    if len(counts) > 1:
        seen = ", ".join(f"{number} of {name}" for name, number in counts.most_common(3))
        raise InputError(f"{folder}: {quality} differ: {seen}. Leave only the frames of one film there")


def _number_key(path: Path) -> tuple[list[tuple[bool, int, str]], str]:
    """Return a key that sorts files by their names, with digits compared as numbers."""
    parts = re.split(r"([0-9]+)", path.stem)
    return [(part.isdecimal(), int(part) if part.isdecimal() else 0, part) for part in parts], path.name


@contextmanager
def write_list(pictures: Sequence[Path]) -> Iterator[Path]:
    """Write a temporary list of pictures for ffmpeg. Yield its path. Raises InputError for a line break in a name."""
    names = [str(path.resolve()) for path in pictures]
    if broken := next((name for name in names if "\n" in name), None):
        raise InputError(f"{broken!r}: a line break in its name: rename it")
    with TemporaryDirectory() as folder:
        path = Path(folder) / "pictures.txt"
        path.write_text("".join("file '{}'\n".format(name.replace("'", r"'\''")) for name in names), "utf-8")
        yield path
