"""Motion measured from tracks, as the command `analyse` measures it."""

import os
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from walkergen.analysis import facts
from walkergen.analysis.estimates import UNITS, Estimate
from walkergen.analysis.motion import Motion
from walkergen.analysis.tracks import Units
from walkergen.api.table import Result, Table
from walkergen.errors import InputError
from walkergen.files.measured import measured
from walkergen.files.progress import Progress, silent
from walkergen.files.tables import csv_text
from walkergen.jobs.analyse import make, tables

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "tracks"
"""Name by which messages and titles call tracks that come from no file."""


class Analysis(Result):
    """Motion that tracks tell, each number with its error or the reason why it has none."""

    def __init__(self, found: make.Studied, title: str) -> None:
        self.found, self.title = found, title

    @property
    def motion(self) -> Motion:
        """Everything that was measured, with curves."""
        return self.found.motion

    @property
    def estimates(self) -> dict[str, Estimate]:
        """Estimates by name: value, standard error, and the reason where both are None."""
        return self.motion.estimates

    @property
    def speed(self) -> Estimate:
        """Mean speed, mm/s, with its standard error; the reason where both are None."""
        return self.estimates["speed"]

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on method and doubts, and on rows that were left out."""
        return tuple(self.found.notes)

    @property
    def table(self) -> Table:
        """Every estimate with its unit, standard error and reason, or the speed at each plate's."""
        if self.motion.by_plate_speed:
            plates, speeds = zip(*self.motion.by_plate_speed, strict=True)
            return Table({
                "plate_speed_mm_s": plates, "speed_mm_s": [one.value for one in speeds],
                "speed_se_mm_s": [one.se for one in speeds],
                "speed_scale_se_mm_s": [
                    facts.scale_se(one.value, "mm_s", self.motion) for one in speeds
                ],
            }, self.title, self.notes)  # fmt: skip
        known = [self.estimates[name] for name in UNITS]
        low, high = zip(*(one.interval(0.95) or (None, None) for one in known), strict=True)
        return Table({
            "name": list(UNITS), "unit": [tables.SHOWN.get(one, one) for one in UNITS.values()],
            "value": [one.value for one in known], "se": [one.se for one in known],
            "scale_se": [
                facts.scale_se(one.value, unit, self.motion)
                for one, unit in zip(known, UNITS.values(), strict=True)
            ],
            "low_95": low, "high_95": high, "reason": [one.reason for one in known],
        }, self.title, self.notes)  # fmt: skip

    @property
    def walkers(self) -> Table:
        """A row for each walker: its speed and turning, with the errors within its track."""
        rows = facts.of(self.motion)["walkers"]
        return Table({
            name: [row.get(name) for row in rows] for name in rows[0] if name != "refused"
        }, self.title)  # fmt: skip

    def rows(self) -> Iterator[tuple[str, str]]:
        """Names and values in words."""
        for name, unit, value, _ in tables.rows(self.motion):
            yield f"{name} ({unit})", value
        for note in self.notes:
            yield "note", note

    def figures(self) -> "dict[str, Figure]":
        """Draw all figures that the motion allows, by name: trajectories, msd, density ..."""
        from walkergen.files.figures import shown
        from walkergen.jobs.analyse.figures import figures

        drawn = figures(self.motion, self.found.tracks, self.title)
        return {name: shown(figure) for name, figure in drawn}

    def plot(self, name: str = "trajectories") -> "Figure":
        """Draw one of the figures. Raises InputError that names them."""
        drawn = self.figures()
        if name not in drawn:
            raise InputError(f"plot {name!r}: must be one of {', '.join(map(repr, drawn))}")
        return drawn[name]


def analyse(
    tracks: Any, *, fps: float | None = None, mm_per_px: float | str | None = None,
    y_down: bool = False, lane: bool = False, lag_ms: float | None = None,
    folder: str | os.PathLike[str] | None = None, pictures: bool = True,
    progress: Progress | None = None,
) -> Analysis:  # fmt: skip
    """Measure speed, persistence and spread from tracks, filmed or simulated.

    `tracks` is the path of a CSV file, a frame of pandas, a table of `simulate(...).trajectory()`,
    or columns by name: trackpy's (frame, particle, x, y, theta), with `fps` (frames per second)
    and `mm_per_px` (0.05, or with its standard error "0.05±0.001"), or walkergen's. With a
    `folder`, tables and pictures (unless these are False) are written there. Raises InputError.
    """
    rate = None if fps is None else float(fps)
    scale, error = measured(mm_per_px, "mm_per_px")
    units, tell = Units(rate, scale, y_down, lane, error), progress or silent
    lag_s = None if lag_ms is None else 1e-3 * lag_ms
    if isinstance(tracks, (str, os.PathLike)):
        return _of_file(Path(tracks), units, lag_s, folder, pictures, tell)
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / f"{NAME}.csv"
        path.write_text(_csv_of(tracks), encoding="utf-8")
        try:
            return _of_file(path, units, lag_s, folder, pictures, tell)
        except InputError as error:  # a person knows nothing of that file
            raise InputError(str(error).replace(str(path), NAME)) from None


def _of_file(
    path: Path, units: Units, lag_s: float | None, folder: str | os.PathLike[str] | None,
    pictures: bool, progress: Progress,
) -> Analysis:  # fmt: skip
    found = make.study(path, units, lag_s, progress)
    if folder is not None:
        make.write(found, path.name, units, Path(folder), pictures, progress)
    return Analysis(found, path.stem)


def _csv_of(tracks: Any) -> str:
    """Columns as the text of a CSV file, with every digit. Raises InputError."""
    columns = tracks.columns if isinstance(tracks, Table) else tracks
    if not isinstance(columns, Mapping) and hasattr(columns, "to_dict"):
        columns = columns.to_dict("list")
    if not isinstance(columns, Mapping):
        raise InputError(
            f"{NAME}: {type(tracks).__name__} seen: must be the path of a CSV file, a frame of "
            "pandas, or columns by name"
        )
    lists = {str(name): np.asarray(one).tolist() for name, one in columns.items()}
    if len({len(one) for one in lists.values()}) > 1:
        told = ", ".join(f"{name} {len(one)}" for name, one in lists.items())
        raise InputError(f"{NAME}: columns must be of one length, seen {told}")
    return csv_text(list(lists), zip(*lists.values(), strict=True))
