"""Tracks in files of arrays: NetCDF of the package movement, SLEAP's and idtracker.ai's HDF5, NPZ of columns.

NetCDF 3 is read by scipy and NPZ by numpy; HDF5, which later NetCDF is as well, by h5py of the extra `poses`.
In a `lane` y may be ignored.
"""

import io
import json
import re
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen import extras
from walkergen.analysis import pose_tables, track_columns
from walkergen.analysis.track_columns import PIXEL, WALKERGEN_PROGRAM, NamedColumn, Source
from walkergen.core.errors import InputError
from walkergen.core.files import columns, file_reading, safe_text
from walkergen.core.files.columns import Columns
from walkergen.core.numerics import Array

NETCDF_MAGIC, HDF5_MAGIC, ZIP_MAGIC = (b"CDF\1", b"CDF\2"), b"\x89HDF\r\n\x1a\n", b"PK\x03\x04"
"""First bytes of NetCDF 3, HDF5 and ZIP (NPZ) files."""

UNSUPPORTED_MAGIC: Mapping[bytes, str] = {
    b"\x93NUMPY": "an array of numpy: give the table as CSV (idtracker.ai: trajectories.csv or trajectories.h5)",
    b"PAR1": "a Parquet table: save it as CSV",
    b"SQLite format 3": "a database: save the table as CSV (FastTrack: its tracking.txt)",
    b"\x80": "a pickle of Python, which can do anything: save the tracks as CSV",
}
"""First bytes of files that are not read, and what to give in their place."""

INFINITE_PATTERN = re.compile(r"(?<=,)-?inf(?=[,\n])")
"""TRex's word for an unknown number."""

MAX_BYTES = 1_000_000_000
"""Most bytes that the arrays of an archive may have when unpacked."""

MAX_NUMBERS = 200_000_000
"""Most numbers of an array."""

UNIT_ATTRIBUTES = ("space_unit", "unit")
"""Attributes of places that state their unit: movement's, and walkergen's."""

PACKING_ATTRIBUTES = ("scale_factor", "add_offset")
"""Attributes of arrays whose stored numbers are scaled or shifted."""

LIKELIHOOD_PROGRAMS = ("DeepLabCut", "LightningPose")
"""Programs whose confidence of a part is a likelihood."""


class ArrayFile(NamedTuple):
    """Contents of a file of arrays."""

    values: Mapping[str, Array]
    dimensions: Mapping[str, tuple[str, ...]]
    """Names of the dimensions of each array, as far as the file has them."""
    words: Mapping[str, list[str]]
    """Arrays of text, by their names."""
    attributes: Mapping[str, Mapping[str, str]]
    """Attributes of each array, and of the file by the name ""."""


def read_arrays(path: Path, lane: bool) -> Source | None:
    """Read the rows of a NetCDF or HDF5 file; None for text, and for NPZ (see `npz_lines`). Raises InputError."""
    begin = file_reading.read_start(path, 16, columns.FORMAT_NAME)
    for first, what in UNSUPPORTED_MAGIC.items():
        if begin.startswith(first):
            raise InputError(f"{path}: is {what}")
    if begin.startswith(ZIP_MAGIC) and not _is_npz(path):
        raise InputError(f"{path}: is a spreadsheet or another archive: save the table as CSV")
    if begin.startswith(NETCDF_MAGIC):
        with file_reading.translate_library_errors(str(path), "NetCDF"):
            return _from_movement(path, _read_netcdf(path), lane)
    if begin.startswith(HDF5_MAGIC):
        extras.require("poses", f"{path}: HDF5")
        with file_reading.translate_library_errors(str(path), "HDF5"):
            return _read_hdf5(path, lane)
    return None


