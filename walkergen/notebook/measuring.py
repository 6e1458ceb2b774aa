"""Contact and material from what was measured, as fit, calibrate, bench and weigh find them."""

import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Literal

from walkergen.analysis import inverse
from walkergen.errors import InputError
from walkergen.files import output
from walkergen.files.progress import Progress, silent
from walkergen.files.words import number
from walkergen.jobs.bench import make as benches
from walkergen.jobs.bench.report import BenchReport
from walkergen.jobs.calibration import make as calibrations
from walkergen.jobs.calibration import tables as calibration_tables
from walkergen.jobs.fit import request
from walkergen.jobs.fit.report import FitReport
from walkergen.jobs.weigh import make as weighing
from walkergen.notebook.loading import Ground, Walker, one_of, scene_of, walker_of
from walkergen.notebook.predicting import SCENE
from walkergen.notebook.table import Result, Table, table_of
from walkergen.scene import Scene
from walkergen.theory.speed import Mode
from walkergen.walker.design import Design
from walkergen.walker.limbs import Kind

PAPER = "koumakis2016"
"""Template of the walker by default, as on the command line."""

Name = str | os.PathLike[str]


def fit(
    speeds: Name, design: Walker = PAPER, scene: Ground = SCENE, *,
    model: Literal["prediction", "theory", "compliant", "space"] = "prediction",
    fix: Mapping[str, float] | None = None, prior: Literal["flat", "scene"] | None = None,
    predict: Iterable[float] | None = None, mode: Mode = "coulomb",
    folder: Name | None = None, pictures: bool = True, progress: Progress | None = None,
) -> FitReport:  # fmt: skip
    """Learn the contact from a CSV file of speeds, and predict walkers that were not measured.

    Columns are those of the command `fit`. `fix` holds parameters, {"friction": 0.25}; `predict`
    are tilts (deg) for bands, by default those of the design's family. Files are written into the
    `folder`, by default out/NAME/fit. Raises InputError.
    """
    path = Path(speeds)
    held = [f"{name}={value!r}" for name, value in (fix or {}).items()]
    ahead = None if predict is None else [float(tilt) for tilt in predict]
    wish = request.Request(
        walker_of(design), scene_of(scene), model, held, prior, ahead, mode, pictures
    )
    return request.fit(path, wish, _folder(path, folder, "fit"), progress or silent)


