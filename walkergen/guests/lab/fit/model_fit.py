"""Fit of a model: from measured speeds to parameters and predictions."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from walkergen.analysis import speeds as measured
from walkergen.analysis.speeds import Measured
from walkergen.core import Design, Scene, mass_of
from walkergen.core.errors import InputError
from walkergen.core.files.config import validate
from walkergen.core.files.progress import Expect, Expected, Progress, ignore_estimate
from walkergen.core.numerics import Array
from walkergen.core.walker.limbs import Kind
from walkergen.guests.lab.fit import emulated_speeds, identifiability, importance_sampling, posterior, surrogate_speeds
from walkergen.guests.lab.fit.emulated_speeds import FitInputs, Setting
from walkergen.guests.lab.fit.fields import FitFields
from walkergen.guests.lab.fit.identifiability import Summary
from walkergen.guests.lab.fit.parameters import (
    DEFAULT_PRIOR,
    PARAMETER_KEYS,
    SCENE_PARAMETERS,
    ModelName,
    apply_fixed,
    is_measured,
    list_unknowns,
)
from walkergen.guests.lab.fit.posterior import Observed, Posterior, SpeedModel
from walkergen.guests.lab.report import Setup, name_after
from walkergen.points import effect_selection, emulator, run_time

PRIOR_WALKERS, POSTERIOR_WALKERS, AHEAD_WALKERS = 64, 32, 48
"""Number of walkers simulated in a setting: over the prior, over the first posterior, and in unmeasured settings."""

LEARNING_S = 15.0
"""CPU time (s) of one core for both posteriors and the emulators: 14 with two settings, 17 with four."""

DEVIATION_KEYS = {"frequency_hz": "frequency_sd_hz", "eccentric_g_mm": "eccentric_sd_g_mm"}
"""Keys of standard deviations that do not end in _sd."""

MAX_SETTINGS = 40
"""Largest number of settings (tilts on plates), measured and predicted, in a fit."""

BAND_LEVELS = (0.5, 0.025, 0.05, 0.1587, 0.8413, 0.95, 0.975)
"""Median and ends of the 95, 90 and 68 % bands."""


class Band(NamedTuple):
    """Predicted speeds (mm/s) of one more print in a setting: median, and ends of bands."""

    tilt_deg: float
    plate_speed_mm_s: float
    measured: int
    """1 where speeds were measured and used in the fit, else 0."""
    speed_mm_s: float
    low_95: float
    low_90: float
    low_68: float
    high_68: float
    high_90: float
    high_95: float
    print_scatter_mm_s: float
    """Standard deviation between prints, which the bands contain."""


class ModelFit(NamedTuple):
    """Result of a fit of the surrogate or of simulations."""

    posterior: Posterior
    seen: Measured
    """Speeds that were measured."""
    rows: tuple[Summary, ...]
    bands: list[Band]
    notes: list[str]
    scene: Scene
    """Scene with the fitted contact and damping."""
    design: Design
    """Design with the fitted thickness and Young's modulus."""
    contradictions: Sequence[str] = ()
    """Pairs of measurements that contradict each other, a sentence each."""


