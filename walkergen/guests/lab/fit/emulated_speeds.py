"""Emulated speeds: short simulated runs over the parameters, and a Gaussian process through them.

Every setting (a walker on a plate) has an emulator of its own. One over tilt as well predicts
speeds left out no better (rms 9 to 11 mm/s at 10 deg with 64 walkers a tilt). Its errors are wrong, because it takes
the scatter between printed walkers as equal at all tilts. That falls from 13 mm/s at 8 deg to 1.4 at 35 deg.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core import Design, mass_of
from walkergen.core.errors import InputError
from walkergen.core.files.progress import Progress, part_progress
from walkergen.core.numerics import Array
from walkergen.core.scene import Drive, Scene
from walkergen.core.theory import uncertain_inputs
from walkergen.guests.lab.fit.parameters import ModelName, Unknown, prior_values
from walkergen.points import emulator, run_time, walkers
from walkergen.points.emulator import Emulator
from walkergen.points.experiments import Walker
from walkergen.points.store import Store

RUN_SECONDS = 2.0
"""Measured time of a simulated run, s: prints differ by more than runs of this length of one print."""

DISCARDED_SECONDS = 0.5
"""Start of a run that is not measured, s."""

MAX_FAILED_SHARE = 0.25
"""Largest share of simulated walkers that may have no speed."""


class Setting(NamedTuple):
    """Walker on a plate whose speed was measured, or is to be predicted."""

    design: Design
    plate_speed: float
    """Peak speed of the plate, mm/s."""

    @property
    def tilt(self) -> float:
        """Tilt of the legs, deg."""
        return self.design.tilt_deg


class FitInputs(NamedTuple):
    """Common inputs of all simulated walkers of a fit."""

    scene: Scene
    model: ModelName
    unknown: Unknown


class Response(NamedTuple):
    """Function that predicts the mean speed in a setting, and its scatter between prints, from the parameters."""

    emulator: Emulator
    floor: float
    """Scatter between prints at speed 0, mm/s, as simulated; 0 where prints do not differ."""
    share: float
    """Scatter between prints over the speed, added to `floor` in quadrature."""
    still: float
    """Speed (mm/s) below which a fitted scatter no longer falls with the speed."""

    def __call__(self, x: Array) -> tuple[Array, Array, Array]:
        """Return mean speed, its error from the emulator, and the scatter between prints, each (k,), mm/s.

        `x`: parameters, shape (k, parameters). An extra last column is the fitted scatter over speed, used if present.
        """
        simulated = len(self.emulator.centre)
        mean, sd = self.emulator(x[:, :simulated])
        scatter = np.hypot(self.floor, self.share * mean)
        if x.shape[1] > simulated:
            scatter = x[:, simulated] * np.hypot(mean, self.still)
        return mean, sd, scatter


STILL_SPEED_RATIO = 0.1
"""Speed over the plate's speed below which a fitted scatter no longer falls with the speed."""


def sample_parameters(inputs: FitInputs, count: int) -> Array:
    """Return parameters of `count` walkers that cover their priors evenly, shape (count, simulated parameters).

    They form a lattice (`uncertain_inputs.lattice_points`).
    """
    parameters = inputs.unknown.simulated
    return prior_values(parameters, uncertain_inputs.lattice_points(len(parameters), count, inputs.scene.run.seed))


def simulate(inputs: FitInputs, setting: Setting, x: Array, progress: Progress, batch: int) -> Array:
    """Simulate the speeds (mm/s), shape (n,), of walkers with parameters `x`, shape (n, simulated), in a setting.

    The speed is NaN where a walker falls. The scene's seed, the setting and the number `batch` determine how each
    walker prints and starts. Stored speeds are reused, and Ctrl-C loses only the current runs.
    """
    prints, seeds = _sample_prints(inputs, setting, len(x), batch)
    names = [parameter.prior.name for parameter in inputs.unknown.simulated]
    names += [varying.name for varying in inputs.unknown.printed]
    scene = _short_scene(inputs, setting)
    runs = []
    for row, seed in zip(np.column_stack([x, prints]), seeds, strict=True):
        run = scene.run.model_copy(update={"seed": seed})
        own_scene = scene.model_copy(update={"run": run})
        values = dict(zip(names, row, strict=True))
        runs.append(Walker(*uncertain_inputs.apply_inputs(own_scene, setting.design, values)))
    keys = [run.key for run in runs]
    store = Store()
    speeds = {key: record["speed_mm_s"] for key, record in store.get(keys).items()}
    missing = [index for index, key in enumerate(keys) if key not in speeds]
    new_runs = [runs[index] for index in missing]
    results = walkers.simulate_parallel(new_runs, part_progress(progress, 0, 1, f"simulating tilt {setting.tilt:g}"))
    new_speeds = {keys[missing[index]]: point.summary.speed.value for index, point in results.items()}
    store.save((key, {"speed_mm_s": speed}) for key, speed in new_speeds.items())
    store.close()
    if len(results) < len(new_runs):
        raise KeyboardInterrupt
    speeds |= new_speeds
    return np.array([np.nan if speeds[key] is None else speeds[key] for key in keys], dtype=float)


