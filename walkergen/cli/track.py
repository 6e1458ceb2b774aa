"""The command `track`."""

from pathlib import Path
from typing import Annotated

import typer

from walkergen.cli import options as opt
from walkergen.cli import show
from walkergen.errors import InputError


def track(
    film: Annotated[Path, typer.Argument(metavar="FILM", help="Film from above: MP4, MOV, AVI.")],
    mm_per_px: Annotated[
        str | None, typer.Option(metavar="MM", help="Millimetres per pixel of the film, as 0.05±0.001.")
    ] = None,
    length: Annotated[
        str | None, typer.Option(metavar="MM", help="Length of a walker, mm, for the scale, as 28 or 28±0.1.")
    ] = None,
    fps: Annotated[
        float | None, typer.Option(metavar="N", help="Frames per second when filmed, if it plays slower.")
    ] = None,
    frames: Annotated[
        str, typer.Option(metavar="FIRST:LAST", help="Frames to look at, from 0: 25:100, or 25:.")
    ] = "0:",
    region: Annotated[
        str | None, typer.Option(metavar="X,Y,W,H", help="Left, top, width and height to look at, pixels.")
    ] = None,
    walkers: Annotated[
        str | None, typer.Option(metavar="SIDE", help="Walkers are dark or light; by default what is wider.")
    ] = None,
    threshold: Annotated[
        float | None, typer.Option(metavar="STEPS", help="Contrast of a walker with the ground, of 255 steps.")
    ] = None,
    width: Annotated[
        float | None, typer.Option(metavar="PX", help="Width of a walker, its shorter side, pixels.")
    ] = None,
    heading: Annotated[
        str, typer.Option(metavar="BY", help="Front by motion (the way it runs) or mark (a spot on it).")
    ] = "motion",
    markers: Annotated[
        str | None, typer.Option(metavar="KIND", help="Markers that walkers bear, by `plate --caps`: aruco.")
    ] = None,
    marker_mm: Annotated[
        str | None, typer.Option(metavar="MM", help="Side of the markers, mm, as 7.2 or 7.2±0.05.")
    ] = None,
    lens: Annotated[
        Path | None,
        typer.Option(
            metavar="LENS.json",
            help="Calibration of a lens that bends, by OpenCV: image_width, image_height, "
            "camera_matrix, distortion_coefficients.",
        ),
    ] = None,
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Track walkers in a film from above: tracks.csv for analyse, and a picture to check.

    The walkers are of one size, on a ground of another brightness, seen straight from above. Give
    the scale by --mm-per-px or --length. With --markers they bear caps, whose markers tell number,
    place and heading, scale and tilt of the camera. What a lens bends is undone by --lens. Needs
    the extra film: pip install 'walkergen[film]'.
    """
    from walkergen.files import output
    from walkergen.files.measured import measured
    from walkergen.track.film import lens as lenses
    from walkergen.track.film import make
    from walkergen.track.film.result import Options

    scale, scale_se = measured(mm_per_px, "--mm-per-px")
    long, long_se = measured(length, "--length")
    side, side_se = measured(marker_mm, "--marker-mm")
    options = Options(
        mm_per_px=scale,
        mm_per_px_se=scale_se,
        length_mm=long,
        length_se_mm=long_se,
        fps=fps,
        frames=_frames(frames),
        region=None if region is None else _region(region),
        walkers=walkers,
        threshold=threshold,
        width_px=width,
        heading=heading,
        lens=None if lens is None else lenses.read(lens),
        markers=markers,
        marker_mm=side,
        marker_se_mm=side_se,
    )
    folder = output.results(film, out, "track")
    with show.progress("track", wanted=not quiet) as progress:
        result = make.track(film, options, folder, progress)
    show.report(result, json, quiet)


def _frames(text: str) -> tuple[int, int | None]:
    """First frame, and the one after the last. Raises InputError."""
    first, colon, last = text.partition(":")
    cells = [cell.strip() for cell in (first, last)]
    if not colon or any(cell and not _whole(cell) for cell in cells):
        raise InputError(f"--frames {text[:40]!r}: must be FIRST:LAST, as 25:100, or 25: or :100")
    return int(cells[0] or 0), int(cells[1]) if cells[1] else None


def _region(text: str) -> tuple[int, int, int, int]:
    """Left, top, width and height. Raises InputError."""
    cells = [cell.strip() for cell in text.split(",")]
    if len(cells) != 4 or not all(map(_whole, cells)):
        raise InputError(f"--region {text[:40]!r}: must be LEFT,TOP,WIDTH,HEIGHT in whole pixels")
    left, top, width, height = map(int, cells)
    return left, top, width, height


def _whole(cell: str) -> bool:
    """True for a whole number of at most seven plain digits."""
    return cell.isascii() and cell.isdigit() and len(cell) <= 7
