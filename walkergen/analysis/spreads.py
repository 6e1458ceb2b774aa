"""Mean squared displacement fitted: a run that turns, diffusion besides, noise of the positions.

Whether data tell these terms apart is asked of the data: a run shows as curvature, the fit's misfit
is held against what the scatter of independent samples makes of it.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.analysis import walks
from walkergen.analysis.walks import Spread
from walkergen.numerics import statistics

Array = npt.NDArray[np.float64]

RATES = 33
"""Number of rates at which the fit's rate is sought first, from far below 1 / longest lag."""

CURVED = 1e-3
"""Probability, for walkers that only diffuse, of a curvature that counts as a run (Student's t)."""

NONE = Spread(*[math.nan] * 5)


class Fitted(NamedTuple):
    """Fit of the mean squared displacement, and of each replicate without one sample."""

    spread: Spread
    replicates: tuple[Spread, ...]
    run: bool
    """Whether a run shows: without it speed2 and rate are 0, and diffusion is all there is."""
    misfit: float
    """Sum of squared residuals over its expectation: about 1 where the law holds."""
    p_value: float
    """Probability of a misfit at least as large where the law holds; NaN where nothing fits."""


def fit(lag: Array, squares: Sequence[Array], errors: Array, turns: Sequence[float]) -> Fitted:
    """Fit squared displacements (mm^2) at lags (s): first of all samples, then without each one.

    `errors` are NaN at lags that are not fitted, `turns` (rad/s) the rates of turning of each.
    """
    use = (errors > 0) & np.isfinite(squares).all(axis=0)
    if use.sum() < 6 or not np.isfinite(turns).all():
        return Fitted(NONE, (NONE,) * (len(squares) - 1), False, math.nan, math.nan)
    lag, errors, values = lag[use], errors[use], np.stack(squares)[:, use]
    run = _curves(lag, values, errors, turns)
    rates = np.geomspace(1e-3 / lag[-1], 2.0 / lag[0], RATES) if run else None
    fits = [
        _best(lag, one, errors, turn, rates) for one, turn in zip(values, turns, strict=True)
    ]
    rest = [
        (one - walks.squared(lag, spread)) / errors for one, spread in zip(values, fits, strict=True)
    ]
    return Fitted(fits[0], tuple(fits[1:]), run, *_goodness(rest[0], np.stack(rest[1:])))


def _curves(lag: Array, values: Array, errors: Array, turns: Sequence[float]) -> bool:
    """Whether a run shows beside diffusion and noise, at any rate that the lags can show."""
    rates = np.geomspace(0.5 / lag[-1], 0.5 / lag[0], 7)
    runs = np.array([
        [_linear(lag, one, errors, rate, turn)[0].speed2 for rate in rates]
        for one, turn in zip(values, turns, strict=True)
    ])  # fmt: skip
    from scipy.special import stdtrit

    error = statistics.jackknife_error(runs[1:])
    return bool((runs[0] > stdtrit(len(values) - 2, 1.0 - CURVED) * error).any())


def _best(lag: Array, values: Array, errors: Array, turn: float, rates: Array | None) -> Spread:
    """Least squares, exact for all but the rate, which is sought over rising `rates` and between.

    Variable projection (Golub and Pereyra 1973); without `rates` there is no run.
    """
    from scipy.optimize import minimize_scalar

    if rates is None:
        return _linear(lag, values, errors, None, turn)[0]

    def misfit(log_rate: float) -> float:
        return _linear(lag, values, errors, math.exp(log_rate), turn)[1]

    logs = np.log(rates)
    best = int(np.argmin([misfit(one) for one in logs]))
    ends = logs[max(best - 1, 0)], logs[min(best + 1, len(logs) - 1)]
    finest = minimize_scalar(misfit, bounds=ends, method="bounded", options={"xatol": 1e-7})
    return _linear(lag, values, errors, math.exp(finest.x), turn)[0]


def _linear(
    lag: Array, values: Array, errors: Array, rate: float | None, turn: float
) -> tuple[Spread, float]:
    """Best parameters at a rate (None: no run), and the sum of squared residuals."""
    terms = [4.0 * lag, np.ones_like(lag)]
    if rate is not None:
        terms.append(walks.run_squared(lag, rate, turn))
    design = np.stack(terms, axis=1) / errors[:, None]
    scale = np.sqrt((design**2).sum(axis=0))
    wanted = values / errors
    solution = np.linalg.lstsq(design / scale, wanted)[0] / scale
    rest = wanted - design @ solution
    speed2 = 0.0 if rate is None else float(solution[2])
    diffusion, offset = map(float, solution[:2])
    return Spread(speed2, rate or 0.0, diffusion, offset, turn), float(rest @ rest)


def _goodness(rest: Array, replicates: Array) -> tuple[float, float]:
    """Misfit and its probability from residuals of all samples and of those without each one.

    Residuals of neighbouring lags go together: their sum of squares is held against its expectation
    by the jackknife's covariance, with degrees of freedom after Satterthwaite (1946).
    """
    apart = replicates - replicates.mean(axis=0)
    others = len(replicates) - 1
    covariance = others / len(replicates) * apart.T @ apart
    expected = float(np.trace(covariance))
    if not expected > 0:
        return math.nan, math.nan
    from scipy.special import fdtrc

    ratio, free = float(rest @ rest) / expected, expected**2 / float((covariance**2).sum())
    return ratio, float(fdtrc(free, others, ratio))
