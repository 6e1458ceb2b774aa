"""Posterior of the parameters, from measured speeds and emulated ones, by emcee.

Sampled in z: every prior is the standard normal there, so that no walker runs into an end of a
range. The emulators' own errors and the scatter between prints are part of the likelihood.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.files.progress import Progress
from walkergen.core.numerics import Array
from walkergen.guests.lab.fit.parameters import Parameter, prior_values
from walkergen.points.emulator import single_thread


class Responds(Protocol):
    """Speed of a setting over the parameters."""

    def __call__(self, x: Array, /) -> tuple[Array, Array, Array]:
        """Return the mean, the common error of all prints, and the scatter between prints, each (k,), mm/s.

        Rows of x (k, parameters) are values of the parameters.
        """


CHAIN_COUNT = 48
FIRST_STEPS, MAX_STEPS = 500, 30_000
"""Steps before the first look at the correlation time, and steps after which sampling gives up."""

MIN_CORRELATION_TIMES = 50
"""Correlation times that a chain needs before its own estimate of them holds (emcee's rule)."""

KEPT_DRAWS = 4096
"""Draws that are kept, of many more that depend on one another."""

PRIOR_DRAWS = 4096
"""Draws of the prior among which the chains' starts are chosen."""


class Observed(NamedTuple):
    """Measured speeds of n prints of one walker on one plate."""

    speed: Array
    """Speeds, mm/s, shape (n,)."""
    se: Array
    """Standard errors, mm/s, shape (n,)."""


class Posterior(NamedTuple):
    """Draws of the parameters, and how independent they are."""

    draws: Array
    """Parameters, shape (KEPT_DRAWS, parameters)."""
    steps: int
    """Steps of the chains, or weighted draws, that these were chosen of."""
    correlation: float | None
    """Longest autocorrelation time of a parameter, in steps; None of weighted draws."""
    independent: float
    """Number of independent draws that all that were made are worth."""
    chi2: float
    """Sum of squared residuals at the best draw, over the variances that the model gives them."""


def sample(
    parameters: Sequence[Parameter],
    observed: Sequence[Observed],
    responses: Sequence[Responds],
    seed: int,
    progress: Progress,
) -> Posterior:
    """Sample the parameters given speeds observed in settings with these responses.

    Equal seeds give equal draws. Raises InputError when the chains do not converge.
    """
    from scipy.special import ndtr

    def log_posterior(z: Array) -> Array:
        speeds = log_likelihood(prior_values(parameters, ndtr(z)), observed, responses)[0]
        return np.asarray(speeds - 0.5 * np.sum(z**2, axis=1))

    rng = np.random.default_rng([seed, len(observed)])
    with single_thread():
        z, steps, time = _run_chains(log_posterior, len(parameters), rng, progress)
        picked = np.linspace(0, len(z) - 1, KEPT_DRAWS).round().astype(int)
        draws = prior_values(parameters, ndtr(z[picked]))
        chi2 = float(log_likelihood(draws, observed, responses)[1].min())
    return Posterior(draws, steps, time, len(z) / time, chi2)


def _run_chains(
    logarithm: Callable[[Array], Array], wide: int, rng: np.random.Generator, progress: Progress
) -> tuple[Array, int, float]:
    """Run the chains; return all draws in z, (n, wide), the number of steps and the correlation time."""
    from emcee import EnsembleSampler, State, moves

    start = _chain_starts(logarithm, wide, rng)
    mixed = [(moves.DEMove(), 0.8), (moves.DESnookerMove(), 0.2)]
    sampler = EnsembleSampler(*start.shape, logarithm, moves=mixed, vectorize=True)
    stream = np.random.RandomState(int(rng.integers(2**32))).get_state()
    state, time = State(start, random_state=stream), np.inf
    while sampler.iteration < MIN_CORRELATION_TIMES * time:
        if sampler.iteration >= MAX_STEPS:
            raise InputError(
                f"the posterior did not converge in {MAX_STEPS} steps (correlation time {time:.0f} "
                "of them): hold a parameter, ‹fix› NAME=VALUE, or take ‹prior=›scene"
            )
        done = sampler.iteration
        progress("learning", done, max(3 * FIRST_STEPS, 2 * done))
        sampler.run_mcmc(state if done == 0 else None, max(FIRST_STEPS, done // 2))
        time = max(1.0, float(np.max(sampler.get_autocorr_time(tol=0))))
    chain = sampler.get_chain(discard=int(4 * time), flat=True)
    return chain, sampler.iteration, time


def _chain_starts(logarithm: Callable[[Array], Array], wide: int, rng: np.random.Generator) -> Array:
    """Draw starts of the chains in z, from the prior weighted by the likelihood, (CHAIN_COUNT, wide).

    A little of the prior is added, because equal starts could not span what is to be sampled.
    """
    z = rng.normal(size=(PRIOR_DRAWS, wide))
    weight = logarithm(z) + 0.5 * np.sum(z**2, axis=1)
    weight = np.exp(weight - weight.max())
    chosen = rng.choice(PRIOR_DRAWS, CHAIN_COUNT, p=weight / weight.sum())
    return np.asarray(z[chosen] + 0.05 * rng.normal(size=(CHAIN_COUNT, wide)))


def log_likelihood(x: Array, observed: Sequence[Observed], responses: Sequence[Responds]) -> tuple[Array, Array]:
    """Return the log-likelihood of parameters x (k, parameters), and chi2, each of shape (k,).

    Prints scatter on their own; the error of an emulator is common to all prints of its setting.
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


def speed_draws(x: Array, response: Responds, rng: np.random.Generator) -> Array:
    """Draw the speed of a new print for each draw of the parameters, shape (k,)."""
    with single_thread():
        mean, sd, scatter = response(x)
    return np.asarray(mean + np.hypot(sd, scatter) * rng.normal(size=len(x)))
