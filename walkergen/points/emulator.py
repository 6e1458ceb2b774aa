"""Emulator: a Gaussian process through noisy values of a slow function, with its own error."""

import math
import warnings
from typing import Any, NamedTuple

import numpy as np

from walkergen.core.numerics import Array

MIN_VALUES = 8
"""Number of values below which no emulator is fitted."""


class Emulator(NamedTuple):
    """Gaussian process over inputs of shape (n, d), scaled to (x - centre) / scale, with both of shape (d,).

    A Matern kernel (twice differentiable paths) with a length for each input, by scikit-learn.
    """

    process: Any
    centre: Array
    scale: Array
    noise: Array
    """Standard errors of the values, given or found, shape (n,)."""
    left_out: Array
    """Residuals of every value against the process without it, shape (n,)."""
    left_out_sd: Array
    """Standard deviations that the process gives these residuals, noise included, shape (n,)."""

    factor: Array
    """Inverse of the Cholesky factor of the values' covariance, shape (n, n)."""

    def __call__(self, x: Array) -> tuple[Array, Array]:
        """Return mean and standard deviation of the function at `x` (k, d), each of shape (k,), without noise.

        The same numbers as `process.predict`, whose checks take five times the time of its work.
        """
        from scipy.spatial.distance import cdist

        process = self.process
        variance, lengths = process.kernel_.k1.constant_value, process.kernel_.k2.length_scale
        scaled = (x - self.centre) / self.scale
        distance = math.sqrt(5.0) * cdist(scaled / lengths, process.X_train_ / lengths)
        covariance = variance * (1.0 + distance + distance**2 / 3.0) * np.exp(-distance)
        mean = process._y_train_mean + process._y_train_std * (covariance @ process.alpha_)
        explained = np.sum((covariance @ self.factor.T) ** 2, axis=1)
        sd = process._y_train_std * np.sqrt(np.maximum(variance - explained, 0.0))
        return np.ravel(mean), sd


def single_thread() -> Any:
    """Return a context manager in which linear algebra uses one thread: more would slow down such small matrices."""
    from threadpoolctl import threadpool_limits

    return threadpool_limits(1)


def fit(x: Array, y: Array, noise: Array | None = None, seed: int = 1, like: Emulator | None = None) -> Emulator:
    """Return an emulator, fitted to values `y` (n,) of a function at inputs `x` (n, d) by maximum likelihood.

    `noise`: standard errors of the values (n,); None to fit one for all. `like`: emulator whose kernel and scales are
    used unchanged. Raises ValueError for fewer than MIN_VALUES values.
    """
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

    if len(y) < MIN_VALUES:
        raise ValueError(f"{len(y)} values; an emulator needs {MIN_VALUES}")
    centre, scale = x.mean(axis=0), x.std(axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    spread = float(y.std()) or 1.0
    kernel = ConstantKernel(1.0, (1e-2, 1e3)) * Matern(np.full(x.shape[1], 3.0), (0.2, 100.0), nu=2.5)
    alpha: Any = 1e-8
    if noise is None:
        kernel = kernel + WhiteKernel(0.1, (1e-6, 1.0))
    else:
        alpha = np.maximum(noise / spread, 1e-4) ** 2
    if like is not None:
        kernel, centre, scale = like.process.kernel_, like.centre, like.scale
    process = GaussianProcessRegressor(
        kernel,
        alpha=alpha,
        normalize_y=True,
        n_restarts_optimizer=0 if like else 1,
        optimizer=None if like else "fmin_l_bfgs_b",
        random_state=seed,
    )
    with warnings.catch_warnings(), single_thread():
        # A length at its bound means that an input does not matter: that is a valid result.
        warnings.simplefilter("ignore", ConvergenceWarning)
        process.fit((x - centre) / scale, y)
    factor = np.linalg.inv(process.L_)
    inverse = factor.T @ factor
    residual = process.alpha_ / np.diag(inverse) * spread
    sd = spread / np.sqrt(np.diag(inverse))
    if noise is None:  # the white part is noise, which predictions of the function leave out
        noise = np.full(len(y), spread * np.sqrt(process.kernel_.k2.noise_level))
        process.kernel_ = process.kernel_.k1
    return Emulator(process, centre, scale, noise, np.ravel(residual), sd, factor)