def fit(
    request: FitFields, setup: Setup, held: Mapping[str, float], progress: Progress, expect: Expect = ignore_estimate
) -> ModelFit:
    """Fit a model to a file of speeds, with the parameters in `held` fixed.

    The file has the columns of `theory.fit`, and for simulated models it must have speed_se_mm_s. `expect` receives the
    expected run time. Raises InputError for unusable input.
    """
    model, path = request.model, request.speeds
    assert model != "theory"
    drive = setup.scene.drive.equivalent_plate_drive(float(mass_of(setup.design).total))
    table = measured.read_speeds(path, setup.design.kind, drive.peak_speed)
    measured.check_units(path, table)
    seen, notes = _select_flexible(table, path, model)
    scene, design = apply_fixed(setup.scene, setup.design, held)
    prior = request.prior or DEFAULT_PRIOR
    inputs = FitInputs(scene, model, list_unknowns(scene, design, model, prior, held, seen.se is not None))
    settings, observed = _group_by_setting(design, seen)
    unmeasured = _predicted_settings(request.predict, design, seen, settings)
    if model != "prediction":
        effect_selection.check_no_accepted_error(scene, "a fit needs all effects of the scene")
        expect(lambda: _expected_time(inputs, settings, unmeasured))
    sample_posterior = _sample_with_surrogate if model == "prediction" else _sample_with_runs
    sampled, responses, unmeasured_responses = sample_posterior(inputs, settings, observed, unmeasured, progress)
    parameters = inputs.unknown.parameters
    bands = _predict_bands(inputs, settings, responses, sampled, is_measured=True) + _predict_bands(
        inputs, unmeasured, unmeasured_responses, sampled, is_measured=False
    )
    bands.sort(key=lambda band: (band.plate_speed_mm_s, band.tilt_deg))
    sampled = sampled._replace(draws=sampled.draws[:, : len(parameters)])
    rows = tuple(
        row._replace(measured=is_measured(row.name, setup.scene, setup.design))
        for row in identifiability.summarise_draws(parameters, sampled.draws)
    )
    contradictions = identifiability.disagreements(parameters, rows)
    notes = [
        *identifiability.unlearnt_notes(rows),
        *identifiability.trade_off_notes(inputs.unknown.simulated, sampled.draws),
        *identifiability.misfit_notes(sampled, len(seen.speed), model),
        *(["check the speeds and those measurements, or the model is off for this walker"] if contradictions else []),
        *_outlier_notes(seen, bands),
        *notes,
        *_caveat_notes(inputs),
    ]
    return ModelFit(
        *(sampled, seen, rows, bands, notes),
        _fitted_scene(model, scene, rows, path),
        _fitted_design(design, rows, path),
        contradictions,
    )


def _outlier_notes(seen: Measured, bands: Sequence[Band]) -> list[str]:
    """Return notes on measured speeds far from the band of one more print in their setting."""
    by_setting = {(band.tilt_deg, band.plate_speed_mm_s): band for band in bands}
    own = [by_setting[key] for key in zip(map(float, seen.tilt), map(float, seen.plate_speed), strict=True)]
    errors = np.zeros(len(own)) if seen.se is None else seen.se
    sds = [math.hypot((band.high_95 - band.low_95) / 3.92, error) for band, error in zip(own, errors, strict=True)]
    return identifiability.outlier_notes(list(seen.speed), [band.speed_mm_s for band in own], sds, seen.tilt)


def _select_flexible(table: Measured, path: Path, model: ModelName) -> tuple[Measured, list[str]]:
    """Return the rows of walkers with flexible legs, and notes on omitted rows. Raises InputError if there are none."""
    if not len(table.speed):
        raise InputError(f"{path}: no row is usable: {table.bad}")
    if table.se is None and model != "prediction":
        raise InputError(
            f"{path}: no column speed_se_mm_s. A simulated fit weights speeds by their standard "
            "errors. Add them (walkergen analyse prints them), or leave ‹model› out"
        )
    braced = np.array([kind == "braced" for kind in table.legs])
    if braced.all():
        raise InputError(
            f"{path}: all rows have braced legs. Their speeds near 0 do not constrain the contact. "
            "Measure walkers with flexible legs"
        )
    notes = table.notes
    if braced.any():
        notes.append(f"{braced.sum()} rows of braced legs are left out: they do not constrain the contact")
    if table.se is None:
        notes.append("no standard errors given: those here come from the scatter of the speeds")
    kept = ~braced
    se = None if table.se is None else table.se[kept]
    legs: list[Kind] = ["flexible"] * int(kept.sum())
    return Measured(table.tilt[kept], legs, table.speed[kept], se, table.plate_speed[kept], table.bad), notes


def _group_by_setting(design: Design, seen: Measured) -> tuple[list[Setting], list[Observed]]:
    """Return the different pairs of tilt and plate speed, with the speeds of each. Raises InputError for too many."""
    pairs = np.column_stack([seen.tilt, seen.plate_speed])
    different, indices = np.unique(pairs, axis=0, return_inverse=True)
    if len(different) > MAX_SETTINGS:
        raise InputError(
            f"{len(different)} pairs of tilt and plate speed. At most {MAX_SETTINGS}. Give prints "
            "of one tilt the same tilt_deg and plate_speed_mm_s"
        )
    members = design.members([float(tilt) for tilt, _ in different], ["flexible"])
    settings = [Setting(member, float(plate)) for member, (_, plate) in zip(members, different, strict=True)]
    rows = [np.ravel(indices) == index for index in range(len(different))]
    se = np.full(len(seen.speed), measured.MIN_VALUE_MM_S) if seen.se is None else seen.se
    words = [f"{tilt:g} deg" for tilt, _ in different]
    return settings, [Observed(seen.speed[row], se[row], name) for row, name in zip(rows, words, strict=True)]


