"""Warnings on a film with markers, each with its size: missing, duplicate or bent markers."""

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from walkergen.core import Quantity
from walkergen.core.files import formatting
from walkergen.guests.track.film.marker_tracking import MARKER_MM, Marked
from walkergen.guests.track.film.plane import CORRELATED_SIGHTINGS
from walkergen.guests.track.film.quality import MAX_LOST_SHARE, Remarks
from walkergen.guests.track.film.result import Tracked, Walker

MAX_CORNER_OFFSET_PX = 0.7
"""Distance of corners from those of squares that is worth a warning, pixels."""

LONG_GAP_S = 0.5
"""Time without any marker that is worth a warning, s."""

MAX_TILT_DEG = 45.0
"""Tilt of the camera that is worth a warning, deg: far markers are few pixels high."""

EDGE_MARGIN_SIDES = 3.0
"""Smallest distance, in sides of a marker, between its middle and the edge of the searched part for one that has not
crossed that edge."""

MIN_SIZE_CHANGE, MIN_SIGNIFICANCE = 0.005, 3.0
"""Relative change of markers' size by a lens that is worth a warning, and its significance in standard errors."""

MAX_NAMES = 10
"""Largest number of markers that a warning names."""


def collect_remarks(tracked: Tracked, found: Marked) -> Remarks:
    """Return facts, notes and warnings on a film with markers."""
    flat, out = found.plane, found.left_out
    change, (side, _) = _scale_change(found), tracked.request.marker_mm or (MARKER_MM, None)
    facts = {
        "marker_mm": side,
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
    return Remarks(
        facts, list(_notes(tracked, found, change)), [*_left_out_warnings(tracked, found), *_lens_warnings(found)]
    )


def _scale_change(found: Marked) -> float:
    """Return the largest scale (mm per pixel) over the smallest, less 1, at the positions of walkers in the film."""
    scales = np.concatenate([found.plane.scales(corners.mean(axis=1)) for corners in found.straight])
    return float(scales.max() / scales.min() - 1.0)


def _notes(tracked: Tracked, found: Marked, change: float) -> Iterator[str]:
    """Yield notes on the readings: scale, tilt and rate. `change`: relative change of lengths between places."""
    flat, (side, side_se) = found.plane, tracked.request.marker_mm or (MARKER_MM, None)
    scale, scale_se = tracked.mm_per_px.pair
    size = f"{formatting.format_number(side, 4)} mm"
    if side_se is not None:
        size += f" ± {formatting.format_number(side_se, 2)}"
    sides = [walker.size_px for walker in tracked.walkers]
    pixels = " to ".join(dict.fromkeys(formatting.format_number(side, 3) for side in (min(sides), max(sides))))
    yield (
        f"Markers {size} wide, black frame included (‹marker_mm›), {pixels} pixels in the picture: "
        f"{formatting.format_number(scale, 4)} mm a pixel in its middle ± "
        f"{formatting.format_number(100.0 * scale_se / scale, 2)} %; {tracked.clock.in_words}."
    )
    yield (
        f"The camera is tilted by {flat.tilt_deg:.0f} deg, and lengths differ by "
        f"{100.0 * change:.2g} % between the places of walkers, which is corrected. Corners lie "
        f"{formatting.format_number(flat.residual_px, 2)} pixels off those of squares."
    )


def _left_out_warnings(tracked: Tracked, found: Marked) -> Iterator[str]:
    """Yield warnings about markers that are in no track, or missing in some frames."""
    out = found.left_out
    for number, count in out.twice.items():
        yield (
            f"marker {number} is seen in two places in {count} of {tracked.looked} frames, and left out. Print each "
            "number once"
        )
    for number in out.mirrored:
        yield f"marker {number} is only read as a mirror image, and left out. Print it again"
    if out.rare:
        yield f"read too rarely to be walkers, and left out: marker {_format_counts(out.rare)} frames"
    if out.bent:
        yield (
            f"sightings left out: marker {_format_counts(out.bent)} frames, not squares in the plane of the others "
            "(the cap leans or is half covered)"
        )
    yield from _gap_warnings(tracked, found)
    yield from _lost_warnings(tracked)
    yield from _absent_warnings(tracked, found)


def _lens_warnings(found: Marked) -> Iterator[str]:
    """Yield warnings of lens distortion, and of a tilted camera."""
    flat, (change, away_px) = found.plane, edge_size_change(found)
    share, error = change.pair
    if abs(share) > max(MIN_SIZE_CHANGE, MIN_SIGNIFICANCE * error):
        size = "smaller" if share < 0.0 else "larger"
        yield (
            f"markers are {100.0 * abs(share):.2g} % {size} {away_px:.0f} pixels from "
            "the picture's middle than in it, and so are all lengths there. The lens distorts: "
            "calibrate it, and give ‹lens›"
        )
    if flat.residual_px > MAX_CORNER_OFFSET_PX:
        yield (
            f"corners lie {flat.residual_px:.2g} pixels off those of squares: the lens distorts, caps are not flat, or "
            "the film has motion blur"
        )
    if flat.tilt_deg > MAX_TILT_DEG:
        yield f"the camera is tilted by {flat.tilt_deg:.0f} deg: film from above, within {MAX_TILT_DEG:g} deg"


def edge_size_change(found: Marked) -> tuple[Quantity, float]:
    """Return the relative change of markers' sides from the picture's middle to the farthest marker, and its distance.

    The change grows with the distance (pixels) squared. The plane already corrects perspective, a linear change.
    """
    corners = np.concatenate(found.straight)
    sides = found.plane.to_mm(corners)
    size = np.log(np.hypot(*np.moveaxis(sides - np.roll(sides, 1, axis=1), -1, 0)).mean(axis=1))
    distance = np.linalg.norm(corners.mean(axis=1) - found.plane.middle, axis=1)
    square = (distance / found.plane.half) ** 2
    terms = np.column_stack([np.ones_like(square), square])
    fitted, _, rank, _ = np.linalg.lstsq(terms, size)
    if rank < 2 or len(size) <= CORRELATED_SIGHTINGS:
        return Quantity("bend", "", 0.0, math.inf), float(distance.max())
    variance = CORRELATED_SIGHTINGS * float(np.mean((size - terms @ fitted) ** 2))
    error = math.sqrt(variance * float(np.linalg.pinv(terms.T @ terms)[1, 1]))
    reach = float(square.max())
    return Quantity("bend", "", math.expm1(float(fitted[1]) * reach), error * reach), float(distance.max())


class Missing(NamedTuple):
    """Number of frames that must contain the walker `number` but do not show its marker."""

    number: int
    frames: int
    with_others: int
    """Number of these frames in which other markers were read."""
    required: int
    """Number of frames that must contain the walker."""

    @property
    def share(self) -> float:
        """Missing frames over the frames that must contain the walker."""
        return self.frames / self.required


def count_missing(tracked: Tracked) -> list[Missing]:
    """Count the frames that must contain each walker but do not show it.

    A walker must be in all frames from its first to its last. If it was seen in the middle of the picture, it must be
    in those before and after too: walkers enter only over the edge.
    """
    first = tracked.request.frames[0]
    readings = np.zeros(tracked.looked, int)
    for walker in tracked.walkers:
        readings[walker.frames - first] += 1
    counts = []
    for walker in tracked.walkers:
        seen = np.zeros(tracked.looked, bool)
        seen[walker.frames - first] = True
        required = slice(
            0 if _is_inside(tracked, walker, 0) else int(walker.frames[0]) - first,
            None if _is_inside(tracked, walker, -1) else int(walker.frames[-1]) - first + 1,
        )
        missing = ~seen[required]
        with_others = missing & (readings[required] > 0)
        counts.append(Missing(walker.number, int(missing.sum()), int(with_others.sum()), len(missing)))
    return counts


def _is_inside(tracked: Tracked, walker: Walker, at: int) -> bool:
    """Return whether the sighting of a walker with index `at` is away from the edges of the searched part."""
    left, top, right, bottom = tracked.part
    x, y = walker.pixels[at]
    return bool(min(x - left, y - top, right - x, bottom - y) > EDGE_MARGIN_SIDES * walker.size_px)


def _lost_warnings(tracked: Tracked) -> Iterator[str]:
    """Yield warnings of walkers that are missing in more than a few of their frames, with the share."""
    for walker in count_missing(tracked):
        if walker.share > MAX_LOST_SHARE:
            others = (
                f". Other markers are read in {walker.with_others} of them: this one is hidden, half covered or blurred"
                if walker.with_others
                else ""
            )
            yield (
                f"walker {walker.number} is lost in {walker.frames} of {walker.required} frames "
                f"({100.0 * walker.share:.0f} %){others}"
            )


def _absent_warnings(tracked: Tracked, found: Marked) -> Iterator[str]:
    """Yield a warning about markers that were never read, if most numbers between the lowest and the highest were."""
    out = found.left_out
    numbers = {walker.number for walker in tracked.walkers}
    read = numbers | set(out.twice) | set(out.rare) | set(out.mirrored)
    absent = [number for number in range(min(read), max(read)) if number not in read]
    if 0 < len(absent) < len(numbers):
        names = ", ".join(map(str, absent[:MAX_NAMES])) + (" ..." if len(absent) > MAX_NAMES else "")
        yield (
            f"marker {names}: read in none of {tracked.looked} frames, unlike lower and higher numbers. It is always "
            "half covered, or not in the film"
        )


def _format_counts(frames: Mapping[int, int]) -> str:
    """Format marker numbers, each with its number of frames, as in "3 in 12, 7 in 2 ..."."""
    named = ", ".join(f"{number} in {count}" for number, count in list(frames.items())[:MAX_NAMES])
    return named + (" ..." if len(frames) > MAX_NAMES else "")


def _gap_warnings(tracked: Tracked, found: Marked) -> Iterator[str]:
    """Yield a warning of frames without any marker, with the longest time in a row."""
    if not len(found.empty):
        return
    runs = np.split(found.empty, np.flatnonzero(np.diff(found.empty) > 1) + 1)
    longest = max(runs, key=len)
    times = tracked.clock.times
    end = min(int(longest[-1]) + 1, len(times) - 1)
    seconds = float(times[end] - times[longest[0]])
    line = f"no marker is read in {len(found.empty)} of {tracked.looked} frames"
    yield line if seconds < LONG_GAP_S else f"{line}; at most {seconds:.2g} s in a row, from {times[longest[0]]:.4g} s"
