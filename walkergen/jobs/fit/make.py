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
from walkergen.files import output, templates
from walkergen.files.config import validate
from walkergen.files.output import Folder
from walkergen.files.progress import Progress
from walkergen.jobs.fit import tables as fit_tables
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
    """Result of a fit, its data, and the folder it was written to."""

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
    folder: Path


OF_THEORY = (
    "this is the theory's contact, with which theory_mm_s meets the speeds; without --model theory "
    "fit learns that by which speeds are predicted"
)
"""Note on what a fitted contact is good for."""


def fit(path: Path, job: Job, folder: Path, progress: Progress) -> Fitted:
    """Fit the theory's contact to a CSV file of speeds and write tables, figures and a scene.

    Columns: tilt_deg, speed_mm_s; optionally speed_se_mm_s, legs, plate_speed_mm_s (the scene's
    where blank). Writes fit.csv, fit.md, speeds.csv, scene.toml, design.toml (as given), fit.png,
    fit.pdf, manifest.json. Raises InputError, before anything is written, for unusable input.
    """
    if not job.design.alike:
        raise InputError(
            f"{job.design.name}: the theory's mean over two equal feet is fitted, and its legs are "
            "not two equal ones: learn from simulated speeds, --model space"
        )
    found = measured.read(path, job.design.kind, job.scene.drive.peak_speed)
    measured.refuse_slips(path, found)
    tilt, legs = found.tilt, found.legs
    speeds = _with_tensors(job, tilt, legs, found.speed, found.se, found.plate_speed)
    progress("fitting", 0, 2)
    result = fits.fit_contact(speeds, job.fixed)
    progress("drawing", 1, 2)
    scene = _scene(job.scene, result, path)
    notes = [*result.notes, *([found.bad] if found.bad else []), OF_THEORY]
    fitted = Fitted(result, tilt, legs, speeds, notes, scene, job.design, folder)
    told = caption(job)
    with Folder(folder) as target:
        target.write("fit.csv", fit_tables.to_csv(result).encode())
        target.write("fit.md", fit_tables.to_markdown(result, path.name, told, notes).encode())
        points = fit_tables.points_to_csv(tilt, legs, speeds, result.predicted)
        target.write("speeds.csv", points.encode())
        comment = f"Fitted to {path.name}: {told}"
        target.write("scene.toml", templates.dump(scene, comment).encode())
        target.write("design.toml", templates.dump(job.design, comment).encode())
        if job.pictures:
            _write_figures(fitted, job, path.name, target)
        facts: dict[str, Any] = {
            "file": path.name, "design": job.design.model_dump(mode="json"),
            "scene": job.scene.model_dump(mode="json"), "mode": job.mode, "fixed": dict(job.fixed),
        }  # fmt: skip
        target.finish(facts)
    return fitted


def caption(job: Job) -> str:
    """Statement of the assumptions on which a fit rests."""
    held = ", ".join(f"{name} = {value:g}" for name, value in job.fixed.items())
    return f"walker {job.design.name}, mode {job.mode}, law {job.scene.contact.law}" + (
        f", given {held}" if held else ""
    )


def _with_tensors(
    job: Job, tilt: Array, legs: list[Kind], speed: Array, se: Array | None, plate: Array
) -> Speeds:
    pairs = zip(tilt, legs, strict=True)
    members = [job.design.members([float(one)], [kind])[0] for one, kind in pairs]
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


def _write_figures(fitted: Fitted, job: Job, title: str, target: Folder) -> None:
    from walkergen.files import figures as pictures
    from walkergen.jobs.fit import figures as fit_plots

    curves = {kind: _curve(fitted, job, kind) for kind in KINDS if kind in fitted.legs}
    figure = fit_plots.fit_figure(fitted.tilt, fitted.legs, fitted.speeds, curves, title)
    target.write("fit.png", pictures.png(figure))
    target.write("fit.pdf", pictures.pdf(figure))


def _curve(fitted: Fitted, job: Job, kind: Kind) -> tuple[Array, Array, Array]:
    """Tilt (deg), speed over plate speed, and its standard error, over the measured tilts."""
    tilt = np.linspace(fitted.tilt.min(), fitted.tilt.max(), CURVE_POINTS)
    ones, result = np.ones_like(tilt), fitted.fit
    along = _with_tensors(job, tilt, [kind] * len(tilt), ones, None, ones)
    values = result.values
    unit = fits.unit_speeds(along, values["restitution"], values["friction"])
    slopes = fits.jacobian(along, values, result.free)
    variance = np.einsum("ni,ij,nj->n", slopes, result.covariance, slopes)
    return tilt, values["impact_speed_factor"] * unit, np.sqrt(np.maximum(variance, 0.0))