def _predicted_settings(
    wanted: Sequence[float] | None, design: Design, seen: Measured, settings: Sequence[Setting]
) -> list[Setting]:
    """Return the settings to predict: unmeasured tilts of `wanted` (or the family) at the most frequent plate speed."""
    plates, counts = np.unique(seen.plate_speed, return_counts=True)
    plate = float(plates[np.argmax(counts)])
    tilts = design.family.tilt_deg if wanted is None else wanted
    measured_tilts = [setting.tilt for setting in settings if setting.plate_speed == plate]
    missing = sorted({float(tilt) for tilt in tilts} - set(measured_tilts))
    if len(missing) + len(settings) > MAX_SETTINGS:
        raise InputError(
            f"‹predict›: {len(missing)} tilts and {len(settings)} measured ones are more than {MAX_SETTINGS}. "
            "Give fewer tilts."
        )
    return [Setting(member, plate) for member in design.members(missing, ["flexible"])]


def _sample_with_surrogate(
    inputs: FitInputs,
    settings: Sequence[Setting],
    observed: Sequence[Observed],
    unmeasured: Sequence[Setting],
    progress: Progress,
) -> tuple[Posterior, Sequence[SpeedModel], Sequence[SpeedModel]]:
    """Return the posterior from the surrogate, and speed models of the measured and of the `unmeasured` settings."""
    responses, unmeasured_responses = (surrogate_speeds.speed_models(inputs, some) for some in (settings, unmeasured))
    seed = inputs.scene.run.seed
    sampled = importance_sampling.sample(inputs.unknown.sampled, observed, responses, seed, progress)
    return sampled, responses, unmeasured_responses


def _sample_with_runs(
    inputs: FitInputs,
    settings: Sequence[Setting],
    observed: Sequence[Observed],
    unmeasured: Sequence[Setting],
    progress: Progress,
) -> tuple[Posterior, Sequence[SpeedModel], Sequence[SpeedModel]]:
    """Return the posterior from emulators of simulated speeds, and emulators of measured and `unmeasured` settings.

    Emulators over the prior are refined by walkers drawn from a first posterior. Those of unmeasured settings cover the
    posterior alone.
    """
    progress("kernels", 0, 1)
    seed = inputs.scene.run.seed
    x = emulated_speeds.sample_parameters(inputs, PRIOR_WALKERS)
    y = emulated_speeds.simulate_settings(inputs, settings, x, progress, batch=0)
    parameters, responses = inputs.unknown.parameters, _fit_responses(inputs, settings, x, y)
    with emulator.single_thread():
        first = importance_sampling.sample(parameters, observed, responses, seed, progress)
    drawn = _thin_draws(first, inputs, POSTERIOR_WALKERS)
    more = emulated_speeds.simulate_settings(inputs, settings, drawn, progress, batch=1)
    x = np.concatenate([x, drawn])
    y = [np.concatenate(both) for both in zip(y, more, strict=True)]
    responses = _fit_responses(inputs, settings, x, y)
    with emulator.single_thread():
        sampled = importance_sampling.sample(parameters, observed, responses, seed, progress)
    drawn = _thin_draws(sampled, inputs, AHEAD_WALKERS)
    y = emulated_speeds.simulate_settings(inputs, unmeasured, drawn, progress, batch=2)
    return sampled, responses, _fit_responses(inputs, unmeasured, drawn, y)


def _expected_time(inputs: FitInputs, settings: Sequence[Setting], unmeasured: Sequence[Setting]) -> Expected:
    """Estimate the time of a fit: its runs, from the CPU time of one run in each setting, and LEARNING_S."""
    counts = [PRIOR_WALKERS + POSTERIOR_WALKERS] * len(settings) + [AHEAD_WALKERS] * len(unmeasured)
    costs = (emulated_speeds.cpu_seconds(inputs, setting) for setting in [*settings, *unmeasured])
    runs_s = sum(run_time.wall_time(each_s, count) for each_s, count in zip(costs, counts, strict=True))
    return Expected(runs_s + LEARNING_S)


