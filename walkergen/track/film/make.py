"""Tracking of a film: read, look, find, link, head; writes tracks.csv and check.png."""

import math
from collections.abc import Sequence
from itertools import chain, islice, pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from walkergen.errors import InputError
from walkergen.files.output import Folder
from walkergen.files.progress import Progress
from walkergen.track.film import appearance, camera, films, heading, linking, report
from walkergen.track.film.appearance import Appearance
from walkergen.track.film.blobs import Blob, find
from walkergen.track.film.camera import Shake
from walkergen.track.film.films import Clock, Film, Grey
from walkergen.track.film.lens import Lens
from walkergen.track.film.linking import Linked, Seen
from walkergen.track.film.report import TrackReport
from walkergen.track.film.result import Array, Options, Tracked, Walker

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

SMALLEST = 8
"""Smallest width and height of what is looked at, pixels."""

LEAST, LARGEST = 1e-6, 1e9


def check(options: Options) -> None:
    """Raise InputError for wishes that contradict each other or are out of range."""
    if (options.mm_per_px is None) == (options.length_mm is None):
        raise InputError(
            "the scale: give either --mm-per-px, millimetres per pixel, or --length, the length of a walker in mm"
        )
    for flag, value, most in (
        ("--mm-per-px", options.mm_per_px, LARGEST),
        ("--length", options.length_mm, LARGEST),
        ("--fps", options.fps, LARGEST),
        ("--threshold", options.threshold, 255.0),
        ("--width", options.width_px, 1e5),
    ):
        if value is not None and not LEAST <= value <= most:
            raise InputError(f"{flag} {value:g}: must be a number in {LEAST:g}..{most:g}")
    if options.walkers is not None and options.walkers not in SIDES:
        raise InputError(f"--walkers {options.walkers[:30]!r}: must be one of {', '.join(SIDES)}")
    if options.heading not in heading.BY:
        ways = ", ".join(heading.BY)
        raise InputError(f"--heading {options.heading[:30]!r}: must be one of {ways}")
    check_frames(options.frames)


def check_frames(frames: tuple[int, int | None]) -> None:
    """Raise InputError for a last frame that does not come after the first."""
    first, last = frames
    if first < 0 or (last is not None and last <= first):
        raise InputError(
            f"--frames {first}:{'' if last is None else last}: counts from 0, the first before the "
            "last: 25:100, or 25: up to the end"
        )


def track(path: Path, options: Options, folder: Path, progress: Progress) -> TrackReport:
    """Track the walkers of a film and write tracks.csv, check.png and manifest.json.

    Raises InputError, before anything is written, when the film cannot be read or no walker is
    found in it.
    """
    films.require()
    check(options)
    film = films.about(path)
    part = part_of(film, options.region)
    lens = None if options.lens is None else options.lens.of_film(film.width, film.height)
    try:
        frames = _looked_at(film, part, options, progress)
        linked = linking.link(frames.blobs, options.frames[0], frames.clock.fps)
    except InputError as error:
        raise error if str(path) in str(error) else InputError(f"{path}: {error}") from None
    straight = [_straight(seen, lens, part) for seen in linked.walkers]
    scale, scale_se = _scale(options, _length(linked, straight))
    by: heading.By = "mark" if options.heading == "mark" else "motion"
    walkers = [
        Walker(seen, own, _places(own, film, part, scale), heading.of(own, by))
        for seen, own in zip(linked.walkers, straight, strict=True)
    ]
    tracked = Tracked(
        film,
        options,
        frames.look,
        linked,
        walkers,
        len(frames.blobs),
        _still(frames.blobs),
        frames.clock,
        scale,
        scale_se,
        frames.shake,
        frames.picture,
        part,
    )
    tracks = report.of(tracked, folder)
    from walkergen.files import figures  # brings matplotlib

    with Folder(folder) as target:
        target.write(report.TRACKS, tracks.table.csv().encode())
        target.write(report.PICTURE, figures.png(tracks.figures["check"]()))
        target.finish(dict(tracks.facts))
    return tracks


