"""Request of `analyse`."""

import math
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import BeforeValidator, Field

from walkergen import film_fields, request
from walkergen.core.errors import InputError
from walkergen.core.files.progress import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.core.dish import Dish
    from walkergen.guests.track.analyse.report import AnalysisReport

UNNAMED_TRACKS = "tracks"
"""Name of tracks without a file, for messages and titles."""


class AnalyseRequest(request.Request):
    """Measure speed, persistence and spread from tracks, filmed or simulated.

    A film is a table with columns frame or t_s, x, y and optionally particle and theta (rad) or theta_deg, counted
    from x toward y. Files of TrackMate, DeepLabCut, SLEAP, movement, idtracker.ai, TRex, FastTrack, MTrackJ and
    Tracker are read too. Units are in the names (x_mm, "X (cm)"), or are given with --fps, --mm-per-px and --unit. A
    simulation writes its tracks with the option trajectory. Tracks at several plate speeds need a column
    plate_speed_mm_s. Several files, such as one for each animal, are one recording with one clock. Python also
    accepts the result of track() or simulate().trajectory(), a frame of pandas, or a mapping of columns.

    With --dish the walkers are a crowd. Its packing, clusters, order and fluctuations are measured, with errors from
    independent runs (--run), and no single walker.

    Notes
    -----
    The scale's own error is part of the errors only if it is given, as in mm_per_px="0.05±0.001". In Python no files
    are written without a folder in `out`.

    Examples
    --------
    >>> import walkergen as wg
    >>> tracks = wg.simulate(tilt=10, seconds=1, runs=4).trajectory(rate_hz=50)
    >>> found = wg.analyse(tracks)
    >>> 30 < found.speed.value < 90  # mm/s
    True
    """

    by_position: ClassVar = ("tracks",)

    tracks: Annotated[
        Any,
        BeforeValidator(film_fields.parse_tracks),
        Flag("Files of tracks of one recording.", "TRACKS.csv", takes="Any", argument=True, repeats=True),
    ]
    fps: film_fields.Fps = None
    mm_per_px: film_fields.MmPerPx = None
    unit: film_fields.Unit = None
    y_down: film_fields.YDown = False
    lane: Annotated[bool, Flag("Ignore y: the walkers ran in a lane along x.")] = False
    lag_ms: Annotated[
        float | None, Flag("Lag of displacements along and across the body, ms; 40 by default.", "MS")
    ] = None
    descent_deg: Annotated[
        float | None,
        Field(ge=-360, le=360),
        Flag("Direction of the plate's descent, from x toward y; adds self-alignment.", "DEG"),
    ] = None
    arena: Annotated[
        str | None,
        Flag(
            "Walls about single walkers, mm: disc:120, ring:160,60 or rectangle:200x100, or open; found by default.",
            "ARENA",
        ),
    ] = None
    dish: Annotated[
        str | None,
        Flag(
            "Measure the walkers as a crowd in a dish: disc:120, ring:160,60, rectangle:200x100 or periodic:150, mm.",
            "DISH",
        ),
    ] = None
    body: Annotated[
        str | None,
        request.AsText,
        Flag("Outline of a walker: 24x8, or 20 of a disc, mm, or a walker's name.", "MM", takes="str | float | None"),
    ] = None
    middle: Annotated[str | None, Flag("Place of the dish's middle, mm; 0,0 by default.", "X,Y")] = None
    runs: Annotated[
        list[Path],
        BeforeValidator(film_fields.parse_paths),
        Flag("Tracks of another run of the same crowd.", "TRACKS.csv", "--run", takes="Iterable[Name]", repeats=True),
    ] = []
    pictures: request.Pictures = True
    out: request.Out = None

    def run(self, progress: Progress) -> "AnalysisReport":
        """Return the report of single walkers or, with `dish`, of a crowd, whose report has another class."""
        if isinstance(self.tracks, list) and self.tracks and all(isinstance(path, Path) for path in self.tracks):
            return self._measure_files(self.tracks, progress)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / UNNAMED_TRACKS
            path.write_text(_to_csv(self.tracks), encoding="utf-8")
            try:
                return self._measure_files([path], progress)
            except InputError as error:  # the user did not name that file
                raise InputError(error.text.replace(str(path), UNNAMED_TRACKS), "tracks") from None

    def _parse_walls(self) -> "Dish | None":
        """Return the walls of the setting `arena` as a dish; None without it."""
        from walkergen.core import dish

        return None if self.arena is None else dish.OPEN_GROUND if self.arena == "open" else dish.parse_dish(self.arena)

    def _measure_files(self, paths: list[Path], progress: Progress) -> "AnalysisReport":
        """Return the report of the tracks of one recording, as single walkers or as a crowd."""
        from walkergen.core.files import output

        if self.dish is None:
            self.check_unset("has an effect only with ‹dish›", "body", "middle", "runs")
        else:
            self.check_unset("works only for single walkers, not with ‹dish›", "lag_ms", "arena", "descent_deg")
        units = film_fields.units(self.fps, self.mm_per_px, self.y_down, self.unit, self.lane)
        folder = output.result_folder(paths[0], self.out, "analysis") if self.out or self._shell else None
        if self.dish is None:
            from walkergen.guests.track.analyse import make

            lag_s = None if self.lag_ms is None else 1e-3 * self.lag_ms
            descent = None if self.descent_deg is None else math.radians(self.descent_deg)
            if descent is not None and self.y_down:
                descent = -descent  # as all angles of the file
            return make.analyse(paths, units, lag_s, self._parse_walls(), descent, folder, self.pictures, progress)
        from walkergen.guests.crowd import film_analysis

        crowd = film_analysis.parse_crowd(self.dish, self.body, self.middle, self.runs)
        return film_analysis.analyse(paths, units, crowd, folder, self.pictures, progress)  # type: ignore[return-value]


def _to_csv(tracks: Any) -> str:
    """Return a report, table, pandas frame or mapping of columns as CSV text, with every digit. Raises InputError."""
    import numpy as np

    from walkergen.core.files.tables import csv_text
    from walkergen.files.report import Report, Table

    if isinstance(tracks, Report):
        tracks = tracks.table
    if isinstance(tracks, Table):
        return tracks.csv()
    columns = tracks
    if not isinstance(columns, Mapping) and hasattr(columns, "to_dict"):
        columns = columns.to_dict("list")
    if not isinstance(columns, Mapping):
        raise InputError(
            f"{UNNAMED_TRACKS}: {type(tracks).__name__} seen: must be the path of a CSV file, a frame of "
            "pandas, or columns by name",
            "tracks",
        )
    lists = {str(name): np.asarray(values).tolist() for name, values in columns.items()}
    if len({len(values) for values in lists.values()}) > 1:
        lengths = ", ".join(f"{name} {len(values)}" for name, values in lists.items())
        raise InputError(f"{UNNAMED_TRACKS}: columns must be of one length, seen {lengths}", "tracks")
    return csv_text(list(lists), zip(*lists.values(), strict=True))
