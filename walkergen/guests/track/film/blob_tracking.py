"""Tracking of walkers without markers: appearance, search in each frame, linking to tracks, headings."""

import math
from collections.abc import Sequence
from itertools import chain, islice, pairwise
from typing import NamedTuple

import numpy as np

from walkergen.core import Quantity
from walkergen.core.files.progress import Progress
from walkergen.core.numerics import Array
from walkergen.guests.track.film import appearance, camera, films, heading, linking
from walkergen.guests.track.film.appearance import Appearance
from walkergen.guests.track.film.blobs import Blob, find_blobs
from walkergen.guests.track.film.camera import Shake
from walkergen.guests.track.film.fields import TrackFields
from walkergen.guests.track.film.films import Box, Clock, Film, Grey
from walkergen.guests.track.film.heading import MIN_ELONGATION
from walkergen.guests.track.film.lens import Lens
from walkergen.guests.track.film.linking import Linked, Track
from walkergen.guests.track.film.result import Outline, Tracked, Walker

SAMPLE_FRAMES = 8
"""Number of frames, from the first on, in which the appearance of a film is measured."""

SHIFT_FRAMES = 200
"""Approximate number of frames in which the camera's shake is measured."""

LENGTH_ERROR_PX = 2.5
"""Standard error of a length in a frame, both ends together, pixels, due to blur, a dark rim or a shadow. Rendered
films err by less."""

MAX_STILL_PX = 0.02
"""Displacement between frames, pixels, below which a walker is at rest: compression of the film moves it so far."""


class Unmarked(NamedTuple):
    """Findings behind tracks of walkers without markers."""

    look: Appearance
    linked: Linked
    straight: Sequence[Track]
    """Tracks of `linked.walkers`, corrected for lens distortion."""
    shake: Shake
    still: int
    """Number of frames without movement since the frame before."""


def track(
    film: Film, part: Box, request: TrackFields, lens: Lens | None, progress: Progress
) -> tuple[Tracked, Unmarked]:
    """Return walkers tracked in a part of a film's frames, and the findings behind the tracks. Raises InputError."""
    frames = _find_in_frames(film, part, request, progress)
    linked = linking.link(frames.blobs, request.frames[0], frames.clock.fps)
    straight = [_undistort(seen, lens, part) for seen in linked.walkers]
    scale = find_scale(request, _walker_length(linked, straight))
    by: heading.By = "mark" if request.heading == "mark" else "motion"
    walkers = [
        _make_walker(number, seen, corrected, by, film, part, scale.number)
        for number, (seen, corrected) in enumerate(zip(linked.walkers, straight, strict=True))
    ]
    looked = len(frames.blobs)
    tracked = Tracked(film, request, lens, part, frames.picture, frames.clock, looked, walkers, scale)
    return tracked, Unmarked(frames.look, linked, straight, frames.shake, _count_still(frames.blobs))


class _FrameFindings(NamedTuple):
    """Blobs in each frame of a film, with the film's appearance, times and shake."""

    picture: Grey
    """First of the frames."""
    look: Appearance
    blobs: list[list[Blob]]
    clock: Clock
    shake: Shake


