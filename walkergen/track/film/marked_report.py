"""Report of what was tracked by markers, and its files: tracks, walkers, plane, warnings."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from walkergen.files import figures, report, words
from walkergen.files.output import Folder
from walkergen.files.progress import Progress
from walkergen.files.report import Column, Report, Table
from walkergen.track.film import doubts, marked, marked_doubts
from walkergen.track.film.marked import Marked, Walker, Wish
from walkergen.track.film.report import COLUMNS, PICTURE, TRACKS, known_lens, rate

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EDGES = 0.2
"""Standard error of a marker's side in the picture, pixels: what its blurred edges leave of the
scale. Drawn films err by that where walkers blur by 2 pixels a frame, by a tenth where none do."""


@dataclass(frozen=True, kw_only=True, repr=False)
class MarkedReport(Report):
    """Walkers that were tracked by markers; look at `.picture` before you believe the numbers."""

    marked: Marked
    """Everything that was found, walker by walker."""
    picture: Path
    """Picture of what was found, to be looked at."""


class Row(NamedTuple):
    """Track of a walker; the field names are keys of JSON."""

    particle: int
    """Number of its marker."""
    first: int
    """First frame in which it was read."""
    last: int
    net_mm: float
    path_mm: float
    turned_deg: float
    """Change of its heading from its first frame to its last."""
    lost: int
    """Frames between these in which it was not read."""
    side_px: float


WALKERS = (
    report.number("walker", "particle"),
    Column("frames", lambda row: f"{row.first}..{row.last}", right=True),
    Column("lost", lambda row: str(row.lost), right=True),
    report.number("net way (mm)", "net_mm", 3),
    report.number("path (mm)", "path_mm", 3),
    report.number("turned (deg)", "turned_deg", 3),
    report.number("marker (px)", "side_px", 3),
)


def track(path: Path, wish: Wish, folder: Path, progress: Progress) -> MarkedReport:
    """Track a film's walkers by their markers; write tracks.csv, check.png and manifest.json.

    Raises InputError, before anything is written, as `marked.find` does.
    """
    tracks = of(marked.find(path, wish, progress), folder)
    with Folder(folder) as target:
        target.write(TRACKS, tracks.table.csv().encode())
        target.write(PICTURE, figures.png(tracks.figures["check"]()))
        target.finish(dict(tracks.facts))
    return tracks


def of(found: Marked, folder: Path) -> MarkedReport:
    """Report of a tracked film, to be written into a folder."""
    walkers = [_row(found, walker) for walker in found.walkers]
    title, picture = found.film.path.name, folder / PICTURE
    warned = marked_doubts.of(found)

    def draw() -> "Figure":
        from walkergen.track.film import marked_figures

        return marked_figures.check_figure(found)

    return MarkedReport(
        name="track",
        title=title,
        tables=[Table("tracks", rows(found), COLUMNS, title=title), report.table("walkers", walkers, WALKERS, title)],
        facts=facts(found, walkers) | {"warnings": warned},
        lines=[*notes(found), f"{picture}: look at it before you believe the numbers"],
        figures={"check": draw},
        folder=folder,
        marked=found,
        picture=picture,
        warnings=warned,
    )


def rows(found: Marked) -> list[tuple[Any, ...]]:
    """Rows of tracks.csv, frame by frame; a walker's particle is the number of its marker.

    The scale is that in the middle of the picture; its standard error is that of all lengths.
    """
    scale = found.plane.mm_per_px
    scales = (scale, scale * scale_error(found))
    table = [
        (frame, walker.number, x, y, theta, float(found.clock.times[frame]), x, y, theta, *scales)
        for walker in found.walkers
        for frame, (x, y), theta in zip(
            walker.frames.tolist(), walker.position.tolist(), walker.theta.tolist(), strict=True
        )
    ]
    return sorted(table, key=lambda row: row[:2])


def scale_error(found: Marked) -> float:
    """Standard error of all lengths as a share: of the markers' true size, and of their edges."""
    side = float(np.median([walker.side_px for walker in found.walkers]))
    size = (found.wish.marker_se_mm or 0.0) / found.wish.marker_mm
    return math.hypot(size, EDGES / side)