def npz_lines(path: Path) -> Iterator[str] | None:
    """Return the columns of an NPZ archive as lines of a CSV file; None for another file. Raises InputError.

    Columns are the arrays as long as that of frames or times; TRex names those of places without their unit.
    """
    if not file_reading.read_start(path, 4, columns.FORMAT_NAME).startswith(ZIP_MAGIC):
        return None
    with file_reading.translate_library_errors(str(path), "NPZ"), zipfile.ZipFile(path) as archive:
        if sum(entry.file_size for entry in archive.infolist()) > MAX_BYTES:
            raise InputError(f"{path}: more than {MAX_BYTES} bytes when unpacked. Is it the right file?")
        with np.load(path, allow_pickle=False) as archived:
            values = {name: np.asarray(archived[name]) for name in archived.files}
    time_name = next((name for name in ("frame", "time", "t_s") if name in values), None)
    if time_name is None:
        raise InputError(
            f"{path}: no array frame, time or t_s; arrays seen: {safe_text.shorten_line(', '.join(values))[:80]}"
        )
    kept = {name: array for name, array in values.items() if array.ndim == 1 and len(array) == len(values[time_name])}
    trex = "cm_per_pixel" in values
    names = (f"{name} (cm)" if trex and name.partition("#")[0] in ("X", "Y") else name for name in kept)
    rows = zip(*(array.tolist() for array in kept.values()), strict=True)
    return chain([",".join(names) + "\n"], (",".join(map(str, row)) + "\n" for row in rows))


def _is_npz(path: Path) -> bool:
    """Return whether a file is an archive of NumPy arrays."""
    try:
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
    except (zipfile.BadZipFile, NotImplementedError, ValueError, OSError):
        return False
    return bool(names) and all(name.endswith(".npy") for name in names)


def _read_netcdf(path: Path) -> ArrayFile:
    """Return the arrays of a NetCDF 3 file, which stores text as letters along a separate dimension."""
    from scipy.io import netcdf_file

    file = netcdf_file(io.BytesIO(file_reading.read_bytes(path)), mmap=False)
    attributes = {"": _decode_attributes(file._attributes)}
    values, dimensions, words = {}, {}, {}
    for name, variable in file.variables.items():
        data = np.array(variable[:])
        attributes[name] = _decode_attributes(variable._attributes)
        dimensions[name] = tuple(variable.dimensions)
        if data.dtype.kind == "S":
            words[name] = _decode_texts(data)
        else:
            values[name] = data.astype(float)
    return ArrayFile(values, dimensions, words, attributes)


def _decode_texts(data: npt.NDArray[Any]) -> list[str]:
    """Return the texts of an array of bytes or objects, in which a row is one text or its letters."""
    rows = data.reshape(len(data), -1).tolist()
    whole = (row[0] if len(row) == 1 else b"".join(row) for row in rows)
    return [text.rstrip(b"\0").decode() if isinstance(text, bytes) else str(text) for text in whole]


def _decode_attributes(attributes: Mapping[str, Any]) -> dict[str, str]:
    """Return attributes with their values as text."""
    return {name: value.decode() if isinstance(value, bytes) else str(value) for name, value in attributes.items()}


def _read_hdf5(path: Path, lane: bool) -> Source:
    """Read the rows of an HDF5 file of a known layout. Raises InputError for others."""
    import h5py

    with h5py.File(path, "r") as file:
        names = set(file)
        if "position" in names:
            return _from_movement(path, _read_datasets(path, file, names), lane)
        if {"tracks", "node_names", "track_names"} <= names:
            return _from_sleap(_read_datasets(path, file, {"tracks", "node_names", "track_names"}))
        if "trajectories" in names and "frames_per_second" in file.attrs:
            return _from_idtracker(_read_datasets(path, file, {"trajectories"}), float(file.attrs["frames_per_second"]))
        fault = "is an HDF5 file of a layout that is not read"
        if {"frames", "instances"} <= names:
            fault = "is SLEAP's project: give its analysis CSV or HDF5 (File, Export)"
        elif any("pandas_type" in file[name].attrs for name in names):
            fault = "is a table of pandas: save it as CSV (DeepLabCut: save_as_csv, or analyze_videos_converth5_to_csv)"
        raise InputError(f"{path}: {fault}; it holds {safe_text.shorten_line(', '.join(sorted(names)))[:60]}")


