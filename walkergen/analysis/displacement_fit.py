"""Fit of the mean squared displacement: a run that turns, diffusion, noise of the positions.

The data decide whether these terms can be separated: a run appears as curvature. The fit's misfit is compared with that
from the scatter of independent samples.

Arguments: `lag` (s) and `errors` (mm^2) have the shape (lags,). `values` are mean squared displacements (mm^2) at these
lags: row 0 of all samples, each later row with one sample left out. `turn` is a mean rate of turning, rad/s.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from walkergen.analysis import persistent_walk
from walkergen.analysis.persistent_walk import Spread
from walkergen.core.numerics import Array, statistics
from walkergen.core.numerics.distributions import fisher_tail, student_quantile

RATE_COUNT = 33
"""Number of rates at which the fit's rate is sought first, from far below 1 / longest lag."""

RUN_P_VALUE = 1e-3
"""Probability, for walkers that only diffuse, of a curvature that counts as a run (Student's t)."""

SUSPECTED_P_VALUE = 0.025
"""Probability, for walkers that only diffuse, of a curvature that may be a run, of unknown contribution."""

INERTIA_P_VALUE = 0.025
"""Probability, for runs without inertia, of a diffusion below 0 that counts as inertia."""

EXPONENT_LAG_RATIO = 1.1
"""Ratio of lags between which a local exponent of the fit is taken."""

MIN_BALLISTIC_EXPONENT = 1.8
"""Minimum local exponent of growth that is called ballistic (2), not a crossover to diffusion (1)."""

START_RATE_RATIOS = (0.5, 2.0, 5.0, 11.0, 24.0)
"""Ratios, less 1, of the rates of a run and of its beginning that are tried first."""

NO_RUNS = ((0.0, 0.0), (0.0, 0.0))

MIN_SAMPLES = 3
"""Number of samples up to which there is no fit: its weights need several when one is left out."""

NO_SPREAD = Spread(*[math.nan] * 5)

NO_ERRORS = np.zeros(0)

MAX_RATE_RATIO = 1e6
"""Ratio of rates of runs, of each other and of those that the lags show, at which they are at their limit."""

MIN_RATE_DIFFERENCE = 0.1
"""Ratio, less 1, of the rates of a run and of its beginning below which they count as equal, the fit's limit."""


class DisplacementFit(NamedTuple):
    """Fit of the mean squared displacement."""

    spreads: tuple[Spread, ...]
    """Parameters of all samples, then with each sample left out in turn."""
    run: bool
    """Whether the data show a run. Without a run speed2 and rate are 0, and only diffusion remains."""
    misfit: float
    """Sum of squared residuals over its expectation: about 1 where the law holds."""
    p_value: float
    """Probability of a misfit at least as large if the law holds; NaN without a fit."""
    errors: Array = NO_ERRORS
    """Errors by lag that were its weights, mm^2; NaN at lags that were not fitted."""
    suspected: bool = False
    """Whether a run is possible though the data show none."""

    @property
    def at_its_limit(self) -> bool:
        """Whether both rates of a smooth run are equal in any of the fits, with all samples or one left out.

        Such a fit has one parameter less, and errors of a jackknife do not cover runs beyond this limit.
        """
        return any(0.0 < spread.smooth_rate < (1.0 + MIN_RATE_DIFFERENCE) * spread.rate for spread in self.spreads)

    @property
    def goodness(self) -> str:
        """Goodness of the fit, as text; '' without a fit, or without scatter."""
        if math.isnan(self.p_value):
            return ""
        return (
            f"fit of the squared displacement: misfit {self.misfit:.2g} times the value "
            f"expected by chance, probability {self.p_value:.2g}"
        )

    def regime(self, lag: float) -> str:
        """Describe in words whether fitted squared displacements are still ballistic at a lag (s)."""
        spread = self.spreads[0]._replace(offset=0.0)
        near, far = persistent_walk.squared_displacement(np.array([lag / EXPONENT_LAG_RATIO, lag]), spread)
        exponent = math.log(far / near) / math.log(EXPONENT_LAG_RATIO) if far > 0 and near > 0 else math.nan
        if exponent > MIN_BALLISTIC_EXPONENT:
            return f"ballistic at all lags up to {lag:.3g} s"
        return f"no end of the run is resolved within {lag:.3g} s"


