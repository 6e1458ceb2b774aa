"""Trajectory of one run: its states at a fixed rate, written as CSV or NPZ."""

import io
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.errors import InputError
from walkergen.files import output
from walkergen.scene import Scene
from walkergen.simulation.model import Plan
from walkergen.simulation.run import simulate

Array = npt.NDArray[np.float64]

MOST_SAMPLES = 20_000_000


class Trajectory(NamedTuple):
    """States of one run at a fixed interval."""

    columns: tuple[str, ...]
    """Names with units: t_s, then those of the state (`Model.columns`)."""
    rows: Array
    """Shape (samples, columns); the time counts from the end of the discarded start."""


def check(scene: Scene, interval: float) -> None:
    """Raise InputError when a trajectory would have too many samples to keep."""
    wanted = scene.run.seconds / interval
    if wanted > MOST_SAMPLES:
        raise InputError(
            f"a trajectory of {wanted:.3g} samples; at most {MOST_SAMPLES}: "
            "lower --rate or --seconds"
        )


def sample(plan: Plan, interval: float, number: int = 0) -> Trajectory:
    """Simulate one run of the ensemble again and keep its state every `interval` seconds."""
    check(plan.scene, interval)
    samples = simulate(plan, number, sample_interval=interval).tally.samples
    assert samples is not None
    columns = plan.model.columns
    rows = samples.rows[: samples.cursor[0], : 1 + len(columns)]
    return Trajectory(("t_s", *columns), rows)


def to_csv(trajectory: Trajectory) -> bytes:
    """CSV with a header line, every digit kept."""
    text = io.StringIO()
    text.write(",".join(trajectory.columns) + "\n")
    np.savetxt(text, trajectory.rows, fmt="%.17g", delimiter=",")
    return text.getvalue().encode()


def to_npz(trajectory: Trajectory) -> bytes:
    """NPZ archive with one array per column."""
    data = io.BytesIO()
    columns = dict(zip(trajectory.columns, trajectory.rows.T, strict=True))
    np.savez(data, allow_pickle=False, **columns)
    return data.getvalue()


FORMATS: dict[str, Callable[[Trajectory], bytes]] = {"csv": to_csv, "npz": to_npz}


def write(plan: Plan, path: Path, form: str, interval: float) -> None:
    """Sample the ensemble's first run and write it in one of FORMATS."""
    output.write(path, FORMATS[form](sample(plan, interval)))
