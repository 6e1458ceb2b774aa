"""Numbers with errors from sums over tracks: how each is computed, and when it is refused.

`sums` are the `Moments` of some tracks, `Settings` turn these into `numbers`: values by name.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.analysis import displacement_fit, persistent_walk
from walkergen.analysis.moments import Grid, Moments
from walkergen.analysis.persistent_walk import Spread
from walkergen.core.numerics import Array, Complex
from walkergen.core.numerics.quantity import Quantity

MIN_SIGNIFICANCE = 3.0
"""Minimum distance of a rate or an offset from 0, in standard errors, to be inverted or reported."""

MIN_DECAY, MIN_DECAY_WALLS = 0.2, 0.05
"""Share of the direction that must be lost at the longest fitted lag for a known rate, in the open and between
walls."""

MIN_SAMPLES = 8
"""Number of independent samples below which every error, and so every estimate, is refused."""

UNITS = {
    "speed": "mm_s",
    "body_speed": "mm_s",
    "lane_speed": "mm_s",
    "motion_speed": "mm_s",
    "speed_scatter": "mm_s",
    "sideways_speed": "mm_s",
    "turning_bias": "rad_s",
    "turning_scatter": "rad_s",
    "rotational_diffusion": "rad2_s",
    "persistence_rate": "per_s",
    "persistence_time": "s",
    "persistence_length": "mm",
    "turning_memory": "s",
    "heading_noise": "rad",
    "ballistic_speed": "mm_s",
    "diffusivity": "mm2_s",
    "translational_diffusion": "mm2_s",
    "crossover_time": "s",
    "localisation_noise": "mm",
    "parallel_mean": "mm",
    "parallel_sd": "mm",
    "orthogonal_mean": "mm",
    "orthogonal_sd": "mm",
    "self_alignment": "per_mm",
    "slope_turning": "rad_s",
}
"""Names of all estimates, and the unit of each as keys write it.

