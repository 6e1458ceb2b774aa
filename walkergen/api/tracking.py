"""Tracks of a film, as the command `track` makes them."""

import os
from pathlib import Path

from walkergen.files import output
from walkergen.files.measured import measured
from walkergen.files.progress import Progress, silent
from walkergen.track.film import lens as lenses
from walkergen.track.film import make
from walkergen.track.film.report import TrackReport
from walkergen.track.film.result import Options


def track(
    film: str | os.PathLike[str],
    *,
    mm_per_px: float | str | None = None,
    length: float | str | None = None,
    fps: float | None = None,
    frames: tuple[int, int | None] = (0, None),
    region: tuple[int, int, int, int] | None = None,
    walkers: str | None = None,
    threshold: float | None = None,
    width: float | None = None,
    heading: str = "motion",
    markers: str | None = None,
    marker_mm: float | str | None = None,
    lens: str | os.PathLike[str] | None = None,
    folder: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
) -> TrackReport:
    """Track walkers in a film from above; give `mm_per_px`, or the `length` of a walker in mm.

    Either may bear its standard error, as "0.05±0.001", which then goes with every length.
    `fps` is the rate at which it was filmed, if it plays slower; `frames` the first and the one
    after the last; `region` left, top, width and height, `width` a walker's, pixels; `walkers`
    "dark" or "light"; `heading` by "motion" or "mark". With `markers` "aruco" the caps' markers,
    `marker_mm` wide (7.2), tell all but `fps`, `frames`, `region` and `lens`, a JSON file of
    OpenCV's calibration of a lens that bends. Tracks and picture are
    written into the `folder`, by default out/NAME/track; `analyse` takes what this returns. Needs
    the extra film. Raises InputError.
    """
    path = Path(film)
    target = output.results(path, None, "track") if folder is None else Path(folder)
    scale, scale_se = measured(mm_per_px, "mm_per_px")
    long, long_se = measured(length, "length")
    side, side_se = measured(marker_mm, "marker_mm")
    options = Options(
        mm_per_px=scale,
        mm_per_px_se=scale_se,
        length_mm=long,
        length_se_mm=long_se,
        fps=fps,
        frames=frames,
        region=region,
        walkers=walkers,
        threshold=threshold,
        width_px=width,
        heading=heading,
        lens=None if lens is None else lenses.read(Path(lens)),
        markers=markers,
        marker_mm=side,
        marker_se_mm=side_se,
    )
    return make.track(path, options, target, progress or silent)
