"""Files of trajectories of all runs, which `simulate --trajectory` writes: CSV, NPZ, NetCDF or extended XYZ.

Each run is a particle. The first columns are those of trackpy and `analyse` (`frame`, `particle`, `x`, `y`, `theta`),
seen from above, in mm and rad. Then come `t_s` and the columns of the simulation, with units in their names. Frame 0
is the first sample after the discarded start of a run.
"""

import io
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from walkergen import __version__
from walkergen.core.errors import InputError
from walkergen.core.files import output
from walkergen.core.files.progress import Progress
from walkergen.core.numerics import Array
from walkergen.core.walker.design import Design
from walkergen.files import extended_xyz
from walkergen.files.extended_xyz import Bodies
from walkergen.points import trajectory, walkers
from walkergen.points.experiments import Results, Walker
from walkergen.points.trajectory import Trajectory


def pack_poses(times: Array, places: Array, headings: Array, names: Sequence[str]) -> bytes:
    """Return the bytes of a NetCDF file with the centres of k walkers, in the layout of the program movement.

    Parameters
    ----------
    times : ndarray
        Times, shape (n,), s.
    places : ndarray
        Positions x and y, shape (n, 2, k), mm; NaN while a walker is not visible.
    headings : ndarray
        Headings, shape (n, k), rad; NaN while a walker is not visible.
    names : sequence of str
        Names of the walkers.
    """
    from scipy.io import netcdf_file

    stream = io.BytesIO()
    file = netcdf_file(stream, "w", version=2)
    file.ds_type, file.source_software, file.time_unit = "poses", f"walkergen {__version__}", "seconds"
    if len(times) > 1:
        file.fps = np.float64((len(times) - 1) / (times[-1] - times[0]))
    for name, count in (("time", len(times)), ("space", 2), ("keypoint", 1), ("individual", len(names))):
        file.createDimension(name, count)
    for name, words in (("space", ("x", "y")), ("keypoint", ("middle",)), ("individual", names)):
        _write_names(file, name, words)
    dimensions = ("time", "space", "keypoint", "individual")
    for name, variable_dimensions, values in (
        ("time", ("time",), times),
        ("position", dimensions, places[:, :, None, :]),
        ("confidence", ("time", *dimensions[2:]), np.where(np.isfinite(places[:, :1]), 1.0, np.nan)),
        ("heading", ("time", "individual"), headings),
    ):
        file.createVariable(name, "d", variable_dimensions)[:] = values
    file.variables["position"].unit, file.variables["heading"].unit = "mm", "rad"
    file.flush()
    return stream.getvalue()


def _write_names(file: Any, dimension: str, labels: Sequence[str]) -> None:
    """Write the labels along a dimension, as xarray writes text."""
    width = max(len(word.encode()) for word in labels)
    file.createDimension(f"{dimension}_letters", width)
    variable = file.createVariable(dimension, "c", (dimension, f"{dimension}_letters"))
    variable[:] = np.array([list(word.encode().ljust(width, b"\0")) for word in labels], np.uint8).view("S1")
    variable._Encoding = "utf-8"


FILM_COLUMNS = ("frame", "particle", "x", "y", "theta")
"""Columns with trackpy's names; x and y in mm, theta in rad."""

BOX_MARGIN = 1.0
"""Margin around all bodies in the box of extended XYZ, over half the diagonal of a body."""


class TrajectoryData(NamedTuple):
    """Trajectories to write to a file, and the design of their walker."""

    rows: Trajectory
    design: Design


def collect(experiment: Walker, point: Results, progress: Progress) -> Trajectory:
    """Return the trajectories of all runs. Runs are simulated again if `point` has no samples.

    Raises InputError if there are too many samples to keep.
    """
    assert experiment.sample_interval is not None
    kept = all(result.tally.samples.kept for result in point.results)
    if not kept:
        trajectory.check_sample_count(experiment.scene, experiment.sample_interval, experiment.scene.run.runs)
        (point,) = walkers.simulate_each([experiment], ["samples"], progress)
    return with_film_columns(trajectory.from_runs(point.results), experiment.sample_interval)


