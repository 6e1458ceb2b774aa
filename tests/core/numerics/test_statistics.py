"""Errors of means, of jackknife estimates and of a slope."""

import numpy as np
import pytest
from scipy import stats

from walkergen.analysis import line
from walkergen.core.numerics import quantity, statistics
from walkergen.core.numerics.quantity import Quantity


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


def test_a_mean_of_equal_weights_has_the_textbook_error_and_interval():
    values = np.random.default_rng(3).normal(size=5)
    mean = quantity.mean("x", "", values)
    assert mean.value == pytest.approx(values.mean())
    assert mean.se == pytest.approx(values.std(ddof=1) / np.sqrt(5))
    assert mean.freedom == pytest.approx(4.0)
    low, high = mean.interval(0.95)
    # 2.776: Student's t of 4 degrees of freedom, from printed tables
    assert (low, high) == pytest.approx((mean.value - 2.776 * mean.se, mean.value + 2.776 * mean.se), rel=1e-3)


def test_a_mean_over_unequal_times_weighs_them_and_covers_the_truth():
    rng = np.random.default_rng(4)
    times = np.array([1.0, 1.0, 2.0, 4.0, 8.0, 8.0])
    errors, means, inside = [], [], []
    for _ in range(4000):
        mean = Quantity("x", "", *statistics.weighted_mean(rng.normal(size=6) / np.sqrt(times), times))
        low, high = mean.interval(0.95)
        means.append(mean.value)
        errors.append(mean.se**2)
        inside.append(low < 0.0 < high)
    assert np.var(means) == pytest.approx(1 / 24, rel=0.07)  # weights by times are the best
    # Squared errors have no bias: 4000 of them know their mean to 1.3 % (freedom 2.8).
    assert np.mean(errors) == pytest.approx(1 / 24, rel=0.04)
    assert 0.93 < np.mean(inside) < 0.97


def test_changes_slower_than_a_series_are_in_the_correlation_time():
    """Series of 10 s whose mean changes within 100 s: about their own means none of it is left."""
    rng = np.random.default_rng(5)
    noise = rng.normal(size=(8, 100))
    assert statistics.correlation_time(list(noise), 0.1) < 0.1
    levels = 5.0 * rng.normal(size=(8, 1))
    assert statistics.correlation_time(list(noise + levels), 0.1) is None


def test_the_correlation_time_of_short_series_of_unequal_length_is_that_of_their_process():
    values = series(6, 2.0, 300_000)
    cut = np.split(values, np.cumsum(np.random.default_rng(7).integers(32, 40, 8300)))
    # Closed form of a first-order process with a memory of 2 values: 1/(2 tanh(1/4)). 300 000
    # values know it to 1.2 %, and the window leaves out 0.7 %; products over all values instead
    # of over all pairs would be 6 % low.
    expected = 0.1 * 0.5 / np.tanh(0.25)
    assert statistics.correlation_time(cut, 0.1) == pytest.approx(expected, rel=0.04)


def test_the_correlation_time_of_few_values_is_right_on_average():
    pieces = series(6, 2.0, 128_000).reshape(-1, 8, 40)
    times = [statistics.correlation_time(list(few), 0.1) for few in pieces]
    known = [time for time in times if time is not None]
    assert len(known) > 0.9 * len(times)
    # 400 ensembles know it to 2 %; without the correction for the mean's error it is 8 % low.
    assert np.mean(known) == pytest.approx(0.1 * 0.5 / np.tanh(0.25), rel=0.05)


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
        fitted = line.line_through_origin(x, y, errors)
        scores.append((fitted.slope.value - 2.0) / fitted.slope.se)
    assert 0.60 < np.mean(np.abs(scores) < 1) < 0.76  # 68 % +- 2.7 %, 3 sigma


@pytest.mark.parametrize("count", [16, 24, 38])
@pytest.mark.parametrize(
    "law",
    [stats.norm(), stats.lognorm(0.6), stats.expon(), stats.triang(1.0), stats.uniform()],
    ids=["normal", "lognormal", "exponential", "triangular", "uniform"],
)
def test_bounds_from_few_values_hold_another_as_often_as_they_say(count, law):
    """2000 ensembles: the least and the largest of 16 and 24 hold 88 and 92 %, not 95."""
    rng = np.random.default_rng(count)
    ends = [
        statistics.prediction_quantiles(values, (0.025, 0.16, 0.84, 0.975))
        for values in law.rvs((2000, count), random_state=rng)
    ]
    low2, low1, high1, high2 = law.cdf(np.array(ends)).mean(axis=0)
    assert 0.937 < high2 - low2 < 0.985  # 2000 means know it to 0.1 %
    assert high1 - low1 == pytest.approx(0.68, abs=0.015)


def test_from_39_values_on_bounds_of_95_percent_are_order_statistics():
    values = np.random.default_rng(6).normal(size=statistics.MIN_VALUES_FOR_95)
    ends = statistics.prediction_quantiles(values, (0.025, 0.5, 0.975))
    assert ends == pytest.approx([values.min(), np.median(values), values.max()])
    fewer = statistics.prediction_quantiles(values[:38], (0.025, 0.975))
    assert fewer[0] < values[:38].min() < values[:38].max() < fewer[1]
