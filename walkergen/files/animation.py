"""Animation: frames encoded as a GIF, and as an MP4 if ffmpeg is installed."""

import importlib.util
import io
import shlex
import shutil
import subprocess
import tempfile
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import IO, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt
from PIL import Image

from walkergen.core.files.progress import Progress

Pixels = npt.NDArray[np.uint8]
"""Picture of shape (height, width, 3), with height and width even."""

NO_FFMPEG_REASON = "ffmpeg is not installed (pip install 'walkergen[film]' brings it)"
"""Reason why there is no MP4."""

Draw = Callable[[int], Pixels]
"""Function that draws the frame with a number, counted from 0, and returns its picture."""

Used = TypeVar("Used")

PALETTE_COLOURS, EXACT_COLOURS = 128, 16
"""Number of colours in a GIF's palette. Number of the commonest colours that are kept exactly; others are mixed."""

PALETTE_FRAMES = 16
"""Number of frames from which the palette is chosen."""


class Encoded(NamedTuple):
    """Contents of a movie's files."""

    gif: bytes
    mp4: bytes | None
    without_mp4: str
    """Reason why there is no MP4; '' when there is an MP4."""


def encode(draw: Draw, count: int, fps: int, hold_s: float, keep: Sequence[str], progress: Progress) -> Encoded:
    """Draw frames 0 to `count` - 1, and encode them as a GIF and as an MP4. Equal frames give equal bytes.

    The GIF holds its last frame for `hold_s`. The MP4 does not, because programs that track walkers in it would find
    that they stop. `fps` must divide 100, since a GIF counts in hundredths of a second. The colours `keep` (#RRGGBB)
    are exact in the GIF, however rare they are.
    """
    palette = _choose_palette(draw, count, keep)
    return Encoded(*_write_film(draw, count, fps, progress, lambda frames: _encode_gif(frames, palette, fps, hold_s)))


def encode_mp4(draw: Draw, count: int, fps: int, progress: Progress) -> tuple[bytes | None, str]:
    """Draw frames 0 to `count` - 1, and encode them as an MP4. Return its bytes and "", or None and the reason.

    Use it for films with so much motion that a GIF would be many times as large.
    """
    if find_ffmpeg() is None:
        return None, NO_FFMPEG_REASON
    _, mp4, without = _write_film(draw, count, fps, progress, lambda frames: deque(frames, 0))  # keeps none
    return mp4, without


def _write_film(
    draw: Draw, count: int, fps: int, progress: Progress, use: Callable[[Iterator[Pixels]], Used]
) -> tuple[Used, bytes | None, str]:
    """Draw frames, pass them to `use`, and encode them as an MP4.

    Return the result of `use`, the bytes of the MP4 or None, and "" or the reason why there is no MP4.
    """
    with tempfile.TemporaryDirectory(prefix="walkergen-movie-") as folder:
        target = Path(folder) / "movie.mp4"
        with (Path(folder) / "messages").open("w+b") as messages:
            ffmpeg = _start_ffmpeg(draw(0).shape, fps, target, messages)
            try:
                used = use(_stream_frames(draw, count, ffmpeg, progress))
                return used, *_close_ffmpeg(ffmpeg, target, messages)
            finally:
                if ffmpeg is not None and ffmpeg.poll() is None:
                    ffmpeg.kill()
                    ffmpeg.communicate()


