"""Posterior of the parameters from weighted draws.

Importance sampling in z, where every prior is the standard normal: first from the prior, then from normal distributions
somewhat wider than the weighted draws so far (population Monte Carlo, Cappé et al., J. Comput. Graph. Stat. 13, 907,
2004). A tenth always comes from the prior, so that no region is left out for ever.
"""

from collections.abc import Sequence

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.files.formatting import format_number
from walkergen.core.files.progress import Progress
from walkergen.core.numerics import Array
from walkergen.guests.lab.fit.parameters import Parameter, prior_values
from walkergen.guests.lab.fit.posterior import (
    KEPT_DRAWS,
    Observed,
    Posterior,
    SpeedModel,
    log_likelihood,
    row_deviations,
)

DRAWS_PER_ROUND, MAX_ROUNDS = 2**13, 24
"""Number of draws of a round, which add to those of earlier rounds, and largest number of rounds."""

MIN_INDEPENDENT = 1000.0
"""Smallest equivalent number of independent draws: bounds of 95 % then err by 0.1 standard deviations."""

UNREACHED_DEVIATIONS, REACHED_DEVIATIONS = 8.0, 4.0
"""Standard deviations from every draw of the prior beyond which a speed is an outlier, if most others are nearer than
the second number. A speed on which sampling fails is one if chi2 falls by the square of the second number without it.
Of 15 000 good speeds one lies that far."""

PRIOR_SHARE, SPREAD_FACTOR = 0.1, 1.4
"""Share of the draws that come from the prior, and factor on the spread of the other draws."""


def sample(
    parameters: Sequence[Parameter],
    observed: Sequence[Observed],
    responses: Sequence[SpeedModel],
    seed: int,
    progress: Progress,
) -> Posterior:
    """Return draws from the posterior of the parameters, given the speeds observed in each setting.

    `responses`: functions that predict the speed in each setting. Raises InputError for an outlier, or
    if too few draws agree with speeds.
    """
    from scipy.special import ndtr

    rng = np.random.default_rng([seed, len(observed)])
    dimension = len(parameters)
    mean: Array = np.zeros(dimension)
    cholesky: Array = np.eye(dimension)
    rounds: list[tuple[Array, Array, Array]] = []
    for done in range(MAX_ROUNDS):
        progress("learning", done, MAX_ROUNDS)
        z = rng.standard_normal((DRAWS_PER_ROUND, dimension))
        adapted = rng.uniform(size=DRAWS_PER_ROUND) >= PRIOR_SHARE
        z[adapted] = mean + z[adapted] @ cholesky.T
        x = prior_values(parameters, ndtr(z))
        if done == 0:
            first = row_deviations(x, observed, responses)
            _check_reach(first, observed)
        log_likelihoods, chi2 = log_likelihood(x, observed, responses)
        rounds.append((z, log_likelihoods - 0.5 * np.sum(z**2, axis=1) - _log_density(z, mean, cholesky), chi2))
        all_z, log_weights, squares = (np.concatenate(parts) for parts in zip(*rounds, strict=True))
        weight = _normalise_weights(log_weights)
        independent = float(1.0 / (weight @ weight))
        if independent >= MIN_INDEPENDENT:
            chosen = rng.choice(len(all_z), KEPT_DRAWS, p=weight)
            draws = prior_values(parameters, ndtr(all_z[chosen]))
            return Posterior(draws, len(all_z), independent, float(squares.min()))
        weight = _temper_weights(log_weights)  # a few heavy draws would span too narrow a region
        mean = weight @ all_z
        centred = (all_z - mean) * np.sqrt(weight)[:, None]
        spread = SPREAD_FACTOR**2 * (centred.T @ centred) + 1e-9 * np.eye(dimension)
        cholesky = np.asarray(np.linalg.cholesky(spread))
    _check_contradiction(np.concatenate([first, row_deviations(x, observed, responses)]), observed)
    raise InputError(
        f"the posterior did not converge: {len(all_z)} draws are worth only {independent:.0f} independent ones. "
        "Hold a parameter, ‹fix› NAME=VALUE, or use ‹prior=›scene"
    )


def _check_reach(deviations: Array, observed: Sequence[Observed]) -> None:
    """Raise InputError for a speed that no draw of the prior comes near, while most others are within its reach.

    `deviations`: `row_deviations` of draws of the prior.
    """
    least = deviations.min(axis=0)
    worst = int(least.argmax())
    if (
        len(least) > 1
        and least[worst] > UNREACHED_DEVIATIONS
        and np.median(np.delete(least, worst)) < REACHED_DEVIATIONS
    ):
        raise _outlier_error(worst, f"{least[worst]:.0f} standard deviations from every walker of the prior", observed)


def _check_contradiction(deviations: Array, observed: Sequence[Observed]) -> None:
    """Raise InputError for the speed without which a draw agrees best with the others, if it costs most of chi2.

    `deviations`: `row_deviations` of draws of the prior and of the last round.
    """
    squares = deviations**2
    whole = squares.sum(axis=1)
    saved = whole.min() - (whole[:, None] - squares).min(axis=0)
    worst = int(saved.argmax())
    if saved[worst] > REACHED_DEVIATIONS**2 and saved[worst] > 0.5 * whole.min():
        off = float(squares[(whole - squares[:, worst]).argmin(), worst]) ** 0.5
        raise _outlier_error(worst, f"{off:.0f} standard deviations from what the other rows predict", observed)


def _outlier_error(row: int, distance: str, observed: Sequence[Observed]) -> InputError:
    """Return the error that names an outlier, the measured speed number `row` in the order of the settings."""
    name, speed = [(seen.name, speed) for seen in observed for speed in seen.speed][row]
    return InputError(
        f"‹speeds›: outlier: the row of {name} and {format_number(float(speed), 3)} mm/s lies {distance}. "
        "Check this print and its film, and correct or remove the row.",
        "speeds",
    )


def _log_density(z: Array, mean: Array, cholesky: Array) -> Array:
    """Return the log density, up to a constant, of the distribution from which the rows of `z` are drawn, shape (n,).

    It mixes the prior with a normal distribution about `mean`. `cholesky`: Cholesky factor of its covariance.
    """
    standard = np.linalg.solve(cholesky, (z - mean).T)
    adapted = -0.5 * np.sum(standard**2, axis=0) - np.log(np.diag(cholesky)).sum()
    prior = -0.5 * np.sum(z**2, axis=1)
    logs = np.logaddexp(np.log(1.0 - PRIOR_SHARE) + adapted, np.log(PRIOR_SHARE) + prior)
    return np.asarray(logs)


def _normalise_weights(log_weights: Array) -> Array:
    """Return weights of sum 1 from their logarithms, shape (n,)."""
    weight = np.exp(log_weights - log_weights.max())
    return np.asarray(weight / weight.sum())


def _temper_weights(log_weights: Array) -> Array:
    """Return weights of sum 1, raised to the largest power 0.7^n worth MIN_INDEPENDENT / 10 independent draws."""
    power = 1.0
    while True:
        weight = _normalise_weights(power * log_weights)
        if 1.0 / (weight @ weight) >= 0.1 * MIN_INDEPENDENT:
            return weight
        power *= 0.7
