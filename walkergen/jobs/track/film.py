"""Films: grey frames of a file, one by one, by the ffmpeg that the extra `film` installs.

A film of varying frame rate, as phones and GIFs have it, comes at its mean rate: frames are
repeated or left out, so that times are right within a frame.
"""

import importlib.util
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.errors import InputError
from walkergen.files import reading

Grey = npt.NDArray[np.uint8]
"""Brightness of a frame, shape (height, width), 0 black to 255 white; row 0 is the upper one."""

NEEDED = {"imageio_ffmpeg": "imageio-ffmpeg", "trackpy": "trackpy"}
"""Packages of the extra `film`, by the names of their modules."""

MOST_PIXELS = 36_000_000
"""Largest frame: 8K."""

MOST_FRAMES = 1_000_000

LOCAL = ["-protocol_whitelist", "file"]
"""Words for ffmpeg: whatever a file says, nothing is fetched from elsewhere."""


class Film(NamedTuple):
    """What a film says of itself."""

    path: Path
    width: int
    """Width of a frame, pixels."""
    height: int
    fps: float | None
    """Frames per second at which it plays; None when it does not say."""
    expected: int
    """Number of frames by its duration; 0 when it does not say. The real one may differ."""


def require() -> None:
    """Raise InputError when the packages of the extra `film` are not installed."""
    missing = [name for module, name in NEEDED.items() if importlib.util.find_spec(module) is None]
    if missing:
        raise InputError(
            f"track: {' and '.join(missing)} not installed: pip install 'walkergen[film]'"
        )


def about(path: Path) -> Film:
    """What a film says of itself. Raises InputError for a file that is no film, or too large."""
    reading.check(path, "a film")
    with closing(_read(path)) as stream:
        found = _next(stream, path, 0)
    width, height = found["size"]
    if not 0 < width * height <= MOST_PIXELS:
        raise InputError(
            f"{path}: {width} x {height} pixels a frame: at most {MOST_PIXELS / 1e6:g} million; "
            "make it smaller: ffmpeg -i FILM -vf scale=1920:-2 SMALL.mp4"
        )
    fps = float(found.get("fps") or 0.0)
    seconds = float(found.get("duration") or 0.0)
    return Film(path, width, height, fps or None, min(round(seconds * fps), MOST_FRAMES))


def frames(film: Film, first: int, last: int | None) -> Iterator[tuple[int, Grey]]:
    """Frames of numbers first..last - 1, counted from 0, or up to the end, with their numbers.

    Raises InputError where the film breaks off within a frame, or has too many.
    """
    with closing(_read(film.path, film.fps)) as stream:
        _next(stream, film.path, 0)
        number = 0
        while last is None or number < last:
            data = _next(stream, film.path, number)
            if data is None:
                return
            if number >= MOST_FRAMES:
                raise InputError(f"{film.path}: more than {MOST_FRAMES} frames: cut the film")
            if number >= first:
                grey = np.frombuffer(data, np.uint8).reshape(film.height, film.width)
                yield number, grey
            number += 1


def _read(path: Path, fps: float | None = None) -> Any:
    """Stream of what the film says of itself, then of its frames' bytes, `fps` a second."""
    import imageio_ffmpeg

    # The whole path: a name that begins with a dash, or with "http:", is a file's all the same.
    return imageio_ffmpeg.read_frames(
        str(path.resolve()), pix_fmt="gray", bits_per_pixel=8, input_params=LOCAL,
        output_params=["-r", f"{fps:.6g}"] if fps else [],
    )  # fmt: skip


def _next(stream: Any, path: Path, number: int) -> Any:
    """Next of a stream; None at its end. Raises InputError in one line for ffmpeg's many."""
    try:
        return next(stream, None)
    except (OSError, RuntimeError, ValueError, IndexError) as error:
        told = [line.strip() for line in str(error).splitlines() if line.strip()]
        where = f"breaks off at frame {number}" if number else "cannot be read as a film"
        raise InputError(f"{path}: {where}: {told[-1][:120] if told else 'no reason'}") from None
