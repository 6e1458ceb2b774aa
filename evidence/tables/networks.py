"""Training of the small networks whose outputs `walkergen.theory.discrepancy` evaluates."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.theory.discrepancy import Layer

Array = npt.NDArray[Any]


class Values(NamedTuple):
    """Values that a network shall give."""

    inputs: Array
    """Shape (n, d), each of about unit scatter."""
    factors: Array
    """Factors of the outputs, shape (n, outputs)."""
    values: Array
    """Shape (n,)."""
    weights: Array
    """What an error counts, shape (n,)."""


def trained(training: Values, hidden: Sequence[int], decay: float, steps: int, seed: int) -> list[Layer]:
    """Network with the least squares of weighted errors, and of `decay` times its own weights."""
    from scipy.optimize import minimize

    rng = np.random.default_rng(seed)
    sizes = [training.inputs.shape[1], *hidden, training.factors.shape[1]]
    start = []
    for wide, high in pairwise(sizes):
        start += [rng.normal(0.0, wide**-0.5, wide * high), np.zeros(high)]

    def loss(values: Array) -> tuple[float, Array]:
        layers = _layers(values, sizes)
        return _loss(layers, training, decay)

    options = {"maxiter": steps, "maxfun": 2 * steps, "maxcor": 30}
    best = minimize(loss, np.concatenate(start), jac=True, method="L-BFGS-B", options=options)
    return _layers(best.x, sizes)


def _layers(values: Array, sizes: Sequence[int]) -> list[Layer]:
    """Layers of the numbers of a network in a row."""
    layers, first = [], 0
    for wide, high in pairwise(sizes):
        middle = first + wide * high
        layers.append(Layer(values[first:middle].reshape(wide, high), values[None, middle : middle + high]))
        first = middle + high
    return layers


def _loss(layers: Sequence[Layer], training: Values, decay: float) -> tuple[float, Array]:
    """Loss of a network, and its derivatives by its numbers in their order."""
    passed = [training.inputs]
    for layer in layers[:-1]:
        passed.append(np.tanh(passed[-1] @ layer.weights + layer.bias))
    outputs = passed[-1] @ layers[-1].weights + layers[-1].bias
    error = (outputs * training.factors).sum(axis=1) - training.values
    total = 0.5 * float(training.weights @ error**2)
    back = (training.weights * error)[:, None] * training.factors
    slopes: list[Array] = []
    for place in range(len(layers) - 1, -1, -1):
        layer = layers[place]
        total += 0.5 * decay * float(np.sum(layer.weights**2))
        slopes = [(passed[place].T @ back + decay * layer.weights).ravel(), back.sum(axis=0), *slopes]
        if place > 0:
            back = (back @ layer.weights.T) * (1.0 - passed[place] ** 2)
    return total, np.concatenate(slopes)


def arrays_of(networks: Sequence[Sequence[Layer]], name: str) -> dict[str, Array]:
    """Arrays, in single precision, of networks of one form, by names that begin with `name`."""
    arrays = {}
    for place, layers in enumerate(zip(*networks, strict=True)):
        arrays[f"{name}_weights{place}"] = np.stack([layer.weights for layer in layers])
        arrays[f"{name}_bias{place}"] = np.stack([layer.bias for layer in layers])
    return {key: value.astype(np.float32) for key, value in arrays.items()}
