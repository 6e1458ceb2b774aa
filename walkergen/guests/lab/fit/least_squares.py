"""Least squares for the contact: restitution, friction and impact speed from measured speeds.

The theory's speed is impact_speed_factor x plate speed x factor(tilt; restitution, friction)
(docs/physics.md section 4; paper eq. 15). The impact speed factor is linear, so it is solved for exactly
at every trial of restitution and friction (variable projection, Golub and Pereyra 1973).
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.numerics import Array
from walkergen.core.theory.speed import Mode, factor
from walkergen.core.theory.tensors import InverseMass, foot_tensors
from walkergen.core.walker.mass import MassProperties

RANGES = {"restitution": (0.0, 1.0), "friction": (1e-3, 5.0), "impact_speed_factor": (1e-3, 100.0)}
"""Names of the parameters that can be fitted, and the search range of each."""

SEARCH_GRID = {"restitution": np.linspace(0.0, 1.0, 33), "friction": np.geomspace(1e-3, 5.0, 145)}
"""Grid that the search starts from: speeds have kinks and several minima in friction."""

MIN_EIGENVALUE = 0.05
"""Smallest eigenvalue of the normalised information at which parameters can still be separated. For two parameters it
is 1 - |correlation|."""

MIN_SPEED_RATIO = 0.05
"""Speed over plate speed below which walkers are not fitted; rigid legs reach some 1e-3."""

SINGULAR_SHARE = 1e-6
"""Share of the information below which it counts as 0, because derivatives of speeds are exact to 1e-9."""

MAX_INTERVAL_RATIO = 3.0
"""Ratio of an interval's ends above which a parameter counts as not determined."""


class Speeds(NamedTuple):
    """Measured speeds of n walkers, and the theory's inputs for them."""

    speed: Array
    """Measured speeds, mm/s, shape (n,)."""
    se: Array | None
    """Standard errors, mm/s, shape (n,). None if unknown: the scatter about the fit then replaces them."""
    plate_speed: Array
    """Peak speed of the plate under each walker, mm/s, shape (n,)."""
    back: InverseMass
    """Inverse-mass tensors at the back feet, 1/g, entries of shape (n,)."""
    front: InverseMass
    mode: Mode


class ContactFit(NamedTuple):
    """Parameters of the contact that describe measured speeds best, with their errors."""

    values: dict[str, float]
    """Values of all parameters in RANGES, fixed or fitted."""
    errors: dict[str, float | None]
    """Standard errors of the fitted parameters, from the covariance; None for parameters that it leaves open."""
    intervals: dict[str, tuple[float | None, float | None]]
    """Intervals (68 %) of fitted parameters by profile likelihood; an end is None if it is outside RANGES."""
    covariance: Array
    """Covariance of the fitted parameters, in the order of `errors`; 0 for parameters without any effect."""
    correlation: Array
    chi2: float | None
    """Sum of squared residuals in standard errors; None when the speeds have no standard errors."""
    dof: int
    p_value: float | None
    predicted: Array
    """Fitted speeds, mm/s, shape (n,)."""
    notes: list[str]
    """Notes on parameters that the speeds do not determine, and on misfits of the theory."""

    @property
    def free(self) -> list[str]:
        """Names of the fitted parameters."""
        return list(self.errors)


def inverse_mass_tensors(masses: Sequence[MassProperties]) -> tuple[InverseMass, InverseMass]:
    """Return the inverse-mass tensors at the back and front feet of n walkers, entries of shape (n,)."""
    both = [foot_tensors(mass) for mass in masses]
    return tuple(InverseMass(*np.array([pair[foot] for pair in both]).T) for foot in (0, 1))  # type: ignore[return-value]