def _choose_palette(draw: Draw, count: int, keep: Sequence[str]) -> Image.Image:
    """Return one palette for all frames, so that fixed parts do not flicker. Colours `keep` (#RRGGBB) stay exact."""
    chosen = sorted({round(number) for number in np.linspace(0, count - 1, min(count, PALETTE_FRAMES))})
    pixels = np.concatenate([draw(number).reshape(-1, 3) for number in chosen]).astype(np.uint32)
    codes, counts = np.unique(pixels @ np.array([1 << 16, 1 << 8, 1], np.uint32), return_counts=True)
    kept = np.array([int(colour.removeprefix("#"), 16) for colour in keep], np.uint32)
    codes = np.concatenate([kept, codes[np.argsort(-counts.astype(np.int64), kind="stable")]])
    colours = np.stack([codes >> 16, codes >> 8 & 255, codes & 255], axis=-1).astype(np.uint8)
    # The commonest colours stay exact as well; all others are represented.
    exact = len(keep) + EXACT_COLOURS
    entries, rest = colours[:exact], colours[exact:]
    if len(rest):
        between = Image.fromarray(rest[None]).quantize(PALETTE_COLOURS - exact, Image.Quantize.MEDIANCUT)
        added = np.frombuffer(bytes(between.getpalette() or ()), np.uint8).reshape(-1, 3)
        entries = np.vstack([entries, added])
    # Pillow looks colours up by their upper six bits: one entry for each of those.
    _, first = np.unique(entries >> 2, axis=0, return_index=True)
    entries = entries[np.sort(first)]
    palette = Image.new("P", (1, 1))
    palette.putpalette(entries.tobytes())
    return palette


def _stream_frames(
    draw: Draw, count: int, ffmpeg: "subprocess.Popen[bytes] | None", progress: Progress
) -> Iterator[Pixels]:
    """Yield the frames, and send each to ffmpeg as well, if it runs."""
    for number in range(count):
        frame = draw(number)
        if ffmpeg is not None and ffmpeg.poll() is None:
            assert ffmpeg.stdin is not None
            try:
                ffmpeg.stdin.write(frame.tobytes())
            except BrokenPipeError:
                ffmpeg.wait()  # ffmpeg has given up; its message is read at the end
        progress("frames", number + 1, count)
        yield frame


def _encode_gif(frames: Iterator[Pixels], palette: Image.Image, fps: int, hold_s: float) -> bytes:
    """Return the frames as a GIF in which the last one stays for `hold_s`."""
    images = [Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    delay = 1000 // fps
    delays = [delay] * (len(images) - 1) + [delay + round(100 * hold_s) * 10]
    data = io.BytesIO()
    images[0].save(data, "GIF", save_all=True, append_images=images[1:], duration=delays, loop=0, optimize=True)
    return data.getvalue()


def find_ffmpeg() -> str | None:
    """Return the path of ffmpeg, from the PATH or from the optional packages `film`; None if it is not installed."""
    found = shutil.which("ffmpeg")
    if found is None and importlib.util.find_spec("imageio_ffmpeg") is not None:
        import imageio_ffmpeg

        try:
            return str(imageio_ffmpeg.get_ffmpeg_exe())
        except RuntimeError:  # a build of the package without the program
            return None
    return found


def _start_ffmpeg(
    shape: tuple[int, ...], fps: int, target: Path, messages: IO[bytes]
) -> "subprocess.Popen[bytes] | None":
    """Start ffmpeg, which reads frames of this shape and writes `target`; return None if it is not installed."""
    found = find_ffmpeg()
    if found is None:
        return None
    frames = f"-loglevel error -nostdin -f rawvideo -pix_fmt rgb24 -s {shape[1]}x{shape[0]} -r {fps} -i pipe:0"
    movie = "-c:v libx264 -crf 20 -pix_fmt yuv420p -movflags +faststart -fflags +bitexact -flags:v +bitexact -y"
    words = [found, *shlex.split(f"{frames} {movie}"), str(target)]
    return subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=messages)


def _close_ffmpeg(
    ffmpeg: "subprocess.Popen[bytes] | None", target: Path, messages: IO[bytes]
) -> tuple[bytes | None, str]:
    """Close ffmpeg. Return the MP4 from `target` and "", or None and the reason from `messages`."""
    if ffmpeg is None:
        return None, NO_FFMPEG_REASON
    ffmpeg.communicate()
    if ffmpeg.returncode == 0:
        return target.read_bytes(), ""
    messages.seek(0)
    lines = messages.read().decode(errors="replace").strip().splitlines()
    return None, f"ffmpeg failed: {lines[-1] if lines else f'exit code {ffmpeg.returncode}'}"
