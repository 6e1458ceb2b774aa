"""Fit of the theory's contact: from measured speeds to restitution, friction and impact speed, by least squares."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from walkergen.analysis import speeds as measured
from walkergen.analysis.speeds import Measured
from walkergen.core import Design, Scene, mass_of
from walkergen.core.errors import InputError
from walkergen.core.files.config import validate
from walkergen.core.files.progress import Progress
from walkergen.core.numerics import Array
from walkergen.core.theory.speed import Mode
from walkergen.core.walker.limbs import KINDS, Kind
from walkergen.guests.lab.fit import least_squares
from walkergen.guests.lab.fit.fields import FitFields
from walkergen.guests.lab.fit.least_squares import RANGES, ContactFit, Speeds
from walkergen.guests.lab.report import Setup, name_after

CURVE_POINTS = 121

DECIMALS = 12
"""Decimals of fitted numbers in scene.toml; further ones are the search's rounding."""

THEORY_NOTE = (
    "this contact makes theory_mm_s match the speeds. Without ‹model=›theory, fit estimates the contact behind "
    "predicted speeds"
)
"""Note in the report on the use of a contact fitted to the theory."""


class Fitted(NamedTuple):
    """Result of a fit of the theory, and its data."""

    fit: ContactFit
    seen: Measured
    speeds: Speeds
    design: Design
    notes: list[str]
    scene: Scene
    """Scene with the fitted contact."""

    @property
    def curves(self) -> dict[Kind, tuple[Array, Array, Array]]:
        """Fitted curves by kind of legs: tilts (deg), speeds over plate speed, and their standard errors."""
        return {kind: _fitted_curve(self, kind) for kind in KINDS if kind in self.seen.legs}


def fit(request: FitFields, setup: Setup, held: Mapping[str, float], progress: Progress) -> Fitted:
    """Fit the theory's contact to a CSV file of speeds, with the parameters in `held` fixed.

    Columns: tilt_deg, speed_mm_s and optionally speed_se_mm_s, legs, plate_speed_mm_s (the scene's where blank). Raises
    InputError for unusable input.
    """
    (design, scene), path = setup, request.speeds
    if not design.is_symmetric_pair:
        raise InputError(
            f"{design.name}: its legs are not two equal ones, as the theory requires. "
            "Fit simulated speeds, ‹model=›space"
        )
    seen = measured.read_speeds(path, design.kind, scene.drive.peak_speed)
    measured.check_units(path, seen)
    speeds = _make_speeds(design, request.mode, seen.tilt, seen.legs, seen.speed, seen.se, seen.plate_speed)
    progress("fitting", 0, 1)
    result = least_squares.fit_contact(speeds, held)
    notes = [*result.notes, *seen.notes, THEORY_NOTE]
    return Fitted(result, seen, speeds, design, notes, _fitted_scene(scene, result, path))


def _make_speeds(
    design: Design, mode: Mode, tilt: Array, legs: list[Kind], speed: Array, se: Array | None, plate_speed: Array
) -> Speeds:
    """Return speeds, their errors and plate speeds (mm/s) with the theory's inputs for these tilts (deg) and legs."""
    pairs = zip(tilt, legs, strict=True)
    masses = [mass_of(design.members([float(angle)], [kind])[0]) for angle, kind in pairs]
    return Speeds(speed, se, plate_speed, *least_squares.inverse_mass_tensors(masses), mode)


def _fitted_scene(scene: Scene, result: ContactFit, source: Path) -> Scene:
    """Return the scene with the fitted values; fixed values keep the scene's standard deviations."""
    data: dict[str, Any] = scene.model_dump(exclude_none=True)
    for name, value in result.values.items():
        table = data["prediction" if name.startswith("impact") else "contact"]
        table[name] = round(value, DECIMALS) + 0.0
        if name in result.errors and table is data["contact"]:
            low, high = RANGES[name]
            error = result.errors[name]
            table[f"{name}_sd"] = min(error if error is not None else high - low, high)
    data["description"] = f"As {scene.name}, with the contact fitted to {source.name[:200]}"
    data["name"] = name_after(scene.name, source, "fit-")
    return validate(data, Scene, "fitted scene")


def _fitted_curve(fitted: Fitted, kind: Kind) -> tuple[Array, Array, Array]:
    """Return tilt (deg), fitted speed over plate speed, and its standard error, for legs of a kind, (CURVE_POINTS,)."""
    tilt = np.linspace(fitted.seen.tilt.min(), fitted.seen.tilt.max(), CURVE_POINTS)
    ones, result = np.ones_like(tilt), fitted.fit
    points = _make_speeds(fitted.design, fitted.speeds.mode, tilt, [kind] * len(tilt), ones, None, ones)
    values = result.values
    per_factor = least_squares.speeds_at_unit_factor(points, values["restitution"], values["friction"])
    slopes = least_squares.jacobian(points, values, result.free)
    variance = np.einsum("ni,ij,nj->n", slopes, result.covariance, slopes)
    return tilt, values["impact_speed_factor"] * per_factor, np.sqrt(np.maximum(variance, 0.0))
