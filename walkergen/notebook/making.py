"""Families in a folder and single files, as the commands `family` and `export` make them."""

import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from walkergen.errors import InputError
from walkergen.files.progress import Progress, silent
from walkergen.jobs.family import make as families
from walkergen.jobs.orders import make as batch
from walkergen.notebook.loading import (
    Ground,
    Machine,
    Walker,
    members_of,
    printer_of,
    scene_of,
    walker_of,
)
from walkergen.notebook.predicting import SCENE
from walkergen.notebook.table import Result, Table
from walkergen.printing import checks
from walkergen.printing.checks import Finding
from walkergen.theory.speed import Mode
from walkergen.walker.limbs import Kind

PRINTER = "prusa-mk3s"
"""Template of the printer by default, as on the command line."""


class Family(Result):
    """Family that was made: its folder, its members and what the printer makes of them."""

    def __init__(
        self, folder: Path, members: Sequence[families.Member], findings: Sequence[Finding]
    ) -> None:
        self.folder = folder
        self.members = tuple(members)
        self.warnings = tuple(
            checks.line(one) for one in checks.grouped(findings) if one.level == "warning"
        )
        """Warnings of the printability checks, a line each."""

    @property
    def table(self) -> Table:
        """Rows of family.csv: masses and speeds, predicted and, where asked for, simulated."""
        (rows, simulated), names = families.rows_of(self.members), [m.name for m in self.members]
        every: dict[str, list[object]] = {"name": list(names)}
        for part in (rows, simulated):
            for field in part[0]._fields if part else ():
                every[field] = [getattr(row, field) for row in part]
        return Table(every, f"{len(names)} walkers in {self.folder}", self.warnings)

    def rows(self) -> Iterator[tuple[str, str]]:
        """Names and values in words."""
        yield "folder", str(self.folder)
        for member in self.members:
            yield member.name, f"{member.row.speed_mm_s:.1f} mm/s predicted"
        for warning in self.warnings:
            yield "warning", warning

    def _repr_html_(self) -> str:
        return self.table._repr_html_()


def family(
    design: Walker, folder: str | os.PathLike[str], *, tilt: Iterable[float] | None = None,
    legs: Kind | Iterable[Kind] | None = None, scene: Ground = SCENE, printer: Machine = PRINTER,
    mode: Mode = "coulomb", simulate: bool = False, pictures: bool = True, strict: bool = False,
    progress: Progress | None = None,
) -> Family:  # fmt: skip
    """Make a family of walkers in a folder: STL files, plates, predicted speeds, pictures.

    Tilts (deg) and kinds of legs are by default those of the design's [family]. Raises InputError
    for parts that cannot be built or printed, OutputError for a file that cannot be written.
    """
    ground, chosen = scene_of(scene), walker_of(design)
    members = members_of(chosen, tilt, legs, whole=True)
    findings: list[Finding] = []
    job = families.Job(
        chosen, members, ground, printer_of(printer), mode, pictures, simulate, strict=strict
    )
    made = families.make(job, Path(folder), progress or silent, findings.extend)
    return Family(Path(folder), made, findings)


def export(design: Walker, path: str | os.PathLike[str]) -> Path:
    """Write a walker as the STL, 3MF, DXF or SVG file that the path's ending names.

    Solids lie as they print. Raises InputError for other endings, OutputError.
    """
    target = Path(path)
    if target.suffix.removeprefix(".").lower() not in batch.FORMATS:
        known = ", ".join(f".{form}" for form in batch.FORMATS)
        raise InputError(f"{str(path)!r}: must end in one of {known}")
    batch.export_part(walker_of(design), target)
    return target