def fit(lag: Array, squares: Sequence[Array], turns: Sequence[float]) -> DisplacementFit:
    """Fit the mean squared displacement of all samples, then with each sample left out in turn.

    `squares` (mm^2, each of shape (lags,)) and `turns` (mean rates of turning, rad/s) have an entry for each of these
    fits. Parameters are NaN where lags are too few.
    """
    values = np.stack(squares)
    use = np.isfinite(values).all(axis=0)
    if len(values) > MIN_SAMPLES:
        use = use & (_replicate_errors(values) > 0).all(axis=0)
    if len(values) <= MIN_SAMPLES or use.sum() < 6 or not np.isfinite(turns).all():
        return DisplacementFit((NO_SPREAD,) * len(values), run=False, misfit=math.nan, p_value=math.nan)
    weights = np.full(len(lag), np.nan)
    lag, values = lag[use], values[:, use]
    errors = np.stack([smooth_errors(lag, error) for error in _replicate_errors(values)])
    significance = _max_run_significance(lag, values, errors, turns)
    run, suspected = (
        bool(significance > student_quantile(len(values) - 2, 1.0 - p)) for p in (RUN_P_VALUE, SUSPECTED_P_VALUE)
    )
    fits = [_fit_run(lag, *row, run) for row in zip(values, errors, turns, strict=True)]
    diffusion = np.array([[spread.diffusion] for spread in fits])
    least = -student_quantile(len(values) - 2, 1.0 - INERTIA_P_VALUE) * float(
        statistics.jackknife_error(diffusion[1:])[0]
    )
    if run and diffusion[0, 0] < least:
        first = _fit_smooth(lag, values[0], errors[0], turns[0], None)
        start = first.rate, first.smooth_rate
        fits = [_fit_smooth(lag, *row, start) for row in zip(values, errors, turns, strict=True)]
    residuals = (values - np.stack([persistent_walk.squared_displacement(lag, spread) for spread in fits])) / errors[0]
    weights[use] = errors[0]
    return DisplacementFit(
        tuple(fits), run, *_misfit_probability(residuals[0], residuals[1:]), weights, suspected and not run
    )


def refit(lag: Array, squares: Sequence[Array], turns: Sequence[float], earlier: DisplacementFit) -> list[Spread]:
    """Fit mean squared displacements by the law (with or without runs) and the weights of an earlier fit.

    `squares` (mm^2, by `lag`) and `turns` (rad/s) are of too few samples to find a law or weights from them.
    """
    use, law = np.isfinite(earlier.errors), earlier.spreads[0]
    if not use.any():
        return [NO_SPREAD] * len(squares)
    lag, errors, spreads = lag[use], earlier.errors[use], []
    for values, turn in zip(squares, turns, strict=True):
        if not np.isfinite(values[use]).all():
            spreads.append(NO_SPREAD)
        elif law.smooth_rate:
            spreads.append(_fit_smooth(lag, values[use], errors, turn, (law.rate, law.smooth_rate)))
        else:
            spreads.append(_fit_run(lag, values[use], errors, turn, earlier.run))
    return spreads


def _replicate_errors(values: Array) -> Array:
    """Return the standard errors of `values`, in an array of their shape.

    Errors are computed anew for every row, because the jackknife must include the scatter of the weights.
    """
    count = len(values) - 1
    samples = count * values[0] - (count - 1) * values[1:]
    resamples = [samples, *(np.delete(samples, number, axis=0) for number in range(count))]
    return np.stack([sample.std(axis=0, ddof=1) / math.sqrt(len(sample)) for sample in resamples])


def smooth_errors(lag: Array, errors: Array) -> Array:
    """Smooth errors over the lags by a parabola in logarithms: weights should not contain their own scatter."""
    log_lag = np.log(lag)
    smooth: Array = np.exp(np.polyval(np.polyfit(log_lag, np.log(errors), 2), log_lag))
    return smooth


def _max_run_significance(lag: Array, values: Array, errors: Array, turns: Sequence[float]) -> float:
    """Return the largest ratio of a run's speed2 to its error, over trial rates of losing direction.

    Rows of `values` and `errors`, and `turns`: all samples, then with each one left out.
    """
    rates = np.geomspace(0.5 / lag[-1], 0.5 / lag[0], 7)
    runs = np.array(
        [
            [_solve_linear(lag, value, error, (rate,), turn)[0].speed2 for rate in rates]
            for value, error, turn in zip(values, errors, turns, strict=True)
        ]
    )
    error = statistics.jackknife_error(runs[1:])
    return float(np.divide(runs[0], error, out=np.where(runs[0] > 0.0, np.inf, 0.0), where=error > 0.0).max())


