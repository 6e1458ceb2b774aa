"""Trajectories, states at a fixed rate: of one run, or of all runs one after the other."""

import io
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.numerics import Array
from walkergen.core.scene import Scene
from walkergen.core.simulation.run import RunResult
from walkergen.core.simulation.space.state import TRAJECTORY_COLUMNS

MAX_SAMPLES = 20_000_000


class Trajectory(NamedTuple):
    """States of one run, or of all runs one after the other, at a fixed interval."""

    columns: tuple[str, ...]
    """Names with units: t_s, for several runs `particle`, then `space.state.TRAJECTORY_COLUMNS`."""
    rows: Array
    """Shape (samples, columns); the time counts from the end of the discarded start."""


def check_sample_count(scene: Scene, interval: float, runs: int) -> None:
    """Raise InputError if samples every `interval` seconds of all runs would be more than MAX_SAMPLES."""
    wanted = runs * scene.run.seconds / interval
    if wanted > MAX_SAMPLES:
        what, fewer = ("the run", "") if runs == 1 else (f"{runs} runs", ", ‹runs›")
        raise InputError(
            f"{what} would give {wanted:.3g} samples. At most {MAX_SAMPLES:g} are kept. "
            f"Lower ‹rate_hz›{fewer} or ‹seconds›."
        )


def from_runs(results: Sequence[RunResult]) -> Trajectory:
    """Return the trajectory of all runs, one after the other. The column `particle` has the number of the run.

    The runs must have kept samples. Time counts from the end of each run's discarded start.
    """
    parts = [np.insert(sample_rows(result), 1, result.number, axis=1) for result in results]
    rows = np.concatenate(parts) if parts else np.zeros((0, 2 + len(TRAJECTORY_COLUMNS)))
    return Trajectory(("t_s", "particle", *TRAJECTORY_COLUMNS), rows)


def sample_rows(result: RunResult) -> Array:
    """Return the samples that a run kept, shape (samples, columns): time (s), then TRAJECTORY_COLUMNS."""
    samples = result.tally.samples
    return np.asarray(samples.rows[: samples.cursor[0]])


def to_csv(trajectory: Trajectory) -> bytes:
    """Return a trajectory as CSV with a header line and all digits."""
    text = io.StringIO()
    text.write(",".join(trajectory.columns) + "\n")
    np.savetxt(text, trajectory.rows, fmt="%.17g", delimiter=",")
    return text.getvalue().encode()


def to_npz(trajectory: Trajectory) -> bytes:
    """Return a trajectory as an NPZ archive with one array per column."""
    data = io.BytesIO()
    columns = dict(zip(trajectory.columns, trajectory.rows.T, strict=True))
    np.savez(data, allow_pickle=False, **columns)
    return data.getvalue()
