"""Fit of the contact: from measured speeds to restitution, friction and impact speed in a scene."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.analysis import fits
from walkergen.analysis import speeds as measured
from walkergen.analysis.fits import RANGES, ContactFit, Speeds
from walkergen.errors import InputError
from walkergen.files import output
from walkergen.files.config import validate
from walkergen.files.progress import Progress
from walkergen.scene import Scene
from walkergen.theory.speed import Mode
from walkergen.walker import solids
from walkergen.walker.design import Design
from walkergen.walker.limbs import KINDS, Kind

Array = npt.NDArray[np.float64]

CURVE_POINTS = 121

DECIMALS = 12
"""Decimals of fitted numbers in scene.toml: what lies beyond is the search's rounding."""


class Job(NamedTuple):
    """Choices of the fit command."""

    design: Design
    scene: Scene
    mode: Mode
    fixed: Mapping[str, float]
    """Parameters (of fits.RANGES) that are held at given values."""
    pictures: bool


class Fitted(NamedTuple):
    """Result of a fit by the theory, and its data."""

    fit: ContactFit
    tilt: Array
    """Tilts of the measured walkers, deg, shape (n,)."""
    legs: list[Kind]
    speeds: Speeds
    notes: list[str]
    scene: Scene
    """Scene with the fitted contact."""
    design: Design
    """Walker as it was given."""
    job: Job


OF_THEORY = (
    "this is the theory's contact, with which theory_mm_s meets the speeds; without --model theory "
    "fit learns that by which speeds are predicted"
)
"""Note on what a fitted contact is good for."""


def fit(path: Path, job: Job, progress: Progress) -> Fitted:
    """Fit the theory's contact to a CSV file of speeds.

    Columns: tilt_deg, speed_mm_s; optionally speed_se_mm_s, legs, plate_speed_mm_s (the scene's
    where blank). Raises InputError for unusable input.
    """
    if not job.design.alike:
        raise InputError(
            f"{job.design.name}: the theory's mean over two equal feet is fitted, and its legs are "
            "not two equal ones: learn from simulated speeds, --model space"
        )
    table = measured.read(path, job.design.kind, job.scene.drive.peak_speed)
    measured.refuse_slips(path, table)
    tilt, legs = table.tilt, table.legs
    speeds = _with_tensors(job, tilt, legs, table.speed, table.se, table.plate_speed)
    progress("fitting", 0, 1)
    result = fits.fit_contact(speeds, job.fixed)
    scene = _scene(job.scene, result, path)
    notes = [*result.notes, *table.notes, OF_THEORY]
    return Fitted(result, tilt, legs, speeds, notes, scene, job.design, job)


def caption(job: Job) -> str:
    """Statement of the assumptions on which a fit rests."""
    held = ", ".join(f"{name} = {value:g}" for name, value in job.fixed.items())
    return f"walker {job.design.name}, mode {job.mode}, law {job.scene.contact.law}" + (
        f", given {held}" if held else ""
    )


def _with_tensors(job: Job, tilt: Array, legs: list[Kind], speed: Array, se: Array | None, plate: Array) -> Speeds:
    pairs = zip(tilt, legs, strict=True)
    members = [job.design.members([float(angle)], [kind])[0] for angle, kind in pairs]
    masses = [solids.mass_of(member) for member in members]
    return Speeds(speed, se, plate, *fits.tensors(masses), job.scene.contact.law, job.mode)


def _scene(scene: Scene, result: ContactFit, source: Path) -> Scene:
    """Scene with the fitted values; fixed values keep the scene's standard deviations."""
    data: dict[str, Any] = scene.model_dump(exclude_none=True)
    places = {name: "prediction" if name.startswith("impact") else "contact" for name in RANGES}
    for name, value in result.values.items():
        data[places[name]][name] = round(value, DECIMALS) + 0.0
        if name in result.errors and places[name] == "contact":
            low, high = RANGES[name]
            error = result.errors[name]
            data[places[name]][f"{name}_sd"] = min(error if error is not None else high - low, high)
    data["description"] = f"As {scene.name}, with the contact fitted to {source.name[:200]}"
    data["name"] = fitted_name(scene.name, source)
    return validate(data, Scene, "fitted scene")


def fitted_name(name: str, source: Path) -> str:
    """Name of a fitted scene, or design, after the file of speeds: never that of a shipped one."""
    return f"{name[:30]}-fit-{output.named_after(source)[:28]}"


def curves(fitted: Fitted) -> dict[Kind, tuple[Array, Array, Array]]:
    """Fitted curves by kind of legs, as `_curve` gives them."""
    return {kind: _curve(fitted, kind) for kind in KINDS if kind in fitted.legs}


def _curve(fitted: Fitted, kind: Kind) -> tuple[Array, Array, Array]:
    """Tilt (deg), speed over plate speed, and its standard error, over the measured tilts."""
    tilt = np.linspace(fitted.tilt.min(), fitted.tilt.max(), CURVE_POINTS)
    ones, result = np.ones_like(tilt), fitted.fit
    along = _with_tensors(fitted.job, tilt, [kind] * len(tilt), ones, None, ones)
    values = result.values
    unit = fits.unit_speeds(along, values["restitution"], values["friction"])
    slopes = fits.jacobian(along, values, result.free)
    variance = np.einsum("ni,ij,nj->n", slopes, result.covariance, slopes)
    return tilt, values["impact_speed_factor"] * unit, np.sqrt(np.maximum(variance, 0.0))