`speed` is the mean along a lane or along the headings; without these it is `motion_speed`, the root mean square of the
velocity that persists for longer than the lag of displacements. `sideways_speed` is the mean drift to the left of the
heading, `speed_scatter` and `turning_scatter` the standard deviations between walkers, `rotational_diffusion` D_r of
headings about each walker's mean turning. `diffusivity` is that of long times, `translational_diffusion` the part of it
that is no run. `persistence_rate` is the decay of the correlation of headings about the mean turning; without headings,
of displacements. Its error, and that of the time and length, allows for a `turning_memory` unless headings exclude it.
"""

FIT_NUMBERS = (
    "amplitude",
    "lasting",
    "heading_variance",
    "msd_speed2",
    "msd_rate",
    "msd_offset",
    "msd_first",
    "shortened",
)
"""Names of auxiliary numbers. `amplitude` (mm^2): persistent part of the displacements' mean square; `lasting`: its
part after the first lag; `heading_variance` (rad^2): noise of headings; `shortened`: share of a speed that
displacements along headings show, or without headings the root of the first product over the speed (s); `msd_first`
(mm^2): squared displacement by noise and diffusion in a sample."""

NEAR_WEIGHT, FAR_WEIGHT = 1.5, -0.5
"""Weights of displacements along headings half a sample and one and a half from their middles, that
extrapolate to none."""

ALIGNMENT_NAMES = ("self_alignment", "slope_turning")
HEADING_NAMES = (
    *("body_speed", "sideways_speed", "turning_scatter", "rotational_diffusion", "turning_memory", "heading_noise"),
    *ALIGNMENT_NAMES,
)
ACROSS_NAMES = ("orthogonal_mean", "orthogonal_sd")
ALONG_NAMES = ("parallel_mean", "parallel_sd")
TURNING_NAMES = ("turning_bias", "persistence_rate", "persistence_time", "persistence_length")

LANE_REASON = "along a lane, where direction does not turn"
HEADINGS_KNOWN_REASON = "headings are known: see body_speed"
NO_HEADINGS_REASON = "no headings in the file (theta, theta_deg)"
NO_SLOPE_REASON = "no slope is known, which alone shows it"
"""Reasons of refusals that no better film would change; tables leave such lines out."""


class Settings(NamedTuple):
    """Settings that turn sums into numbers, the same for all data and for every replicate."""

    grid: Grid
    interval: float
    """Time between samples of a track, s."""
    lane: bool
    """True if walkers run along a lane, not on a plane."""
    headed: bool
    """True if headings are known."""
    detrend_time_s: float
    """Time of the measurement of the mean turning, or in a lane the mean speed, that is subtracted from
    each walker, s; infinite without a subtraction."""
    memory: bool
    """Whether turning noise has a correlation time (a memory), so that headings lose direction late."""
    memory_open: bool
    """Whether the data neither show such a memory nor exclude it: `memory` is then False."""
    square_errors: Array
    """Errors of the mean squared displacement by lag, mm^2; NaN at lags that are not fitted."""
    turn_errors: Array
    """Errors of the correlation: of its real parts by lag, then of its imaginary parts."""
    walls: bool = False
    """Whether sums are of free motion between walls, so that more time shows no longer lags."""

    @property
    def decayed(self) -> float:
        """Share of the direction that must be lost at the longest lag, for its rate to be reported."""
        return MIN_DECAY_WALLS if self.walls else MIN_DECAY

    @property
    def advice(self) -> str:
        """Advice on how to get longer lags."""
        return "a larger box resolves it" if self.walls else "film for longer"

    @property
    def first_lag(self) -> int:
        """Least lag between the starts of displacements that share no position, samples."""
        return self.grid.step + 1


def quantity(name: str, value: float, se: float, freedom: float = math.inf) -> Quantity:
    """Return a named quantity with the unit that UNITS gives, its standard error and its degrees of freedom."""
    return Quantity(name, UNITS.get(name, ""), value, se, freedom)


def refusal(name: str, reason: str) -> Quantity:
    """Return a named quantity without a value, and with the reason why."""
    return Quantity(name, UNITS.get(name, ""), None, refused=reason)


def mean(sums: npt.NDArray[np.generic], pairs: Array) -> npt.NDArray[np.generic]:
    """Return means: `sums` divided by the numbers of `pairs`, of the same shape; NaN where there are no pairs."""
    return np.where(pairs > 0, sums / np.maximum(pairs, 1.0), np.nan)


def evaluate(sums: Moments, settings: Settings) -> dict[str, float]:
    """Return numbers by name from sums over tracks; NaN without a meaning or fit. `from_spread` returns the others."""
    numbers = dict.fromkeys((*UNITS, *FIT_NUMBERS), math.nan)
    numbers["lane_speed"] = _ratio_or_nan(sums.run) / settings.interval
    _add_mean_and_sd(numbers, "parallel", sums.along)
    _add_mean_and_sd(numbers, "orthogonal", sums.across)
    if settings.lane:
        numbers["speed"], numbers["shortened"] = numbers["lane_speed"], 1.0
        _fit_dispersion(numbers, sums, settings)
    else:
        _fit_persistence(numbers, sums, settings)
    return numbers


def _ratio_or_nan(sum_and_count: Array) -> float:
    """Return a sum divided by its number of terms; NaN without terms."""
    return float(sum_and_count[0] / sum_and_count[1]) if sum_and_count[1] > 0 else math.nan


def _add_mean_and_sd(numbers: dict[str, float], name: str, powers: Array) -> None:
    """Add mean and sd of displacements to `numbers`, as `name`_mean and `name`_sd. `powers`: see `Moments.along`."""
    count, first, second = powers
    if count > 1:
        numbers[f"{name}_mean"] = first / count
        numbers[f"{name}_sd"] = math.sqrt(max(second / count - (first / count) ** 2, 0.0))


def _fit_persistence(numbers: dict[str, float], sums: Moments, settings: Settings) -> None:
    """Fit the rate of losing direction, the mean turning and the speed, and add them to `numbers`."""
    window = 0.0 if settings.headed else settings.grid.step * settings.interval
    lag = settings.grid.turn_lags * settings.interval
    values = np.asarray(mean(sums.turn, sums.turn_pairs), dtype=complex)
    real, imaginary = np.split(settings.turn_errors, 2)
    errors = np.hypot(real, imaginary) / math.sqrt(2.0)
    use = np.isfinite(values) & (errors > 0)
    if use.sum() < 4:
        return
    lag, values = lag[use], values[use]
    # Between walls turns are few: weights follow from lag and number, not from their scatter.
    errors = lag / np.sqrt(sums.turn_pairs[use]) if settings.walls else displacement_fit.smooth_errors(lag, errors[use])
    fitted = _fit_decay(lag, values, errors, settings, window)
    if fitted is None:
        return
    amplitude, rate, turn, *memory = map(float, fitted)
    numbers["persistence_rate"] = rate
    numbers["persistence_time"] = 1.0 / rate if rate else math.inf
    if settings.headed:
        numbers["turning_bias"] = _ratio_or_nan(sums.turned) / settings.interval
        variance = -_log_correlation_at_zero(lag, values)
        lasting = memory[0] if memory else 0.0
        if lasting:
            variance = -math.log(max(amplitude, 1e-300))
            numbers["turning_memory"] = lasting

        def correlation(samples: Array) -> Array:
            """Return the autocorrelation of headings at lags in samples."""
            after = samples * settings.interval
            return np.asarray(np.exp(-rate * (persistent_walk.delayed_lag(after, lasting) if lasting else after)))

        shortened = math.exp(-0.5 * variance) * _extrapolated_speed_share(correlation)
        velocity = complex(_body_velocity(sums) / (shortened * settings.interval))
        numbers["shortened"] = shortened
        numbers["body_speed"] = numbers["speed"] = velocity.real
        numbers["sideways_speed"] = velocity.imag
        numbers["heading_variance"] = variance
        numbers["heading_noise"] = math.sqrt(max(variance, 0.0))
    else:
        numbers |= {"turning_bias": turn, "amplitude": amplitude, "lasting": float(values[0].real)}
        numbers["motion_speed"] = numbers["speed"] = math.sqrt(max(amplitude, 0.0)) / window
        first = persistent_walk.velocity_correlation(
            np.array([settings.first_lag * settings.interval]), 1.0, rate, turn, window
        )
        numbers["shortened"] = window * math.sqrt(abs(first[0]))
    numbers["persistence_length"] = abs(numbers["speed"]) * numbers["persistence_time"]


def _fit_decay(lag: Array, values: Complex, errors: Array, settings: Settings, window: float) -> Array | None:
    """Fit the autocorrelation of headings or displacements, `values` with `errors` by `lag` (s); None if it fails.

    Return its amplitude at lag 0, its rate of decay (1/s), the mean turning rate (rad/s) and, with `settings.memory`,
    the correlation time (s) of the turning noise. Displacements span `window` (s); 0 for headings.
    """

    def correlation_without_memory(lags: Array, amplitude: float, rate: float, turn: float) -> Complex:
        """Return the complex autocorrelation of directions at lags (s) without memory. `rate`: 1/s. `turn`: rad/s."""
        # Less the mean turning over a time T, diffusion is smaller by the share lag / T (a Brownian bridge).
        return persistent_walk.velocity_correlation(
            lags * (1.0 - lags / settings.detrend_time_s), amplitude, rate, turn, window
        )

    def correlation_with_memory(lags: Array, amplitude: float, rate: float, turn: float, memory: float) -> Complex:
        """Return the complex autocorrelation of headings or displacements if turning noise has a memory.

        Parameters
        ----------
        lags : Array
            Lags, s.
        amplitude : float
            Amplitude of the decay: 1 for headings without noise, mm^2 for displacements.
        rate : float
            Rate of decay at long lags, 1/s.
        turn : float
            Mean turning rate, rad/s.
        memory : float
            Correlation time of the turning noise, s.

        Returns
        -------
        Complex
            Autocorrelation at the lags, shape (lags,).
        """
        return correlation_without_memory(persistent_walk.delayed_lag(lags, memory), amplitude, rate, turn)

    if not settings.memory:
        start = _guess_start(lag, values, errors)
        return persistent_walk.fit(correlation_without_memory, lag, values, errors, start)
    lowest, start_with_memory = (*[-math.inf] * 3, 0.0), _guess_start_with_memory(lag, values, errors)
    return persistent_walk.fit(correlation_with_memory, lag, values, errors, start_with_memory, lowest)


def _guess_start_with_memory(lag: Array, values: Complex, errors: Array) -> tuple[float, float, float, float]:
    """Guess amplitude, rate (1/s), turn (always 0) and memory (s) of `_fit_decay`, from lines through log(`values`)."""
    log_size, weights = np.log(np.maximum(np.abs(values), 1e-300)), np.abs(values) / errors
    guesses = []
    for memory in np.geomspace(lag[0], lag[-1] / 3.0, 8):
        line, misfit, *_ = np.polyfit(persistent_walk.delayed_lag(lag, memory), log_size, 1, w=weights, full=True)
        guesses.append((float(misfit.sum()), math.exp(line[1]), -float(line[0]), float(memory)))
    _, amplitude, rate, memory = min(guesses)
    return amplitude, rate, 0.0, memory


def _log_correlation_at_zero(lag: Array, correlation: Complex) -> float:
    """Extrapolate the logarithm of the correlation of headings to lag 0: noise makes it negative.

    A parabola goes through the first three lags (s): with inertia headings hardly turn at first, which the fitted decay
    would miss.
    """
    logarithms = np.log(np.maximum(np.abs(correlation[:3]), 1e-300))
    return float(np.polyval(np.polyfit(lag[:3], logarithms, 2), 0.0))


def _body_velocity(sums: Moments) -> complex:
    """Return the mean displacement per sample (mm), along the heading and (imaginary part) to its left.

    It is extrapolated to the heading's own time, from headings before a displacement and after it separately: there may
    be a cusp between them (headings that diffuse) or none (inertia).
    """
    (near, near_pairs), (far, far_pairs) = sums.near, sums.far
    if not near_pairs.real or not far_pairs.real:
        return complex(math.nan, math.nan)
    straight: complex = NEAR_WEIGHT * near / near_pairs + FAR_WEIGHT * far / far_pairs
    return straight


def _extrapolated_speed_share(correlation: Callable[[Array], Array]) -> float:
    """Return the speed that `_body_velocity` extrapolates over the true speed, given the autocorrelation of headings.

    It is 1 up to second order in the turn of a sample. Lags of `correlation` are in samples.
    """
    nodes, weights = np.polynomial.legendre.leggauss(8)
    near, far = (0.5 * float(weights @ correlation(first + 0.5 + 0.5 * nodes)) for first in (0.0, 1.0))
    return NEAR_WEIGHT * near + FAR_WEIGHT * far


def _guess_start(lag: Array, values: Complex, errors: Array) -> tuple[float, float, float]:
    """Guess amplitude, rate (1/s) and turn (rad/s) of `_fit_decay`, from the autocorrelation `values` at lags (s)."""
    size = np.abs(values)
    turn = 0.0
    for seconds, value, error in zip(lag, values, errors, strict=True):
        if abs(value) > 3.0 * error:
            turn += float(np.angle(value * np.exp(-1j * turn * seconds))) / seconds
    fallen = np.flatnonzero(size < size[0] / math.e)
    # Without a fall to 1/e: the rate from the drop between the first and the last lag.
    index, fall = (fallen[0], 1.0) if len(fallen) else (-1, math.log(size[0] / size[-1]))
    return float(size[0]), fall / lag[index], turn


def from_spread(spread: Spread, interval: float) -> dict[str, float]:
    """Return the numbers, by name, that follow from a fit of the squared displacement. `interval`: of samples, s."""
    speed2, offset = spread.mean_square, spread.offset
    return {
        "msd_speed2": speed2,
        "msd_rate": spread.rate,
        "msd_offset": offset,
        "msd_first": offset + 4.0 * spread.diffusion * interval,
        "ballistic_speed": math.sqrt(max(speed2, 0.0)),
        "diffusivity": spread.diffusivity,
        "translational_diffusion": math.nan if spread.smooth_rate else spread.diffusion,
        "crossover_time": 4.0 * spread.diffusivity / speed2 if speed2 else math.nan,
        "localisation_noise": math.sqrt(max(offset, 0.0) / 4.0),
    }


def _fit_dispersion(numbers: dict[str, float], sums: Moments, settings: Settings) -> None:
    """Fit the spread 2 D lag (1 - lag / T) about mean runs in a lane; add D and crossover time to `numbers`."""
    lag = settings.grid.square_lags * settings.interval
    values = np.asarray(mean(sums.about_run, sums.square_pairs), dtype=float)
    use = np.isfinite(values) & (settings.square_errors > 0)
    use &= lag >= 0.1 * lag[use].max(initial=0.0)
    speed = numbers["lane_speed"]
    if use.sum() < 4:
        return
    spread = values[use] / (1.0 - lag[use] / settings.detrend_time_s)
    # The error of a variance grows with the variance itself: weights 1/lag.
    slope, _ = np.polyfit(lag[use], spread, 1, w=1.0 / lag[use])
    numbers["diffusivity"] = 0.5 * float(slope)
    numbers["crossover_time"] = float(slope) / speed**2 if speed else math.nan
