"""Tracking of a film: read, look, find, link, head; writes tracks.csv and check.png."""

import math
from collections.abc import Sequence
from itertools import chain, islice, pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.errors import InputError
from walkergen.files.output import Folder
from walkergen.files.progress import Progress
from walkergen.files.tables import csv_text
from walkergen.jobs.track import camera, doubts, heading, link
from walkergen.jobs.track import film as films
from walkergen.jobs.track import look as looks
from walkergen.jobs.track.camera import Shake
from walkergen.jobs.track.film import Clock, Film, Grey
from walkergen.jobs.track.find import Blob, find
from walkergen.jobs.track.heading import Headed
from walkergen.jobs.track.link import Linked, Seen
from walkergen.jobs.track.look import Look

Array = npt.NDArray[np.float64]

COLUMNS = (
    "frame", "particle", "x", "y", "theta", "t_s", "x_mm", "y_mm", "theta_rad", "mm_per_px",
    "mm_per_px_se",
)  # fmt: skip
"""Columns of tracks.csv: trackpy's names, here in mm and rad, then walkergen's own.

The last two are the scale, by which places have been multiplied, and its standard error, blank when
that is not known: every length measured from the tracks is off by them.
"""

TRACKS, PICTURE = "tracks.csv", "check.png"
"""Files of tracks, and to check them by."""

SAMPLES = 8
"""Number of frames, from the first on, that tell the look of a film."""

SHIFTS = 200
"""Number of frames, about, that tell whether the camera shakes."""

SIDES: tuple[str, ...] = ("dark", "light")
"""How walkers may differ from the ground."""

EDGES = 2.5
"""Standard error of a length in a picture, both ends together, pixels: blur, a dark rim, a shadow.
Films that are drawn err by less."""

STILL = 0.02
"""Way from frame to frame, pixels, below which nothing moves but by the film's compression."""

LEAST, LARGEST = 1e-6, 1e9


class Options(NamedTuple):
    """Wishes of a person; None is what the film tells."""

    mm_per_px: float | None = None
    mm_per_px_se: float | None = None
    """Standard error of `mm_per_px`; None when it is not known."""
    length_mm: float | None = None
    """Length of a walker; either this or `mm_per_px` is given."""
    length_se_mm: float | None = None
    """Standard error of `length_mm`, beside that of its image."""
    fps: float | None = None
    """Frames per second at which the film was taken."""
    frames: tuple[int, int | None] = (0, None)
    """First frame, and the one after the last."""
    region: tuple[int, int, int, int] | None = None
    """Left and upper edge, width and height of the part that is looked at, pixels."""
    walkers: str | None = None
    """One of `SIDES`."""
    threshold: float | None = None
    """Contrast beyond which a pixel is a walker's, steps of 255."""
    width_px: float | None = None
    """Width of a walker, the shorter side."""
    heading: str = "motion"
    """One of `heading.BY`."""


class Walker(NamedTuple):
    """One tracked walker."""

    seen: Seen
    position: Array
    """Places from the frame's lower left corner, shape (n, 2), mm, y up."""
    headed: Headed

    @property
    def net_mm(self) -> float:
        """Distance from its first place to its last, mm; a full circle has none."""
        return math.dist(self.position[0], self.position[-1])


class Tracked(NamedTuple):
    """What was found in a film, and where it was written."""

    film: Film
    options: Options
    look: Look
    linked: Linked
    walkers: Sequence[Walker]
    looked: int
    """Frames looked at."""
    still: int
    """Frames in which nothing has moved since the one before."""
    clock: Clock
    mm_per_px: float
    mm_per_px_se: float | None
    """Standard error of `mm_per_px`; None where it was given without."""
    shake: Shake
    folder: Path

    @property
    def jitter_mm(self) -> float:
        """Error of a place that changes from frame to frame, mm; NaN for too few frames."""
        return doubts.jitter([self._unbroken(one) for one in self.walkers])

    def path_mm(self, walker: Walker) -> float:
        """Length of a walker's path, mm, its jitter left out."""
        return doubts.path(walker.position, 0.0 if math.isnan(self.jitter_mm) else self.jitter_mm)

    def _unbroken(self, walker: Walker) -> tuple[Array, Array]:
        """Times and places of all frames from a walker's first to its last; NaN where lost."""
        first, last = walker.seen.frames[[0, -1]]
        places = np.full((last - first + 1, 2), np.nan)
        places[walker.seen.frames - first] = walker.position
        return self.clock.times[first : last + 1], places


def check(options: Options) -> None:
    """Raise InputError for wishes that contradict each other or are out of range."""
    if (options.mm_per_px is None) == (options.length_mm is None):
        raise InputError(
            "the scale: give either --mm-per-px, millimetres per pixel, or --length, the length of "
            "a walker in mm"
        )
    for flag, value, most in (
        ("--mm-per-px", options.mm_per_px, LARGEST), ("--length", options.length_mm, LARGEST),
        ("--fps", options.fps, LARGEST), ("--threshold", options.threshold, 255.0),
        ("--width", options.width_px, 1e5),
    ):  # fmt: skip
        if value is not None and not LEAST <= value <= most:
            raise InputError(f"{flag} {value:g}: must be a number in {LEAST:g}..{most:g}")
    if options.walkers is not None and options.walkers not in SIDES:
        raise InputError(f"--walkers {options.walkers[:30]!r}: must be one of {', '.join(SIDES)}")
    if options.heading not in heading.BY:
        known = ", ".join(heading.BY)
        raise InputError(f"--heading {options.heading[:30]!r}: must be one of {known}")
    first, last = options.frames
    if first < 0 or (last is not None and last <= first):
        raise InputError(
            f"--frames {first}:{'' if last is None else last}: counts from 0, the first before the "
            "last: 25:100, or 25: up to the end"
        )


