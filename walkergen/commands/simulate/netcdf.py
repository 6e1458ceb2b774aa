"""Tracks as a NetCDF file that xarray opens, in the layout of movement's data sets of poses (since its version 0.17).

Positions have the dimensions time, space, keypoint and individual. Attributes give the software and the unit of time.
Its version 3 needs no library of its own; `xarray.open_dataset` reads it.
"""

import io
from collections.abc import Sequence
from typing import Any

import numpy as np

from walkergen import __version__
from walkergen.core.numerics import Array


def pack_poses(times: Array, places: Array, headings: Array, names: Sequence[str]) -> bytes:
    """Pack the centres of walkers: times (s), shape (n,); places (mm), shape (n, 2, k); headings (rad), shape (n, k).

    Values are NaN while a walker is not visible.
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
    for name, own, values in (
        ("time", ("time",), times),
        ("position", dimensions, places[:, :, None, :]),
        ("confidence", ("time", *dimensions[2:]), np.where(np.isfinite(places[:, :1]), 1.0, np.nan)),
        ("heading", ("time", "individual"), headings),
    ):
        file.createVariable(name, "d", own)[:] = values
    file.variables["position"].unit, file.variables["heading"].unit = "mm", "rad"
    file.flush()
    return stream.getvalue()


def _write_names(file: Any, name: str, words: Sequence[str]) -> None:
    """Write the names along a dimension, as xarray writes text."""
    width = max(len(word.encode()) for word in words)
    file.createDimension(f"{name}_letters", width)
    variable = file.createVariable(name, "c", (name, f"{name}_letters"))
    variable[:] = np.array([list(word.encode().ljust(width, b"\0")) for word in words], np.uint8).view("S1")
    variable._Encoding = "utf-8"
