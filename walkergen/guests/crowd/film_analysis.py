"""Analysis of a crowd's tracks: collective motion in a dish, film by film."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from walkergen.analysis import track_files
from walkergen.analysis.track_files import Units
from walkergen.core import Array, Design, Dish, Folder, InputError, Progress, parse_dish, parse_number, shorten_line
from walkergen.files import templates
from walkergen.files.report import Report
from walkergen.guests.crowd import figures as crowd_figures
from walkergen.guests.crowd import statistics as crowds
from walkergen.guests.crowd import tables as crowd_tables
from walkergen.guests.crowd.statistics import dish_geometry as ground
from walkergen.guests.crowd.statistics import film
from walkergen.guests.crowd.statistics.film import CrowdFilm
from walkergen.readers.walkers import top_outline

DISC_CORNERS = 48
"""Corners of a round body: its area is 0.3 % too small."""

MAX_OUTSIDE_SHARE = 0.02
"""Largest share of positions outside the walls that is accepted, because tracks have errors."""

MIN_SIZE_MM, MAX_SIZE_MM = 1e-3, 1e5
"""Limits of a body's sizes, and of the middle's distance from the origin, mm."""


class FilmedCrowd(NamedTuple):
    """Settings for the analysis of a filmed crowd."""

    dish: Dish
    contours: tuple[Array, ...]
    """Contours of a body's outline, shape (corners, 2) each, mm; empty if unknown."""
    middle: tuple[float, float]
    """Position x, y of the dish's middle in the tracks, mm."""
    others: tuple[Path, ...]
    """Tracks of other independent runs of the same crowd."""


def parse_crowd(dish: str, body: str | None, middle: str | None, others: Sequence[Path]) -> FilmedCrowd:
    """Parse a crowd's dish as "disc:120", body as "24x8" and middle as "60,60". `others`: more tracks of the crowd."""
    parsed_dish = parse_dish(dish, "‹dish›")
    return FilmedCrowd(parsed_dish, _parse_body(body), _parse_middle(middle), tuple(others))


def analyse(
    files: Sequence[Path], units: Units, crowd: FilmedCrowd, folder: Path | None, pictures: bool, progress: Progress
) -> Report:
    """Return the report of a filmed crowd from its tracks and, if there is a folder, write it there.

    `files`: tracks of the first run.

    Writes crowd.csv, crowd.md, tables of its course, its runs and its curves, figures as PNG and
    PDF, the last frame from above, and manifest.json. Raises InputError before anything is written.
    """
    paths, path = (tuple(files), *((other,) for other in crowd.others)), files[0]
    films = []
    for number, each in enumerate(paths):
        progress("reading", number, len(paths) + 1)
        films.append(_read_film(each, units, crowd))
    progress("measuring", len(paths), len(paths) + 1)
    statistics = crowds.measure(films)
    report = Report(
        name="crowd",
        title=path.name,
        tables=crowd_tables.make_tables(statistics),
        facts=crowd_tables.facts(statistics),
        lines=[crowd_tables.summary_line(statistics)],
        figures=crowd_figures.figure_functions(statistics, path.name),
        folder=folder,
    )
    if folder is not None:
        with Folder(folder) as target:
            report.write(target, pictures)
            if pictures:
                from walkergen.guests.crowd import movie as crowd_movie

                target.write("crowd_above.png", crowd_movie.render_still(films[0], path.name))
            names = [each.name for run in paths for each in run]
            facts = {"dish": crowd.dish.words, "middle_mm": list(crowd.middle)}
            target.finish({"files": names, **units._asdict(), **facts})
    return report


def _read_film(paths: Sequence[Path], units: Units, crowd: FilmedCrowd) -> CrowdFilm:
    """Read the files of a run as a film whose origin is the middle of the dish.

    Raises
    ------
    InputError
        For walkers in a lane, or if more than MAX_OUTSIDE_SHARE of the positions lie outside the walls.
    """
    read, path = track_files.read_recording(paths, units), paths[0]
    if read.lane:
        raise InputError(
            f"‹dish›: only for walkers on a plane, but {path} has walkers in a lane. Remove ‹dish› or ‹lane›."
        )
    made = film.from_tracks(read, crowd.dish, crowd.contours)
    made = made._replace(x=made.x - crowd.middle[0], y=made.y - crowd.middle[1])
    seen = np.isfinite(made.x)
    beyond = float((ground.wall_distance(made.x[seen], made.y[seen], crowd.dish) < 0).mean())
    if beyond > MAX_OUTSIDE_SHARE:
        x, y = (round(0.5 * float(np.nanmin(part) + np.nanmax(part)), 3) for part in (made.x, made.y))
        centre = f"{x + crowd.middle[0]:.4g},{y + crowd.middle[1]:.4g}"
        raise InputError(
            f"‹dish=›{crowd.dish.words}: {100 * beyond:.3g} % of the places in {path} lie outside its walls. "
            f"Give the centre of the dish, ‹middle=›X,Y (mm). The centre of the tracks is {centre}."
        )
    return made


def _parse_body(body: str | None) -> tuple[Array, ...]:
    """Return the contours (mm) of a body given as LENGTHxWIDTH, DIAMETER or a walker; empty if it is not given.

    Each contour has shape (corners, 2): x forward, y to the left. Raises InputError.
    """
    if body is None:
        return ()
    sizes = [parse_number(word) for word in body.split("x")]
    if sizes[0] is None:
        return tuple(top_outline.outline_of(templates.load(body, "walkers", Design)))
    if len(sizes) > 2 or not all(size is not None and MIN_SIZE_MM <= size <= MAX_SIZE_MM for size in sizes):
        raise InputError(
            f"‹body=›{shorten_line(body)[:40]}: must be LENGTHxWIDTH in mm, such as 24x8, the DIAMETER of a "
            f"disc in mm, such as 20, or a walker. Sizes must lie in {MIN_SIZE_MM:g}..{MAX_SIZE_MM:g} mm."
        )
    half = 0.5 * np.array([size for size in sizes if size is not None])
    if len(half) == 2:
        return (half * np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]),)
    angle = np.linspace(0.0, 2.0 * np.pi, DISC_CORNERS, endpoint=False)
    return (half * np.column_stack([np.cos(angle), np.sin(angle)]),)


def _parse_middle(middle: str | None) -> tuple[float, float]:
    """Parse the position "X,Y" of the dish's middle in the tracks, mm. It is the origin by default."""
    if middle is None:
        return 0.0, 0.0
    numbers = [parse_number(word) for word in middle.split(",")]
    if len(numbers) != 2 or any(n is None or abs(n) > MAX_SIZE_MM for n in numbers):
        raise InputError(f"‹middle=›{shorten_line(middle)[:40]}: must be X,Y in mm, as 60,55, within ±{MAX_SIZE_MM:g}")
    x, y = (float(number or 0.0) for number in numbers)
    return x, y
