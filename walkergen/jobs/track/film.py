"""Films: grey frames of a file, one by one, by the ffmpeg that the extra `film` installs.

ffmpeg sends them as YUV4MPEG2, whose first line says size and rate in a machine's words. A film of
varying frame rate, as phones make them, comes at one rate: frames are repeated or left out, so that
times are right within a frame.
"""

import importlib.util
import os
import re
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import IO, NamedTuple

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

MOST_LETTERS = 4096
"""Longest line between frames."""


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
    with _playing(path) as (pipe, messages):
        found = {word[:1]: word[1:] for word in pipe.readline(MOST_LETTERS).split()[1:]}
        if b"W" not in found:
            raise InputError(f"{path}: cannot be read as a film: {_reason(messages)}")
        width, height = int(found[b"W"]), int(found[b"H"])
        rate = found[b"F"].decode().split(":")
        fps = float(Fraction(int(rate[0]), int(rate[1]))) if int(rate[1]) else 0.0
        seconds = _duration(messages)
    if width * height > MOST_PIXELS:
        raise InputError(
            f"{path}: {width} x {height} pixels a frame: at most {MOST_PIXELS / 1e6:g} million; "
            "make it smaller: ffmpeg -i FILM -vf scale=1920:-2 SMALL.mp4"
        )
    return Film(path, width, height, fps or None, min(round(seconds * fps), MOST_FRAMES))


def frames(film: Film, first: int, last: int | None) -> Iterator[tuple[int, Grey]]:
    """Frames of numbers first..last - 1, counted from 0, or up to the end, with their numbers.

    Raises InputError where a frame is incomplete, or where there are too many.
    """
    size = film.width * film.height
    with _playing(film.path) as (pipe, messages):
        pipe.readline(MOST_LETTERS)
        number = 0
        while (last is None or number < last) and pipe.readline(MOST_LETTERS):
            data = pipe.read(size)
            if len(data) < size:
                why = _reason(messages)
                raise InputError(f"{film.path}: breaks off in frame {number}: {why}")
            if number >= MOST_FRAMES:
                raise InputError(f"{film.path}: more than {MOST_FRAMES} frames: cut the film")
            if number >= first:
                yield number, np.frombuffer(data, np.uint8).reshape(film.height, film.width)
            number += 1


@contextmanager
def _playing(path: Path) -> Iterator[tuple[IO[bytes], IO[bytes]]]:
    """Ffmpeg at work on a film: where its frames come from, and its messages; ended at the end."""
    import imageio_ffmpeg

    words = [
        imageio_ffmpeg.get_ffmpeg_exe(), "-hide_banner", "-nostats", "-nostdin",
        # Whatever the file says, nothing is fetched from elsewhere; whatever its name, it is a
        # file's: one that begins with a dash, or with "http:".
        "-protocol_whitelist", "file", "-i", os.path.realpath(path),
        "-map", "0:v:0", "-pix_fmt", "gray", "-f", "yuv4mpegpipe", "-strict", "-1", "-",
    ]  # fmt: skip
    with (
        tempfile.TemporaryFile() as messages,
        subprocess.Popen(
            words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=messages
        ) as process,
    ):
        assert process.stdout is not None
        try:
            yield process.stdout, messages
        finally:
            process.kill()


def _told(messages: IO[bytes]) -> list[str]:
    """Lines that ffmpeg has written so far."""
    messages.seek(0)
    return [line.strip() for line in messages.read().decode(errors="replace").splitlines()]


def _reason(messages: IO[bytes]) -> str:
    """Last of ffmpeg's lines."""
    return next((line[:120] for line in reversed(_told(messages)) if line), "no reason is given")


def _duration(messages: IO[bytes]) -> float:
    """Duration by the film's own account, s; 0 where it says nothing."""
    found = re.search(r"Duration: (\d+):(\d+):(\d+\.\d+)", " ".join(_told(messages)))
    if found is None:
        return 0.0
    hours, minutes, seconds = map(float, found.groups())
    return 3600.0 * hours + 60.0 * minutes + seconds