def part_of(film: Film, region: tuple[int, int, int, int] | None) -> tuple[int, int, int, int]:
    """Left, top, right and bottom of what is looked at, pixels. Raises InputError."""
    if region is None and min(film.width, film.height) < SMALLEST:
        raise InputError(
            f"{film.path}: {film.width} x {film.height} pixels a frame: at least {SMALLEST} x {SMALLEST}: film larger"
        )
    left, top, width, height = region or (0, 0, film.width, film.height)
    inside = left >= 0 and top >= 0 and left + width <= film.width and top + height <= film.height
    if min(width, height) < SMALLEST or not inside:
        raise InputError(
            f"--region {left},{top},{width},{height}: left, top, width, height in pixels must lie "
            f"within the {film.width} x {film.height} of {film.path}, and be {SMALLEST} or more "
            "wide"
        )
    return left, top, left + width, top + height


class _Frames(NamedTuple):
    """What was found in a film, frame by frame."""

    picture: Grey
    """First of the frames."""
    look: Appearance
    blobs: list[list[Blob]]
    clock: Clock
    shake: Shake


def _looked_at(film: Film, part: tuple[int, int, int, int], options: Options, progress: Progress) -> _Frames:
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
                f"{len(samples)} frame{'' if len(samples) == 1 else 's'} from {first} on: at least 2 are needed"
            )
        look = appearance.learn(samples, dark, options.threshold, options.width_px)
        near = [blob for grey in samples for blob in find(grey, look, marked=False)]
        points = camera.fixed(samples, look, near)
        blobs: list[list[Blob]] = []
        shifts: list[Array] = []
        for number, grey in enumerate(chain(samples, frames)):
            blobs.append(find(grey, look, marked))
            if points is not None and number % max(1, total // SHIFTS) == 0:
                shifts.append(camera.shift(points, grey, blobs[-1]))
            progress("frames", len(blobs), max(total, len(blobs)))
        clock = films.clock(film, reel.stamps, options.fps)
    return _Frames(samples[0], look, blobs, clock, camera.shake(shifts))


def _still(frames: Sequence[Sequence[Blob]]) -> int:
    """Number of frames in which something is seen and nothing moves."""

    def still(before: Sequence[Blob], now: Sequence[Blob]) -> bool:
        if not now or len(now) != len(before):
            return False
        pairs = zip(before, now, strict=True)
        return all(math.hypot(b.x - a.x, b.y - a.y) < STILL for a, b in pairs)

    return sum(still(before, now) for before, now in pairwise(frames))


def _straight(seen: Seen, lens: Lens | None, part: tuple[int, int, int, int]) -> Seen:
    """Walker as a lens that does not bend sees it."""
    if lens is None:
        return seen
    return seen._replace(blobs=lens.straight_blobs(seen.blobs, part[:2]))


def _length(linked: Linked, straight: Sequence[Seen]) -> float:
    """Length of a walker by a lens that does not bend, pixels."""
    bent, own = (np.concatenate([walker.blobs.length for walker in walkers]) for walkers in (linked.walkers, straight))
    return linked.length * float(np.median(own / bent))


def _scale(options: Options, length: float) -> tuple[float, float | None]:
    """Millimetres per pixel by a walker's length, pixels, and the standard error: by blurred edges,
    or what a person gives.
    """
    if options.mm_per_px is not None:
        return options.mm_per_px, options.mm_per_px_se
    assert options.length_mm is not None
    scale = options.length_mm / length
    share_se = (options.length_se_mm or 0.0) / options.length_mm
    return scale, scale * math.hypot(EDGES / length, share_se)


def _places(seen: Seen, film: Film, part: tuple[int, int, int, int], scale: float) -> Array:
    """Places in mm from the lower left corner of the whole frame, y up, shape (n, 2)."""
    left, top, _, _ = part
    x, y = seen.blobs.x + left + 0.5, film.height - (seen.blobs.y + top + 0.5)
    return scale * np.column_stack([x, y])
