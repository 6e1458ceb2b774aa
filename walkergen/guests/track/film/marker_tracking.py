"""Tracking by markers on caps: number, position and heading of every walker in every frame.

Reads markers frame by frame, and finds the plane that makes them squares of their size.
"""

import math
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core import Quantity
from walkergen.core.errors import InputError
from walkergen.core.files.progress import Progress
from walkergen.core.numerics import Array, Whole
from walkergen.guests.track.film import films, plane
from walkergen.guests.track.film.fields import TrackFields
from walkergen.guests.track.film.films import Box, Clock, Film, Grey
from walkergen.guests.track.film.heading import unwrap
from walkergen.guests.track.film.lens import Lens
from walkergen.guests.track.film.linking import MIN_TRACK_FRAMES, MIN_TRACK_SHARE
from walkergen.guests.track.film.markers import MIN_SIDE_PX, Reader, Sighted
from walkergen.guests.track.film.plane import Plane, Pose
from walkergen.guests.track.film.result import Outline, Tracked, Walker
from walkergen.readers.walkers import caps

MARKER_MM = 7.2
"""Side of the markers that `plate --caps` prints by default, black frame included."""

EDGE_ERROR_PX = 0.2
"""Standard error of a marker's side in the picture, pixels, due to blurred edges. Rendered films err by as much if
walkers blur by 2 pixels a frame, by a tenth of it without blur."""

MIRROR_SAMPLES = 8
"""Number of frames searched for mirrored markers if no others are found."""

MAX_DOUBLE_SHARE = 0.02
"""Largest share of a marker's frames that show its number at two places; with more, it was printed twice."""


class LeftOut(NamedTuple):
    """Markers that were read but left out of the tracks, by marker number."""

    twice: Mapping[int, int]
    """Number of frames that show a marker's number at two places. These markers are left out."""
    rare: Mapping[int, int]
    """Number of frames that show a marker, for markers that were read too rarely."""
    bent: Mapping[int, int]
    """Number of frames in which a marker is no square in the plane of the others."""
    mirrored: Sequence[int]
    """Numbers of markers that are printed mirrored."""


class Marked(NamedTuple):
    """Findings behind tracks of walkers with markers."""

    plane: Plane
    straight: Sequence[Array]
    """Corners of each walker's marker, corrected for the lens, shape (n, 4, 2), pixels, in the order of `Sighted`."""
    left_out: LeftOut
    empty: Whole
    """Numbers of the frames without a marker."""


def track(film: Film, part: Box, request: TrackFields, lens: Lens | None, progress: Progress) -> tuple[Tracked, Marked]:
    """Return the walkers tracked by their markers in a part of a film's frames, and the findings behind the tracks.

    Walkers are in the order of their numbers. Raises InputError if no marker is read.
    """
    left, top, right, bottom = part
    if min(right - left, bottom - top) < 2.0 * MIN_SIDE_PX:
        raise InputError(
            f"{right - left} x {bottom - top} pixels: a marker needs {MIN_SIDE_PX:g} and a rim: film larger"
        )
    seen, clock, picture, mirrored = _read_markers(film, part, request, progress)
    first, (side, side_se) = request.frames[0], request.marker_mm or (MARKER_MM, None)
    empty = [at for at, sighted in enumerate(seen, first) if not len(sighted.numbers)]
    tracks, twice, rare = _group_by_number(seen, first)
    corrected = {key: corners if lens is None else lens.undistort(corners) for key, (_, corners) in tracks.items()}
    flat = plane.fit_plane(np.concatenate([*corrected.values()]), side, film.width, film.height)
    walkers, straight, bent = list[Walker](), list[Array](), dict[int, int]()
    poses = {number: plane.find_poses(flat, corners, side) for number, corners in corrected.items()}
    is_square = plane.is_square(np.concatenate([pose.off_px for pose in poses.values()]))
    for number, (frames, corners) in tracks.items():
        good, is_square = np.split(is_square, [len(frames)])  # of this marker, and of those that follow
        if not good.all():
            bent[number] = int((~good).sum())
        if good.any():
            pose = Pose(*(values[good] for values in poses[number]))
            walkers.append(_make_walker(number, frames[good], corners[good], pose))
            straight.append(corrected[number][good])
    side_px = float(np.median([walker.size_px for walker in walkers]))
    scale_se = flat.mm_per_px * math.hypot((side_se or 0.0) / side, EDGE_ERROR_PX / side_px)
    scale = Quantity("mm_per_px", "", flat.mm_per_px, scale_se)
    tracked = Tracked(film, request, lens, part, picture, clock, len(seen), walkers, scale)
    return tracked, Marked(flat, straight, LeftOut(twice, rare, bent, mirrored), np.array(empty, np.int64))


def _make_walker(number: int, frames: Whole, corners: Array, pose: Pose) -> Walker:
    """Build a walker from the `pose` of its marker in the plane, and its corners in the picture.

    `corners`: shape (frames, 4, 2), pixels, in order around the marker, the first two at its front.
    """
    sides = corners - np.roll(corners, 1, axis=1)
    side_px = float(np.median(np.hypot(sides[..., 0], sides[..., 1])))
    middles, outlines = corners.mean(axis=1), []
    for index in (0, -1):
        square = corners[index]
        ahead = 0.5 * (square[0] + square[1]) - middles[index]
        outlines.append(Outline(square[[0, 1, 2, 3, 0]], middles[index] + np.outer((1.4, 2.6), ahead)))
    theta, first_and_last = unwrap(pose.headings), (outlines[0], outlines[1])
    return Walker(number, frames, middles, pose.places, theta, "its marker", side_px, first_and_last)


