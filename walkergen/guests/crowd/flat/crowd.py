"""One run of a crowd of cards in a plane: its LAMMPS input, or its positions.

The crowd comes from `crowd_checks`. `simulate` runs LAMMPS here; `input_files` writes the input for another machine.
"""

import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from walkergen.core import Array, Progress, silent
from walkergen.core.files import output
from walkergen.guests.crowd.flat import dump, lammps_engine, lammps_input
from walkergen.guests.crowd.flat.lammps_input import Crowd


class FlatRun(NamedTuple):
    """Poses of N walkers at F frames, from the start of the run on."""

    times: Array
    """Times of the frames, s, shape (F,)."""
    poses: Array
    """x, y (mm) and heading (rad), shape (F, N, 3). Positions and headings are not wrapped."""


def simulate(crowd: Crowd, progress: Progress = silent) -> FlatRun:
    """Run a crowd with LAMMPS and return the positions of its walkers.

    Equal crowds give the same bits. Progress counts frames. The files are in a temporary folder, deleted after the run.
    Raises InputError if LAMMPS is absent, too old or stopped; OutputError if the disk is full.
    """
    program = lammps_engine.find_lammps()
    parts = lammps_input.mechanics(crowd.cards)
    stride = lammps_input.steps_per_frame(crowd, parts)

    def report_frames(task: str, step: int, _: int) -> None:
        """Report the frame that a step of LAMMPS belongs to."""
        progress(task, step // stride, crowd.frames - 1)

    with tempfile.TemporaryDirectory(prefix="walkergen-crowd-") as place:
        folder = Path(place)
        for name, data in lammps_input.input_files(crowd, parts).items():
            output.write(folder / name, data)
        lammps_engine.run_script(program, folder, lammps_input.INPUT_FILE, report_frames)
        poses = dump.read_frames(folder / lammps_input.DUMP_FILE, len(crowd.places), crowd.frames)
    return FlatRun(np.arange(crowd.frames) / crowd.rate_hz, poses)


def input_files(crowd: Crowd) -> dict[str, bytes]:
    """Return a crowd's LAMMPS input by file name, for `lmp -in crowd.in` on another machine."""
    return lammps_input.input_files(crowd, lammps_input.mechanics(crowd.cards))
