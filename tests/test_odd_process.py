"""A process that its first inputs turn about: odd, near its function, honest about its error."""

import numpy as np
import pytest

from evidence.tables import process as processes
from evidence.tables.process import Values
from walkergen.numerics import odd_process

RNG = np.random.default_rng(8)
INPUTS = RNG.normal(size=(240, 4))
NOISE = np.full(240, 0.05**2)


def function(x):
    """Odd in the first two inputs together, and independent of the last."""
    return 2.0 * np.sin(x[:, 0]) * (1.0 + 0.3 * x[:, 2] ** 2) + 0.5 * x[:, 1]


SEEN = function(INPUTS) + 0.05 * RNG.standard_normal(240)
PROCESS = processes.fitted(Values(INPUTS, SEEN, NOISE), 2, 120, 1)


def test_it_finds_its_function_and_says_how_far_it_errs():
    there = RNG.normal(size=(400, 4))
    mean, variance = PROCESS(there)
    z = (mean - function(there)) / np.sqrt(variance)
    assert np.median(np.abs(mean - function(there))) < 0.1
    assert 0.9 < np.mean(np.abs(z) < 1.96) <= 1.0
    far, unknown = PROCESS(np.full((1, 4), 30.0))
    assert abs(far[0]) < 0.1 * np.ptp(SEEN)
    assert unknown[0] > 5.0 * np.median(variance)


def test_the_mirror_image_has_the_other_sign_and_what_is_its_own_image_none():
    image = odd_process.mirrored(INPUTS, 2)
    np.testing.assert_allclose(PROCESS(image)[0], -PROCESS(INPUTS)[0], atol=1e-10)
    np.testing.assert_allclose(PROCESS(image)[1], PROCESS(INPUTS)[1], atol=1e-10)
    upright = INPUTS * [0.0, 0.0, 1.0, 1.0]
    np.testing.assert_allclose(PROCESS(upright)[0], 0.0, atol=1e-10)
    assert PROCESS(upright)[1] == pytest.approx(PROCESS.rough)


def test_what_does_not_matter_has_a_long_length():
    assert PROCESS.lengths[3] > 3.0 * PROCESS.lengths[0]


def test_of_all_values_it_is_the_process_in_closed_form():
    """Rival: the textbook's mean and variance, with a kernel written out by hand."""
    few = slice(0, 40)
    x, y, noise = INPUTS[few], SEEN[few], NOISE[few]
    process = processes.fitted(Values(x, y, noise), 2, 40, 1)

    def matern(a, b):
        far = np.sqrt(5.0 * (((a[:, None] - b[None]) / process.lengths) ** 2).sum(axis=2))
        return (1.0 + far + far**2 / 3.0) * np.exp(-far)

    def kernel(a, b):
        image = b * [-1.0, -1.0, 1.0, 1.0]
        return 0.5 * process.variance * (matern(a, b) - matern(a, image))

    there = RNG.normal(size=(7, 4))
    inverse = np.linalg.inv(kernel(x, x) + np.diag(noise + process.rough))
    mean = kernel(there, x) @ inverse @ y
    left = np.diag(kernel(there, there) - kernel(there, x) @ inverse @ kernel(x, there))
    got, variance = process(there)
    # What keeps the covariance regular moves it by 1e-4
    np.testing.assert_allclose(got, mean, atol=1e-3)
    np.testing.assert_allclose(variance, left + process.rough, atol=1e-3)


def test_arrays_hold_all_of_it():
    kept = odd_process.process_of(processes.arrays_of(PROCESS))
    np.testing.assert_array_equal(kept(INPUTS)[0], PROCESS(INPUTS)[0])
    np.testing.assert_array_equal(kept(INPUTS)[1], PROCESS(INPUTS)[1])
