"""Report of tracking: tracks, walkers, and warnings with their numbers."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from walkergen.core import Quantity
from walkergen.core.files import formatting
from walkergen.files import report
from walkergen.files.report import Column, Report, Table
from walkergen.guests.track.film import quality
from walkergen.guests.track.film.quality import Remarks
from walkergen.guests.track.film.result import Tracked

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from walkergen.guests.track.film.blob_tracking import Unmarked
    from walkergen.guests.track.film.marker_tracking import Marked

COLUMNS = ("frame", "particle", "x", "y", "theta", "t_s", "x_mm", "y_mm", "theta_rad", "mm_per_px", "mm_per_px_se")
"""Columns of tracks.csv: first trackpy's names (in mm and rad), then walkergen's names with units.

The last two are the scale, already applied to positions, and its standard error, blank if unknown. Every length
measured from the tracks shares this error. With markers a particle is the number of its marker.
"""

TRACKS_FILE, PICTURE_FILE = "tracks.csv", "check.png"
"""Names of the file of tracks, and of the picture for checking them."""


@dataclass(frozen=True, kw_only=True, repr=False)
class TrackReport(Report):
    """Walkers tracked in a film. Check `picture` before you use the numbers."""

    tracked: Tracked
    """Tracked walkers, with the film, its times and its scale."""
    found: "Unmarked | Marked"
    """Findings behind the tracks: of walkers without markers, or with them."""
    picture: Path
    """Picture for checking the tracks."""


class Row(NamedTuple):
    """Row of a walker in the table of walkers; the field names are keys of JSON."""

    particle: int
    first: int
    """First frame that shows the walker."""
    last: int
    lost: int
    """Number of frames between first and last that do not show the walker."""
    net_mm: float
    path_mm: float
    turned_deg: float | None
    """Change of the heading from the first known one to the last; None if unknown."""
    size_px: float
    """Side of its marker in the picture, or its length."""
    heading_by: str
    headings: int
    """Number of frames with a known heading."""


WALKER_COLUMNS = (
    report.number_column("walker", "particle"),
    Column("frames", lambda row: f"{row.first}..{row.last}", right=True),
    Column("lost", lambda row: str(row.lost), right=True),
    report.number_column("displacement (mm)", "net_mm", 3),
    report.number_column("path (mm)", "path_mm", 3),
    report.number_column("turned (deg)", "turned_deg", 3),
    report.number_column("size (px)", "size_px", 3, wide=True),
    report.text_column("heading from", "heading_by"),
)


def make_report(tracked: Tracked, found: "Unmarked | Marked", remarks: Remarks, folder: Path) -> TrackReport:
    """Make the report of a tracked film. `found`: findings behind its tracks. `remarks`: notes and warnings."""
    walkers, title = _walker_rows(tracked), tracked.film.path.name
    warnings = [*quality.truncation_warnings(tracked.film, tracked.clock, tracked.request.frames), *remarks.warnings]
    picture, lines = folder / PICTURE_FILE, [*remarks.notes]
    if not math.isnan(tracked.jitter_mm):
        lines.append(
            f"Positions jitter by {formatting.format_number(tracked.jitter_mm, 2)} mm between neighbouring frames. "
            "Constant and slowly changing errors, from shadows, the lens or a cap's height, are not included."
        )

    def draw() -> "Figure":
        from walkergen.guests.track.film import figures

        return figures.draw_check(tracked)

    return TrackReport(
        name="track",
        title=title,
        tables=[
            Table("tracks", track_rows(tracked), COLUMNS, title=title),
            report.table_from_rows("walkers", walkers, WALKER_COLUMNS, title),
        ],
        facts=_facts(tracked, remarks) | {"tracks": [row._asdict() for row in walkers], "warnings": warnings},
        lines=[*lines, f"{picture}: look at it before you trust the numbers"],
        figures={"check": draw},
        folder=folder,
        tracked=tracked,
        found=found,
        picture=picture,
        warnings=warnings,
    )


def track_rows(tracked: Tracked) -> list[tuple[Any, ...]]:
    """Return the rows of tracks.csv, frame by frame."""
    rows = []
    for walker in tracked.walkers:
        for frame, (x, y), theta in zip(
            walker.frames.tolist(), walker.position.tolist(), walker.theta.tolist(), strict=True
        ):
            place = (x, y, None if math.isnan(theta) else theta)
            scale = (tracked.mm_per_px.value, tracked.mm_per_px.se)
            rows.append((frame, walker.number, *place, float(tracked.clock.times[frame]), *place, *scale))
    return sorted(rows, key=lambda row: row[:2])


def _walker_rows(tracked: Tracked) -> list[Row]:
    """Return the row of each walker in the table of walkers."""
    return [
        Row(
            walker.number,
            int(walker.frames[0]),
            int(walker.frames[-1]),
            walker.lost,
            walker.net_mm,
            tracked.path_mm(walker),
            walker.turned_deg,
            walker.size_px,
            walker.heading_by,
            sum(not math.isnan(theta) for theta in walker.theta),
        )
        for walker in tracked.walkers
    ]


def _facts(tracked: Tracked, remarks: Remarks) -> dict[str, Any]:
    """Return facts for JSON and the manifest, without walkers and warnings. Their names have units."""
    request, jitter = tracked.request, tracked.jitter_mm
    return {
        "film": tracked.film.path.name,
        **Quantity("mm_per_px", "", *(request.mm_per_px or (None,))).row(),
        **Quantity("length", "mm", *(request.length or (None,))).row(),
        **{name: getattr(request, name) for name in ("frames", "region", "walkers", "threshold", "heading", "markers")},
        "width_px": request.width,
        **Quantity("marker", "mm", *(request.marker_mm or (None,))).row(),
        "lens": tracked.lens and tracked.lens._asdict(),
        "fps": tracked.clock.fps,
        "regular_rate": tracked.clock.regular,
        **tracked.mm_per_px.row(),
        "frames_looked_at": tracked.looked,
        "jitter_mm": None if math.isnan(jitter) else jitter,
        **remarks.facts,
    }