def _find_in_frames(film: Film, part: Box, request: TrackFields, progress: Progress) -> _FrameFindings:
    """Return the blobs in each frame of a part of the film, with the film's appearance, times and shake."""
    dark = None if request.walkers is None else request.walkers == "dark"
    with films.play(film, part, request.frames, progress) as reel:
        samples = list(islice(reel.frames, SAMPLE_FRAMES))
        films.check_frame_count(len(samples), request.frames[0])
        look = appearance.learn_appearance(samples, dark, request.threshold, request.width)
        near = [blob for grey in samples for blob in find_blobs(grey, look, marked=False)]
        points = camera.find_fixed_points(samples, near)
        blobs: list[list[Blob]] = []
        shifts: list[Array] = []
        for number, grey in enumerate(chain(samples, reel.frames)):
            blobs.append(find_blobs(grey, look, request.heading == "mark"))
            if points is not None and number % max(1, reel.expected // SHIFT_FRAMES) == 0:
                shifts.append(camera.find_shift(points, grey, blobs[-1]))
        clock = films.read_clock(film, reel.stamps, request.fps)
    return _FrameFindings(samples[0], look, blobs, clock, camera.measure_shake(shifts))


def _count_still(frames: Sequence[Sequence[Blob]]) -> int:
    """Count the frames that show walkers, none of which moved since the frame before."""

    def is_still(before: Sequence[Blob], now: Sequence[Blob]) -> bool:
        if not now or len(now) != len(before):
            return False
        pairs = zip(before, now, strict=True)
        return all(math.hypot(b.x - a.x, b.y - a.y) < MAX_STILL_PX for a, b in pairs)

    return sum(is_still(before, now) for before, now in pairwise(frames))


def _undistort(seen: Track, lens: Lens | None, part: Box) -> Track:
    """Return a track corrected for the lens, if any. Its pixels count from the corner of `part`, the searched part."""
    return seen if lens is None else seen._replace(blobs=lens.undistort_blobs(seen.blobs, part[:2]))


def _walker_length(linked: Linked, straight: Sequence[Track]) -> float:
    """Return the typical length of a walker (pixels), corrected for the lens as are the tracks in `straight`."""
    raw, true = (np.concatenate([walker.blobs.length for walker in walkers]) for walkers in (linked.walkers, straight))
    return linked.length * float(np.median(true / raw))


def find_scale(request: TrackFields, length: float) -> Quantity:
    """Return the scale (mm per pixel) with its standard error: as requested, or from a walker's `length` in pixels.

    Errors of a scale from a length are those of blurred edges and of the given length.
    """
    if request.mm_per_px is not None:
        return Quantity("mm_per_px", "", *request.mm_per_px)
    assert request.length is not None
    walker_mm, se = request.length
    scale, share_se = walker_mm / length, (se or 0.0) / walker_mm
    return Quantity("mm_per_px", "", scale, scale * math.hypot(LENGTH_ERROR_PX / length, share_se))


def _make_walker(
    number: int, seen: Track, straight: Track, by: heading.By, film: Film, part: Box, scale: float
) -> Walker:
    """Build a walker with positions in mm from the lower left corner of the whole frame.

    `seen`, `straight`: track as filmed, and corrected for the lens. `by`: source of headings. `scale`: mm per pixel.
    """
    left, top, _, _ = part
    raw, true = (np.column_stack([blobs.x + left + 0.5, blobs.y + top + 0.5]) for blobs in (seen.blobs, straight.blobs))
    position = scale * np.column_stack([true[:, 0], film.height - true[:, 1]])
    headings = heading.find_headings(straight, by)
    outlines = [_make_outline(seen, index, raw[index], headings.theta[index]) for index in (0, -1)]
    size = float(np.median(seen.blobs.length))
    return Walker(number, seen.frames, raw, position, headings.theta, headings.how, size, (outlines[0], outlines[1]))


def _make_outline(seen: Track, index: int, middle: Array, theta: float) -> Outline:
    """Build the box or ellipse around a walker, and the arrow at its front, in one frame: number `index` of `seen`.

    `middle`: its centre, pixels of the whole frame, y down. `theta`: its heading, rad, y up.
    """
    blobs = seen.blobs
    shape = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1), (1, 1)])
    if np.median(blobs.length / blobs.width) < MIN_ELONGATION:
        angles = np.linspace(0.0, 2.0 * np.pi, 60)
        shape = np.column_stack([np.cos(angles), np.sin(angles)])
    c, s = np.cos(blobs.axis[index]), np.sin(blobs.axis[index])
    rim = (0.5 * shape * (blobs.length[index], blobs.width[index])) @ np.array([[c, -s], [s, c]])
    ahead = blobs.length[index] * np.array([np.cos(theta), -np.sin(theta)])
    return Outline(rim + middle, middle + np.outer((0.5, 0.85), ahead))  # the arrow starts at the front
