"""Tracking by markers on caps: number, place and heading of every walker in every frame it shows.

Reads markers frame by frame, and finds the plane in which they are squares of their size.
"""

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.errors import InputError
from walkergen.files.progress import Progress
from walkergen.track.film import films, make, plane
from walkergen.track.film.films import Clock, Film, Grey
from walkergen.track.film.heading import unwrapped
from walkergen.track.film.lens import Lens
from walkergen.track.film.linking import PART, SHORTEST
from walkergen.track.film.markers import SMALLEST, Reader, Sighted
from walkergen.track.film.plane import Plane
from walkergen.walker import caps

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]

KINDS = ("aruco",)
"""Markers that are read: OpenCV's ArUco."""

LOOKED_AT = 8
"""Number of frames in which markers are looked for in the mirror where there are none."""

TWICE = 0.02
"""Part of a marker's frames in which it may be seen at two places at once: misread, not printed
twice."""


class Wish(NamedTuple):
    """What a person tells of a film with markers."""

    marker_mm: float = 7.2
    """Side of the markers, their black frame included."""
    marker_se_mm: float | None = None
    """Standard error of `marker_mm`."""
    fps: float | None = None
    """Frames per second at which the film was taken."""
    frames: tuple[int, int | None] = (0, None)
    """First frame, and the one after the last."""
    region: tuple[int, int, int, int] | None = None
    """Left and upper edge, width and height of the part that is looked at, pixels."""
    lens: Lens | None = None
    """Lens that bends, which is undone; None for one that does not."""


class Walker(NamedTuple):
    """Walker by its marker, in the frames in which that was read."""

    number: int
    frames: Whole
    """Ascending, shape (n,)."""
    corners: Array
    """Corners of the marker, shape (n, 4, 2), pixels; see `markers.Sighted`."""
    straight: Array
    """The same by a lens that does not bend."""
    position: Array
    """Middles of the marker, shape (n, 2), mm from the frame's lower left corner, y up."""
    theta: Array
    """Headings, shape (n,), rad, from x (to the right) toward y (up); whole turns are counted."""

    @property
    def side_px(self) -> float:
        """Median side of the marker in the picture, pixels."""
        ways = self.corners - np.roll(self.corners, 1, axis=1)
        return float(np.median(np.hypot(ways[..., 0], ways[..., 1])))


class LeftOut(NamedTuple):
    """What was read and is in no track."""

    twice: Mapping[int, int]
    """Frames in which a number was read at two places, by the number that is left out for it."""
    rare: Mapping[int, int]
    """Frames of numbers that were read too rarely."""
    bent: Mapping[int, int]
    """Sightings that are no squares in the plane of the others, by number."""
    mirrored: Sequence[int]
    """Numbers of markers that are printed mirrored."""


class Marked(NamedTuple):
    """What was found in a film with markers."""

    film: Film
    wish: Wish
    plane: Plane
    walkers: tuple[Walker, ...]
    """In the order of their numbers."""
    left_out: LeftOut
    looked: int
    """Frames looked at."""
    empty: Whole
    """Numbers of the frames in which no marker was read."""
    clock: Clock
    picture: Grey
    """Part of the first frame that was looked at."""
    part: tuple[int, int, int, int]
    """Left, top, right and bottom of it in the frame, pixels."""


def check_kind(markers: str, flag: str) -> None:
    """Raise InputError, which begins with a flag, for markers of another kind."""
    if markers not in KINDS:
        raise InputError(f"{flag}{markers[:30]!r}: must be {' or '.join(KINDS)}")


def check(wish: Wish) -> None:
    """Raise InputError for wishes that are out of range."""
    for flag, value in (("--marker-mm", wish.marker_mm), ("--fps", wish.fps)):
        if value is not None and not make.LEAST <= value <= make.LARGEST:
            raise InputError(f"{flag} {value:g}: must be a number in {make.LEAST:g}..{make.LARGEST:g}")
    make.check_frames(wish.frames)


def find(path: Path, wish: Wish, progress: Progress) -> Marked:
    """Walkers of a film by their markers.

    Raises InputError when the film cannot be read, or no marker in it.
    """
    films.require()
    check(wish)
    film = films.about(path)
    part = make.part_of(film, wish.region)
    if min(part[2] - part[0], part[3] - part[1]) < 2.0 * SMALLEST:
        raise InputError(
            f"{path}: {part[2] - part[0]} x {part[3] - part[1]} pixels: a marker needs "
            f"{SMALLEST:g} and a rim: film larger"
        )
    try:
        return _found(film, part, wish, progress)
    except InputError as error:
        raise error if str(path) in str(error) else InputError(f"{path}: {error}") from None


class _Read(NamedTuple):
    """What was read in a film, frame by frame."""

    seen: list[Sighted]
    clock: Clock
    picture: Grey
    """First of the frames."""
    mirrored: list[int]
    """Numbers that are read in the mirror."""