def _thin_draws(sampled: Posterior, inputs: FitInputs, count: int) -> Array:
    """Return the simulated parameters of `count` evenly spaced draws of the posterior, shape (count, simulated)."""
    wide = len(inputs.unknown.simulated)
    return sampled.draws[:: len(sampled.draws) // count][:count, :wide]


def _fit_responses(inputs: FitInputs, settings: Sequence[Setting], x: Array, y: Sequence[Array]) -> list[SpeedModel]:
    """Fit an emulator in each setting to the speeds `y`, shape (n,) each, at parameters `x`, shape (n, simulated)."""
    differ = inputs.unknown.prints_differ
    return [
        emulated_speeds.fit_response(x, speeds, setting, differ) for setting, speeds in zip(settings, y, strict=True)
    ]


def _predict_bands(
    inputs: FitInputs, settings: Sequence[Setting], models: Sequence[SpeedModel], sampled: Posterior, is_measured: bool
) -> list[Band]:
    """Compute bands of the speed of one more print in each setting. `is_measured`: the settings were measured."""
    bands = []
    for number, (setting, response) in enumerate(zip(settings, models, strict=True)):
        rng = np.random.default_rng([inputs.scene.run.seed, number, is_measured])
        speeds = posterior.speed_draws(sampled.draws, response, rng)
        _, _, scatter = response(sampled.draws[:: posterior.KEPT_DRAWS // 64])
        ends = [float(end) for end in np.quantile(speeds, BAND_LEVELS)]
        key = (setting.tilt, setting.plate_speed, int(is_measured))
        bands.append(Band._make((*key, *ends, float(np.median(scatter)))))
    return bands


def _caveat_notes(inputs: FitInputs) -> list[str]:
    """Return notes on the limits of the written files and bands."""
    notes = [
        "scene.toml and design.toml hold means and standard deviations. Correlations of parameters are in "
        "posterior.csv, and only bands.csv includes them"
    ]
    if inputs.model == "space" and not inputs.unknown.prints_differ:
        notes.insert(0, "the scene has no unevenness: bands exclude differences between prints")
    return notes


def _fitted_scene(model: ModelName, scene: Scene, rows: Sequence[Summary], path: Path) -> Scene:
    """Return the scene with the fitted values, named after the file `path`. Held values keep the scene's deviations."""
    data: dict[str, Any] = scene.model_dump(exclude_none=True)
    for row in rows:
        if row.name == "tip_radius_um":  # log-normal: the factor from the 68 % interval
            factor = math.sqrt(row.high_68 / row.low_68)
            data["feet"] |= {"tip_radius_um": math.sqrt(row.high_68 * row.low_68), "tip_radius_sd_factor": factor}
        elif row.name in SCENE_PARAMETERS:
            table, _, key = PARAMETER_KEYS[row.name].partition(".")
            data[table] |= {key: row.mean, DEVIATION_KEYS.get(key, f"{key}_sd"): row.sd}
    data["description"] = f"As {scene.name}, as learnt from {path.name[:200]} by {model}"
    data["name"] = name_after(scene.name, path, "fit-")
    return validate(data, Scene, "fitted scene")


def _fitted_design(design: Design, rows: Sequence[Summary], path: Path) -> Design:
    """Return the design with the fitted values of its legs and material, named after the file of speeds."""
    data: dict[str, Any] = {"legs": {}, "material": {}} | design.model_dump(exclude_unset=True)
    for row in rows:
        if row.name == "thickness_mm":
            data["legs"] |= {"flexible_thickness_mm": row.mean, "thickness_sd_mm": row.sd}
        elif row.name == "youngs_modulus_gpa":
            data["material"] |= {row.name: row.mean, "youngs_modulus_sd_gpa": row.sd}
    data["description"] = f"As {design.name}, legs and material learnt from {path.name[:200]}"
    data["name"] = name_after(design.name, path, "fit-")
    return validate(data, Design, "fitted design")
