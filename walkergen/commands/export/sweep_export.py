"""Export of the walkers of a sweep as single files, one after the other to limit memory."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from walkergen.commands.export import make, profile
from walkergen.core.errors import OutputError, WalkergenError
from walkergen.core.files.output import Folder
from walkergen.core.files.progress import Progress
from walkergen.core.files.tables import csv_text
from walkergen.core.walker import solids
from walkergen.files.report import Report
from walkergen.guests.sweep import sweep_setup

PARTS_FILE = "parts.csv"
"""File with a table of the walkers: number, values of the keys, and the reason if a walker cannot be made."""


def write(path: Path, formats: Sequence[str], folder: Path | None, progress: Progress) -> Report:
    """Write the walkers of a sweep's file as FOLDER/FORMAT/DESIGN_NUMBER.FORMAT, and a table of them.

    NUMBER is the number of the walker's row in the table of the sweep, from 1. If a walker cannot be made, the table
    states the reason. Raises InputError for an invalid sweep.
    """
    points = sweep_setup.from_file(path)
    count, width = points.space.point_count, len(str(points.space.point_count))
    folder = folder or Path("out") / points.folder_name
    keys, refused = points.space.keys, 0
    rows: list[tuple[Any, ...]] = []
    with Folder(folder, "") as target:
        for number, values in enumerate(points.space.rows(), start=1):
            name, reason = f"{points.design.name}_{number:0{width}}", ""
            try:
                design = points.point(dict(zip(keys, values, strict=True))).design
                mesh = solids.orient_for_print(design, solids.build(design).walker)
                drawing = profile.drawing_outlines(design) if set(formats) & profile.FORMATS.keys() else []
                for form in formats:
                    file, data = make.pack_walker(form, name, mesh, drawing)
                    target.write(f"{form}/{file}", data)
            except OutputError:
                raise
            except WalkergenError as error:
                reason, refused = " ".join(error.text.removeprefix("‹set›: ").split()), refused + 1
            rows.append((number, *values, reason))
            progress(name, number, count)
        target.write(PARTS_FILE, csv_text(("number", *keys, "refused"), rows).encode())
    facts = {"folder": str(folder), "made": count - refused, "refused": refused}
    line = f"{count - refused} walkers, numbered as the rows of {PARTS_FILE}"
    warning = f"{refused} of {count} walkers cannot be made: {PARTS_FILE} has the reasons"
    return Report(
        name="export",
        title="Exported walkers",
        tables=[],
        facts=facts,
        lines=[line],
        warnings=[warning] if refused else [],
        files=[folder / PARTS_FILE],
        folder=folder,
    )