def _read_datasets(path: Path, file: Any, names: set[str]) -> ArrayFile:
    """Return the contents of the named data sets of an open HDF5 `file`; `path` is for messages."""
    values, dimensions, words = {}, {}, {}
    attributes = {"": _decode_attributes(dict(file.attrs))}
    for name in names:
        data = file[name]
        if not hasattr(data, "shape") or not data.shape:
            continue
        if data.size > MAX_NUMBERS:
            raise InputError(
                f"{path}: {safe_text.shorten_line(name)[:30]} has {data.size} numbers. At most {MAX_NUMBERS}"
            )
        dimensions[name] = _dimension_names(file, data)
        attributes[name] = _decode_attributes(
            {key: data.attrs[key] for key in (*UNIT_ATTRIBUTES, *PACKING_ATTRIBUTES) if key in data.attrs}
        )
        if data.dtype.kind in "OS":
            words[name] = _decode_texts(data[:])
        else:
            values[name] = data[:].astype(float)
    return ArrayFile(values, dimensions, words, attributes)


def _dimension_names(file: Any, data: Any) -> tuple[str, ...]:
    """Return the names of a data set's dimensions, from NetCDF's dimension scales or the attribute of sleap-io."""
    if "DIMENSION_LIST" in data.attrs:  # h5py's own walk along the scales does not end in a damaged file
        return tuple(file[scales[0]].name.rpartition("/")[2] for scales in data.attrs["DIMENSION_LIST"])
    return tuple(json.loads(data.attrs.get("dims", "[]")))


def _reorder_dimensions(arrays: ArrayFile, name: str, order: tuple[str, ...]) -> Array:
    """Return a named array with its dimensions (singular or plural) in this order; missing ones have length 1."""
    present = [dimension.removesuffix("s") for dimension in arrays.dimensions[name]]
    if not set(present) <= set(order):
        raise ValueError(f"{name} has the dimensions {', '.join(present)}")
    array = arrays.values[name].transpose([present.index(dimension) for dimension in order if dimension in present])
    return np.expand_dims(array, [at for at, dimension in enumerate(order) if dimension not in present])


def _from_movement(path: Path, arrays: ArrayFile, lane: bool) -> Source:
    """Return the rows of a file in the layout of the package movement, with poses or boxes around walkers."""
    words = {name.removesuffix("s"): texts for name, texts in arrays.words.items()}
    if not {"position", "time"} <= set(arrays.values) or not {"x", "y"} <= set(words.get("space", ())):
        raise InputError(f"{path}: no position in x and y with its time, as movement's data sets have")
    attributes = arrays.attributes["position"]
    if set(PACKING_ATTRIBUTES) & set(attributes):
        raise InputError(f"{path}: position is packed: save it without {' and '.join(PACKING_ATTRIBUTES)}")
    places = _reorder_dimensions(arrays, "position", ("individual", "keypoint", "space", "time"))
    if arrays.attributes[""].get("source_software") in LIKELIHOOD_PROGRAMS and "confidence" in arrays.values:
        confidence = _reorder_dimensions(arrays, "confidence", ("individual", "keypoint", "time"))
        places = np.where(confidence[:, :, None] < pose_tables.MIN_LIKELIHOOD, np.nan, places)
    x, y = (places[:, :, words["space"].index(axis)] for axis in "xy")
    individuals = words.get("individual", [])
    unit = next((attributes[name] for name in UNIT_ATTRIBUTES if name in attributes), "")
    source = arrays.attributes[""]
    if source.get("source_software", "").startswith(WALKERGEN_PROGRAM) and "heading" in arrays.values and unit == "mm":
        return _from_walkergen(arrays, x[:, 0], y[:, 0], individuals, lane)
    clock, second = ("time", "s") if source.get("time_unit") == "seconds" else ("frame", "")
    named = {axis: NamedColumn("position", track_columns.canonical_unit(unit) if unit else PIXEL) for axis in "xy"}
    named |= {clock: NamedColumn("time", second), "theta": NamedColumn("theta", "rad")}
    return _from_parts(x, y, words.get("keypoint", []), individuals, {clock: arrays.values["time"]}, named, "movement")