def track(path: Path, options: Options, folder: Path, progress: Progress) -> Tracked:
    """Track the walkers of a film and write tracks.csv, check.png and manifest.json.

    Raises InputError, before anything is written, when the film cannot be read or no walker is
    found in it.
    """
    films.require()
    check(options)
    film = films.about(path)
    part = _part(film, options.region)
    try:
        found = _found(film, part, options, progress)
        linked = link.link(found.blobs, options.frames[0], found.clock.fps)
    except InputError as error:
        raise error if str(path) in str(error) else InputError(f"{path}: {error}") from None
    scale, scale_se = _scale(options, linked)
    by: heading.By = "mark" if options.heading == "mark" else "motion"
    walkers = [
        Walker(one, _places(one, film, part, scale), heading.of(one, by)) for one in linked.walkers
    ]
    made = Tracked(
        film, options, found.look, linked, walkers, len(found.blobs), _still(found.blobs),
        found.clock, scale, scale_se, found.shake, folder,
    )  # fmt: skip
    _write(made, found.picture, part)
    return made


def _part(film: Film, region: tuple[int, int, int, int] | None) -> tuple[int, int, int, int]:
    """Left, top, right and bottom of what is looked at, pixels. Raises InputError."""
    left, top, width, height = region or (0, 0, film.width, film.height)
    inside = left >= 0 and top >= 0 and left + width <= film.width and top + height <= film.height
    if width < 8 or height < 8 or not inside:
        raise InputError(
            f"--region {left},{top},{width},{height}: left, top, width, height in pixels must lie "
            f"within the {film.width} x {film.height} of {film.path}, and be 8 or more wide"
        )
    return left, top, left + width, top + height


class _Found(NamedTuple):
    """What was found in a film, frame by frame."""

    picture: Grey
    """First of the frames."""
    look: Look
    blobs: list[list[Blob]]
    clock: Clock
    shake: Shake


def _found(
    film: Film, part: tuple[int, int, int, int], options: Options, progress: Progress
) -> _Found:
    left, top, right, bottom = part
    first, last = options.frames
    total = max((round(film.seconds * (film.fps or 0.0)) if last is None else last) - first, 1)
    dark = None if options.walkers is None else options.walkers == "dark"
    marked = options.heading == "mark"
    with films.play(film, first, last) as reel:
        frames = (whole[top:bottom, left:right] for _, whole in reel.frames)
        samples = list(islice(frames, SAMPLES))
        if len(samples) < 2:
            raise InputError(
                f"{len(samples)} frame{'' if len(samples) == 1 else 's'} from {first} on: at least "
                "2 are needed"
            )
        look = looks.learn(samples, dark, options.threshold, options.width_px)
        near = [blob for grey in samples for blob in find(grey, look, marked=False)]
        points = camera.fixed(samples, look, near)
        found: list[list[Blob]] = []
        shifts: list[Array] = []
        for number, grey in enumerate(chain(samples, frames)):
            found.append(find(grey, look, marked))
            if points is not None and number % max(1, total // SHIFTS) == 0:
                shifts.append(camera.shift(points, grey, found[-1]))
            progress("frames", len(found), max(total, len(found)))
        clock = films.clock(film, reel.stamps, options.fps)
    return _Found(samples[0], look, found, clock, camera.shake(shifts))


def _still(found: Sequence[Sequence[Blob]]) -> int:
    """Number of frames in which something is seen and nothing moves."""

    def still(before: Sequence[Blob], now: Sequence[Blob]) -> bool:
        if not now or len(now) != len(before):
            return False
        moved = zip(now, before, strict=True)
        return all(math.hypot(one.x - two.x, one.y - two.y) < STILL for one, two in moved)

    return sum(still(before, now) for before, now in pairwise(found))


def _scale(options: Options, linked: Linked) -> tuple[float, float | None]:
    """Millimetres per pixel, and the standard error: by blurred edges, or what a person gives."""
    if options.mm_per_px is not None:
        return options.mm_per_px, options.mm_per_px_se
    assert options.length_mm is not None
    scale = options.length_mm / linked.length
    own = (options.length_se_mm or 0.0) / options.length_mm
    return scale, scale * math.hypot(EDGES / linked.length, own)


def _places(seen: Seen, film: Film, part: tuple[int, int, int, int], scale: float) -> Array:
    """Places in mm from the lower left corner of the whole frame, y up, shape (n, 2)."""
    left, top, _, _ = part
    x, y = seen.blobs[:, 0] + left + 0.5, film.height - (seen.blobs[:, 1] + top + 0.5)
    return scale * np.column_stack([x, y])


def rows(made: Tracked) -> list[tuple[Any, ...]]:
    """Rows of tracks.csv, frame by frame."""
    rows = []
    for number, walker in enumerate(made.walkers):
        for frame, (x, y), theta in zip(
            walker.seen.frames.tolist(), walker.position.tolist(), walker.headed.theta.tolist(),
            strict=True,
        ):  # fmt: skip
            angle = None if math.isnan(theta) else theta
            place = (x, y, angle)
            scale = (made.mm_per_px, made.mm_per_px_se)
            rows.append((frame, number, *place, float(made.clock.times[frame]), *place, *scale))
    return sorted(rows, key=lambda row: row[:2])


def _write(made: Tracked, picture: Grey, part: tuple[int, int, int, int]) -> None:
    from walkergen.files import figures
    from walkergen.jobs.track import tables
    from walkergen.jobs.track.figures import check_figure

    with Folder(made.folder) as target:
        target.write(TRACKS, csv_text(COLUMNS, rows(made)).encode())
        target.write(PICTURE, figures.png(check_figure(made, picture, part)))
        target.finish(tables.facts(made))