class Calibration(Result):
    """Material and contact that a calibration plate tells; `design` and `scene` go on with them."""

    def __init__(self, found: calibrations.Calibrated, title: str) -> None:
        self.found, self.title = found, title

    @property
    def design(self) -> Design:
        """Walker with the plastic that was measured."""
        return self.found.design

    @property
    def scene(self) -> Scene:
        """Scene with the contact and damping that were measured."""
        return self.found.scene

    @property
    def settings(self) -> dict[str, float]:
        """Keys of design and scene (these begin with scene.) that were set, with their values."""
        return self.found.settings

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on what disagrees, and on what the readings lack."""
        return tuple(calibration_tables.lines(self.found))

    @property
    def table(self) -> Table:
        """Every number that was measured, with its error and the key that it sets."""
        return table_of(list(calibration_tables.rows(self.found)), self.title, self.notes)

    def rows(self) -> Iterator[tuple[str, str]]:
        """Names and values in words."""
        for row in calibration_tables.rows(self.found):
            yield row.quantity, f"{number(row.value, 4)} ± {number(row.se, 2)} {row.unit}".strip()
        for note in self.notes:
            yield "note", note


def calibrate(
    measurements: Name, design: Walker = PAPER, scene: Ground = SCENE, *,
    tilt: float | None = None, legs: Kind | None = None,
    by: Literal["deflection", "ring", "both"] = "both", roll_deg: float = 1.0, drops: int = 24,
    folder: Name | None = None, pictures: bool = True, progress: Progress | None = None,
) -> Calibration:  # fmt: skip
    """Estimate Young's modulus, density, friction, damping and restitution from a filled form.

    The form is that of `walkergen plate --calibration`; `by` says what Young's modulus is by;
    `roll_deg` and `drops` are the simulated drops'. Files are written into the `folder`, by default
    out/NAME/calibrate. Raises InputError.
    """
    path = Path(measurements)
    job = calibrations.Job(
        one_of(design, tilt, legs), scene_of(scene), float(roll_deg), drops, pictures, by
    )
    target = _folder(path, folder, "calibrate")
    return Calibration(calibrations.calibrate(path, job, target, progress or silent), path.stem)


OWN = {
    "drop": ("tries", "height_mm", "roll_deg", "drops"),
    "slide": (),
    "pluck": ("decrement", "decrement_sd"),
}
"""Tests, with the choices that only they have."""


def bench(
    test: Literal["drop", "slide", "pluck"], design: Walker, scene: Ground = SCENE, *,
    tilt: float | None = None, legs: Kind | None = None,
    measured: float | None = None, measured_sd: float | None = None, tries: int | None = None,
    height_mm: float | None = None, roll_deg: float | None = None, drops: int | None = None,
    decrement: float | None = None, decrement_sd: float | None = None,
    folder: Name | None = None, pictures: bool = True, progress: Progress | None = None,
) -> BenchReport:  # fmt: skip
    """Simulate a test on a bench, and invert what was `measured`, with its standard error.

    Of a "drop" that is the rebound, root of height over height, the mean of `tries`; of a "slide"
    the slope (deg) at which it slid; of a "pluck" the frequency (Hz), and `decrement` the logarithm
    of a swing over the next. Files are written into the `folder`, by default below out/ and the
    walker's name. Raises InputError.
    """
    if test not in OWN:
        raise InputError(f"test={test!r}: must be one of {', '.join(map(repr, OWN))}")
    given = {"tries": tries, "height_mm": height_mm, "roll_deg": roll_deg, "drops": drops,
             "decrement": decrement, "decrement_sd": decrement_sd}  # fmt: skip
    for name, value in given.items():
        if value is not None and name not in OWN[test]:
            raise InputError(f"{name}={value!r}: test {test!r} has none; leave it out")
    member, tell = one_of(design, tilt, legs), progress or silent
    seen = inverse.measured(measured, measured_sd, tries or 1, benches.MOST[test])
    wish = benches.Test(member, scene_of(scene), seen, pictures)
    place = benches.folder_of(test, member) if folder is None else Path(folder)
    if test == "slide":
        return benches.slid(wish, place, tell)
    if test == "pluck":
        decay = inverse.measured(
            decrement, decrement_sd, 1, benches.MOST_DECREMENT, "--decrement"
        )  # fmt: skip
        return benches.plucked(wish, decay, place, tell)
    usual = benches.Drop()
    how = benches.Drop(
        usual.height if height_mm is None else float(height_mm),
        usual.turn_deg if roll_deg is None else float(roll_deg),
        usual.drops if drops is None else drops,
    )
    return benches.dropped(wish, how, place, tell)


class Weighing(Result):
    """Mass properties of a mesh file, in its own axes."""

    def __init__(self, found: weighing.Weighing, title: str) -> None:
        self.found, self.title = found, title

    @property
    def total(self) -> weighing.Weighed:
        """All objects together, as one rigid body."""
        return self.found.total

    @property
    def table(self) -> Table:
        """Row for each object, and one for all together; vectors and tensors are arrays."""
        several = len(self.found.parts) > 1
        return table_of([*self.found.parts, *([self.total] if several else [])], self.title)

    def rows(self) -> Iterator[tuple[str, str]]:
        """Names and values in words."""
        for row in self.table:
            yield row["name"], f"{row['volume_mm3']:.6g} mm3, {row['mass_g']:.6g} g"


def weigh(file: Name, density: float = weighing.DENSITY, scale: float = 1.0) -> Weighing:
    """Weigh a mesh (STL, OBJ, PLY, OFF, 3MF, GLB) of a density in g/cm3, its unit `scale` mm long.

    Finds volume, mass, centre of mass, inertia tensor, principal moments and axes. Raises
    InputError for what cannot be read or is not sound.
    """
    return Weighing(weighing.weigh(Path(file), density, scale), Path(file).stem)


def _folder(path: Path, folder: Name | None, what: str) -> Path:
    return output.results(path, None, what) if folder is None else Path(folder)
