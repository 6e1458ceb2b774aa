"""Tracks of a film, as the command `track` makes them."""

import os
from collections.abc import Iterator
from pathlib import Path

from walkergen.api.analysing import Analysis, analyse
from walkergen.api.table import Result, Table
from walkergen.files import output
from walkergen.files.measured import measured
from walkergen.files.progress import Progress, silent
from walkergen.jobs.track import make, tables


class Tracking(Result):
    """Walkers that were tracked in a film; look at `.picture` before you believe the numbers."""

    def __init__(self, found: make.Tracked) -> None:
        self.found = found
        """Everything that was found, walker by walker."""

    @property
    def picture(self) -> Path:
        """Picture of what was found, to be looked at."""
        return self.found.folder / make.PICTURE

    @property
    def warnings(self) -> tuple[str, ...]:
        """What went wrong, each with the number of frames."""
        return tuple(tables.warnings(self.found))

    @property
    def table(self) -> Table:
        """Tracks as tracks.csv has them: trackpy's columns in mm and rad, then t_s, x_mm ..."""
        columns = zip(*make.rows(self.found), strict=True)
        return Table(
            {name: list(values) for name, values in zip(make.COLUMNS, columns, strict=True)},
            self.found.film.path.name, self.warnings,
        )  # fmt: skip

    def rows(self) -> Iterator[tuple[str, str]]:
        """Names and values in words."""
        for number, one in enumerate(self.found.walkers):
            frames = one.seen.frames
            path = f"path {self.found.path_mm(one):.3g} mm, ends {one.net_mm:.3g} mm apart"
            told = f"{len(frames)} frames from {frames[0]} to {frames[-1]}, {path}"
            yield f"walker {number}", f"{told}; heading: {one.headed.how}"
        for note in tables.notes(self.found):
            yield "note", note
        for warning in self.warnings:
            yield "warning", warning
        yield "look at", str(self.picture)

    def analyse(self, *, lane: bool = False, lag_ms: float | None = None) -> Analysis:
        """Measure speed, persistence and spread of the tracks, as `wg.analyse` does."""
        return analyse(self.found.folder / make.TRACKS, lane=lane, lag_ms=lag_ms)


def track(
    film: str | os.PathLike[str], *, mm_per_px: float | str | None = None,
    length: float | str | None = None,
    fps: float | None = None, frames: tuple[int, int | None] = (0, None),
    region: tuple[int, int, int, int] | None = None, walkers: str | None = None,
    threshold: float | None = None, width: float | None = None, heading: str = "motion",
    folder: str | os.PathLike[str] | None = None, progress: Progress | None = None,
) -> Tracking:  # fmt: skip
    """Track walkers in a film from above; give `mm_per_px`, or the `length` of a walker in mm.

    Either may bear its standard error, as "0.05±0.001", which then goes with every length.
    `fps` is the rate at which it was filmed, if it plays slower; `frames` the first and the one
    after the last; `region` left, top, width and height, `width` a walker's, pixels; `walkers`
    "dark" or "light"; `heading` by "motion" or "mark". Tracks and picture are written into the
    `folder`, by default out/NAME/track. Needs the extra film. Raises InputError.
    """
    path = Path(film)
    scale, scale_se = measured(mm_per_px, "mm_per_px")
    long, long_se = measured(length, "length")
    wish = make.Options(
        mm_per_px=scale, mm_per_px_se=scale_se, length_mm=long, length_se_mm=long_se, fps=fps,
        frames=frames, region=region, walkers=walkers, threshold=threshold,
        width_px=width, heading=heading,
    )  # fmt: skip
    target = output.results(path, None, "track") if folder is None else Path(folder)
    return Tracking(make.track(path, wish, target, progress or silent))
