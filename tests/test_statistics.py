"""Errors of means, of whatever the jackknife is put to, and of a slope."""

import numpy as np
import pytest

from walkergen.numerics import statistics


def series(seed, memory, count):
    rng = np.random.default_rng(seed)
    values = np.zeros(count)
    for i in range(1, count):
        values[i] = values[i - 1] * np.exp(-1 / memory) + rng.normal()
    return values


def test_error_of_a_correlated_mean_covers_it():
    scores = []
    for seed in range(100):
        values = [series(seed, 5.0, 2000)]
        time = statistics.correlation_time(values, 0.1)
        scores.append(values[0].mean() / statistics.error_of_mean(values, 0.1, time))
    assert 0.54 < np.mean(np.abs(scores) < 1) < 0.82  # 68 % +- 4.7 %, 3 sigma


def test_too_few_values_are_refused():
    assert statistics.correlation_time([np.zeros(31)], 0.1) is None
    assert statistics.correlation_time([], 0.1) is None
    assert statistics.error_of_mean([series(1, 5.0, 100)], 0.1, 1.0) is None


def test_jackknife_of_a_mean_is_its_standard_error():
    values = np.random.default_rng(1).normal(size=20)
    replicates = ((values.sum() - values) / 19)[:, None]
    expected = values.std(ddof=1) / np.sqrt(20)
    assert statistics.jackknife_error(replicates)[0] == pytest.approx(expected)


def test_a_line_through_the_origin_covers_its_slope():
    x, scores = np.linspace(1, 5, 6), []
    for seed in range(300):
        errors = np.linspace(0.1, 0.5, 6)
        y = 2.0 * x + errors * np.random.default_rng(seed).normal(size=6)
        line = statistics.line_through_origin(x, y, errors)
        scores.append((line.slope - 2.0) / line.slope_se)
    assert 0.60 < np.mean(np.abs(scores) < 1) < 0.76  # 68 % +- 2.7 %, 3 sigma
