"""Read films: grey frames of a file or of a folder of pictures, one by one, from ffmpeg (extra `film`).

ffmpeg sends the frames as YUV4MPEG2, whose header has size and rate, and writes the time of each frame to a file.
Films of varying frame rate, as phones make them, keep these times: no frame is repeated or left out.
"""

import os
import re
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from fractions import Fraction
from itertools import count
from pathlib import Path
from typing import IO, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen import extras
from walkergen.core.errors import InputError
from walkergen.core.files import file_reading, formatting
from walkergen.core.files.progress import Progress
from walkergen.core.numerics import Array
from walkergen.guests.track.film import pictures

Grey = npt.NDArray[np.uint8]
"""Brightness of a frame, shape (height, width), 0 black to 255 white; row 0 is the upper one."""

Box = tuple[int, int, int, int]
"""Left, top, right and bottom of a part of the frame, pixels."""

MAX_PIXELS = 36_000_000
"""Largest frame: 8K."""

MAX_FRAMES = 1_000_000

MAX_LINE_BYTES = 4096
"""Largest number of bytes of a header line between frames."""

RATE_TOLERANCE = 0.01
"""Tolerance of frame times against a constant rate, over the time between frames."""


class Film(NamedTuple):
    """Metadata of a film."""

    path: Path
    width: int
    """Width of a frame, pixels."""
    height: int
    fps: float | None
    """Playing rate in frames per second; None if not stated. Often a round number."""
    seconds: float
    """Duration; 0 if not stated."""
    aspect: Fraction = Fraction(1)
    """Width over height of a pixel in the file. Frames that `play` yields have square pixels."""
    pictures: tuple[Path, ...] = ()
    """Files of the frames, for a folder of pictures; empty for a film file."""


class Reel(NamedTuple):
    """Frames of a film while it is read, and the file of their times."""

    frames: Iterator[Grey]
    """Searched part of each frame. The iterator raises InputError at an incomplete frame, or if there are too many
    frames."""
    expected: int
    """Number of frames expected from the film's metadata, at least 1."""
    stamps: Path
    """File of the frames' times, complete after the last frame."""


class Clock(NamedTuple):
    """Times of a film's frames."""

    times: Array
    """Time of each frame since the first one, s, shape (frames,)."""
    fps: float
    """Mean number of frames per second."""
    regular: bool
    """Whether all frames are evenly spaced at that rate."""
    played_s: float
    """Time of the last frame when the film is played, s."""

    @property
    def in_words(self) -> str:
        """Frame rate as text and, if it varies, the shortest and longest time between frames."""
        rate = f"{formatting.format_number(self.fps, 4)} frames a second"
        if self.regular:
            return rate
        steps = 1e3 * np.diff(self.times)
        return (
            f"{rate} in the mean, {formatting.format_range(steps.min(), steps.max(), 3)} ms apart by the film's times"
        )


def require_extra() -> None:
    """Raise InputError when the packages of the extra `film` are not installed."""
    extras.require("film", "track")


def probe_film(path: Path) -> Film:
    """Read size, rate and duration of a film or a folder of pictures. Raises InputError for others, or if too large."""
    shots = pictures.list_pictures(path) if path.is_dir() else ()
    if not shots:
        file_reading.check_readable(path, "a film")
    with _run_ffmpeg(path, shots[:1]) as (process, messages):
        assert process.stdout is not None
        first = process.stdout.readline(MAX_LINE_BYTES)
        header = {word[:1]: word[1:] for word in first.split()[1:]}
        if b"W" not in header:
            raise InputError(f"{path}: cannot be read as a film: {_last_message(messages)}")
        width, height = int(header[b"W"]), int(header[b"H"])
        fps, aspect = _parse_ratio(header[b"F"]), _parse_ratio(header.get(b"A", b"")) or Fraction(1)
        seconds = _parse_duration(messages)
    if aspect > 1:
        width = round(width * aspect)
    else:
        height = round(height / aspect)
    if width * height > MAX_PIXELS:
        raise InputError(
            f"{path}: {width} x {height} pixels a frame: at most {MAX_PIXELS / 1e6:g} million. "
            "Make it smaller: ffmpeg -i FILM -vf scale=1920:-2 SMALL.mp4"
        )
    if shots:
        return Film(path, width, height, None, 0.0, aspect, shots)
    return Film(path, width, height, float(fps) or None, seconds, aspect)


def _parse_ratio(text: bytes) -> Fraction:
    """Parse a ratio that ffmpeg writes as 4:3; 0 if unknown."""
    numbers = [int(part) for part in text.split(b":")] if text else [0]
    return Fraction(*numbers) if len(numbers) == 2 and numbers[1] else Fraction(0)


@contextmanager
def play(film: Film, part: Box, frames: tuple[int, int | None], progress: Progress) -> Iterator[Reel]:
    """Open a film and yield its `Reel`: frames `frames[0]` to `frames[1]` - 1 (None: the end), cropped to `part`."""
    first, last = frames
    count = len(film.pictures) or round(film.seconds * (film.fps or 0.0))
    expected = max((count if last is None else last) - first, 1)
    with tempfile.TemporaryDirectory() as folder:
        stamps = Path(folder) / "stamps"
        # Frames keep their times, in the container's unit of time, which ffmpeg would round to frames
        options = [
            "-fps_mode",
            "passthrough",
            "-enc_time_base",
            "demux",
            "-stats_enc_pre",
            str(stamps),
            "-stats_enc_pre_fmt",
            "{pts} {tb}",
            *(() if last is None else ("-frames:v", str(last))),
            *(() if film.aspect == 1 else ("-vf", f"scale={film.width}:{film.height},setsar=1")),
        ]
        with _run_ffmpeg(film.path, film.pictures, options) as (process, messages):
            whole = _read_frames(film, first, process, messages)
            yield Reel(_crop_frames(whole, part, expected, progress), expected, stamps)


