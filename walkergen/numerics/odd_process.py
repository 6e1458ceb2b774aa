"""Gaussian process through noisy values of a function that some inputs turn about.

The first inputs change their sign in the mirror image, where the function has the other sign: its
kernel is half of what a Matern process (twice differentiable paths, a length for each input) has
between two inputs, less what it has between the one and the other's mirror image. The process rests
on some of the values (what they tell of the others is projected on these), and needs numpy alone.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]

BLOCK, PIECE = 32, 2**18
"""Inputs that are evaluated together, and multiplications of a product of matrices: of more a
library shares it out to threads, which wait for one another, on a busy machine for a hundred times
the time of the work."""

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


class Process(NamedTuple):
    """Process of which the first `odd` inputs change their sign in the mirror image."""

    odd: int
    lengths: Array
    """Shape (d,)."""
    variance: float
    rough: float
    """Variance of what is not smooth, beside the noise."""
    support: Array
    """Inputs on which it rests, shape (m, d)."""
    mean: Array
    """Weights of the kernel at these in the mean, shape (m,)."""
    known: Array
    """Those of its squares in the part of the variance that is known, shape (m, m)."""

    def __call__(self, inputs: Array) -> tuple[Array, Array]:
        """Mean and variance (roughness included) at inputs of shape (n, d)."""
        mean, variance = np.empty(len(inputs)), np.empty(len(inputs))
        for first in range(0, len(inputs), BLOCK):
            rows = slice(first, first + BLOCK)
            near = inputs[rows]
            alike = self.variance * _odd(near, self.support, self.odd, self.lengths)
            mean[rows] = alike @ self.mean
            own = self.variance * _own(near, self.odd, self.lengths)
            variance[rows] = own - np.sum(_product(alike, self.known) * alike, axis=1)
        return mean, np.maximum(variance, 0.0) + self.rough


def arrays_of(process: Process) -> dict[str, Array]:
    """Arrays of a process by the names of its fields."""
    return {name: np.asarray(value) for name, value in process._asdict().items()}


def process_of(arrays: Mapping[str, Array]) -> Process:
    """Process of the arrays that `arrays_of` has made, among others."""
    lengths, support, mean, known = (arrays[n] for n in ("lengths", "support", "mean", "known"))
    variance, rough = float(arrays["variance"]), float(arrays["rough"])
    return Process(int(arrays["odd"]), lengths, variance, rough, support, mean, known)


def mirrored(inputs: Array, odd: int) -> Array:
    """Inputs of the mirror image."""
    return np.column_stack([-inputs[:, :odd], inputs[:, odd:]])


def fitted(given: Values, odd: int, supports: int, seed: int) -> Process:
    """Process through values, which rests on at most so many of them."""
    lengths, variance, rough = _learnt(given, odd, seed)
    places = _chosen(given.inputs, odd, lengths, supports)
    support = given.inputs[places]
    lower = np.linalg.cholesky(variance * (_odd(support, support, odd, lengths) + JITTER * np.eye(len(places))))
    within = np.linalg.inv(lower)
    weight = 1.0 / (given.noise + rough)
    shown = within @ (variance * _odd(support, given.inputs, odd, lengths))
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
    near, far = _distance(x, x, lengths), _distance(x, image, lengths)
    alike = 0.5 * (_matern(near) - _matern(far))
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
    left = _own(inputs, odd, lengths)
    rows = np.empty((min(count, len(inputs)), len(inputs)))
    places: list[int] = []
    for number in range(len(rows)):
        place = int(np.argmax(left))
        if left[place] < JITTER:
            break
        column = _odd(inputs[place : place + 1], inputs, odd, lengths)[0]
        rows[number] = (column - rows[:number, place] @ rows[:number]) / math.sqrt(left[place])
        left = np.maximum(left - rows[number] ** 2, 0.0)
        left[place] = 0.0
        places.append(place)
    return np.array(places)


def _odd(x: Array, y: Array, odd: int, lengths: Array) -> Array:
    """Kernel of unit variance, shape (n, m)."""
    near, far = _distance(x, y, lengths), _distance(x, mirrored(y, odd), lengths)
    return 0.5 * (_matern(near) - _matern(far))


def _own(x: Array, odd: int, lengths: Array) -> Array:
    """Kernel of each input with itself, shape (n,)."""
    far = 2.0 * math.sqrt(5.0) * np.linalg.norm(x[:, :odd] / lengths[:odd], axis=1)
    return np.asarray(0.5 * (1.0 - _matern(far)))


def _distance(x: Array, y: Array, lengths: Array) -> Array:
    """Distances in lengths, times the square root of 5, shape (n, m)."""
    a, b = x / lengths, y / lengths
    squares = (a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1) - 2.0 * _product(a, b.T)
    return np.asarray(np.sqrt(5.0 * np.maximum(squares, 0.0)))


def _product(a: Array, b: Array) -> Array:
    """Product of matrices, in pieces."""
    wide = max(PIECE // a.size, 1)
    return np.concatenate([a @ b[:, k : k + wide] for k in range(0, b.shape[1], wide)], axis=1)


def _matern(distance: Array) -> Array:
    return np.asarray((1.0 + distance + distance**2 / 3.0) * np.exp(-distance))


def _steep(distance: Array) -> Array:
    """Slope of the kernel by half of the square of a distance without the 5, its sign changed."""
    return np.asarray(5.0 / 3.0 * (1.0 + distance) * np.exp(-distance))