def speeds_at_unit_factor(speeds: Speeds, restitution: Array | float, friction: Array | float) -> Array:
    """Predict the speeds (mm/s) of n walkers with an impact_speed_factor of 1. Shape: the parameters' shape, then n."""
    e, mu = np.asarray(restitution)[..., None], np.asarray(friction)[..., None]
    mean = 0.5 * (factor(speeds.back, e, mu, speeds.mode) + factor(speeds.front, e, mu, speeds.mode))
    return speeds.plate_speed * mean


def fit_contact(speeds: Speeds, fixed: Mapping[str, float], profiles: bool = True) -> ContactFit:
    """Fit the contact parameters that are not in `fixed` to speeds, by weighted least squares.

    `profiles`: whether to compute intervals by profile likelihood, in about a second. Raises InputError if all are
    fixed, for fewer speeds than free parameters plus one, or if the theory gives all walkers nearly speed 0.
    """
    free = [name for name in RANGES if name not in fixed]
    dof = len(speeds.speed) - len(free)
    if not free:
        raise InputError("‹fix›: no parameter is left to fit. Leave one of them free")
    if dof < 1:
        raise InputError(
            f"{len(speeds.speed)} speeds for {len(free)} parameters ({', '.join(free)}). Measure "
            f"at least {len(free) + 1}, or fix some: ‹fix› restitution=0.8. Or leave ‹model› out: the other "
            "models accept any number of speeds"
        )
    if np.abs(speeds_at_unit_factor(speeds, 0.5, 0.1)).max() < MIN_SPEED_RATIO * speeds.plate_speed.max():
        raise InputError(
            "the theory predicts nearly speed 0 for all these walkers, as for all rigid legs. They do not constrain "
            "the contact. Add walkers with flexible, tilted legs"
        )
    values, min_chi2 = _find_best(speeds, fixed)
    variance = 1.0 if speeds.se is not None else min_chi2 / dof
    slopes = jacobian(speeds, values, free) / _speed_errors(speeds)[:, None]
    uncertainty = _find_covariance(slopes / math.sqrt(max(variance, 1e-300)), values, free)
    errors = uncertainty.errors
    intervals = {
        name: _profile_interval(speeds, fixed, values, name, errors[name], min_chi2, variance)
        for name in (free if profiles else ())
    }
    chi2 = p_value = None
    if speeds.se is not None:
        from scipy.stats import chi2 as chi2_law

        chi2, p_value = min_chi2, float(chi2_law.sf(min_chi2, dof))
    notes = _notes(uncertainty, values, intervals)
    if chi2 is not None and p_value is not None and p_value <= 1e-3:
        notes.append(
            f"chi2 {chi2:.3g} for {dof} degrees of freedom (probability {p_value:.1g}): the theory "
            "does not describe these speeds within their errors, but the errors here assume it"
        )
    predicted = values["impact_speed_factor"] * speeds_at_unit_factor(speeds, values["restitution"], values["friction"])
    return ContactFit(
        values, errors, intervals, uncertainty.covariance, uncertainty.correlation, chi2, dof, p_value, predicted, notes
    )


def _speed_errors(speeds: Speeds) -> Array:
    """Return the standard errors of the speeds, or 1 for all if they are unknown."""
    return np.ones_like(speeds.speed) if speeds.se is None else speeds.se


