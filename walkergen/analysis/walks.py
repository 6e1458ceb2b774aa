"""Correlation and squared displacement of a persistent walk against lag, and their least squares.

A walker of constant speed v whose direction turns at mean rate omega and decorrelates at rate
gamma has velocity correlation <conj(v(t)) v(t + tau)> = v^2 exp((-gamma + i omega) tau) with
v = v_x + i v_y (active Brownian motion with a turning bias: van Teeffelen and Loewen 2008).
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]


def decay(lag: Array, amplitude: float, rate: float, turn: float, window: float = 0.0) -> Complex:
    """Correlation at lags (s): amplitude exp((-rate + i turn) lag); rate in 1/s, turn in rad/s.

    With a `window` (s) it is that of mean velocities over windows of this length whose starts lie
    `lag` >= window apart: exactly (sinh(z)/z)^2 as large, with z = (rate - i turn) window / 2.
    """
    exponent = complex(rate, -turn)
    z = 0.5 * exponent * window
    shape = 1.0 + z * z / 3.0 if abs(z) < 1e-4 else (np.sinh(z) / z) ** 2
    result: Complex = amplitude * shape * np.exp(-exponent * lag)
    return result


def squared(lag: Array, speed2: float, rate: float, offset: float, turn: float = 0.0) -> Array:
    """Mean squared displacement (mm^2) at lags (s) of a persistent walk on a plane, plus `offset`.

    It is speed2 lag^2 at short lags and 4 D lag at long ones, D = `diffusivity`; for turn = 0 it is
    Fuerth's formula (1920). The offset is twice the variance of the position's noise, summed over
    the dimensions.
    """
    exponent = complex(rate, -turn)
    z = exponent * lag
    small = np.abs(z) < 1e-3
    safe = np.where(small, 1.0, z)
    shape = np.where(small, 0.5 - z / 6.0 + z * z / 24.0, (safe - 1.0 + np.exp(-safe)) / safe**2)
    result: Array = 2.0 * speed2 * lag**2 * shape.real + offset
    return result


def diffusivity(speed2: float, rate: float, turn: float = 0.0) -> float:
    """Long-time diffusivity on the plane, mm^2/s: speed2 rate / (2 (rate^2 + turn^2))."""
    return speed2 * rate / (2.0 * (rate**2 + turn**2))


def fit(
    model: Callable[..., npt.NDArray[Any]],
    lag: Array,
    values: npt.NDArray[Any],
    errors: Array,
    start: Sequence[float],
) -> Array | None:
    """Fit model(lag, *parameters) by weighted least squares; None when no parameters fit.

    `values` and the model may be complex, with the same error for both parts.
    """
    from scipy.optimize import least_squares

    def residuals(parameters: Array) -> Array:
        difference = (model(lag, *parameters) - values) / errors
        if np.iscomplexobj(difference):
            return np.concatenate([difference.real, difference.imag])
        return np.asarray(difference, dtype=float)

    scale = np.where(np.asarray(start) == 0.0, 1.0 / lag[-1], np.abs(start))
    # Far trial points may overflow: they are rejected.
    with np.errstate(over="ignore", invalid="ignore"):
        found = least_squares(residuals, start, x_scale=scale, max_nfev=200)
    return np.asarray(found.x) if found.success else None
