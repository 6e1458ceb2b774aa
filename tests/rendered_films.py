"""Films with known poses: walkers on a plate, with light and camera as bad as requested.

Brightness is light times reflectance. Lengths are pixels of a camera that looks straight down, y up
from the lower edge; rows of a picture go down.
"""

import subprocess
from collections.abc import Callable
from typing import NamedTuple

import imageio_ffmpeg
import numpy as np

LONG, ACROSS = 40.0, 14.0
"""Length and width of a walker."""

EVEN = lambda x, y: 1.0 + 0.0 * x  # noqa: E731


class Filmed(NamedTuple):
    """A plate, its light and its camera."""

    wide: int = 320
    high: int = 240
    ground: float = 190.0
    """Brightness of the plate where the light is 1."""
    contrast: float = 110.0
    """Contrast of walkers against the plate there."""
    noise: float = 2.0
    light: Callable[..., np.ndarray] = EVEN
    """Light by x and y as shares of the picture's width and height."""
    shadow: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Offset of a walker's shadow, and the share of the light that it takes."""
    screws: bool = False
    """True for a plate with things on it that do not move."""
    tilt: float = 0.0
    """Relative difference of distance to the camera between the picture's right edge and its middle."""


def picture(walkers, film=Filmed(), shift=(0.0, 0.0), seed=0):  # noqa: B008
    """Grey frame with walkers (x, y, heading), by a camera that is off by `shift`."""
    row, column = np.mgrid[: film.high, : film.wide] + 0.5
    x, y = column + shift[0], film.high - row + shift[1]
    near = 1.0 + film.tilt * (x / film.wide - 0.5)  # magnification there, from the middle
    x, y = (0.5 * film.wide + (x - 0.5 * film.wide) / near, 0.5 * film.high + (y - 0.5 * film.high) / near)
    light = film.light(x / film.wide, y / film.high) * np.ones_like(x)
    reflected = np.full_like(x, film.ground)
    if film.screws:
        for at in ((0.08, 0.1), (0.93, 0.12), (0.5, 0.95), (0.06, 0.9), (0.95, 0.88)):
            off = np.hypot(x - at[0] * film.wide, y - at[1] * film.high)
            reflected -= 70.0 * (3.0 - off).clip(0.0, 1.0)
    bodies = [_inside(x, y, *one) for one in walkers]
    for one, body in zip(walkers, bodies, strict=True):
        if film.shadow[2]:
            beside = _inside(x, y, one[0] + film.shadow[0], one[1] + film.shadow[1], one[2])
            light *= 1.0 - film.shadow[2] * beside * (1.0 - body)
        reflected -= film.contrast * body
    found = light * reflected + np.random.default_rng(seed).normal(0.0, film.noise or 1e-9, x.shape)
    return found.clip(0, 255).round().astype(np.uint8)


def _inside(x, y, at_x, at_y, heading):
    """Share of each pixel that a walker covers."""
    u, v, c, s = x - at_x, y - at_y, np.cos(heading), np.sin(heading)
    out = np.maximum(np.abs(u * c + v * s) - 0.5 * LONG, np.abs(v * c - u * s) - 0.5 * ACROSS)
    return (0.5 - out).clip(0.0, 1.0)


def write(path, pictures, times="N/25", rate=None, aspect=(1, 1)):
    """Film of frames at `times`, s, an expression of ffmpeg's in N; `rate` in kbit/s, or fine; pixels of an aspect."""
    high, wide = pictures[0].shape
    quality = ("-crf", "10") if rate is None else ("-b:v", f"{rate}k")
    source = ("-f", "rawvideo", "-pix_fmt", "gray", "-s", f"{wide}x{high}", "-r", "60", "-i", "-")
    clock = (
        "-vf",
        f"settb=1/90000,setpts='({times})/TB',setsar={aspect[0]}/{aspect[1]}",
        "-fps_mode",
        "passthrough",
        "-enc_time_base",
        "1/90000",
    )
    code = ("-c:v", "libx264", "-preset", "veryfast", "-pix_fmt", "yuv420p", *quality)
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "error", "-y", *source, *clock, *code, str(path)]
    subprocess.run(command, input=b"".join(one.tobytes() for one in pictures), check=True)
    return path