def with_film_columns(trajectory: Trajectory, interval: float) -> Trajectory:
    """Return trajectories with `FILM_COLUMNS` before their other columns. `interval`: time between samples, s."""
    values_by_name = dict(zip(trajectory.columns, trajectory.rows.T, strict=True))
    film = (
        np.rint(values_by_name["t_s"] / interval),
        *(values_by_name[name] for name in ("particle", "x_mm", "y_mm", "theta_rad")),
    )
    other_columns = {name: values for name, values in values_by_name.items() if name != "particle"}
    return Trajectory((*FILM_COLUMNS, *other_columns), np.column_stack([*film, *other_columns.values()]))


def to_csv(data: TrajectoryData) -> bytes:
    """Return the bytes of a CSV file with a header line and all digits."""
    return trajectory.to_csv(data.rows)


def to_npz(data: TrajectoryData) -> bytes:
    """Return the bytes of an NPZ archive with an array for each column."""
    return trajectory.to_npz(data.rows)


def to_xyz(data: TrajectoryData) -> bytes:
    """Return the bytes of an extended XYZ file for OVITO: a frame for each time, with all runs that last so long."""
    values = dict(zip(data.rows.columns, data.rows.rows.T, strict=True))
    size = data.design.size
    half = 0.5 * np.array([size.length, size.depth, size.thickness])
    places = np.column_stack([values["x"], values["y"], values["height_mm"]])
    rotations = extended_xyz.to_quaternions(values["theta"], values["pitch_rad"], values["roll_rad"])
    box = _bounding_box(places, float(np.linalg.norm(half)))
    kinds = np.zeros(len(places), np.int64)
    bodies = Bodies(
        values["frame"], values["t_s"], values["particle"], ["walker"], kinds, places, rotations, half[None]
    )
    return extended_xyz.format_frames(bodies, box).encode()


def _bounding_box(places: Array, half_diagonal: float) -> str:
    """Return the text of a box that contains all bodies at all times, so that OVITO's view does not move.

    `places`: positions of bodies, shape (n, 3), mm. `half_diagonal`: half the diagonal of a body, mm.
    """
    margin = (1.0 + BOX_MARGIN) * half_diagonal
    low = places.min(axis=0, initial=np.inf) - margin
    return extended_xyz.format_box(low, places.max(axis=0, initial=-np.inf) + margin - low)


def to_nc(data: TrajectoryData) -> bytes:
    """Return the bytes of a NetCDF file for xarray and movement, in which each run is an individual."""
    values = dict(zip(data.rows.columns, data.rows.rows.T, strict=True))
    frames, frame_index = np.unique(values["frame"], return_inverse=True)
    names, run_index = np.unique(values["particle"].astype(np.int64), return_inverse=True)
    table = np.full((len(frames), 4, len(names)), np.nan)
    table[frame_index, :, run_index] = np.column_stack([values["t_s"], values["x"], values["y"], values["theta"]])
    times = np.nanmax(table[:, 0], axis=1)
    return pack_poses(times, table[:, 1:3], table[:, 3], [f"run_{name}" for name in names])


FORMATS: dict[str, Callable[[TrajectoryData], bytes]] = {".csv": to_csv, ".npz": to_npz, ".xyz": to_xyz, ".nc": to_nc}
"""Functions that return the bytes of a file, by its suffix."""


def check(path: Path) -> None:
    """Raise InputError if the suffix of a file is none of FORMATS."""
    if path.suffix.lower() not in FORMATS:
        problem = output.describe_wrong_ending(path, FORMATS, " (xyz for OVITO, nc for xarray)")
        raise InputError(f"‹trajectory=›{str(path)[:80]!r}: {problem}")


def write(path: Path, experiment: Walker, point: Results, progress: Progress) -> None:
    """Write the trajectories of all runs to a file, whose suffix selects the format."""
    written = TrajectoryData(collect(experiment, point, progress), experiment.design)
    output.write(path, FORMATS[path.suffix.lower()](written))