def _from_parts(
    x: Array,
    y: Array,
    parts: Sequence[str],
    individuals: Sequence[str],
    times: Mapping[str, Array],
    named: Mapping[str, NamedColumn],
    program: str,
) -> Source:
    """Return the rows of walkers whose parts are at x and y, shape (walkers, parts, times).

    `parts` and `individuals` are names, empty without any. `times`: one array, under frame or time; `named`: names and
    units of columns.
    """
    ((clock, ticks),) = times.items()
    table = Columns({}, np.arange(1, len(ticks) + 1), {})
    if not parts:
        walkers = list(zip(x[:, 0], y[:, 0], strict=True))
        long = track_columns.to_long_table(table, clock, ticks, walkers, range(len(x)))
        return Source(long, named, program, y_down=True, notes=track_columns.format_labels(individuals))
    bodies = {
        individual: {part: pose_tables.Part(x[n, k], y[n, k]) for k, part in enumerate(parts)}
        for n, individual in enumerate(individuals or map(str, range(len(x))))
    }
    return pose_tables.from_bodies(table, clock, ticks, bodies, named, program)


def _from_walkergen(arrays: ArrayFile, x: Array, y: Array, individuals: Sequence[str], lane: bool) -> Source:
    """Return the rows of walkergen's own runs; x and y: shape (walkers, times). In a lane y stays 0."""
    theta = _reorder_dimensions(arrays, "heading", ("individual", "time"))
    table = Columns({}, np.arange(1, x.shape[-1] + 1), {})
    runs = [individual.rpartition("_")[2] for individual in individuals]
    are_numbered = len(runs) == len(x) and all(map(str.isdigit, runs))
    numbers = [float(run) for run in (runs if are_numbered else range(len(x)))]
    walkers = list(zip(x, y, theta, strict=True))
    long = track_columns.to_long_table(table, "time", arrays.values["time"], walkers, numbers)
    if lane or not (np.nan_to_num(y).any() or np.nan_to_num(theta).any()):
        long = long._replace(values={name: long.values[name] for name in ("time", "x", "particle")})
    return Source(long, {"time": NamedColumn("time", "s"), "x": NamedColumn("position", "mm")}, WALKERGEN_PROGRAM)


def _from_sleap(arrays: ArrayFile) -> Source:
    """Read the rows of SLEAP's analysis file. By default its arrays have the order of its reader in MATLAB."""
    arrays = arrays._replace(dimensions={"tracks": arrays.dimensions["tracks"] or ("track", "xy", "node", "frame")})
    x, y = _reorder_dimensions(arrays, "tracks", ("xy", "track", "node", "frame"))
    frames = {"frame": np.arange(x.shape[-1], dtype=float)}
    return _from_parts(
        x, y, arrays.words["node_names"], arrays.words["track_names"], frames, pose_tables.PIXEL_COLUMNS, "SLEAP"
    )


def _from_idtracker(arrays: ArrayFile, fps: float) -> Source:
    """Return the rows of idtracker.ai's trajectories, shape (frames, animals, 2); `fps`: frames per second."""
    x, y = arrays.values["trajectories"].transpose(2, 1, 0)[:, :, None]
    times = {"time": np.arange(x.shape[-1]) / fps}
    named = {axis: NamedColumn("trajectories", PIXEL) for axis in "xy"}
    named["time"] = NamedColumn("frames_per_second", "s")
    return _from_parts(x, y, (), (), times, named, "idtracker.ai")
