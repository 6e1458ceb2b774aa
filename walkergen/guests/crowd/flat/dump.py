"""Read the file of frames (dump) that LAMMPS writes: the pose of each walker at each frame."""

import io
from pathlib import Path
from typing import TextIO

import numpy as np

from walkergen.core import Array, InputError, OutputError

COLUMNS = "id xu yu c_heading[1] c_heading[2]"
"""Columns of a dump: number of the walker, position x, y (mm), cosine and sine of half the heading."""


def read_frames(path: Path, walkers: int, frames: int) -> Array:
    """Read x, y (mm) and heading (rad) of a finished run from its dump, not wrapped, shape (frames, walkers, 3).

    Raises OutputError if the file ends early, because the disk was full.
    """
    poses = np.empty((frames, walkers, 3))
    try:
        with path.open(encoding="ascii", errors="replace") as stream:
            for frame in range(frames):
                places = _read_frame(stream, walkers)
                if places is None:
                    raise OutputError(
                        f"{str(path)!r}: ends in frame {frame + 1} of {frames}: was the disk full? "
                        "Free space, or lower ‹rate_hz›"
                    )
                poses[frame] = places
    except OSError as error:
        raise InputError(f"{str(path)!r}: cannot be read: {error.strerror}") from None
    if not np.isfinite(poses).all():
        frame = int(np.argmin(np.isfinite(poses).all(axis=(1, 2))))
        raise InputError(f"{str(path)!r}: frame {frame + 1} has places that are not numbers")
    poses[:, :, 2] = np.unwrap(poses[:, :, 2], axis=0)
    return poses


def _read_frame(stream: TextIO, walkers: int) -> Array | None:
    """Read x, y and heading from the next frame, shape (walkers, 3). Return None if the file ends within the frame."""
    head = [stream.readline() for _ in range(9)]  # the fourth is the number of rows, the ninth names the columns
    if not head[8].endswith("\n"):
        return None
    if head[8].split()[2:] != COLUMNS.split() or head[3].strip() != str(walkers):
        raise InputError(
            f"{stream.name!r}: its frames have {head[3].strip()[:20]} rows of "
            f"{head[8].strip()[:80]!r}: must be {walkers} of {COLUMNS!r}, as walkergen requests"
        )
    lines = [stream.readline() for _ in range(walkers)]
    if not lines[-1].endswith("\n"):
        return None
    try:
        rows = np.loadtxt(io.StringIO("".join(lines)), ndmin=2)
    except ValueError:  # a row that was cut short
        return None
    heading = 2.0 * np.arctan2(rows[:, 4], rows[:, 3])
    return np.column_stack((rows[:, 1:3], heading))
