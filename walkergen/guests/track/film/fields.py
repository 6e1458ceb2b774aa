"""Fields of the request of `track`."""

from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator

from walkergen import film_fields, request
from walkergen.request import Flag


def _parse_frames(value: Any) -> Any:
    """Parse a text FIRST:LAST to the numbers of the first frame and of the frame after the last (None: the end)."""
    if not isinstance(value, str):
        return value
    first, colon, last = value.partition(":")
    cells = [cell.strip() for cell in (first, last)]
    if not colon or any(cell and not _is_whole(cell) for cell in cells):
        raise ValueError("must be FIRST:LAST, as 25:100, or 25: or :100")
    return int(cells[0] or 0), int(cells[1]) if cells[1] else None


def _parse_region(value: Any) -> Any:
    """Parse a text LEFT,TOP,WIDTH,HEIGHT to four whole numbers of pixels. Other values pass unchanged."""
    if not isinstance(value, str):
        return value
    cells = [cell.strip() for cell in value.split(",")]
    if len(cells) != 4 or not all(map(_is_whole, cells)):
        raise ValueError("must be LEFT,TOP,WIDTH,HEIGHT in whole pixels")
    return tuple(map(int, cells))


def _is_whole(cell: str) -> bool:
    """Return whether a cell is a whole number of at most seven plain digits."""
    return cell.isascii() and cell.isdigit() and len(cell) <= 7


class TrackFields(request.Request):
    """Choices of `track`."""

    by_position: ClassVar = ("film",)

    film: Annotated[
        Path, request.File, Flag("Film from above, or a folder of its pictures.", "FILM", takes="Name", argument=True)
    ]
    mm_per_px: film_fields.MmPerPx = None
    length: Annotated[
        film_fields.Measured,
        BeforeValidator(film_fields.parse_measured),
        Flag("Length of a walker, mm, for the scale, as 28 or 28±0.1.", "MM", takes="float | str | None"),
    ] = None
    fps: Annotated[float | None, Flag("Frames per second when filmed: of slow motion, of pictures.", "N")] = None
    frames: Annotated[
        tuple[int, int | None],
        BeforeValidator(_parse_frames),
        Flag("Frames to look at, from 0: 25:100, or 25:.", "FIRST:LAST", takes="tuple[int, int | None] | str"),
    ] = (0, None)
    region: Annotated[
        tuple[int, int, int, int] | None,
        BeforeValidator(_parse_region),
        Flag(
            "Left, top, width and height to look at, pixels.", "X,Y,W,H", takes="tuple[int, int, int, int] | str | None"
        ),
    ] = None
    walkers: Annotated[
        Literal["dark", "light"] | None, Flag("Walkers are dark or light; by default the wider objects.", "SIDE")
    ] = None
    threshold: Annotated[float | None, Flag("Contrast of a walker with the ground, of 255 levels.", "LEVELS")] = None
    width: Annotated[float | None, Flag("Width of a walker, its shorter side, pixels.", "PX")] = None
    heading: Annotated[
        Literal["motion", "mark"],
        Flag("Source of the front: motion (direction of running) or mark (a spot on it).", "BY"),
    ] = "motion"
    markers: Annotated[Literal["aruco"] | None, Flag("Markers on the walkers, from `plate --caps`: aruco.", "KIND")] = (
        None
    )
    marker_mm: Annotated[
        film_fields.Measured,
        BeforeValidator(film_fields.parse_measured),
        Flag("Side of the markers, mm, as 7.2 or 7.2±0.05.", "MM", takes="float | str | None"),
    ] = None
    lens: Annotated[
        Path | None,
        request.File,
        Flag(
            "Calibration of the lens by OpenCV: image_width, image_height, camera_matrix, distortion_coefficients.",
            "LENS.json",
            takes="Name | None",
        ),
    ] = None
    out: request.Out = None