def cpu_seconds(inputs: FitInputs, setting: Setting) -> float:
    """Estimate the CPU time (s) of one short run in a setting."""
    return run_time.run_cpu_s(Walker(_short_scene(inputs, setting), setting.design, mass_of(setting.design)))


def _sample_prints(inputs: FitInputs, setting: Setting, count: int, batch: int) -> tuple[Array, list[int]]:
    """Draw the inputs that differ between prints, shape (count, inputs), and a seed for the run of each print.

    The draws differ between settings and batches. Otherwise errors of emulators would be the same at all tilts.
    """
    setting_key = [round(1e6 * (setting.tilt + 90.0)), round(1e6 * setting.plate_speed)]
    rng = np.random.default_rng([inputs.scene.run.seed, batch, *setting_key])
    seeds = [int(seed) for seed in rng.integers(2**62, size=count)]
    uniform = rng.uniform(1e-9, 1.0, (count, len(inputs.unknown.printed)))
    columns = [
        uncertain_inputs.input_quantiles(varying, uniform[:, column])
        for column, varying in enumerate(inputs.unknown.printed)
    ]
    return np.column_stack(columns) if columns else np.empty((count, 0)), seeds


def _short_scene(inputs: FitInputs, setting: Setting) -> Scene:
    """Return the scene of a short run in a setting, without walls, which a speed does not need."""
    scene = plate_scene(inputs.scene, setting)
    run = {"seconds": RUN_SECONDS, "discard_seconds": DISCARDED_SECONDS, "runs": 1}
    return scene.model_copy(
        update={
            "run": scene.run.model_copy(update=run),
            "arena": scene.arena.model_copy(update={"length_mm": None, "width_mm": None}),
        }
    )


def plate_scene(scene: Scene, setting: Setting) -> Scene:
    """Return the scene with a setting's plate speed and the scene's frequency. A motor's scene stays the same."""
    drive = scene.drive
    if drive.kind == "motor" or math.isclose(setting.plate_speed, drive.peak_speed, rel_tol=1e-9):
        return scene
    other = Drive(
        frequency_hz=drive.frequency,
        peak_speed_mm_s=setting.plate_speed,
        second_harmonic_ratio=drive.second_harmonic_ratio,
        second_harmonic_phase_deg=drive.second_harmonic_phase_deg,
    )
    return scene.model_copy(update={"drive": other})


def fit_response(x: Array, y: Array, setting: Setting, prints_differ: bool) -> Response:
    """Return an emulator fitted to speeds `y` (mm/s), shape (n,), of walkers with parameters `x`, shape (n, simulated).

    Walkers that fell have the speed NaN. Scatter about the emulator grows with speed. It counts as scatter between
    prints if `prints_differ`, otherwise as noise of short runs. Raises InputError when too many walkers fell.
    """
    finite = np.isfinite(y)
    fell = len(y) - int(finite.sum())
    if fell > MAX_FAILED_SHARE * len(y) or len(y) - fell < emulator.MIN_VALUES:
        raise InputError(
            f"tilt {setting.tilt:g} deg: {fell} of {len(y)} simulated walkers have no speed, because they "
            "topple or their energy does not balance. Leave this tilt out, or fix parameters"
        )
    x, y = x[finite], y[finite]
    rough = emulator.fit(x, y)
    floor, share = _fit_scatter(y - rough.left_out, rough.left_out)
    noise = np.hypot(floor, share * (y - rough.left_out))
    fitted = emulator.fit(x, y, noise)
    # The residuals also contain the emulator's own error, which is no noise: divide it out
    excess = float(np.sqrt(np.mean((fitted.left_out / fitted.left_out_sd) ** 2)))
    floor, share = floor * excess, share * excess
    fitted = emulator.fit(x, y, noise * excess)
    still = STILL_SPEED_RATIO * setting.plate_speed
    return Response(fitted, *((floor, share) if prints_differ else (0.0, 0.0)), still)


def _fit_scatter(speed: Array, residual: Array) -> tuple[float, float]:
    """Fit the variance a^2 + (b speed)^2 to residuals (mm/s) by speed (mm/s), both (n,). Return a (mm/s) and b."""
    from scipy.optimize import nnls

    typical = float(np.sqrt(np.mean(residual**2))) or 1e-6
    columns = np.column_stack([np.ones_like(speed), speed**2])
    # The scatter of a squared residual grows with its expected value: weights from the fit before
    weight = np.full(len(speed), typical**-2)
    for _ in range(3):
        (floor, share), _ = nnls(columns * weight[:, None], residual**2 * weight)
        weight = 1.0 / np.maximum(columns @ (floor, share), (0.3 * typical) ** 2)
    return max(math.sqrt(floor), 0.1 * typical), math.sqrt(share)


def simulate_settings(
    inputs: FitInputs, settings: Sequence[Setting], x: Array, progress: Progress, batch: int
) -> list[Array]:
    """Simulate speeds (mm/s, shape (n,)) of walkers with parameters `x` in each setting, as `simulate` does in one."""
    speeds = []
    for number, setting in enumerate(settings):

        def report_overall_progress(message: str, done: int, total: int, number: int = number) -> None:
            progress(message, number * len(x) + done, len(settings) * len(x))

        speeds.append(simulate(inputs, setting, x, report_overall_progress, batch))
    return speeds