def jitter_mm(found: Marked) -> float:
    """Error of a place that changes from frame to frame, mm; NaN for too few frames."""
    return doubts.jitter([_unbroken(found, walker) for walker in found.walkers])


def _unbroken(found: Marked, walker: Walker) -> tuple[marked.Array, marked.Array]:
    """Times and places of all frames from a walker's first to its last; NaN where lost."""
    first, last = walker.frames[[0, -1]]
    places = np.full((last - first + 1, 2), np.nan)
    places[walker.frames - first] = walker.position
    return found.clock.times[first : last + 1], places


def _row(found: Marked, walker: Walker) -> Row:
    noise = jitter_mm(found)
    first, last = int(walker.frames[0]), int(walker.frames[-1])
    return Row(
        walker.number,
        first,
        last,
        math.dist(walker.position[0], walker.position[-1]),
        doubts.path(walker.position, 0.0 if math.isnan(noise) else noise),
        math.degrees(float(walker.theta[-1] - walker.theta[0])),
        last - first + 1 - len(walker.frames),
        walker.side_px,
    )


def notes(found: Marked) -> list[str]:
    """What was read, in words: scale, tilt, rate and jitter."""
    flat, wish = found.plane, found.wish
    size = f"{words.number(wish.marker_mm, 4)} mm"
    if wish.marker_se_mm is not None:
        size += f" ± {words.number(wish.marker_se_mm, 2)}"
    pixels = " to ".join(dict.fromkeys(words.number(side, 3) for side in _sides(found)))
    lines = [
        f"Markers {size} wide, black frame included (--marker-mm), {pixels} pixels in the picture: "
        f"{words.number(flat.mm_per_px, 4)} mm a pixel in its middle ± "
        f"{words.number(100.0 * scale_error(found), 2)} %; {rate(found.clock)}.",
        f"The camera is tilted by {flat.tilt_deg:.0f} deg, and lengths differ by "
        f"{100.0 * _scale_change(found):.2g} % between the places of walkers: undone. Corners lie "
        f"{words.number(flat.residual_px, 2)} pixels off those of squares.",
    ]
    if not math.isnan(noise := jitter_mm(found)):
        lines.append(
            f"Places jitter by {words.number(noise, 2)} mm between neighbouring frames. It is no "
            "bound: a lens that bends, or caps of another height, are not in it."
        )
    return lines


def _sides(found: Marked) -> tuple[float, float]:
    sides = [walker.side_px for walker in found.walkers]
    return min(sides), max(sides)


def _scale_change(found: Marked) -> float:
    """Share by which lengths differ between the places that walkers reach."""
    scales = np.concatenate([found.plane.scales(walker.straight.mean(axis=1)) for walker in found.walkers])
    return float(scales.max() / scales.min() - 1.0)


def facts(found: Marked, walkers: list[Row]) -> dict[str, Any]:
    """Everything but warnings for JSON and the manifest, with units in the names."""
    flat, out, noise = found.plane, found.left_out, jitter_mm(found)
    return {
        "film": found.film.path.name,
        "markers": "aruco",
        **found.wish._asdict(),
        "lens": known_lens(found.wish.lens),
        "film_fps": found.clock.fps,
        "regular_rate": found.clock.regular,
        "mm_per_px": flat.mm_per_px,
        "mm_per_px_se": flat.mm_per_px * scale_error(found),
        "tilt_deg": flat.tilt_deg,
        "scale_change_share": _scale_change(found),
        "plane_terms": flat.terms.tolist(),
        "plane_terms_se": flat.errors.tolist(),
        "corners_off_px": flat.residual_px,
        "jitter_mm": None if math.isnan(noise) else noise,
        "frames_looked_at": found.looked,
        "frames_without_markers": len(found.empty),
        "seen_twice_frames": {str(key): count for key, count in out.twice.items()},
        "seen_rarely_frames": {str(key): count for key, count in out.rare.items()},
        "sightings_left_out": sum(out.bent.values()),
        "mirrored": list(out.mirrored),
        "tracks": [row._asdict() for row in walkers],
    }
