"""Turning, sideways drift and local exponents of walkers of which everything is known."""

import numpy as np
import pytest
from synthetic_tracks import Walker, film

from walkergen.analysis import motion, turning, walks
from walkergen.analysis.walks import Spread

SPEED, DRIFT, TURN, SCATTER, D_R = 60.0, 4.0, 0.8, 1.5, 0.1
"""mm/s ahead and to the left, rad/s of all and between walkers, rad^2/s."""

INTERVAL = 0.02

EXACT = Walker(
    speed=SPEED, drift=DRIFT, turn=TURN, turn_sd=SCATTER, rate=D_R,
    noise=0.0, heading_noise=0.0, lost=0.0,
)  # fmt: skip


def wanderers(seed, walkers=16, seconds=8.0, scatter=SCATTER, diffusion=D_R, noise=0.0):
    one = EXACT._replace(turn_sd=scatter, rate=diffusion, heading_noise=noise)
    return film(seed, walkers, seconds, one, INTERVAL)


def test_drift_turning_and_scatter_are_those_put_in():
    found = motion.analyse(wanderers(1))
    for name, expected in (
        ("speed", SPEED), ("sideways_speed", DRIFT), ("turning_bias", TURN),
        ("turning_scatter", SCATTER), ("rotational_diffusion", D_R),
    ):  # fmt: skip
        one = found.estimates[name]
        assert one.value is not None, (name, one.reason)
        assert abs(one.value - expected) < 3.5 * one.se, (name, one)
        assert 0 < one.se < 0.5 * expected, name
    assert any("rates of their own" in doubt for doubt in found.doubts)
    # What the group loses by turning apart is no diffusion: an exponential alone has 1.3 per s.
    for name, expected in (("persistence_time", 1 / D_R), ("persistence_length", SPEED / D_R)):
        one = found.estimates[name]
        assert abs(one.value - expected) < 3.5 * one.se, (name, one)
        assert one.se < 0.3 * expected, name


def test_a_walker_that_turns_steadily_does_not_drift_sideways():
    found = wanderers(2, scatter=0.0)
    still = [t._replace(position=t.position - _drifted(t)) for t in found.tracks]
    one = motion.analyse(found._replace(tracks=tuple(still))).estimates["sideways_speed"]
    assert abs(one.value) < 3.5 * one.se
    # Headings at the start of an interval alone would give SPEED TURN INTERVAL / 2 = 0.48 mm/s.
    assert one.se < 0.05


def _drifted(track):
    unit = np.exp(1j * track.heading)
    way = np.cumsum(1j * DRIFT * INTERVAL * 0.5 * (unit[1:] + unit[:-1]))
    return np.stack([np.append(0, way.real), np.append(0, way.imag)], axis=1)


def test_diffusion_alone_is_no_scatter():
    told = [turning.scatter(wanderers(seed, scatter=0.0).tracks, INTERVAL) for seed in range(40)]
    # One in a hundred is resolved by chance: more than 3 of 40 in one of 1600 test suites.
    assert sum(one.value is not None for one in told) <= 3
    assert all("not resolved: below" in one.reason for one in told if one.value is None)
    bounds = [float(one.reason.split()[3]) for one in told if one.value is None]
    assert max(bounds) < 0.5  # rad/s; chance alone gives sqrt(2 D_r / 8 s) = 0.16


def test_errors_of_scatter_and_diffusion_cover_the_truth():
    scores = []
    for seed in range(40):
        tracks = wanderers(seed, seconds=4.0).tracks
        found = turning.scatter(tracks, INTERVAL), turning.diffusion(tracks, INTERVAL, 0.0)
        scores.append([(one.value - true) / one.se for one, true in zip(found, (SCATTER, D_R))])  # noqa: B905
    scores = np.array(scores)
    # 68 % +- 7.4 % of 40, 3 sigma, and less for the skewness of variances.
    assert ((np.abs(scores) < 1).mean(axis=0) > 0.42).all()
    assert (np.abs(scores.mean(axis=0)) < 0.6).all()


def test_noise_of_headings_is_no_diffusion():
    tracks = wanderers(3, walkers=60, noise=0.1).tracks
    one = turning.diffusion(tracks, INTERVAL, 0.1)
    assert abs(one.value - D_R) < 3.5 * one.se
    assert turning.diffusion(tracks, INTERVAL, 0.0).value - one.value == pytest.approx(0.01)


def test_few_walkers_are_refused_with_the_reason():
    found = motion.analyse(wanderers(4, walkers=3)).estimates
    assert "3 walkers" in found["turning_scatter"].reason
    assert found["rotational_diffusion"].value is not None  # 21 degrees of freedom
    lone = motion.analyse(wanderers(4, walkers=1)).estimates["rotational_diffusion"]
    assert "at least 8" in lone.reason


def test_the_local_exponent_of_a_power_law_is_its_power():
    lags = np.unique(np.rint(np.geomspace(1, 500, 40)).astype(int))
    for power in (1.0, 1.5, 2.0):
        found = motion._exponents(lags, 3.0 * lags**power)
        known = ~np.isnan(found)
        np.testing.assert_allclose(found[known], power, rtol=1e-12)
        assert known.sum() == 30  # of 34
        assert np.isnan(found[[0, -1]]).all()  # no lag beyond the ends


def test_local_exponents_fall_from_ballistic_to_diffusive_as_the_walk_says():
    found = motion.analyse(wanderers(5, walkers=40, seconds=20.0, scatter=0.0, diffusion=2.0))
    at, value, se = found.exponent
    exact = _exact_exponent(at)
    known = np.isfinite(value) & np.isfinite(se)
    assert known.sum() > 20
    assert np.all(np.abs(value - exact)[known] < 4.5 * se[known] + 0.005)  # parabolas: 0.005
    assert value[known][0] > 1.9
    assert value[known][-1] < 1.2
    assert np.array_equal(at, found.msd.at)


def test_local_exponents_follow_the_curvature():
    lags = np.unique(np.rint(np.geomspace(1, 300, 60)).astype(int))
    found = motion._exponents(lags, walks.squared(0.02 * lags, Spread(1.0, 2.0, 0.0, 0.0, TURN)))
    known = ~np.isnan(found)
    # Lines through the same lags, which lie unevenly on the scale of logarithms, are 0.02 off.
    np.testing.assert_allclose(found[known], _exact_exponent(0.02 * lags)[known], atol=0.01)


def _exact_exponent(lag):
    up, down = (
        walks.squared(lag * f, Spread(1.0, 2.0, 0.0, 0.0, TURN)) for f in (1.001, 1 / 1.001)
    )
    return np.log(up / down) / (2 * np.log(1.001))