def _found(film: Film, part: tuple[int, int, int, int], wish: Wish, progress: Progress) -> Marked:
    seen, clock, picture, mirrored = _read(film, part, wish, progress)
    first = wish.frames[0]
    empty = [at for at, sighted in enumerate(seen, first) if not len(sighted.numbers)]
    tracks, twice, rare = _sorted(seen, first)
    side = wish.marker_mm
    lens = None if wish.lens is None else wish.lens.of_film(film.width, film.height)
    straight = {number: corners if lens is None else lens.straight(corners) for number, (_, corners) in tracks.items()}
    flat = plane.fit(np.concatenate([*straight.values()]), side, film.width, film.height)
    walkers, bent = list[Walker](), dict[int, int]()
    poses = {number: plane.pose(flat, corners, side) for number, corners in straight.items()}
    sound = plane.sound(np.concatenate([pose.off_px for pose in poses.values()]))
    for number, (frames, corners) in tracks.items():
        pose, (good, sound) = poses[number], np.split(sound, [len(frames)])
        if not good.all():
            bent[number] = int((~good).sum())
        if good.any():
            walkers.append(
                Walker(
                    number,
                    frames[good],
                    corners[good],
                    straight[number][good],
                    pose.places[good],
                    unwrapped(pose.headings[good]),
                )
            )
    return Marked(
        film,
        wish,
        flat,
        tuple(walkers),
        LeftOut(twice, rare, bent, mirrored),
        len(seen),
        np.array(empty, np.int64),
        clock,
        picture,
        part,
    )


def _read(film: Film, part: tuple[int, int, int, int], wish: Wish, progress: Progress) -> _Read:
    """Markers of all frames. Raises InputError."""
    left, top, right, bottom = part
    first, last = wish.frames
    total = max((round(film.seconds * (film.fps or 0.0)) if last is None else last) - first, 1)
    reader, seen = Reader(right - left, bottom - top), list[Sighted]()
    samples: list[Grey] = []
    with films.play(film, first, last) as reel:
        for _, whole in reel.frames:
            grey = np.ascontiguousarray(whole[top:bottom, left:right])
            sighted = reader.read(grey)
            if len(seen) % max(1, total // LOOKED_AT) == 0 and len(samples) < LOOKED_AT:
                samples.append(grey)
            seen.append(sighted._replace(corners=sighted.corners + np.array([left, top])))
            progress("frames", len(seen), max(total, len(seen)))
        if len(seen) < 2:
            raise InputError(f"{len(seen)} frame{'' if len(seen) == 1 else 's'} from {first} on: at least 2 are needed")
        clock = films.clock(film, reel.stamps, wish.fps)
    upright = {number for sighted in seen for number in sighted.numbers.tolist()}
    mirrored = [number for number in _mirrored(reader, samples) if number not in upright]
    if not upright or (mirrored and upright <= caps.symmetric()):
        raise InputError(_none(mirrored, len(seen)))
    return _Read(seen, clock, samples[0], mirrored)


def _mirrored(reader: Reader, samples: list[Grey]) -> list[int]:
    """Numbers of markers that are read in the mirror image of most of some frames."""
    images = (np.ascontiguousarray(grey[:, ::-1]) for grey in samples)
    counts = Counter(number for image in images for number in reader.read(image).numbers.tolist())
    return sorted(number for number, count in counts.items() if count > 0.5 * len(samples))


def _none(mirrored: list[int], count: int) -> str:
    """Reason why no marker was read."""
    if mirrored:
        return (
            "the film is mirrored: markers are read in its mirror image only; mirror it back: "
            "ffmpeg -i FILM -vf hflip RIGHT.mp4"
        )
    return (
        f"no marker (ArUco, 4x4, 0 to 99) is read in {count} frames: it must be {SMALLEST:g} "
        "pixels wide or more, sharp, in a white rim; of walkers without: leave --markers out"
    )


class _Sorted(NamedTuple):
    """Markers of a film by their numbers."""

    tracks: dict[int, tuple[Whole, Array]]
    """Frames, ascending, and corners of those that are walkers'."""
    twice: dict[int, int]
    """Frames in which a number was read at two places, of those left out for it."""
    rare: dict[int, int]
    """Frames of those that were read too rarely."""


def _sorted(seen: list[Sighted], first: int) -> _Sorted:
    """Markers of frames from the first on by their numbers. Raises InputError for no walker."""
    frames: dict[int, list[int]] = defaultdict(list)
    corners: dict[int, list[Array]] = defaultdict(list)
    double: Counter[int] = Counter()
    for at, sighted in enumerate(seen, first):
        counts = Counter(sighted.numbers.tolist())
        # Which of two is the walker's cannot be told
        double.update(number for number, count in counts.items() if count > 1)
        for number, square in zip(sighted.numbers.tolist(), sighted.corners, strict=True):
            if counts[number] == 1:
                frames[number].append(at)
                corners[number].append(square)
    least = max(SHORTEST, PART * len(seen))
    twice = {
        number: double[number]
        for number in sorted(double)
        if double[number] > TWICE * (double[number] + len(frames[number]))
    }
    once = {number: frames[number] for number in sorted(frames) if number not in twice}
    tracks = {
        number: (np.array(own, np.int64), np.array(corners[number]))
        for number, own in once.items()
        if len(own) >= least
    }
    rare = {number: len(own) for number, own in once.items() if 0 < len(own) < least}
    if not tracks:
        raise InputError(_no_walker(twice, rare, least, len(seen)))
    return _Sorted(tracks, twice, rare)


def _no_walker(twice: Mapping[int, int], rare: Mapping[int, int], least: float, count: int) -> str:
    """Reason why no marker that was read is a walker's."""
    if twice:
        return (
            f"marker {', '.join(map(str, list(twice)[:10]))} is seen at two places at once, in "
            f"{max(twice.values())} of {count} frames, and no other is left: print each number "
            "once, or cover what mirrors it"
        )
    counts = ", ".join(f"{number} in {own}" for number, own in list(rare.items())[:10])
    return (
        f"no marker is read in {least:.3g} of {count} frames ({counts}): give more light, shorter "
        "exposure or larger markers"
    )
