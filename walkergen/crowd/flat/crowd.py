"""One run of a crowd of cards in a plane: its LAMMPS input, or where everybody was.

Here LAMMPS is a program like any other; with `files` it is another machine's.
"""

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.crowd.cards.card import Card
from walkergen.crowd.flat import deck, doors, dump, engine
from walkergen.dish import Dish
from walkergen.files import output
from walkergen.files.progress import Progress, silent

Array = npt.NDArray[np.float64]


class FlatRun(NamedTuple):
    """Where N walkers were at F frames, the first at the start; nothing is discarded."""

    times: Array
    """s, shape (F,)."""
    poses: Array
    """x, y (mm) and heading (rad), shape (F, N, 3); neither wrapped."""


def simulate(
    cards: Sequence[Card],
    kinds: npt.ArrayLike,
    dish: Dish,
    places: npt.ArrayLike,
    *,
    seconds: float,
    rate_hz: float,
    seed: int,
    ranks: int = 1,
    progress: Progress = silent,
) -> FlatRun:
    """Run N walkers of the cards in a dish with LAMMPS and read back where they were.

    `kinds` are numbers of cards, shape (N,), `places` x, y (mm) and heading (rad), shape (N, 3),
    where no bodies overlap. The same arguments give the same, to the bit. `ranks` above 1 are
    processes of MPI. Progress counts frames. Its files stand in a temporary folder that goes with
    the run. Raises InputError for bad numbers, for LAMMPS absent, too old or stopped; OutputError
    where the disk is full.
    """
    asked = doors.crowd(cards, kinds, dish, places, seconds, rate_hz, seed)
    if ranks < 1:
        raise doors.wrong("ranks", ranks, ">= 1")
    program = engine.locate()
    parts = deck.mechanics(asked.cards)
    stride = deck.steps_per_frame(asked, parts)

    def count(what: str, step: int, _: int) -> None:
        progress(what, step // stride, asked.frames - 1)

    with tempfile.TemporaryDirectory(prefix="walkergen-crowd-") as place:
        folder = Path(place)
        for name, data in deck.files(asked, parts).items():
            output.write(folder / name, data)
        engine.run(program, folder, deck.INPUT, ranks, count)
        frames = dump.read(folder / deck.DUMP, len(asked.places), asked.frames)
    return FlatRun(np.arange(asked.frames) / rate_hz, frames.poses)


def files(
    cards: Sequence[Card],
    kinds: npt.ArrayLike,
    dish: Dish,
    places: npt.ArrayLike,
    *,
    seconds: float,
    rate_hz: float,
    seed: int,
) -> dict[str, bytes]:
    """LAMMPS input of the same run, by names of files, for a cluster: `lmp -in crowd.in`.

    It needs no LAMMPS here. Its dump is read back by `read`.
    """
    asked = doors.crowd(cards, kinds, dish, places, seconds, rate_hz, seed)
    return deck.files(asked, deck.mechanics(asked.cards))


def write(
    folder: Path,
    cards: Sequence[Card],
    kinds: npt.ArrayLike,
    dish: Dish,
    places: npt.ArrayLike,
    *,
    seconds: float,
    rate_hz: float,
    seed: int,
) -> list[Path]:
    """Write the files of `files` into a folder; their paths."""
    texts = files(cards, kinds, dish, places, seconds=seconds, rate_hz=rate_hz, seed=seed)
    for name, data in texts.items():
        output.write(folder / name, data)
    return [folder / name for name in texts]


def read(path: Path, walkers: int, seconds: float, rate_hz: float) -> FlatRun:
    """Dump that a cluster has made of the input of so many walkers, seconds and frames a second."""
    count = deck.frames(seconds, rate_hz)
    return FlatRun(np.arange(count) / rate_hz, dump.read(path, walkers, count).poses)
