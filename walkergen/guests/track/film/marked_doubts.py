"""What goes wrong in a film with markers, each with its size: what is missing, twice or bent."""

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from walkergen.core.files import words
from walkergen.guests.track.film.doubts import LOST, Told
from walkergen.guests.track.film.marked import MARKER_MM, Marked
from walkergen.guests.track.film.plane import ALIKE
from walkergen.guests.track.film.result import Tracked, Walker

CROOKED = 0.7
"""Distance of corners from those of squares that is worth a warning, pixels."""

LONG_S = 0.5
"""Time without any marker that is worth a warning, s."""

ASKEW = 45.0
"""Tilt of the camera that is worth a warning, deg: far markers are few pixels high."""

INSIDE = 3.0
"""Sides of a marker between its middle and the edge of what is looked at, beyond which it has not
come in, or gone, over that edge."""

BENT, SURE = 0.005, 3.0
"""Change of the size of markers by a lens that is worth a warning, and how many of its errors."""

NAMED = 10
"""Most numbers that are named."""


def of(tracked: Tracked, found: Marked) -> Told:
    """All that is to be said of a film."""
    flat, out = found.plane, found.left_out
    change = _scale_change(found)
    facts = {
        "marker_mm": tracked.options.marker_mm or MARKER_MM,
        "heading": "marker",
        "tilt_deg": flat.tilt_deg,
        "scale_change_share": change,
        "plane_terms": flat.terms.tolist(),
        "plane_terms_se": flat.errors.tolist(),
        "corners_off_px": flat.residual_px,
        "frames_without_markers": len(found.empty),
        "seen_twice_frames": {str(key): count for key, count in out.twice.items()},
        "seen_rarely_frames": {str(key): count for key, count in out.rare.items()},
        "sightings_left_out": sum(out.bent.values()),
        "mirrored": list(out.mirrored),
    }
    return Told(facts, list(_notes(tracked, found, change)), [*_left_out(tracked, found), *_bent(found)])


def _scale_change(found: Marked) -> float:
    """Share by which lengths differ between the places that walkers reach."""
    scales = np.concatenate([found.plane.scales(corners.mean(axis=1)) for corners in found.straight])
    return float(scales.max() / scales.min() - 1.0)


def _notes(tracked: Tracked, found: Marked, change: float) -> Iterator[str]:
    """Yield notes on what was read: scale, tilt and rate."""
    assert tracked.mm_per_px_se is not None
    flat, options = found.plane, tracked.options
    size = f"{words.format_number(options.marker_mm or MARKER_MM, 4)} mm"
    if options.marker_se_mm is not None:
        size += f" ± {words.format_number(options.marker_se_mm, 2)}"
    sides = [walker.size_px for walker in tracked.walkers]
    pixels = " to ".join(dict.fromkeys(words.format_number(side, 3) for side in (min(sides), max(sides))))
    yield (
        f"Markers {size} wide, black frame included (‹marker_mm›), {pixels} pixels in the picture: "
        f"{words.format_number(flat.mm_per_px, 4)} mm a pixel in its middle ± "
        f"{words.format_number(100.0 * tracked.mm_per_px_se / flat.mm_per_px, 2)} %; {tracked.clock.in_words}."
    )
    yield (
        f"The camera is tilted by {flat.tilt_deg:.0f} deg, and lengths differ by "
        f"{100.0 * change:.2g} % between the places of walkers: undone. Corners lie "
        f"{words.format_number(flat.residual_px, 2)} pixels off those of squares."
    )


def _left_out(tracked: Tracked, found: Marked) -> Iterator[str]:
    """Warnings of markers that are in no track, or missing in some frames."""
    out = found.left_out
    for number, count in out.twice.items():
        yield (
            f"marker {number} is seen at two places at once in {count} of {tracked.looked} frames, "
            "and left out: print each number once"
        )
    for number in out.mirrored:
        yield f"marker {number} is read in the mirror only, and left out: print it anew"
    if out.rare:
        yield f"read too rarely to be walkers, and left out: marker {_counted(out.rare)} frames"
    if out.bent:
        yield (
            f"sightings left out: marker {_counted(out.bent)} frames, no squares in the plane of "
            "the others (a cap that leans, or is half covered)"
        )
    yield from _gaps(tracked, found)
    yield from _lost(tracked)
    yield from _between(tracked, found)


def _bent(found: Marked) -> Iterator[str]:
    """Warnings of a lens that bends, and a camera that looks askew."""
    flat, bend = found.plane, of_lens(found)
    if abs(bend.share) > max(BENT, SURE * bend.error):
        size = "smaller" if bend.share < 0.0 else "larger"
        yield (
            f"markers are {100.0 * abs(bend.share):.2g} % {size} {bend.away_px:.0f} pixels from "
            "the picture's middle than in it, and so are all lengths there: the lens bends: "
            "calibrate it, and give ‹lens›"
        )
    if flat.residual_px > CROOKED:
        yield (
            f"corners lie {flat.residual_px:.2g} pixels off those of squares: a lens that "
            "bends, caps that are not flat, or motion blur"
        )
    if flat.tilt_deg > ASKEW:
        yield f"the camera is tilted by {flat.tilt_deg:.0f} deg: film from above, within {ASKEW:g} deg"