class _Readings(NamedTuple):
    """Markers in each frame of a film, its times, and its first frame."""

    seen: list[Sighted]
    clock: Clock
    picture: Grey
    """First of the frames."""
    mirrored: list[int]
    """Numbers of markers that are read only in mirror images of frames."""


def _read_markers(film: Film, part: Box, request: TrackFields, progress: Progress) -> _Readings:
    """Read the markers of all frames. Raises InputError."""
    left, top, right, bottom = part
    reader, seen = Reader(right - left, bottom - top), list[Sighted]()
    samples: list[Grey] = []
    with films.play(film, part, request.frames, progress) as reel:
        for grey in reel.frames:
            sighted = reader.find_markers(grey)
            if len(seen) % max(1, reel.expected // MIRROR_SAMPLES) == 0 and len(samples) < MIRROR_SAMPLES:
                samples.append(grey)
            seen.append(sighted._replace(corners=sighted.corners + np.array([left, top])))
        films.check_frame_count(len(seen), request.frames[0])
        clock = films.read_clock(film, reel.stamps, request.fps)
    upright = {number for sighted in seen for number in sighted.numbers.tolist()}
    mirrored = [number for number in _find_mirrored(reader, samples) if number not in upright]
    if not upright or (mirrored and upright <= caps.symmetric_numbers()):
        raise InputError(_no_marker_reason(mirrored, len(seen)))
    return _Readings(seen, clock, samples[0], mirrored)


def _find_mirrored(reader: Reader, samples: list[Grey]) -> list[int]:
    """Return the numbers of the markers that are read in mirror images of most of the `samples`."""
    images = (np.ascontiguousarray(grey[:, ::-1]) for grey in samples)
    counts = Counter(number for image in images for number in reader.find_markers(image).numbers.tolist())
    return sorted(number for number, count in counts.items() if count > 0.5 * len(samples))


def _no_marker_reason(mirrored: list[int], count: int) -> str:
    """Return the reason why no marker was read in `count` frames. `mirrored`: numbers read in mirror images."""
    if mirrored:
        return (
            "the film is mirrored: markers are only read in its mirror image. Mirror it back: "
            "ffmpeg -i FILM -vf hflip RIGHT.mp4"
        )
    return (
        f"no marker (ArUco, 4x4, 0 to 99) is read in {count} frames. It must be at least {MIN_SIDE_PX:g} pixels wide, "
        "sharp, in a white rim. For walkers without markers leave ‹markers› out"
    )


class _Grouped(NamedTuple):
    """Tracks of a film's markers, and the markers that have none."""

    tracks: dict[int, tuple[Whole, Array]]
    """By marker number: numbers of the frames, ascending, (n,), and corners in these frames, (n, 4, 2), pixels."""
    twice: dict[int, int]
    """Number of frames that show a marker number at two places, by this number, which is left out."""
    rare: dict[int, int]
    """Number of frames, by marker number, of markers that were read too rarely."""


def _group_by_number(seen: list[Sighted], first: int) -> _Grouped:
    """Return the track of each marker number from the markers in frames `first` on. Raises InputError without any."""
    frames: dict[int, list[int]] = defaultdict(list)
    corners: dict[int, list[Array]] = defaultdict(list)
    double: Counter[int] = Counter()
    for at, sighted in enumerate(seen, first):
        counts = Counter(sighted.numbers.tolist())
        # It is unknown which of the two belongs to the walker
        double.update(number for number, count in counts.items() if count > 1)
        for number, square in zip(sighted.numbers.tolist(), sighted.corners, strict=True):
            if counts[number] == 1:
                frames[number].append(at)
                corners[number].append(square)
    least = max(MIN_TRACK_FRAMES, MIN_TRACK_SHARE * len(seen))
    twice = {
        number: double[number]
        for number in sorted(double)
        if double[number] > MAX_DOUBLE_SHARE * (double[number] + len(frames[number]))
    }
    once = {number: frames[number] for number in sorted(frames) if number not in twice}
    tracks = {
        number: (np.array(frame_numbers, np.int64), np.array(corners[number]))
        for number, frame_numbers in once.items()
        if len(frame_numbers) >= least
    }
    rare = {number: len(frame_numbers) for number, frame_numbers in once.items() if 0 < len(frame_numbers) < least}
    if not tracks:
        raise InputError(_no_walker_reason(twice, rare, least, len(seen)))
    return _Grouped(tracks, twice, rare)


def _no_walker_reason(twice: Mapping[int, int], rare: Mapping[int, int], least: float, count: int) -> str:
    """Return the reason why no marker is read in `least` of `count` frames. `twice`, `rare`: see `_Grouped`."""
    if twice:
        return (
            f"marker {', '.join(map(str, list(twice)[:10]))} is seen in two places in "
            f"{max(twice.values())} of {count} frames, and no other is left. Print each number once, or cover "
            "mirrors"
        )
    counts = ", ".join(f"{number} in {frames}" for number, frames in list(rare.items())[:10])
    return (
        f"no marker is read in {least:.3g} of {count} frames ({counts}). Use more light, a "
        "shorter exposure or larger markers"
    )
