"""Contact and material from what was measured, as fit, calibrate, bench and weigh find them."""

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Literal

from walkergen.api.loading import Ground, Walker, one_of, scene_of, walker_of
from walkergen.api.predicting import SCENE
from walkergen.errors import InputError
from walkergen.files import output
from walkergen.files.progress import Progress, silent
from walkergen.jobs.make.weigh import make as weighing
from walkergen.jobs.make.weigh import report as weigh_report
from walkergen.jobs.make.weigh.report import WeighReport
from walkergen.lab import inverse
from walkergen.lab.bench import make as benches
from walkergen.lab.calibrate import make as calibrations
from walkergen.lab.fit import make as fitting
from walkergen.lab.fit.job import Job
from walkergen.lab.fit.report import FitReport
from walkergen.lab.report import LabReport
from walkergen.theory.speed import Mode
from walkergen.walker.limbs import Kind

PAPER = "koumakis2016"
"""Template of the walker by default, as on the command line."""

Name = str | os.PathLike[str]


def fit(
    speeds: Name,
    design: Walker = PAPER,
    scene: Ground = SCENE,
    *,
    model: Literal["prediction", "theory", "compliant", "space"] = "prediction",
    fix: Mapping[str, float] | None = None,
    prior: Literal["flat", "scene"] | None = None,
    predict: Iterable[float] | None = None,
    mode: Mode = "coulomb",
    folder: Name | None = None,
    pictures: bool = True,
    progress: Progress | None = None,
) -> FitReport:
    """Learn the contact from a CSV file of speeds, and predict walkers that were not measured.

    Columns are those of the command `fit`. `fix` holds parameters, {"friction": 0.25}; `predict`
    are tilts (deg) for bands, by default those of the design's family. Files are written into the
    `folder`, by default out/NAME/fit. Raises InputError.
    """
    path = Path(speeds)
    held = [f"{name}={value!r}" for name, value in (fix or {}).items()]
    ahead = None if predict is None else [float(tilt) for tilt in predict]
    wish = Job(walker_of(design), scene_of(scene), model, held, prior, ahead, mode, pictures)
    return fitting.fit(path, wish, _folder(path, folder, "fit"), progress or silent)


def calibrate(
    measurements: Name,
    design: Walker = PAPER,
    scene: Ground = SCENE,
    *,
    tilt: float | None = None,
    legs: Kind | None = None,
    by: Literal["deflection", "ring", "both"] = "both",
    roll_deg: float = 1.0,
    drops: int = 24,
    folder: Name | None = None,
    pictures: bool = True,
    progress: Progress | None = None,
) -> LabReport:
    """Estimate Young's modulus, density, friction, damping and restitution from a filled form.

    The form is that of `walkergen plate --calibration`; `by` says what Young's modulus is by;
    `roll_deg` and `drops` are the simulated drops'. Files are written into the `folder`, by default
    out/NAME/calibrate. Raises InputError.
    """
    path = Path(measurements)
    job = calibrations.Job(one_of(design, tilt, legs), scene_of(scene), float(roll_deg), drops, pictures, by)
    target = _folder(path, folder, "calibrate")
    return calibrations.calibrate(path, job, target, progress or silent)


OWN = {"drop": ("tries", "height_mm", "roll_deg", "drops"), "slide": (), "pluck": ("decrement", "decrement_sd")}
"""Tests, with the choices that only they have."""


def bench(
    test: Literal["drop", "slide", "pluck"],
    design: Walker,
    scene: Ground = SCENE,
    *,
    tilt: float | None = None,
    legs: Kind | None = None,
    measured: float | None = None,
    measured_sd: float | None = None,
    tries: int | None = None,
    height_mm: float | None = None,
    roll_deg: float | None = None,
    drops: int | None = None,
    decrement: float | None = None,
    decrement_sd: float | None = None,
    folder: Name | None = None,
    pictures: bool = True,
    progress: Progress | None = None,
) -> LabReport:
    """Simulate a test on a bench, and invert what was `measured`, with its standard error.

    Of a "drop" that is the rebound, root of height over height, the mean of `tries`; of a "slide"
    the slope (deg) at which it slid; of a "pluck" the frequency (Hz), and `decrement` the logarithm
    of a swing over the next. Files are written into the `folder`, by default below out/ and the
    walker's name. Raises InputError.
    """
    if test not in OWN:
        raise InputError(f"test={test!r}: must be one of {', '.join(map(repr, OWN))}")
    arguments = {
        "tries": tries,
        "height_mm": height_mm,
        "roll_deg": roll_deg,
        "drops": drops,
        "decrement": decrement,
        "decrement_sd": decrement_sd,
    }
    for name, value in arguments.items():
        if value is not None and name not in OWN[test]:
            raise InputError(f"{name}={value!r}: test {test!r} has none; leave it out")
    member, tell = one_of(design, tilt, legs), progress or silent
    seen = inverse.measured(measured, measured_sd, tries or 1, benches.MOST[test])
    wish = benches.Test(member, scene_of(scene), seen, pictures)
    place = benches.folder_of(test, member) if folder is None else Path(folder)
    if test == "slide":
        return benches.slid(wish, place, tell)
    if test == "pluck":
        decay = inverse.measured(decrement, decrement_sd, 1, benches.MOST_DECREMENT, "--decrement")
        return benches.plucked(wish, decay, place, tell)
    usual = benches.Drop()
    how = benches.Drop(
        usual.height if height_mm is None else float(height_mm),
        usual.turn_deg if roll_deg is None else float(roll_deg),
        usual.drops if drops is None else drops,
    )
    return benches.dropped(wish, how, place, tell)


def weigh(file: Name, density: float = weighing.DENSITY, scale: float = 1.0) -> WeighReport:
    """Weigh a mesh (STL, OBJ, PLY, OFF, 3MF, GLB) of a density in g/cm3, its unit `scale` mm long.

    Finds volume, mass, centre of mass, inertia tensor, principal moments and axes. Raises
    InputError for what cannot be read or is not sound.
    """
    weighed = weighing.weigh(Path(file), density, scale)
    return weigh_report.of(weighed, Path(file), density, scale)


def _folder(path: Path, folder: Name | None, what: str) -> Path:
    return output.results(path, None, what) if folder is None else Path(folder)
