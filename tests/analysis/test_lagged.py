"""Sums over lags: by transform as by hand, with gaps, and as trackpy has them."""

import warnings

import numpy as np
import pytest
from synthetic_tracks import Walker, film, track

from walkergen.analysis import lag_sums

LAGS = np.array([1, 2, 3, 7, 20, 55, 180, 300])


def naive_squares(position, lag):
    moved = ((position[lag:] - position[:-lag]) ** 2).sum(axis=1)
    return np.nansum(moved), np.count_nonzero(~np.isnan(moved))


@pytest.mark.parametrize("lost", [0.0, 0.3])
@pytest.mark.parametrize("dimensions", [1, 2])
def test_squares_equal_the_naive_double_loop(lost, dimensions):
    one = track(np.random.default_rng(1), Walker(lost=lost), 250, 0.01)
    position = one.position[:, :dimensions] + 1e4  # far from the origin: digits may not be lost
    found, pairs = lag_sums.sum_squares(position, LAGS)
    for place, lag in enumerate(LAGS):
        expected, count = naive_squares(position, lag) if lag < 250 else (0.0, 0)
        assert pairs[place] == count
        # 1e4 mm from the origin at 1e-16: 1e-12 of a displacement of 1 mm.
        assert found[place] == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_a_long_straight_run_keeps_the_digits_of_its_short_lags():
    rng = np.random.default_rng(2)
    times = np.arange(200_000)
    position = (0.12 * times + 1e-3 * rng.normal(size=times.size))[:, None]
    found, pairs = lag_sums.sum_squares(position, np.array([1]))
    expected, _ = naive_squares(position, 1)
    assert found[0] / pairs[0] == pytest.approx(expected / pairs[0], rel=1e-9)


def test_products_equal_the_naive_sum():
    one = track(np.random.default_rng(3), Walker(lost=0.2), 250, 0.01)
    unit = np.exp(1j * one.heading)
    found, pairs = lag_sums.sum_products(unit, LAGS)
    for place, lag in enumerate(LAGS):
        expected = np.conj(unit[:-lag]) * unit[lag:] if lag < 250 else np.zeros(0)
        assert pairs[place] == np.count_nonzero(~np.isnan(expected))
        assert found[place] == pytest.approx(np.nansum(expected), abs=1e-10)


def test_mean_squared_displacement_equals_trackpys():
    import pandas as pd
    import trackpy

    filmed = film(4, 3, 3.0, Walker(lost=0.1))
    frames = [
        pd.DataFrame(one.position, columns=["x", "y"]).rename_axis("frame").reset_index().assign(particle=one.particle)
        for one in filmed.tracks
    ]
    lags = np.arange(1, 80)
    sums = [lag_sums.sum_squares(one.position, lags) for one in filmed.tracks]
    with warnings.catch_warnings(action="ignore"):  # trackpy calls pandas in ways it deprecates
        each = trackpy.imsd(pd.concat(frames).dropna(), mpp=1.0, fps=100.0, max_lagtime=79)
        pooled = trackpy.emsd(pd.concat(frames).dropna(), mpp=1.0, fps=100.0, max_lagtime=5).to_numpy()
    for one, (total, pairs) in zip(filmed.tracks, sums, strict=True):
        np.testing.assert_allclose(total / pairs, each[one.particle].to_numpy(), rtol=1e-9)
    # trackpy weighs particles by effective numbers of pairs that all have in common at small lags.
    ours = sum(total for total, _ in sums) / sum(pairs for _, pairs in sums)
    np.testing.assert_allclose(ours[:5], pooled, rtol=2e-3)


def test_lags_are_spread_evenly_and_stay_within():
    lags = lag_sums.log_spaced_lags(1000, 30, 5)
    assert (lags[0], lags[-1]) == (5, 1000)
    assert (np.diff(lags) > 0).all()
    assert len(lag_sums.log_spaced_lags(3, 30, 5)) == 0
