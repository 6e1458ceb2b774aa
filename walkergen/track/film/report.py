"""Report of what was tracked: tracks, walkers, and warnings with their numbers."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from walkergen.files import report, words
from walkergen.files.report import Column, Report, Table
from walkergen.track.film import doubts
from walkergen.track.film.films import Clock, Film
from walkergen.track.film.lens import Lens
from walkergen.track.film.result import Tracked

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLUMNS = ("frame", "particle", "x", "y", "theta", "t_s", "x_mm", "y_mm", "theta_rad", "mm_per_px", "mm_per_px_se")
"""Columns of tracks.csv: trackpy's names, here in mm and rad, then walkergen's own.

The last two are the scale, by which places have been multiplied, and its standard error, blank when
that is not known: every length measured from the tracks is off by them.
"""

TRACKS, PICTURE = "tracks.csv", "check.png"
"""Files of tracks, and to check them by."""

READ, LEAST_S = 0.95, 0.5
"""Share of its duration, less this time (s) for its last frames, below which a film breaks off."""

SHAKY, PULLED, LARGER, UNSTEADY = 0.2, 0.3, 0.04, 0.02
"""Shake and pull of shadows, pixels, and shares by which a walker's size differs from place to
place, or from frame to frame, that are worth a warning."""

LOST = 0.05
"""Share of frames in which a walker is lost that is worth a warning."""


@dataclass(frozen=True, kw_only=True, repr=False)
class TrackReport(Report):
    """Walkers that were tracked in a film; look at `.picture` before you believe the numbers."""

    tracked: Tracked
    """Everything that was found, walker by walker."""
    picture: Path
    """Picture of what was found, to be looked at."""


class Row(NamedTuple):
    """Track of a walker; the field names are keys of JSON."""

    particle: int
    first: int
    """First frame in which it was seen."""
    last: int
    net_mm: float
    path_mm: float
    lost: int
    """Frames between these in which it was not seen."""
    heading_by: str
    headings: int
    """Frames in which its heading is known."""


WALKERS = (
    report.number("walker", "particle"),
    Column("frames", lambda row: f"{row.first}..{row.last}", right=True),
    Column("lost", lambda row: str(row.lost), right=True),
    report.number("net way (mm)", "net_mm", 3),
    report.number("path (mm)", "path_mm", 3),
    report.text("heading by", "heading_by"),
)


def of(tracked: Tracked, folder: Path) -> TrackReport:
    """Report of a tracked film, to be written into a folder."""
    walkers, title = _walkers(tracked), tracked.film.path.name
    warned, picture = warnings(tracked), folder / PICTURE

    def draw() -> "Figure":
        from walkergen.track.film import figures

        return figures.check_figure(tracked)

    return TrackReport(
        name="track",
        title=title,
        tables=[Table("tracks", rows(tracked), COLUMNS, title=title), report.table("walkers", walkers, WALKERS, title)],
        facts=facts(tracked, walkers) | {"warnings": warned},
        lines=[*notes(tracked), f"{picture}: look at it before you believe the numbers"],
        figures={"check": draw},
        folder=folder,
        tracked=tracked,
        picture=picture,
        warnings=warned,
    )


def rows(tracked: Tracked) -> list[tuple[Any, ...]]:
    """Rows of tracks.csv, frame by frame."""
    rows = []
    for number, walker in enumerate(tracked.walkers):
        for frame, (x, y), theta in zip(
            walker.seen.frames.tolist(), walker.position.tolist(), walker.headed.theta.tolist(), strict=True
        ):
            angle = None if math.isnan(theta) else theta
            place = (x, y, angle)
            scale = (tracked.mm_per_px, tracked.mm_per_px_se)
            rows.append((frame, number, *place, float(tracked.clock.times[frame]), *place, *scale))
    return sorted(rows, key=lambda row: row[:2])


def _walkers(tracked: Tracked) -> list[Row]:
    return [
        Row(
            number,
            int(walker.seen.frames[0]),
            int(walker.seen.frames[-1]),
            walker.net_mm,
            tracked.path_mm(walker),
            _lost(walker.seen.frames),
            walker.headed.how,
            int((~np.isnan(walker.headed.theta)).sum()),
        )
        for number, walker in enumerate(tracked.walkers)
    ]


def notes(tracked: Tracked) -> list[str]:
    """What was looked for, in words, and the scale with its error."""
    look, linked = tracked.look, tracked.linked
    side = "darker" if look.dark else "lighter"
    error = " (its error is not known: give it as 0.05+-0.001)"
    if tracked.mm_per_px_se is not None:
        error = f" ± {words.number(100.0 * tracked.mm_per_px_se / tracked.mm_per_px, 2)} %"
    lines = [
        f"Walkers {side} than the ground by more than {words.number(look.threshold)} of 255 steps, "
        f"{linked.length:.1f} pixels long and {look.width:.0f} wide, area {linked.area:.0f}; "
        f"{words.number(tracked.mm_per_px, 4)} mm a pixel{error}; "
        f"{rate(tracked.clock)}."
    ]
    if not math.isnan(tracked.jitter_mm):
        lines.append(
            f"Places jitter by {words.number(tracked.jitter_mm, 2)} mm between neighbouring "
            "frames. It is no bound: what stays or changes slowly, as a shadow or the lens, is not "
            "in it."
        )
    if math.isnan(tracked.shake.rms):
        lines.append("Nothing that stands still tells whether the camera shakes.")
    return lines


def rate(clock: Clock) -> str:
    """Rate of frames in words, and how far apart they are where that changes."""
    told = f"{words.number(clock.fps, 4)} frames a second"
    if clock.regular:
        return told
    steps = 1e3 * np.diff(clock.times)
    intervals = words.span(steps.min(), steps.max(), 3)
    return f"{told} in the mean, {intervals} ms apart by the film's times"


def warnings(tracked: Tracked) -> list[str]:
    """What went wrong, each with the number of frames."""
    linked, count, seen = (tracked.linked, tracked.looked, [walker.seen for walker in tracked.walkers])
    lines = broken_off(tracked.film, tracked.clock, tracked.options.frames)
    if linked.empty:
        lines.append(f"nothing was found in {linked.empty} of {count} frames")
    if linked.merged:
        lines.append(
            f"walkers touch, and are left out, in {linked.merged} of {count} frames; afterwards "
            "they may have changed their numbers: look at check.png"
        )
    for number, walker in enumerate(tracked.walkers):
        if (lost := _lost(walker.seen.frames)) > LOST * (lost + len(walker.seen.frames)):
            lines.append(f"walker {number} is lost in {lost} frames between its first and last")
    if linked.short:
        lines.append(f"{linked.short} tracks were too short and are left out")
    unknown = [str(number) for number, walker in enumerate(tracked.walkers) if np.isnan(walker.headed.theta).all()]
    if unknown:
        lines.append(f"no heading of walker {', '.join(unknown[:10])}: see the table")
    if (most := doubts.at_once(seen)) < len(seen):
        lines.append(
            f"{len(seen)} tracks, but never more than {most} walkers at once: one that was lost "
            "may go on under another number, so that tracks are not independent samples"
        )
    lines += _camera(tracked)
    if tracked.still:
        lines.append(
            f"nothing moves in {tracked.still} of {count} frames: if the film holds its last "
            "picture, leave it out with --frames"
        )
    return lines


def broken_off(film: Film, clock: Clock, frames: tuple[int, int | None]) -> list[str]:
    """Warning of a film that ends before it should, when it was read to its end."""
    end, announced = clock.played_s, film.seconds
    if frames[1] is not None or end >= READ * announced - LEAST_S:
        return []
    return [f"the film breaks off: {end:.3g} s of {announced:.3g} s could be read"]


def _camera(tracked: Tracked) -> list[str]:
    """What light and camera do to the places, each with its size."""
    seen, look = [walker.seen for walker in tracked.walkers], tracked.look
    lines = []
    if look.blur:
        lines.append(
            f"little contrast: walkers differ from the ground by {look.contrast:.3g} of 255 steps, "
            f"{look.contrast / look.noise:.2g} times the noise of a pixel: give more light"
        )
    if tracked.shake.rms > SHAKY:
        lines.append(
            f"the camera shakes: what stands still moves by {_length(tracked.shake.rms, tracked)} "
            f"r.m.s., {_length(tracked.shake.largest, tracked)} at most, and places with it: fix "
            "the camera"
        )
    if (pull := doubts.shadow(seen)) > PULLED:
        lines.append(
            "shadows are taken for walkers, and pull at their centres by "
            f"{_length(pull, tracked)}: light from all sides, or give a higher --threshold"
        )
    size = doubts.sizes([walker.straight for walker in tracked.walkers])
    if size.change > max(LARGER, doubts.SURE * size.error):
        lines.append(
            f"walkers look {100 * size.change:.2g} % larger in one place than in another, and "
            "lengths with them: the camera does not look straight down, or its lens bends (--lens)"
        )
    if size.scatter > UNSTEADY:
        lines.append(
            f"walkers change their size by {100 * size.scatter:.2g} % as they run: shadows, light "
            "or noise are taken for a part of them"
        )
    return lines


def _length(pixels: float, tracked: Tracked) -> str:
    return f"{words.number(pixels, 2)} pixels ({words.number(pixels * tracked.mm_per_px, 2)} mm)"


def facts(tracked: Tracked, walkers: Sequence[Row]) -> dict[str, Any]:
    """Everything but warnings for JSON and the manifest, with units in the names."""
    linked, look = tracked.linked, tracked.look
    size = doubts.sizes([walker.straight for walker in tracked.walkers])
    return {
        "film": tracked.film.path.name,
        **tracked.options._asdict(),
        "lens": known_lens(tracked.options.lens),
        "fps": tracked.clock.fps,
        "regular_rate": tracked.clock.regular,
        "mm_per_px": tracked.mm_per_px,
        "mm_per_px_se": tracked.mm_per_px_se,
        "frames_looked_at": tracked.looked,
        "frames_without_walkers": linked.empty,
        "frames_with_touching_walkers": linked.merged,
        "frames_without_motion": tracked.still,
        "short_tracks": linked.short,
        "walkers_are": "dark" if look.dark else "light",
        "threshold": look.threshold,
        "width_px": look.width,
        "length_px": linked.length,
        "area_px": linked.area,
        "jitter_mm": _known(tracked.jitter_mm),
        "contrast": look.contrast,
        "noise": look.noise,
        "shake_px": _known(tracked.shake.rms),
        "shake_most_px": _known(tracked.shake.largest),
        "shadow_px": doubts.shadow([walker.seen for walker in tracked.walkers]),
        "size_change_share": size.change,
        "size_change_se_share": _known(size.error),
        "size_scatter_share": size.scatter,
        "tracks": [row._asdict() for row in walkers],
    }


def known_lens(lens: Lens | None) -> dict[str, Any] | None:
    """Lens that is undone, for JSON."""
    return None if lens is None else lens._asdict()


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _lost(frames: "np.ndarray[Any, np.dtype[np.int64]]") -> int:
    """Frames between a track's first and last in which it was not seen."""
    return int(frames[-1] - frames[0] + 1 - len(frames))
