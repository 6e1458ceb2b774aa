"""Analysis of tracks: from a file of tracks to a folder of tables and figures of their motion."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from walkergen.analysis import motion, tracks
from walkergen.analysis.facts import scale_errors
from walkergen.analysis.motion import Array, Motion
from walkergen.analysis.tracks import Tracks, Units
from walkergen.files.output import Folder
from walkergen.files.progress import Progress
from walkergen.jobs.analyse import tables as motion_tables

MSD = ("lag_s", "msd_mm2", "se_mm2", "scale_se_mm2", "exponent", "exponent_se")
"""Columns of msd.csv."""


class Studied(NamedTuple):
    """Tracks as they were read, and what they tell."""

    tracks: Tracks
    motion: Motion
    notes: list[str]


class Analysed(NamedTuple):
    """Results of `analyse`, and the folder they were written to."""

    motion: Motion
    notes: list[str]
    bad_rows: int
    folder: Path


def study(path: Path, units: Units, lag_s: float | None, progress: Progress) -> Studied:
    """Read tracks and measure their motion; writes nothing. Raises InputError."""
    progress("reading", 0, 3)
    found = tracks.read(path, units)
    progress("measuring", 1, 3)
    result = motion.analyse(found, lag_s)._replace(scale_se=found.scale_se)
    fit = result.msd_fit.told if result.msd_fit else ""
    told = [result.method, fit, *result.doubts, motion_tables.scale_told(result), found.told]
    return Studied(found, result, [f"{line}." for line in told if line])


def analyse(
    path: Path, units: Units, lag_s: float | None, folder: Path, pictures: bool, progress: Progress
) -> Analysed:
    """Read tracks, measure their motion and write tables and figures.

    Writes analysis.csv, analysis.md, walkers.csv, msd.csv, density.csv, correlation.csv, figures
    as PNG and PDF, manifest.json. Raises InputError before anything is written.
    """
    studied = study(path, units, lag_s, progress)
    write(studied, path.name, units, folder, pictures, progress)
    return Analysed(studied.motion, studied.notes, studied.tracks.bad_rows, folder)


def write(
    studied: Studied, title: str, units: Units, folder: Path, pictures: bool, progress: Progress
) -> None:
    """Write tables and figures of tracks, of a file called `title`, as `analyse` says."""
    found, result, notes = studied
    with Folder(folder) as target:
        target.write("analysis.csv", motion_tables.to_csv(result).encode())
        target.write("analysis.md", motion_tables.to_markdown(result, title, notes).encode())
        target.write("walkers.csv", motion_tables.walkers_csv(result).encode())
        if not result.by_plate_speed:
            _write_curves(result, target)
        progress("drawing", 2, 3)
        if pictures:
            _write_figures(result, found, title, target)
        facts: dict[str, Any] = {"file": title, **units._asdict(), "lag_s": result.lag_s}
        target.finish(facts)


def _write_curves(result: Motion, target: Folder) -> None:
    msd = (*result.msd, scale_errors(result), *result.exponent[1:])
    tables: dict[str, tuple[Sequence[str], Sequence[tuple[str, Sequence[Array]]]]] = {
        "msd.csv": (MSD, [("", msd)]),
        "correlation.csv": (("lag_s", "value", "se"), [("", result.correlation)]),
        "density.csv": (
            ("direction", "mm", "density_per_mm", "se_per_mm"),
            [("parallel", result.parallel), ("orthogonal", result.orthogonal)],
        ),
    }
    for name, (columns, curves) in tables.items():
        target.write(name, motion_tables.curve_to_csv(columns, curves).encode())


def _write_figures(result: Motion, found: tracks.Tracks, title: str, target: Folder) -> None:
    from walkergen.files import figures as pictures
    from walkergen.jobs.analyse import figures as motion_plots

    for name, figure in motion_plots.figures(result, found, title):
        target.write(f"{name}.png", pictures.png(figure))
        target.write(f"{name}.pdf", pictures.pdf(figure))
