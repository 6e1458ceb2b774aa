"""The emulator against functions that are known, with noise that is known."""

import numpy as np
import pytest

from walkergen.points import emulator


def _points(count, seed):
    return np.random.default_rng(seed).uniform(-1.0, 1.0, (count, 3))


def _function(x):
    return 50.0 + 20.0 * x[:, 0] - 8.0 * x[:, 1] ** 2 + 6.0 * np.sin(2.0 * x[:, 0] * x[:, 1])


@pytest.mark.parametrize("known", [True, False])
def test_the_function_lies_inside_its_band(known):
    rng, x = np.random.default_rng(5), _points(80, 1)
    noise = np.full(80, 2.0)
    found = emulator.fit(x, _function(x) + rng.normal(0.0, noise), noise if known else None)
    fresh = _points(400, 2)
    mean, sd = found(fresh)
    z = (mean - _function(fresh)) / sd
    # The errors of 400 places are few independent ones (about ten coefficients): hence wide limits.
    assert 0.4 < np.sqrt(np.mean(z**2)) < 1.7
    assert np.sqrt(np.mean((mean - _function(fresh)) ** 2)) < 1.5  # below the noise, 2
    assert 0.75 < np.sqrt(np.mean((found.left_out / found.left_out_sd) ** 2)) < 1.3


def test_residuals_left_out_are_those_of_fits_without_the_value():
    x = _points(30, 3)
    noise = np.full(30, 1.0)
    y = _function(x) + np.random.default_rng(1).normal(0.0, noise)
    found = emulator.fit(x, y, noise)
    kernel, spread = found.process.kernel_, y.std()
    scaled = (x - found.centre) / found.scale
    rest = np.arange(30) != 7
    gram = kernel(scaled[rest]) + np.eye(29) / spread**2
    expected = kernel(scaled[7:8], scaled[rest]) @ np.linalg.solve(gram, (y - y.mean())[rest])
    assert found.left_out[7] == pytest.approx(y[7] - y.mean() - expected[0], rel=1e-6)


def test_too_few_values_are_refused():
    with pytest.raises(ValueError, match="8"):
        emulator.fit(np.zeros((7, 1)), np.zeros(7))


@pytest.mark.parametrize("known", [True, False])
def test_the_fast_prediction_equals_scikit_learns(known):
    x = _points(40, 3)
    y = _function(x) + np.random.default_rng(6).normal(0.0, 2.0, 40)
    found = emulator.fit(x, y, np.full(40, 2.0) if known else None)
    fresh = _points(50, 4)
    mean, sd = found(fresh)
    rival = found.process.predict((fresh - found.centre) / found.scale, return_std=True)
    # Inverting the factor costs some digits of a variance that is a small difference.
    assert mean == pytest.approx(rival[0], rel=1e-9)
    assert sd == pytest.approx(rival[1], rel=1e-6)
