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
            alike = self.variance * kernel(near, self.support, self.odd, self.lengths)
            mean[rows] = alike @ self.mean
            own = self.variance * with_itself(near, self.odd, self.lengths)
            variance[rows] = own - np.sum(_product(alike, self.known) * alike, axis=1)
        return mean, np.maximum(variance, 0.0) + self.rough


def process_of(arrays: Mapping[str, Array]) -> Process:
    """Process of the arrays by the names of its fields, among others."""
    lengths, support, mean, known = (arrays[n] for n in ("lengths", "support", "mean", "known"))
    variance, rough = float(arrays["variance"]), float(arrays["rough"])
    return Process(int(arrays["odd"]), lengths, variance, rough, support, mean, known)


def mirrored(inputs: Array, odd: int) -> Array:
    """Inputs of the mirror image."""
    return np.column_stack([-inputs[:, :odd], inputs[:, odd:]])


def kernel(x: Array, y: Array, odd: int, lengths: Array) -> Array:
    """Kernel of unit variance, shape (n, m)."""
    near, far = distance(x, y, lengths), distance(x, mirrored(y, odd), lengths)
    return 0.5 * (matern(near) - matern(far))


def with_itself(x: Array, odd: int, lengths: Array) -> Array:
    """Kernel of each input with itself, shape (n,)."""
    far = 2.0 * math.sqrt(5.0) * np.linalg.norm(x[:, :odd] / lengths[:odd], axis=1)
    return np.asarray(0.5 * (1.0 - matern(far)))


def distance(x: Array, y: Array, lengths: Array) -> Array:
    """Distances in lengths, times the square root of 5, shape (n, m)."""
    a, b = x / lengths, y / lengths
    squares = (a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1) - 2.0 * _product(a, b.T)
    return np.asarray(np.sqrt(5.0 * np.maximum(squares, 0.0)))


def _product(a: Array, b: Array) -> Array:
    """Product of matrices, in pieces."""
    wide = max(PIECE // a.size, 1)
    return np.concatenate([a @ b[:, k : k + wide] for k in range(0, b.shape[1], wide)], axis=1)


def matern(distance: Array) -> Array:
    """Matern kernel of 5/2 at a distance as `distance` has it."""
    return np.asarray((1.0 + distance + distance**2 / 3.0) * np.exp(-distance))
