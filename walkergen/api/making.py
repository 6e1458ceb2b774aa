"""Families in a folder and single files, as the commands `family` and `export` make them."""

import numbers
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from walkergen.analysis import speeds
from walkergen.api.loading import Ground, Machine, Walker, members_of, printer_of, scene_of, walker_of
from walkergen.api.predicting import SCENE
from walkergen.errors import InputError
from walkergen.files.progress import Progress, silent
from walkergen.jobs.make.export import make as exports
from walkergen.jobs.make.family import make as families
from walkergen.jobs.make.family.report import FamilyReport
from walkergen.printing import findings as printed
from walkergen.printing.findings import Finding
from walkergen.printing.packing import MOST_PARTS
from walkergen.scene import Scene
from walkergen.theory.speed import Mode
from walkergen.walker import weights as balance
from walkergen.walker.design import Design
from walkergen.walker.limbs import Kind

PRINTER = "prusa-mk3s"
"""Template of the printer by default, as on the command line."""


def family(
    design: Walker,
    folder: str | os.PathLike[str],
    *,
    tilt: Iterable[float] | None = None,
    legs: Kind | Iterable[Kind] | None = None,
    scene: Ground = SCENE,
    printer: Machine = PRINTER,
    mode: Mode = "coulomb",
    simulate: bool = False,
    pictures: bool = True,
    strict: bool = False,
    copies: int | Mapping[float, int] | None = None,
    max_parts: int = MOST_PARTS,
    weights: str | os.PathLike[str] | None = None,
    measured: str | os.PathLike[str] | None = None,
    prusaslicer: bool = False,
    progress: Progress | None = None,
) -> FamilyReport:
    """Make a family of walkers in a folder: STL files, plates, predicted speeds, pictures.

    Tilts (deg) and kinds of legs are by default those of the design's [family]. `copies` is that of
    each walker on the plates, or copies by tilt, {10: 20, 15: 40}, which then names the tilts;
    `max_parts` the most on a plate. `weights` is a filled in weights.csv: masses from a balance, g;
    `measured` a CSV file of measured speeds, mm/s, for speed.png. `prusaslicer` spares PrusaSlicer
    slicing every copy anew. Raises InputError for parts that cannot be built or printed and for
    files that are not as they should be, OutputError for a file that cannot be written.
    """
    ground, chosen = scene_of(scene), walker_of(design)
    members, counts = _copied(chosen, tilt, legs, copies)
    weighed, unused = _weighed(weights, members)
    seen, bad = _measured(measured, chosen, ground)
    findings: list[Finding] = []
    job = families.Job(
        chosen,
        members,
        ground,
        printer_of(printer),
        mode,
        pictures,
        simulate,
        counts,
        _whole(max_parts, MOST_PARTS, "max_parts"),
        prusaslicer,
        weighed,
        strict,
        seen,
    )
    report = families.make(job, Path(folder), progress or silent, findings.extend)
    warnings = printed.warnings(findings)
    warnings += [*unused, *bad]
    return replace(report, warnings=warnings)


def _copied(
    design: Design,
    tilt: Iterable[float] | None,
    legs: Kind | Iterable[Kind] | None,
    copies: int | Mapping[float, int] | None,
) -> tuple[list[Design], list[int]]:
    """Members of a family and the number of copies of each. Raises InputError."""
    if not isinstance(copies, Mapping):
        members = members_of(design, tilt, legs, whole=True)
        count = 1 if copies is None else _whole(copies, MOST_PARTS, "copies")
        return members, [count] * len(members)
    if tilt is not None:
        raise InputError("copies: names the tilts: leave tilt out")
    if not copies:
        raise InputError("copies: no tilt: write copies by tilt, {10: 20, 15: 40}")
    counts = {_tilt(one): _whole(count, MOST_PARTS, f"copies[{one!r}]") for one, count in copies.items()}
    members = members_of(design, counts, legs, whole=True)
    return members, [counts[member.tilt_deg] for member in members]


def _tilt(value: Any) -> float:
    """Tilt that copies are of, deg; its range is the design's. Raises InputError."""
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise InputError(f"copies: {value!r}: must be a tilt in deg, as in {{10: 20, 15: 40}}")
    return float(value) + 0.0


def _whole(value: Any, most: int, name: str) -> int:
    """Number of copies or parts. Raises InputError."""
    whole = isinstance(value, numbers.Integral) and not isinstance(value, bool)
    if not whole or not 1 <= value <= most:
        raise InputError(f"{name}={value!r}: must be a whole number in 1..{most}")
    return int(value)


def _weighed(
    path: str | os.PathLike[str] | None, members: Sequence[Design]
) -> tuple[dict[str, balance.Weighings], list[str]]:
    """Masses from a balance by names of members, and what is said of other walkers' rows."""
    if path is None:
        return {}, []
    weighings, unused = balance.read(Path(path), members), balance.unused(Path(path), members)
    few = ", ".join(unused[:2]) + (" ..." if len(unused) > 2 else "")
    warnings = [f"{path}: {len(unused)} walkers beside those asked for: {few}"] if unused else []
    return weighings, warnings


def _measured(
    path: str | os.PathLike[str] | None, design: Design, scene: Scene
) -> tuple[speeds.Measured | None, list[str]]:
    """Speeds measured on the scene's plate, and what is said of rows left out."""
    if path is None:
        return None, []
    measured = speeds.on_plate(Path(path), design.kind, scene.drive.peak_speed)
    return measured, [f"{path}: {note}" for note in measured.notes]


def export(design: Walker, path: str | os.PathLike[str], *, scene: Ground = SCENE) -> Path:
    """Write a walker as the STL, 3MF, DXF or SVG file that the path's ending names, or for MuJoCo.

    Solids lie as they print. A path that ends in .xml is MJCF of the walker in the scene, its STL
    files beside it; other files have no scene. Raises InputError for other endings and for scenes
    that MJCF cannot hold, OutputError.
    """
    target = Path(path)
    moving = target.suffix.lower() == exports.MODEL
    exports.one(walker_of(design), target, scene_of(scene) if moving else None)
    return target
