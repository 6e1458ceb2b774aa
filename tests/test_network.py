"""Networks against functions that are known, and their slopes against differences."""

import numpy as np

from evidence.tables import networks
from evidence.tables.networks import Values
from walkergen.theory import discrepancy


def _values(count, seed=1):
    inputs = np.random.default_rng(seed).uniform(-1.5, 1.5, (count, 2))
    factors = inputs[:, :1]
    values = inputs[:, 0] * (2.0 + np.sin(2.0 * inputs[:, 1]))
    return Values(inputs, factors, values, np.ones(count))


def _at(layers, given):
    return (discrepancy.evaluated(layers, given.inputs) * given.factors).sum(axis=-1)


def test_a_network_finds_its_function_and_vanishes_with_its_factor():
    layers = networks.trained(_values(300), (12, 12), decay=1e-3, steps=300, seed=2)
    fresh = _values(700, seed=3)
    assert np.sqrt(np.mean((_at(layers, fresh) - fresh.values) ** 2)) < 0.05
    level = fresh._replace(factors=0.0 * fresh.factors)
    assert np.all(_at(layers, level) == 0.0)


def test_several_networks_stored_together_are_each_itself():
    """More inputs than one block, in single precision."""
    several = [networks.trained(_values(50), (6,), 1e-2, 30, seed) for seed in (1, 2)]
    arrays = networks.arrays_of(several, "walker")
    fresh = _values(600, seed=4)
    together = discrepancy.evaluated(discrepancy.layers_of(arrays, "walker"), fresh.inputs)
    for layers, outputs in zip(several, together, strict=True):
        np.testing.assert_allclose(discrepancy.evaluated(layers, fresh.inputs), outputs, atol=1e-5)
