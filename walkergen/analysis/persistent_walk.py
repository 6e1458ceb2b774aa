"""Correlation and squared displacement of a persistent walk against lag, and their least squares.

A walker of constant speed v whose direction turns at mean rate omega and decorrelates at rate
gamma has velocity correlation <conj(v(t)) v(t + tau)> = v^2 exp((-gamma + i omega) tau) with
v = v_x + i v_y (active Brownian motion with a turning bias: van Teeffelen and Loewen 2008).
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.core.numerics import Array, Complex


def velocity_correlation(lag: Array, amplitude: float, rate: float, turn: float, window: float = 0.0) -> Complex:
    """Return the complex autocorrelation at lags (s): amplitude exp((-rate + i turn) lag); rate in 1/s, turn in rad/s.

    With a `window` (s) it is the autocorrelation of mean velocities over windows of this length whose starts lie
    `lag` >= window apart: exactly (sinh(z)/z)^2 as large, with z = (rate - i turn) window / 2.
    """
    exponent = complex(rate, -turn)
    z = 0.5 * exponent * window
    shape = 1.0 + z * z / 3.0 if abs(z) < 1e-4 else (np.sinh(z) / z) ** 2
    result: Complex = amplitude * shape * np.exp(-exponent * lag)
    return result


def delayed_lag(lag: Array, memory: float) -> Array:
    """Return lags (s), shortened because rates of turning last for the correlation time `memory` > 0 (s).

    With an exponential correlation of this time, as of a body with moment of inertia in a viscous medium, direction is
    lost as exp(-rate * delayed lag) (Uhlenbeck and Ornstein 1930).
    """
    result: Array = lag + memory * np.expm1(-lag / memory)
    return result


class Spread(NamedTuple):
    """Parameters of the mean squared displacement on a plane; NaN if not fitted."""

    speed2: float
    """Mean square of the speed that persists, mm^2/s^2."""
    rate: float
    """Rate at which this speed's direction is lost, 1/s."""
    diffusion: float
    """Translational diffusion in addition to the run, mm^2/s."""
    offset: float
    """Twice the variance of the position's noise, summed over the dimensions, mm^2."""
    turn: float = 0.0
    """Mean rate of turning, rad/s."""
    smooth2: float = 0.0
    """Decrease (below 0) of the correlation of speeds at short lags, mm^2/s^2. Inertia makes runs start
    smoothly, so that `smooth2` is 0 without a run."""
    smooth_rate: float = 0.0
    """Rate at which `smooth2` is lost, 1/s; 0 without inertia."""

    @property
    def mean_square(self) -> float:
        """Mean square of the speed, mm^2/s^2. Inertia lowers it below `speed2`."""
        return self.speed2 + self.smooth2

    @property
    def diffusivity(self) -> float:
        """Long-time diffusivity, mm^2/s: diffusion + speed2 rate / (2 (rate^2 + turn^2))."""
        runs = ((self.speed2, self.rate), (self.smooth2, self.smooth_rate))
        return self.diffusion + sum(0.5 * speed2 * rate / (rate**2 + self.turn**2) for speed2, rate in runs if rate)


def squared_displacement(lag: Array, spread: Spread) -> Array:
    """Compute the mean squared displacement (mm^2) at lags (s): the run, diffusion and noise.

    Without diffusion and noise it is speed2 lag^2 at short lags and 4 D lag at long ones, D =
    `spread.diffusivity`; for turn = 0 it is Fuerth's formula (1920).
    """
    result: Array = spread.speed2 * run_squared_displacement(lag, spread.rate, spread.turn)
    result += spread.smooth2 * run_squared_displacement(lag, spread.smooth_rate, spread.turn)
    return result + 4.0 * spread.diffusion * lag + spread.offset


def run_squared_displacement(lag: Array, rate: float, turn: float) -> Array:
    """Return the mean squared displacement (s^2) at lags (s) of a run of speed 1; `rate` 1/s, `turn` rad/s."""
    z = complex(rate, -turn) * lag
    small = np.abs(z) < 1e-3
    safe = np.where(small, 1.0, z)
    shape = np.where(small, 0.5 - z / 6.0 + z * z / 24.0, (safe - 1.0 + np.exp(-safe)) / safe**2)
    result: Array = 2.0 * lag**2 * shape.real
    return result


def fit(
    model: Callable[..., npt.NDArray[Any]],
    lag: Array,
    values: npt.NDArray[Any],
    errors: Array,
    start: Sequence[float],
    lowest: Sequence[float] | float = -math.inf,
) -> Array | None:
    """Fit model(lag, *parameters) to values with errors by weighted least squares; None when no parameters fit.

    `values` and the model may be complex, with the same error for both parts. No parameter falls below `lowest`.
    """
    from scipy.optimize import least_squares

    def residuals(parameters: Array) -> Array:
        """Return the residuals over their errors; real parts, then imaginary parts if complex."""
        difference = (model(lag, *parameters) - values) / errors
        if np.iscomplexobj(difference):
            return np.concatenate([difference.real, difference.imag])
        return np.asarray(difference, dtype=float)

    scale = np.where(np.asarray(start) == 0.0, 1.0 / lag[-1], np.abs(start))
    limits = lowest, math.inf
    # Far trial points may overflow: they are rejected.
    with np.errstate(over="ignore", invalid="ignore"):
        solution = least_squares(residuals, start, x_scale=scale, bounds=limits, max_nfev=200)
    return np.asarray(solution.x) if solution.success else None
