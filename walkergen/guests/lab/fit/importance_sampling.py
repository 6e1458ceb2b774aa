"""Posterior of the parameters from weighted draws.

Importance sampling in z, where every prior is the standard normal: first from the prior, then from normal distributions
somewhat wider than the weighted draws so far (population Monte Carlo, Cappé et al., J. Comput. Graph. Stat. 13, 907,
2004). A tenth always comes from the prior, so that no region is left out for ever.
"""

from collections.abc import Sequence

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.files.progress import Progress
from walkergen.core.numerics import Array
from walkergen.guests.lab.fit.parameters import Parameter, prior_values
from walkergen.guests.lab.fit.posterior import KEPT_DRAWS, Observed, Posterior, Responds, log_likelihood

DRAWS_PER_ROUND, MAX_ROUNDS = 2**13, 24
"""Draws of a round, which add to those of earlier rounds, and rounds until sampling gives up."""

MIN_INDEPENDENT = 1000.0
"""Least equivalent number of independent draws: bounds of 95 % then err by 0.1 sd."""

PRIOR_SHARE, SPREAD_FACTOR = 0.1, 1.4
"""Share of the draws that are the prior's, and factor on the spread of the others."""


def sample(
    parameters: Sequence[Parameter],
    observed: Sequence[Observed],
    responses: Sequence[Responds],
    seed: int,
    progress: Progress,
) -> Posterior:
    """Sample the parameters given speeds observed in settings with these responses.

    Equal seeds give equal draws. Raises InputError when too few draws agree with the speeds.
    """
    from scipy.special import ndtr

    rng = np.random.default_rng([seed, len(observed)])
    wide = len(parameters)
    middle: Array = np.zeros(wide)
    root: Array = np.eye(wide)
    rounds: list[tuple[Array, Array, Array]] = []
    for done in range(MAX_ROUNDS):
        progress("learning", done, MAX_ROUNDS)
        z = rng.standard_normal((DRAWS_PER_ROUND, wide))
        narrow = rng.uniform(size=DRAWS_PER_ROUND) >= PRIOR_SHARE
        z[narrow] = middle + z[narrow] @ root.T
        logs, chi2 = log_likelihood(prior_values(parameters, ndtr(z)), observed, responses)
        rounds.append((z, logs - 0.5 * np.sum(z**2, axis=1) - _log_density(z, middle, root), chi2))
        every, logarithm, squares = (np.concatenate(parts) for parts in zip(*rounds, strict=True))
        weight = _normalise_weights(logarithm)
        worth = float(1.0 / (weight @ weight))
        if worth >= MIN_INDEPENDENT:
            picked = rng.choice(len(every), KEPT_DRAWS, p=weight)
            draws = prior_values(parameters, ndtr(every[picked]))
            return Posterior(draws, len(every), worth, float(squares.min()))
        weight = _temper_weights(logarithm)
        middle = weight @ every
        off = (every - middle) * np.sqrt(weight)[:, None]
        spread = SPREAD_FACTOR**2 * (off.T @ off) + 1e-9 * np.eye(wide)
        root = np.asarray(np.linalg.cholesky(spread))
    raise InputError(
        f"the posterior did not converge: {len(every)} draws are worth only {worth:.0f} independent ones. "
        "Hold a parameter, ‹fix› NAME=VALUE, or use ‹prior=›scene"
    )


def _log_density(z: Array, middle: Array, root: Array) -> Array:
    """Compute the logarithm of the sampling density of rows of z, up to a constant."""
    inner = np.linalg.solve(root, (z - middle).T)
    narrow = -0.5 * np.sum(inner**2, axis=0) - np.log(np.diag(root)).sum()
    prior = -0.5 * np.sum(z**2, axis=1)
    logs = np.logaddexp(np.log(1.0 - PRIOR_SHARE) + narrow, np.log(PRIOR_SHARE) + prior)
    return np.asarray(logs)


def _normalise_weights(logarithm: Array) -> Array:
    weight = np.exp(logarithm - logarithm.max())
    return np.asarray(weight / weight.sum())


def _temper_weights(logarithm: Array) -> Array:
    """Raise weights to the largest power, at most 1, that makes them worth a tenth of MIN_INDEPENDENT.

    With a few heavy draws alone the next ones would come from too narrow a spread.
    """
    power = 1.0
    while True:
        weight = _normalise_weights(power * logarithm)
        if 1.0 / (weight @ weight) >= 0.1 * MIN_INDEPENDENT:
            return weight
        power *= 0.7
