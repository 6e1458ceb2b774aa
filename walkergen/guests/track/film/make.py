"""Tracking of a film: walkers with or without markers; writes tracks.csv and check.png."""

from pathlib import Path

from walkergen.core.errors import InputError
from walkergen.core.files.output import Folder
from walkergen.core.files.progress import Progress
from walkergen.guests.track.film import (
    blob_tracking,
    blob_warnings,
    films,
    lens,
    marker_tracking,
    marker_warnings,
    report,
)
from walkergen.guests.track.film.blob_tracking import Unmarked
from walkergen.guests.track.film.fields import TrackFields
from walkergen.guests.track.film.films import Box, Film
from walkergen.guests.track.film.marker_tracking import Marked
from walkergen.guests.track.film.quality import Remarks
from walkergen.guests.track.film.report import TrackReport
from walkergen.guests.track.film.result import Tracked

MIN_SIZE_PX = 8
"""Smallest width and height of the searched part, pixels."""

MIN_VALUE, MAX_VALUE = 1e-6, 1e9
"""Range of lengths, scales and rates."""


def track(request: TrackFields, folder: Path, progress: Progress) -> TrackReport:
    """Track the walkers of a film, write tracks.csv, check.png and manifest.json, and return the report.

    Raises InputError, before anything is written, if the film cannot be read or shows no walker.
    """
    tracks = report.make_report(*find_walkers(request, progress), folder)
    from walkergen.files import figures  # brings matplotlib

    with Folder(folder) as target:
        target.write(report.TRACKS_FILE, tracks.table.csv().encode())
        target.write(report.PICTURE_FILE, figures.png(tracks.figures["check"]()))
        target.finish(dict(tracks.facts))
    return tracks


def find_walkers(request: TrackFields, progress: Progress) -> tuple[Tracked, Unmarked | Marked, Remarks]:
    """Return a film's walkers, the findings behind them, and warnings. Raises InputError."""
    path = request.film
    calibrated = None if request.lens is None else lens.read_lens(request.lens)
    films.require_extra()
    check_request(request)
    film = films.probe_film(path)
    own_lens = calibrated and calibrated.for_film(film.width, film.height)
    if film.pictures and request.fps is None:
        raise InputError(f"{path}: pictures have no times. Give their rate, ‹fps›")
    part = select_part(film, request.region)
    found: Unmarked | Marked
    try:
        if request.markers is None:
            tracked, seen = blob_tracking.track(film, part, request, own_lens, progress)
            found, remarks = seen, blob_warnings.collect_remarks(tracked, seen)
        else:
            tracked, read = marker_tracking.track(film, part, request, own_lens, progress)
            found, remarks = read, marker_warnings.collect_remarks(tracked, read)
        return tracked, found, remarks._replace(notes=[*_conversion_notes(film), *remarks.notes])
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
            f"{film.height}. ‹region›, ‹width› and ‹mm_per_px› count these pixels."
        )
    return notes


def check_request(request: TrackFields) -> None:
    """Raise InputError for values that exclude each other or are out of range."""
    for field, value, largest in (
        ("mm_per_px", request.mm_per_px and request.mm_per_px[0], MAX_VALUE),
        ("length", request.length and request.length[0], MAX_VALUE),
        ("fps", request.fps, MAX_VALUE),
        ("threshold", request.threshold, 255.0),
        ("width", request.width, 1e5),
        ("marker_mm", request.marker_mm and request.marker_mm[0], MAX_VALUE),
    ):
        if value is not None and not MIN_VALUE <= value <= largest:
            raise InputError(f"‹{field}=›{value:g}: must be a number in {MIN_VALUE:g}..{largest:g}")
    if request.markers is not None:
        for field in ("mm_per_px", "length", "walkers", "threshold", "width", "heading"):
            if getattr(request, field) != type(request).model_fields[field].default:
                raise InputError(f"‹markers=›{request.markers} determines it: leave ‹{field}› out")
    elif request.marker_mm is not None:
        raise InputError("‹markers› is not given: leave ‹marker_mm› out")
    elif (request.mm_per_px is None) == (request.length is None):
        raise InputError(
            "the scale: give either ‹mm_per_px›, millimetres per pixel, or ‹length›, the length of a walker in mm"
        )
    first, last = request.frames
    if first < 0 or (last is not None and last <= first):
        raise InputError(
            f"‹frames=›{first}:{'' if last is None else last}: must count from 0, with the first before the last. "
            "Write 25:100, or 25: up to the end"
        )


def select_part(film: Film, region: tuple[int, int, int, int] | None) -> Box:
    """Return left, top, right, bottom (pixels) of the part given by left, top, width, height. Raises InputError."""
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
