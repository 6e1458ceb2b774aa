"""Scatter of the rows' runs, as smooth functions of their numbers: in time, and from print to print."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.core.theory import networks

Array = npt.NDArray[Any]

PRIOR = 2.0
"""Precision about zero of the weights of smooth features."""


class Scatter(NamedTuple):
    """Logarithms of a run's scatter as weights of smooth features."""

    in_time: Array
    between_prints: Array
    """Over the unevenness."""

    def run_sd(self, terms: Array, uneven: Array) -> Array:
        """Compute the standard deviation of a run, shape (n,), which weights the rows.

        Their own scatter would pull speeds down, because the prints of slow rows agree by chance.
        """
        between = uneven * networks.evaluate_smooth(terms, self.between_prints)
        return np.hypot(networks.evaluate_smooth(terms, self.in_time), between)


def fit_scatter(terms: Array, uneven: Array, se: Array, runs: Array) -> Scatter:
    """Scatter of runs from standard errors of the means of so many."""
    return Scatter(*_most_likely_weights(terms, uneven, np.maximum(se**2 * runs, 1e-6), 0.5 * (runs - 1.0)))


def _most_likely_weights(terms: Array, uneven: Array, observed: Array, half: Array) -> tuple[Array, Array]:
    """Weights of both scatters: the likeliest of variances with so many halves of degrees of freedom."""
    from scipy.optimize import minimize

    def loss(values: Array) -> tuple[float, Array]:
        in_time, between = values.reshape(2, -1)
        first = networks.evaluate_smooth(terms, in_time) ** 2
        second = (uneven * networks.evaluate_smooth(terms, between)) ** 2
        variance = first + second
        total = float(half @ (np.log(variance) + observed / variance))
        slope = 2.0 * half * (1.0 - observed / variance) / variance
        slopes = np.concatenate([terms.T @ (slope * first), terms.T @ (slope * second)])
        return total + PRIOR * float(values @ values), slopes + 2.0 * PRIOR * values

    start = np.zeros(2 * terms.shape[1])
    start[0], start[terms.shape[1]] = -3.0, -1.0
    first = float(np.linalg.norm(loss(start)[1]))  # so that the first step is a short one

    def scaled_loss(values: Array) -> tuple[float, Array]:
        total, slopes = loss(values)
        return total / first, slopes / first

    solution = minimize(scaled_loss, start, jac=True, method="L-BFGS-B", bounds=[(-6.0, 6.0)] * len(start))
    in_time, between = solution.x.reshape(2, -1)
    return np.asarray(in_time), np.asarray(between)
