"""Analysis of tracks: from files of tracks to a report of their motion, and a folder with the results."""

from collections.abc import Sequence
from pathlib import Path

from walkergen.analysis import motion, track_files, walls
from walkergen.analysis.track_files import Units
from walkergen.core.dish import Dish
from walkergen.core.files.output import Folder
from walkergen.core.files.progress import Progress
from walkergen.guests.track.analyse import report
from walkergen.guests.track.analyse.report import AnalysisReport


def analyse(
    paths: Sequence[Path],
    units: Units,
    lag_s: float | None,
    arena: Dish | None,
    descent: float | None,
    folder: Path | None,
    pictures: bool,
    progress: Progress,
) -> AnalysisReport:
    """Return the report of the motion in one or several files of tracks and, if there is a folder, write it there.

    `lag_s`: lag of displacements, None for the default. Walls are those of an `arena`, or those that the tracks show.
    The plate descends toward `descent` (rad), or is level if None. Writes analysis.csv, analysis.md, walkers.csv,
    msd.csv, density.csv, correlation.csv, or at several plate speeds plate_speed.csv in place of these curves, figures
    as PNG and PDF, manifest.json. Raises InputError before anything is written.
    """
    progress("reading", 0, 3)
    read = track_files.read_recording(paths, units)
    progress("measuring", 1, 3)
    measured = motion.analyse(read, lag_s, walls.find_walls(read, arena), descent)._replace(scale_se=read.scale_se)
    more = f" and {len(paths) - 1} more" if len(paths) > 1 else ""
    analysis = report.make_report(read, measured, paths[0].name + more, folder)
    if folder is not None:
        with Folder(folder) as target:
            progress("drawing", 2, 3)
            analysis.write(target, pictures)
            target.finish(
                {
                    "file": ", ".join(path.name for path in paths),
                    **units._asdict(),
                    "lag_s": measured.lag_s,
                    "arena": arena and arena.words,
                    "descent_rad": descent,
                }
            )
    return analysis
