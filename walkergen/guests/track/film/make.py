"""Tracking of a film: walkers with or without markers; writes tracks.csv and check.png."""

from pathlib import Path

from walkergen.core.errors import InputError
from walkergen.core.files.output import Folder
from walkergen.core.files.progress import Progress
from walkergen.guests.track.film import (
    blob_tracking,
    blob_warnings,
    films,
    heading,
    marker_tracking,
    marker_warnings,
    report,
)
from walkergen.guests.track.film.blob_tracking import Unmarked
from walkergen.guests.track.film.films import Box, Film
from walkergen.guests.track.film.marker_tracking import Marked
from walkergen.guests.track.film.quality import Told
from walkergen.guests.track.film.report import TrackReport
from walkergen.guests.track.film.result import Options, Tracked

CONTRAST_SIDES: tuple[str, ...] = ("dark", "light")
"""How walkers may differ from the ground."""

MARKER_KINDS: tuple[str, ...] = ("aruco",)
"""Markers that are read: OpenCV's ArUco."""

MIN_SIZE_PX = 8
"""Smallest width and height of the searched part, pixels."""

MIN_VALUE, MAX_VALUE = 1e-6, 1e9


def track(path: Path, options: Options, folder: Path, progress: Progress) -> TrackReport:
    """Track the walkers of a film and write tracks.csv, check.png and manifest.json.

    Raises InputError, before anything is written, when the film cannot be read or no walker is
    found in it.
    """
    tracks = report.make_report(*find_walkers(path, options, progress), folder)
    from walkergen.files import figures  # brings matplotlib

    with Folder(folder) as target:
        target.write(report.TRACKS_FILE, tracks.table.csv().encode())
        target.write(report.PICTURE_FILE, figures.png(tracks.figures["check"]()))
        target.finish(dict(tracks.facts))
    return tracks


def find_walkers(path: Path, options: Options, progress: Progress) -> tuple[Tracked, Unmarked | Marked, Told]:
    """Return a film's walkers, the findings behind them, and warnings. Raises InputError."""
    films.require_extra()
    check_options(options)
    film = films.probe_film(path)
    if film.pictures and options.fps is None:
        raise InputError(f"{path}: pictures do not say when they were taken; give ‹fps›, how many a second")
    part = select_part(film, options.region)
    found: Unmarked | Marked
    lens = None if options.lens is None else options.lens.for_film(film.width, film.height)
    try:
        if options.markers is None:
            tracked, seen = blob_tracking.track(film, part, options, lens, progress)
            found, told = seen, blob_warnings.collect_doubts(tracked, seen)
        else:
            tracked, read = marker_tracking.track(film, part, options, lens, progress)
            found, told = read, marker_warnings.collect_doubts(tracked, read)
        return tracked, found, told._replace(notes=[*_conversion_notes(film), *told.notes])
    except InputError as error:
        raise error if str(path) in error.text else InputError(f"{path}: {error.text}") from None


def _conversion_notes(film: Film) -> list[str]:
    """Return notes on how a film was changed before tracking."""
    notes = []
    if film.pictures:
        first, last = film.pictures[0].name, film.pictures[-1].name
        notes.append(
            f"The frames are {len(film.pictures)} pictures, from {first} to {last}, by the numbers in their names."
        )
    if film.aspect != 1:
        notes.append(
            f"Pixels of {film.aspect.numerator}:{film.aspect.denominator} were made square: frames of {film.width} x "
            f"{film.height}, in which ‹region›, ‹width› and ‹mm_per_px› count."
        )
    return notes


def check_options(options: Options) -> None:
    """Raise InputError for settings that contradict each other or are out of range."""
    for field, value, most in (
        ("mm_per_px", options.mm_per_px.value, MAX_VALUE),
        ("length", options.length.value, MAX_VALUE),
        ("fps", options.fps, MAX_VALUE),
        ("threshold", options.threshold, 255.0),
        ("width", options.width_px, 1e5),
        ("marker_mm", options.marker.value, MAX_VALUE),
    ):
        if value is not None and not MIN_VALUE <= value <= most:
            raise InputError(f"‹{field}=›{value:g}: must be a number in {MIN_VALUE:g}..{most:g}")
    for field, name, names in (
        ("walkers", options.walkers, CONTRAST_SIDES),
        ("heading", options.heading, heading.HEADING_SOURCES),
        ("markers", options.markers, MARKER_KINDS),
    ):
        if name is not None and name not in names:
            raise InputError(f"‹{field}=›{name[:30]!r}: must be one of {', '.join(names)}")
    _check_scale(options)
    first, last = options.frames
    if first < 0 or (last is not None and last <= first):
        raise InputError(
            f"‹frames=›{first}:{'' if last is None else last}: counts from 0, the first before the "
            "last: 25:100, or 25: up to the end"
        )


def _check_scale(options: Options) -> None:
    """Raise InputError unless exactly one input gives the scale: markers, which give more, or a length."""
    if options.markers is None:
        if options.marker.value is not None:
            raise InputError("‹markers› is not given: leave ‹marker_mm› out")
        if (options.mm_per_px.value is None) == (options.length.value is None):
            raise InputError(
                "the scale: give either ‹mm_per_px›, millimetres per pixel, or ‹length›, the length of a walker in mm"
            )
        return
    beside = {
        "mm_per_px": options.mm_per_px.value,
        "length": options.length.value,
        "walkers": options.walkers,
        "threshold": options.threshold,
        "width": options.width_px,
        "heading": None if options.heading == Options().heading else options.heading,
    }
    for field, value in beside.items():
        if value is not None:
            raise InputError(f"‹markers=›{options.markers} tells it: leave ‹{field}› out")


def select_part(film: Film, region: tuple[int, int, int, int] | None) -> Box:
    """Return left, top, right and bottom of the searched part, pixels. Raises InputError."""
    if region is None and min(film.width, film.height) < MIN_SIZE_PX:
        raise InputError(
            f"{film.path}: {film.width} x {film.height} pixels a frame: at least {MIN_SIZE_PX} x "
            f"{MIN_SIZE_PX}: film larger"
        )
    left, top, width, height = region or (0, 0, film.width, film.height)
    inside = left >= 0 and top >= 0 and left + width <= film.width and top + height <= film.height
    if min(width, height) < MIN_SIZE_PX or not inside:
        raise InputError(
            f"‹region=›{left},{top},{width},{height}: left, top, width, height in pixels must lie "
            f"within the {film.width} x {film.height} of {film.path}, and be {MIN_SIZE_PX} or more "
            "wide"
        )
    return left, top, left + width, top + height