class Bend(NamedTuple):
    """Size of markers at the place farthest from the picture's middle, against that in it."""

    share: float
    """Change of their sides in the plane, as a share; negative where they are smaller."""
    error: float
    away_px: float


def of_lens(found: Marked) -> Bend:
    """Change of markers' sizes with the square of the way from the middle: a lens that bends.

    Perspective changes them in a line, which the plane undoes.
    """
    corners = np.concatenate(found.straight)
    sides = found.plane.to_mm(corners)
    size = np.log(np.hypot(*np.moveaxis(sides - np.roll(sides, 1, axis=1), -1, 0)).mean(axis=1))
    away = np.linalg.norm(corners.mean(axis=1) - found.plane.middle, axis=1)
    square = (away / found.plane.half) ** 2
    terms = np.column_stack([np.ones_like(square), square])
    fitted, _, rank, _ = np.linalg.lstsq(terms, size)
    if rank < 2 or len(size) <= ALIKE:
        return Bend(0.0, math.inf, float(away.max()))
    variance = ALIKE * float(np.mean((size - terms @ fitted) ** 2))
    error = math.sqrt(variance * float(np.linalg.pinv(terms.T @ terms)[1, 1]))
    reach = float(square.max())
    return Bend(math.expm1(float(fitted[1]) * reach), error * reach, float(away.max()))


class Missing(NamedTuple):
    """Frames in which a walker must be there, and its marker is not read."""

    number: int
    frames: int
    beside: int
    """Those of them in which other markers are read."""
    of: int
    """Frames in which it must be there."""

    @property
    def share(self) -> float:
        """Share of the frames in which it must be there."""
        return self.frames / self.of


def missing(tracked: Tracked) -> list[Missing]:
    """Frames in which each walker is missing, of those in which it must be there.

    It must from its first frame to its last, and before and after these where it was seen in the
    midst of the picture, into which nothing comes but over its edge.
    """
    first = tracked.options.frames[0]
    read = np.zeros(tracked.looked, int)
    for walker in tracked.walkers:
        read[walker.frames - first] += 1
    counts = []
    for walker in tracked.walkers:
        seen = np.zeros(tracked.looked, bool)
        seen[walker.frames - first] = True
        there = slice(
            0 if _inside(tracked, walker, 0) else int(walker.frames[0]) - first,
            None if _inside(tracked, walker, -1) else int(walker.frames[-1]) - first + 1,
        )
        gone = ~seen[there]
        beside = gone & (read[there] > 0)
        counts.append(Missing(walker.number, int(gone.sum()), int(beside.sum()), len(gone)))
    return counts


def _inside(tracked: Tracked, walker: Walker, at: int) -> bool:
    """Return whether a sighting of a walker lies away from the edges of the part that is searched."""
    left, top, right, bottom = tracked.part
    x, y = walker.pixels[at]
    return bool(min(x - left, y - top, right - x, bottom - y) > INSIDE * walker.size_px)


def _lost(tracked: Tracked) -> Iterator[str]:
    """Walkers that are missing in more than a few frames, with the share of them."""
    for walker in missing(tracked):
        if walker.share > LOST:
            others = (
                f"; in {walker.beside} of them others are read, and it is hidden, half covered or blurred"
                if walker.beside
                else ""
            )
            yield (
                f"walker {walker.number} is lost in {walker.frames} of {walker.of} frames "
                f"({100.0 * walker.share:.0f} %){others}"
            )


def _between(tracked: Tracked, found: Marked) -> Iterator[str]:
    """Numbers between those that are read, which no frame has; where most others are there."""
    out = found.left_out
    numbers = {walker.number for walker in tracked.walkers}
    known = numbers | set(out.twice) | set(out.rare) | set(out.mirrored)
    absent = [number for number in range(min(known), max(known)) if number not in known]
    if 0 < len(absent) < len(numbers):
        names = ", ".join(map(str, absent[:NAMED])) + (" ..." if len(absent) > NAMED else "")
        yield (
            f"marker {names}: read in none of {tracked.looked} frames, and numbers around are: half "
            "covered all the time, or not in the film"
        )


def _counted(frames: Mapping[int, int]) -> str:
    """Numbers of markers with their numbers of frames."""
    named = ", ".join(f"{number} in {count}" for number, count in list(frames.items())[:NAMED])
    return named + (" ..." if len(frames) > NAMED else "")


def _gaps(tracked: Tracked, found: Marked) -> Iterator[str]:
    """Frames without any marker, and the longest time of them."""
    if not len(found.empty):
        return
    runs = np.split(found.empty, np.flatnonzero(np.diff(found.empty) > 1) + 1)
    longest = max(runs, key=len)
    times = tracked.clock.times
    end = min(int(longest[-1]) + 1, len(times) - 1)
    seconds = float(times[end] - times[longest[0]])
    line = f"no marker is read in {len(found.empty)} of {tracked.looked} frames"
    yield line if seconds < LONG_S else f"{line}; for {seconds:.2g} s on end from {times[longest[0]]:.4g} s on"