def _crop_frames(frames: Iterator[Grey], part: Box, expected: int, progress: Progress) -> Iterator[Grey]:
    """Yield the part of each frame, and report progress against the expected number of frames."""
    left, top, right, bottom = part
    for done, whole in enumerate(frames, 1):
        yield np.ascontiguousarray(whole[top:bottom, left:right])
        progress("frames", done, max(expected, done))


def check_frame_count(frames: int, first: int) -> None:
    """Raise InputError if `frames`, the number of frames from frame `first` on, is below two."""
    if frames < 2:
        raise InputError(f"{frames} frame{'' if frames == 1 else 's'} from {first} on: at least 2 are needed")


def _read_frames(film: Film, first: int, process: "subprocess.Popen[bytes]", messages: IO[bytes]) -> Iterator[Grey]:
    """Yield the whole frames that ffmpeg writes, from number `first` on. Raises InputError if one is incomplete."""
    size = film.width * film.height
    assert process.stdout is not None
    process.stdout.readline(MAX_LINE_BYTES)
    for number in count():
        if not process.stdout.readline(MAX_LINE_BYTES):
            break
        data = process.stdout.read(size)
        if len(data) < size:
            why = _last_message(messages)
            raise InputError(f"{film.path}: breaks off in frame {number}: {why}")
        if number >= MAX_FRAMES:
            raise InputError(f"{film.path}: more than {MAX_FRAMES} frames. Cut the film")
        if number >= first:
            yield np.frombuffer(data, np.uint8).reshape(film.height, film.width)
    process.wait()  # ffmpeg writes the last times when it ends


def read_clock(film: Film, stamps: Path, filmed_fps: float | None) -> Clock:
    """Return the times of the frames that were played.

    If the film's stated or mean rate fits the times that ffmpeg wrote, times are evenly spaced at that rate. Otherwise
    they are those that ffmpeg wrote. A folder of pictures has no times, nor has a film of one frame or with times that
    do not increase: theirs are evenly spaced at `filmed_fps`.

    Parameters
    ----------
    film : Film
        Film with its stated rate.
    stamps : Path
        File of the times that ffmpeg wrote.
    filmed_fps : float or None
        Frames per second when filmed, of a slow-motion film: times are rescaled to this mean rate. None if the film
        plays as fast as it was filmed.

    Returns
    -------
    Clock
        Times, and their rate.

    Raises
    ------
    InputError
        If the film has no times and `filmed_fps` is None.
    """
    lines = [line.split() for line in stamps.read_text().splitlines()]
    unit = Fraction(lines[0][1]) if lines else Fraction(0)
    ticks = np.array([int(line[0]) for line in lines], dtype=float)
    times = float(unit) * (ticks - ticks[0]) if lines else np.zeros(0)
    if film.pictures or len(times) < 2 or not (np.diff(times) > 0).all():
        if filmed_fps is None:
            raise InputError(f"{film.path}: its frames have no times. Give ‹fps›")
        return Clock(np.arange(len(times)) / filmed_fps, filmed_fps, True, len(times) / filmed_fps)
    played = (len(times) - 1) / times[-1]
    for rate in (film.fps, played):
        if rate is None:
            continue
        even = np.arange(len(times)) / rate
        if np.abs(times - even).max() <= max(float(unit), RATE_TOLERANCE / rate):
            fps = filmed_fps or rate
            return Clock(np.arange(len(times)) / fps, fps, True, float(times[-1]))
    fps = filmed_fps or played
    return Clock(times * (played / fps), fps, False, float(times[-1]))


@contextmanager
def _run_ffmpeg(
    path: Path, shots: Sequence[Path], more: Sequence[str] = ()
) -> Iterator[tuple["subprocess.Popen[bytes]", IO[bytes]]]:
    """Run ffmpeg on a film or on pictures `shots`, with `more` options. Yield its process and file of messages."""
    import imageio_ffmpeg

    program = imageio_ffmpeg.get_ffmpeg_exe()
    # Never fetch from elsewhere, for any content of the file. Any name is a file's, even one that begins with a dash,
    # or with "http:".
    options = ["-hide_banner", "-nostats", "-nostdin", "-protocol_whitelist", "file"]
    if shots:
        options += ["-f", "concat", "-safe", "0"]
    grey = ["-map", "0:v:0", "-pix_fmt", "gray", *more, "-f", "yuv4mpegpipe", "-strict", "-1", "-"]
    with (
        pictures.write_list(shots) if shots else nullcontext(os.path.realpath(path)) as source,
        tempfile.TemporaryFile() as messages,
        subprocess.Popen(
            [program, *options, "-i", str(source), *grey],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=messages,
        ) as process,
    ):
        try:
            yield process, messages
        finally:
            process.kill()


def _message_lines(messages: IO[bytes]) -> list[str]:
    """Return the lines that ffmpeg has written so far."""
    messages.seek(0)
    return [line.strip() for line in messages.read().decode(errors="replace").splitlines()]


def _last_message(messages: IO[bytes]) -> str:
    """Return the last line of ffmpeg's messages that is not empty, cut to 120 characters."""
    return next((line[:120] for line in reversed(_message_lines(messages)) if line), "no reason is given")


def _parse_duration(messages: IO[bytes]) -> float:
    """Parse the duration (s) in ffmpeg's messages, or return 0 if it is not stated."""
    match = re.search(r"Duration: (\d+):(\d+):(\d+\.\d+)", " ".join(_message_lines(messages)))
    if match is None:
        return 0.0
    hours, minutes, seconds = map(float, match.groups())
    return 3600.0 * hours + 60.0 * minutes + seconds