def _fit_run(lag: Array, values: Array, errors: Array, turn: float, with_run: bool) -> Spread:
    """Fit a run, diffusion and noise by least squares; only diffusion and noise if not `with_run`.

    All parameters but the run's rate are linear. The rate is sought over a grid and between its nodes (variable
    projection, Golub and Pereyra 1973).
    """
    from scipy.optimize import minimize_scalar

    if not with_run:
        return _solve_linear(lag, values, errors, (), turn)[0]

    def misfit(log_rate: float) -> float:
        """Return the sum of squared residuals at a rate (1/s), given as its logarithm."""
        return _solve_linear(lag, values, errors, (math.exp(log_rate),), turn)[1]

    logs = np.linspace(math.log(1e-3 / lag[-1]), math.log(2.0 / lag[0]), RATE_COUNT)
    best = int(np.argmin([misfit(log) for log in logs]))
    bracket = logs[max(best - 1, 0)], logs[min(best + 1, len(logs) - 1)]
    finest = minimize_scalar(misfit, bounds=bracket, method="bounded", options={"xatol": 1e-7})
    return _solve_linear(lag, values, errors, (math.exp(finest.x),), turn)[0]


def _fit_smooth(lag: Array, values: Array, errors: Array, turn: float, start: tuple[float, float] | None) -> Spread:
    """Fit a run that begins smoothly, by inertia, and noise by least squares.

    `start`: rates (1/s) of losing direction and of gaining speed at the beginning; None: the best of a grid.
    """
    from scipy.optimize import minimize

    most = math.log(MAX_RATE_RATIO)
    low, high = -most - math.log(lag[-1]), most - math.log(lag[0])

    def to_rates(logs: Sequence[float]) -> tuple[float, float]:
        """Return both rates (1/s), limited, from logarithms of the lower one and of their ratio less 1."""
        slow = math.exp(min(max(logs[0], low), high))
        return slow, slow * (1.0 + math.exp(min(logs[1], most)))

    def misfit(logarithms: Sequence[float]) -> float:
        """Return the sum of squared residuals at the two rates."""
        return _solve_linear(lag, values, errors, to_rates(logarithms), turn)[1]

    if start is None:
        slow = np.linspace(math.log(0.1 / lag[-1]), math.log(0.3 / lag[0]), 14)
        logs = min(((log, math.log(ratio)) for log in slow for ratio in START_RATE_RATIOS), key=misfit)
    else:
        logs = math.log(start[0]), math.log(start[1] / start[0] - 1.0)
    options = {"xatol": 1e-4, "fatol": 1e-6, "maxiter": 300}
    finest = minimize(misfit, logs, method="Nelder-Mead", options=options)
    return _solve_linear(lag, values, errors, to_rates(finest.x), turn)[0]


def _solve_linear(
    lag: Array, values: Array, errors: Array, rates: tuple[float, ...], turn: float
) -> tuple[Spread, float]:
    """Fit the linear parameters of up to two runs with these `rates` (1/s) of losing direction.

    Return all parameters, and the sum of squared residuals. With two runs there is no diffusion term, because the
    second run at a high rate is diffusion.
    """
    terms = [np.ones_like(lag), *(persistent_walk.run_squared_displacement(lag, rate, turn) for rate in rates)]
    if len(rates) < 2:
        terms.append(4.0 * lag)
    design = np.stack(terms, axis=1) / errors[:, None]
    scale = np.sqrt((design**2).sum(axis=0))
    scaled = values / errors
    solution = np.linalg.lstsq(design / scale, scaled)[0] / scale
    residuals = scaled - design @ solution
    offset, *others = map(float, solution)
    diffusion = 0.0 if len(rates) > 1 else others.pop()
    (speed2, rate), (smooth2, smooth_rate) = (*zip(others, rates, strict=True), *NO_RUNS)[:2]  # 0 for missing runs
    spread = Spread(speed2, rate, diffusion, offset, turn, smooth2, smooth_rate)
    return spread, float(residuals @ residuals)


def _misfit_probability(residuals: Array, replicates: Array) -> tuple[float, float]:
    """Return the misfit, over its expectation, and the probability of at least as large a misfit.

    `residuals`, shape (lags,), are in units of their errors; `replicates`, shape (samples, lags), lack one sample each.
    Residuals of neighbouring lags correlate: the expected sum of squares is from the jackknife's covariance, with
    degrees of freedom after Satterthwaite (1946).
    """
    deviations = replicates - replicates.mean(axis=0)
    others = len(replicates) - 1
    covariance = others / len(replicates) * deviations.T @ deviations
    expected = float(np.trace(covariance))
    if not expected > 0:
        return math.nan, math.nan
    ratio = float(residuals @ residuals) / expected
    freedom = expected**2 / float((covariance**2).sum())
    return ratio, fisher_tail(freedom, others, ratio)
