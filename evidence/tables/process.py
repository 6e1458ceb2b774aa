"""Fit of the process that `walkergen.numerics.odd_process` evaluates, through noisy values."""

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.numerics.odd_process import Process, distance, kernel, matern, mirrored, with_itself

Array = npt.NDArray[Any]

LEARNT_FROM = 700
"""Most values from which lengths are learnt, at random: time goes as their cube."""

LONG, LONG_SD = 1.2, 1.0
"""Mean and standard deviation beforehand of the logarithm of a length, over an input's scatter."""

STEPS = 100

JITTER = 1e-8
"""Share of the variance that keeps a covariance regular."""


class Values(NamedTuple):
    """Values through which a process goes."""

    inputs: Array
    """Shape (n, d), each of about unit scatter."""
    values: Array
    """Shape (n,)."""
    noise: Array
    """Variances of the values' errors, shape (n,)."""


def arrays_of(process: Process) -> dict[str, Array]:
    """Arrays of a process by the names of its fields."""
    return {name: np.asarray(value) for name, value in process._asdict().items()}


def fitted(given: Values, odd: int, supports: int, seed: int) -> Process:
    """Process through values, which rests on at most so many of them."""
    lengths, variance, rough = _learnt(given, odd, seed)
    places = _chosen(given.inputs, odd, lengths, supports)
    support = given.inputs[places]
    lower = np.linalg.cholesky(variance * (kernel(support, support, odd, lengths) + JITTER * np.eye(len(places))))
    within = np.linalg.inv(lower)
    weight = 1.0 / (given.noise + rough)
    shown = within @ (variance * kernel(support, given.inputs, odd, lengths))
    gained = np.linalg.inv(np.eye(len(places)) + (shown * weight) @ shown.T)
    mean = within.T @ (gained @ (shown @ (weight * given.values)))
    known = within.T @ (np.eye(len(places)) - gained) @ within
    return Process(odd, lengths, variance, rough, support, mean, known)


def _learnt(given: Values, odd: int, seed: int) -> tuple[Array, float, float]:
    """Lengths, variance and roughness of the largest likelihood, and what is known beforehand."""
    from scipy.optimize import minimize

    some = np.random.default_rng(seed).permutation(len(given.values))[:LEARNT_FROM]
    given = Values(*(column[some] for column in given))
    wide = given.inputs.shape[1]
    spread = math.log(float(np.var(given.values)))
    start = np.r_[np.full(wide, LONG), spread, spread - 2.0]
    bounds = [(LONG - 3.0, LONG + 3.0)] * wide + [(spread - 4.0, spread + 4.0)]
    best = minimize(
        _loss,
        start,
        (given, odd),
        jac=True,
        method="L-BFGS-B",
        bounds=[*bounds, (spread - 8.0, spread + 1.0)],
        options={"maxiter": STEPS},
    )
    return np.exp(best.x[:wide]), math.exp(best.x[wide]), math.exp(best.x[wide + 1])


def _loss(numbers: Array, given: Values, odd: int) -> tuple[float, Array]:
    """Negative logarithm of the likelihood, and its derivatives by those of the numbers."""
    x, image = given.inputs, mirrored(given.inputs, odd)
    wide = x.shape[1]
    lengths = np.exp(numbers[:wide])
    variance, rough = np.exp(numbers[wide:])
    near, far = distance(x, x, lengths), distance(x, image, lengths)
    alike = 0.5 * (matern(near) - matern(far))
    covariance = variance * alike + np.diag(given.noise + rough + JITTER * variance)
    lower = np.linalg.cholesky(covariance)
    half = np.linalg.inv(lower)
    inverse = half.T @ half
    solved = inverse @ given.values
    off = (numbers[:wide] - LONG) / LONG_SD
    total = 0.5 * float(given.values @ solved) + float(np.log(np.diag(lower)).sum())
    slopes = inverse - np.outer(solved, solved)
    by_length = (
        0.25 * variance * (_moved(slopes * _steep(near), x, x) - _moved(slopes * _steep(far), x, image)) / lengths**2
    )
    by_variance = 0.5 * variance * float(np.sum(slopes * alike))
    by_rough = 0.5 * rough * float(np.trace(slopes))
    gradient = np.r_[by_length + off / LONG_SD, by_variance, by_rough]
    return total + 0.5 * float(off @ off), gradient


def _moved(weights: Array, x: Array, y: Array) -> Array:
    """Sums of weighted squares of the differences of each input, shape (d,)."""
    return np.asarray(
        weights.sum(axis=1) @ x**2 + weights.sum(axis=0) @ y**2 - 2.0 * np.einsum("ik,ik->k", x, weights @ y)
    )


def _chosen(inputs: Array, odd: int, lengths: Array, count: int) -> Array:
    """Places of the inputs on which a process rests: each the one of which others tell least."""
    left = with_itself(inputs, odd, lengths)
    rows = np.empty((min(count, len(inputs)), len(inputs)))
    places: list[int] = []
    for number in range(len(rows)):
        place = int(np.argmax(left))
        if left[place] < JITTER:
            break
        column = kernel(inputs[place : place + 1], inputs, odd, lengths)[0]
        rows[number] = (column - rows[:number, place] @ rows[:number]) / math.sqrt(left[place])
        left = np.maximum(left - rows[number] ** 2, 0.0)
        left[place] = 0.0
        places.append(place)
    return np.array(places)


def _steep(distance: Array) -> Array:
    """Slope of the kernel by half of the square of a distance without the 5, its sign changed."""
    return np.asarray(5.0 / 3.0 * (1.0 + distance) * np.exp(-distance))