def _find_best(speeds: Speeds, fixed: Mapping[str, float]) -> tuple[dict[str, float], float]:
    """Find the best values of all parameters, given those in `fixed`, and their chi2: on a grid, then by descent."""
    from scipy.optimize import least_squares

    names = [name for name in SEARCH_GRID if name not in fixed]
    axes = [SEARCH_GRID[name] if name in names else np.array([fixed[name]]) for name in SEARCH_GRID]
    e, mu = np.meshgrid(*axes, indexing="ij")
    errors, fixed_factor = _speed_errors(speeds), fixed.get("impact_speed_factor")

    def residuals(per_factor: Array) -> Array:
        """Return residuals over standard errors, once the speeds at factor 1 have their best impact_speed_factor."""
        scaled = (_best_factor(per_factor, speeds, fixed_factor)[..., None] * per_factor - speeds.speed) / errors
        return np.asarray(scaled, dtype=float)

    chi2 = np.sum(residuals(speeds_at_unit_factor(speeds, e, mu)) ** 2, axis=-1)
    lowest = np.unravel_index(np.argmin(chi2), chi2.shape)
    point = {"restitution": float(e[lowest]), "friction": float(mu[lowest])}
    min_chi2 = float(chi2[lowest])
    if names:
        low, high = np.array([RANGES[name] for name in names]).T

        def trial_residuals(trial: Array) -> Array:
            values = point | dict(zip(names, trial, strict=True))
            return residuals(speeds_at_unit_factor(speeds, values["restitution"], values["friction"]))

        start = np.clip([point[name] for name in names], low, high)
        solution = least_squares(trial_residuals, start, bounds=(low, high), x_scale=np.maximum(start, 0.01))
        if 2.0 * solution.cost < min_chi2:
            min_chi2 = 2.0 * float(solution.cost)
            point |= {name: float(value) for name, value in zip(names, solution.x, strict=True)}
    per_factor = speeds_at_unit_factor(speeds, point["restitution"], point["friction"])
    return point | {"impact_speed_factor": float(_best_factor(per_factor, speeds, fixed_factor))}, min_chi2


def _best_factor(per_factor: Array, speeds: Speeds, fixed_factor: float | None) -> Array:
    """Return the best (or fixed) impact_speed_factor, shape (...). `per_factor`: speeds at factor 1, shape (..., n)."""
    if fixed_factor is not None:
        return np.full(per_factor.shape[:-1], fixed_factor)
    weights = _speed_errors(speeds) ** -2.0
    norm = np.sum(weights * per_factor**2, axis=-1)
    best = np.sum(weights * per_factor * speeds.speed, axis=-1) / np.where(norm > 0, norm, 1.0)
    result: Array = np.clip(best, *RANGES["impact_speed_factor"])
    return result


def jacobian(speeds: Speeds, values: Mapping[str, float], free: Sequence[str]) -> Array:
    """Compute the derivatives of the n speeds with respect to the free parameters at `values`, shape (n, free)."""
    columns = []
    for name in free:
        step = 1e-5 * max(values[name], 0.01)
        low, high = RANGES[name]
        ends = [min(max(values[name] + side * step, low), high) for side in (-1, 1)]
        below, above = (
            now["impact_speed_factor"] * speeds_at_unit_factor(speeds, now["restitution"], now["friction"])
            for now in (dict(values) | {name: end} for end in ends)
        )
        columns.append((above - below) / (ends[1] - ends[0]))
    return np.stack(columns, axis=1)


def _profile_interval(
    speeds: Speeds,
    fixed: Mapping[str, float],
    values: Mapping[str, float],
    name: str,
    error: float | None,
    min_chi2: float,
    increase: float,
) -> tuple[float | None, float | None]:
    """Return the interval of the parameter `name` outside which the best chi2 exceeds `min_chi2` by `increase`.

    `values` and `error`: best fit, and standard error of the parameter. An end outside its range is None.
    """
    from scipy.optimize import brentq

    def excess(value: float) -> float:
        """Return how far the best chi2 with the parameter at `value` lies above the limit; negative: below it."""
        if value == values[name]:  # the search from a grid need not give `min_chi2` to every digit
            return -increase
        return _find_best(speeds, {**fixed, name: value})[1] - min_chi2 - increase

    ends: list[float | None] = []
    for side, limit in zip((-1, 1), RANGES[name], strict=True):
        if excess(limit) <= 0:
            ends.append(None)
            continue
        inner, step = values[name], error or 0.1 * abs(values[name]) or 0.01
        outer = inner
        while outer != limit and (outer == inner or excess(outer) <= 0):
            inner, outer = outer, (max if side < 0 else min)(outer + side * step, limit)
            step *= 2.0
        ends.append(float(brentq(excess, inner, outer, xtol=1e-4 * step, rtol=1e-4)))
    return ends[0], ends[1]


