"""Likelihood of measured speeds, and draws of the posterior.

The emulators' own errors and the scatter between prints are part of the likelihood.
"""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from walkergen.core.numerics import Array
from walkergen.points.emulator import single_thread


class SpeedModel(Protocol):
    """Function that predicts the speed of a walker in one setting from the parameters."""

    def __call__(self, x: Array, /) -> tuple[Array, Array, Array]:
        """Return the mean speed, its error common to all prints, and the scatter between prints, each (k,), mm/s.

        `x`: values of the parameters, shape (k, parameters).
        """


KEPT_DRAWS = 4096
"""Number of draws of a posterior."""


class Observed(NamedTuple):
    """Measured speeds of n prints of one walker on one plate."""

    speed: Array
    """Speeds, mm/s, shape (n,)."""
    se: Array
    """Standard errors, mm/s, shape (n,)."""
    name: str = ""
    """Setting in words, such as "10 deg"."""


class Posterior(NamedTuple):
    """Draws of the parameters from their posterior, and the equivalent number of independent draws."""

    draws: Array
    """Parameters, shape (KEPT_DRAWS, parameters)."""
    steps: int
    """Number of weighted draws from which `draws` are chosen."""
    independent: float
    """Equivalent number of independent draws."""
    chi2: float
    """Sum of squared residuals at the best draw, over the variances of the model."""


def log_likelihood(x: Array, observed: Sequence[Observed], responses: Sequence[SpeedModel]) -> tuple[Array, Array]:
    """Return the log-likelihood of each row of parameters `x`, shape (k, parameters), and chi2, each of shape (k,).

    `observed`, `responses`: measured speeds and speed model of each setting. Prints scatter independently. The error
    of a speed model is common to all prints of its setting.
    """
    total, squares = np.zeros(len(x)), np.zeros(len(x))
    for seen, response in zip(observed, responses, strict=True):
        mean, sd, scatter = response(x)
        variance = seen.se**2 + scatter[:, None] ** 2
        residual = seen.speed - mean[:, None]
        precision = np.sum(1.0 / variance, axis=1)
        pull = np.sum(residual / variance, axis=1)
        # Sherman and Morrison: prints of variances `variance`, all moved by an error of sd `sd`.
        shared = sd**2 / (1.0 + precision * sd**2)
        chi2 = np.sum(residual**2 / variance, axis=1) - shared * pull**2
        squares += chi2
        total -= 0.5 * (chi2 + np.sum(np.log(variance), axis=1) + np.log1p(precision * sd**2))
    return total, squares


def row_deviations(x: Array, observed: Sequence[Observed], responses: Sequence[SpeedModel]) -> Array:
    """Return how many standard deviations each measured speed lies from the model, shape (k, speeds), for rows of `x`.

    `observed`, `responses`: measured speeds and speed model of each setting.
    """
    columns = []
    for seen, response in zip(observed, responses, strict=True):
        mean, sd, scatter = (values[:, None] for values in response(x))
        columns.append(np.abs(seen.speed - mean) / np.sqrt(seen.se**2 + scatter**2 + sd**2))
    return np.concatenate(columns, axis=1)


def speed_draws(x: Array, response: SpeedModel, rng: np.random.Generator) -> Array:
    """Draw the speed (mm/s) of a new print for each row of parameters `x`, shape (k, parameters). Shape (k,)."""
    with single_thread():
        mean, sd, scatter = response(x)
    return np.asarray(mean + np.hypot(sd, scatter) * rng.normal(size=len(x)))
