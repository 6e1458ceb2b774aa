"""What both kinds of tables share: rows after asinh, their scatter, and errors at rows left out of a fit."""

import json
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.files.output import versions
from walkergen.theory import surrogate
from walkergen.theory.surrogate import LINEAR_BELOW, transformed

Array = npt.NDArray[Any]

TENTHS = 10
"""Parts of the rows, each of which is left out of a fit."""

ROUGH = 0.1
"""Error (after asinh) that every row has beside its own noise: the fit errs by as much, so that a
row of less noise counts for no more."""

PRIOR = 2.0
"""Precision about zero of the weights of smooth features."""

WIDEST = 6.0
"""Largest ratio of an input's range to its scale."""

PRIOR_RUNS = 3
"""Degrees of freedom by which the smooth scatter of runs counts beside a row's own."""

GOAL_SHARE, GOAL_SLOW = 0.04, 0.016
"""Error that half of the rows shall not exceed: of the two, share and speed over the peak speed, the larger."""

SLOW = 0.1
"""Speed over the peak speed of plate or swing below which errors in per cent say nothing."""


class Rows(NamedTuple):
    """Rows after asinh."""

    places: Array
    speed: Array
    """Speeds over the peak speed of plate or swing."""
    y: Array
    spread: Array
    """Standard deviation of a row's runs."""
    runs: Array


def rows_of(simulated: Array) -> Rows:
    """Rows of a table whose columns end with those of `make.MEASURED`."""
    *place, speed, se, runs = simulated.T
    y, se = transformed(speed, se)
    return Rows(np.stack(place, axis=1), speed, y, se * np.sqrt(runs), runs)


def facts(ranges: Mapping[str, Any], errors: Mapping[str, Any]) -> dict[str, Array]:
    """Array of what a table tells of itself, in JSON."""
    return {"facts": np.array(json.dumps({"ranges": ranges, "errors": errors, "versions": versions()}))}


def tenths(count: int) -> Array:
    """Number of the tenth that each of so many rows belongs to, shape (count,)."""
    return np.random.default_rng(TENTHS).permutation(count) % TENTHS


def scatter(features: Array, uneven: Array, rows: Rows) -> tuple[Array, Array, Array]:
    """Weights of the scatter of prints over `uneven`, as a smooth function of the features;
    variances of the rows' means; and what an error of each row counts, 1 on average.
    """
    in_time, between = _scatter(features, uneven, rows)
    variance = surrogate.smooth(features, in_time) ** 2
    variance += (uneven * surrogate.smooth(features, between)) ** 2
    freedom = rows.runs - 1.0
    noise = (freedom * rows.spread**2 + PRIOR_RUNS * variance) / (freedom + PRIOR_RUNS) / rows.runs
    weights = 1.0 / (noise + ROUGH**2)
    return between, noise, weights / weights.mean()


def _scatter(features: Array, uneven: Array, rows: Rows) -> tuple[Array, Array]:
    """Logarithms of the scatter of runs in time, and of that of prints over `uneven`.

    As weights of smooth features: the likeliest of variances of `rows.runs` normal numbers each.
    """
    half, observed = 0.5 * (rows.runs - 1.0), np.maximum(rows.spread**2, 1e-6)

    def loss(values: Array) -> tuple[float, Array]:
        in_time, between = values.reshape(2, -1)
        first = surrogate.smooth(features, in_time) ** 2
        second = (uneven * surrogate.smooth(features, between)) ** 2
        variance = first + second
        total = float(half @ (np.log(variance) + observed / variance))
        slope = 2.0 * half * (1.0 - observed / variance) / variance
        slopes = np.concatenate([features.T @ (slope * first), features.T @ (slope * second)])
        return total + PRIOR * float(values @ values), slopes + 2.0 * PRIOR * values

    start = np.zeros(2 * features.shape[1])
    start[0], start[features.shape[1]] = -3.0, -1.0
    in_time, between = _least(loss, start).reshape(2, -1)
    return in_time, between


def log_sd(features: Array, residual: Array, noise: Array) -> Array:
    """Logarithm of the standard deviation of residuals beyond their noise's variance, as weights
    of smooth features: the likeliest of normal residuals.
    """

    def loss(weights: Array) -> tuple[float, Array]:
        excess = surrogate.smooth(features, weights) ** 2
        variance = excess + noise
        total = 0.5 * float(np.sum(np.log(variance) + residual**2 / variance))
        slope = (1.0 - residual**2 / variance) / variance * excess
        return total + PRIOR * float(weights @ weights), features.T @ slope + 2.0 * PRIOR * weights

    return _least(loss, np.r_[-2.0, np.zeros(features.shape[1] - 1)])


def _least(loss: Any, start: Array) -> Array:
    from scipy.optimize import minimize

    bounds = [(-6.0, 6.0)] * len(start)
    first = float(np.linalg.norm(loss(start)[1]))  # so that the first step is a short one

    def scaled(values: Array) -> tuple[float, Array]:
        total, slopes = loss(values)
        return total / first, slopes / first

    solution = minimize(scaled, start, jac=True, method="L-BFGS-B", bounds=bounds)
    return np.asarray(solution.x)


def errors(rows: Rows, centre: Array, sd: Array, groups: Mapping[str, Array]) -> dict[str, dict[str, float]]:
    """Errors at rows left out, by groups of rows, their own noise within; speeds over the peak speed.

    `centre`: what was said of each row by a fit without it, after asinh; `sd`: its standard deviation,
    the row's noise within.
    """
    speed = LINEAR_BELOW * np.sinh(centre)
    off, size = np.abs(speed - rows.speed), np.abs(rows.speed)
    z = (centre - rows.y) / sd
    goal = np.maximum(GOAL_SHARE * size, GOAL_SLOW)
    by_group = {}
    for name, chosen in groups.items():
        if chosen.any():
            miss = np.mean((centre - rows.y)[chosen] ** 2)
            share = (100.0 * off / np.maximum(size, SLOW))[chosen & (size > SLOW)]
            by_group[name] = {
                "rows": int(chosen.sum()),
                "rms": float(np.sqrt(miss)),
                "explained": float(1.0 - miss / np.mean(rows.y[chosen] ** 2)),
                "median_of_peak": _quantile(off[chosen], 0.5),
                "ninety_percent_of_peak": _quantile(off[chosen], 0.9),
                "median_percent": _quantile(share, 0.5),
                "ninety_percent_percent": _quantile(share, 0.9),
                "median_over_goal": _quantile((off / goal)[chosen], 0.5),
                "z_rms": float(np.sqrt(np.mean(z[chosen] ** 2))),
                "z_within_68": float(np.mean(np.abs(z[chosen]) < 1.0)),
                "z_within_95": float(np.mean(np.abs(z[chosen]) < 1.96)),
            }
    return by_group


def _quantile(values: Array, share: float) -> float:
    return float(np.quantile(values, share)) if len(values) else 0.0
