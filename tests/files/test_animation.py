"""Encoding frames: GIF with Pillow, MP4 with ffmpeg, and the message without ffmpeg."""

import io
import shutil

import numpy as np
from PIL import Image

from walkergen.files import animation


def silent(what, done, total):
    pass


def plain(at):
    return np.full((4, 6, 3), 20 * at, np.uint8)


def test_without_ffmpeg_only_the_gif_is_made_with_a_note(monkeypatch):
    monkeypatch.setattr(animation, "find_ffmpeg", lambda: None)
    made = animation.encode(plain, 3, 10, 0.5, [], silent)
    assert made.gif.startswith(b"GIF89a")
    assert made.mp4 is None
    assert "pip install 'walkergen[film]'" in made.without_mp4


def test_the_ffmpeg_of_the_extra_replaces_a_missing_one(monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    made = animation.encode(lambda at: np.full((32, 48, 3), 20 * at, np.uint8), 3, 10, 0.5, [], silent)
    assert made.without_mp4 == ""
    assert made.mp4[4:8] == b"ftyp"


def test_an_ffmpeg_that_fails_is_quoted(monkeypatch, tmp_path):
    program = tmp_path / "ffmpeg"
    program.write_text("#!/bin/sh\necho \"Unknown encoder 'libx264'\" >&2\nexit 1\n")
    program.chmod(0o755)
    monkeypatch.setattr(shutil, "which", lambda name: str(program))
    made = animation.encode(plain, 12, 10, 0.5, [], silent)
    assert made.gif.startswith(b"GIF89a")
    assert (made.mp4, made.without_mp4) == (None, "ffmpeg failed: Unknown encoder 'libx264'")


def test_rare_colours_stay_exact():
    def draw(at):
        frame = np.zeros((64, 64, 3), np.uint8)
        frame[..., 0] = 4 * np.arange(64)
        frame[..., 1] = 4 * np.arange(64)[:, None]
        frame[0, 0] = (0x12, 0x34, 0x56)
        return frame

    made = animation.encode(draw, 2, 10, 0.1, ["#123456"], silent)
    with Image.open(io.BytesIO(made.gif)) as image:
        assert image.convert("RGB").getpixel((0, 0)) == (0x12, 0x34, 0x56)
