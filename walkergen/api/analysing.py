"""Motion measured from tracks, as the command `analyse` measures it."""

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from walkergen.analysis.track_files import Units
from walkergen.errors import InputError
from walkergen.files.measured import measured
from walkergen.files.progress import Progress, silent
from walkergen.files.report import Report, Table
from walkergen.files.tables import csv_text
from walkergen.track.analyse import make
from walkergen.track.analyse.report import AnalysisReport

NAME = "tracks"
"""Name by which messages and titles call tracks that come from no file."""


def analyse(
    tracks: Any,
    *,
    fps: float | None = None,
    mm_per_px: float | str | None = None,
    y_down: bool = False,
    lane: bool = False,
    lag_ms: float | None = None,
    folder: str | os.PathLike[str] | None = None,
    pictures: bool = True,
    progress: Progress | None = None,
) -> AnalysisReport:
    """Measure speed, persistence and spread from tracks, filmed or simulated.

    `tracks` is the path of a CSV file, what `track(...)` or `simulate(...).trajectory()` returns, a
    frame of pandas, or columns by name: trackpy's (frame, particle, x, y, theta), with `fps`
    (frames per second) and `mm_per_px` (0.05, or with its standard error "0.05±0.001"), or
    walkergen's. With a `folder`, tables and pictures (unless these are False) are written there.
    Raises InputError.
    """
    rate = None if fps is None else float(fps)
    scale, error = measured(mm_per_px, "mm_per_px")
    units, tell = Units(rate, scale, y_down, lane, error), progress or silent
    lag_s = None if lag_ms is None else 1e-3 * lag_ms
    target = None if folder is None else Path(folder)
    if isinstance(tracks, (str, os.PathLike)):
        return make.analyse(Path(tracks), units, lag_s, target, pictures, tell)
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / NAME
        path.write_text(_csv_of(tracks), encoding="utf-8")
        try:
            return make.analyse(path, units, lag_s, target, pictures, tell)
        except InputError as error:  # a person knows nothing of that file
            raise InputError(str(error).replace(str(path), NAME)) from None


def _csv_of(tracks: Any) -> str:
    """Columns as the text of a CSV file, with every digit. Raises InputError."""
    if isinstance(tracks, Report):
        tracks = tracks.table
    if isinstance(tracks, Table):
        return tracks.csv()
    columns = tracks
    if not isinstance(columns, Mapping) and hasattr(columns, "to_dict"):
        columns = columns.to_dict("list")
    if not isinstance(columns, Mapping):
        raise InputError(
            f"{NAME}: {type(tracks).__name__} seen: must be the path of a CSV file, a frame of "
            "pandas, or columns by name"
        )
    lists = {str(name): np.asarray(values).tolist() for name, values in columns.items()}
    if len({len(values) for values in lists.values()}) > 1:
        lengths = ", ".join(f"{name} {len(values)}" for name, values in lists.items())
        raise InputError(f"{NAME}: columns must be of one length, seen {lengths}")
    return csv_text(list(lists), zip(*lists.values(), strict=True))