class _Uncertainty(NamedTuple):
    """Covariance of the parameters near the best fit, and names of those left undetermined."""

    errors: dict[str, float | None]
    covariance: Array
    correlation: Array
    unseen: list[str]
    """Parameters that no speed depends on."""
    together: list[str]
    """Parameters in the combination with the largest uncertainty."""
    level: float
    """Eigenvalue of the normalised information for that combination."""


def _find_covariance(slopes: Array, values: Mapping[str, float], free: Sequence[str]) -> _Uncertainty:
    """Compute the covariance of the free parameters. `slopes`: derivatives of speeds over errors, shape (n, free)."""
    information = slopes.T @ slopes
    norm = np.sqrt(np.diag(information))
    weight = norm * np.maximum([abs(values[name]) for name in free], 0.01)
    unseen = weight <= SINGULAR_SHARE * weight.max()
    norm = np.where(unseen, 1.0, norm)
    normalised = np.where(unseen[:, None] | unseen, 0.0, information / np.outer(norm, norm))
    levels, vectors = np.linalg.eigh(normalised)
    resolved = levels > SINGULAR_SHARE
    inverse = (vectors[:, resolved] / levels[resolved]) @ vectors[:, resolved].T
    covariance = inverse / np.outer(norm, norm)
    widths = np.sqrt(np.diag(covariance))
    undetermined = unseen | (np.abs(vectors[:, ~resolved]) > 0.1).any(axis=1)
    width = np.where(widths > 0, widths, 1.0)
    weakest = min(np.flatnonzero(np.abs(vectors[unseen]).sum(axis=0) < 0.5), key=levels.__getitem__)
    return _Uncertainty(
        {name: None if gone else float(error) for name, gone, error in zip(free, undetermined, widths, strict=True)},
        covariance,
        covariance / np.outer(width, width),
        [name for name, gone in zip(free, unseen, strict=True) if gone],
        [name for name, part in zip(free, vectors[:, weakest], strict=True) if abs(part) > 0.2],
        float(levels[weakest]),
    )


def _notes(
    fitted: _Uncertainty, values: Mapping[str, float], intervals: Mapping[str, tuple[float | None, float | None]]
) -> list[str]:
    """Return notes on parameters that the speeds do not determine, alone or together, or at an end of their range."""
    errors, together = fitted.errors, fitted.together

    def is_poorly_determined(name: str) -> bool:
        error = errors[name]
        if error is None:
            return True
        low, high = intervals.get(name) or (values[name] - error, values[name] + error)
        return low is None or high is None or high > MAX_INTERVAL_RATIO * low

    notes = [f"{name}: none of these speeds depends on it. Measure other tilts, or fix it" for name in fitted.unseen]
    if fitted.level <= MIN_EIGENVALUE and len(together) >= 2:
        names = ", ".join(together[:-1]) + f" and {together[-1]}"
        evidence = f"(smallest eigenvalue of the information {max(fitted.level, 0.0):.2g})"
        notes.append(
            f"{names} cannot be separated {evidence}: fix one, ‹fix› {together[0]}=..."
            if any(map(is_poorly_determined, together))
            else f"{names} are strongly correlated {evidence}: quote them together"
        )
    notes += [
        f"{name} is hardly determined: its interval spans more than a factor of {MAX_INTERVAL_RATIO:g}"
        for name, error in errors.items()
        if error is not None and is_poorly_determined(name)
    ]
    return notes + [
        f"{name} lies at the limit {limit:g} of its range: its standard error has no meaning there"
        for name in errors
        for limit in RANGES[name]
        if math.isclose(values[name], limit, rel_tol=1e-6, abs_tol=1e-6)
    ]
