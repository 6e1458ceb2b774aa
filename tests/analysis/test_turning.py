"""Turning, sideways drift and local exponents of walkers of which everything is known."""

import numpy as np
import pytest
from synthetic_tracks import Walker, film

from walkergen.analysis import motion, persistent_walk, turning
from walkergen.analysis.persistent_walk import Spread
from walkergen.core.numerics.quantity import Quantity, exact

SPEED, DRIFT, TURN, SCATTER, D_R = 60.0, 4.0, 0.8, 1.5, 0.1
"""mm/s ahead and to the left, rad/s of all and between walkers, rad^2/s."""

INTERVAL = 0.02

NOISELESS, AT_ONCE = exact("noise", "rad2", 0.0), exact("memory", "s", 0.0)

EXACT = Walker(speed=SPEED, drift=DRIFT, turn=TURN, turn_sd=SCATTER, rate=D_R, noise=0.0, heading_noise=0.0, lost=0.0)


def wanderers(seed, walkers=16, seconds=8.0, scatter=SCATTER, diffusion=D_R, noise=0.0):
    one = EXACT._replace(turn_sd=scatter, rate=diffusion, heading_noise=noise)
    return film(seed, walkers, seconds, one, INTERVAL)


def scatter_of(tracks):
    return turning.scatter(turning.walker_turnings(tracks.tracks, tracks.interval))


def diffusion_of(tracks, noise2=NOISELESS, memory=AT_ONCE):
    return turning.diffusion(turning.walker_turnings(tracks.tracks, tracks.interval), noise2, memory)


def test_drift_turning_and_scatter_are_those_put_in():
    found = motion.analyse(wanderers(1, seconds=10.0))
    for name, expected in (
        ("speed", SPEED),
        ("sideways_speed", DRIFT),
        ("turning_bias", TURN),
        ("turning_scatter", SCATTER),
        ("rotational_diffusion", D_R),
    ):
        one = found.estimates[name]
        assert one.value is not None, (name, one.refused)
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
    told = [scatter_of(wanderers(seed, scatter=0.0)) for seed in range(40)]
    # One in a hundred is resolved by chance: more than 3 of 40 in one of 1600 test suites.
    assert sum(one.value is not None for one in told) <= 3
    assert all("not resolved: " in one.refused for one in told if one.value is None)
    bounds = [float(one.refused.split()[3]) for one in told if "not resolved: below" in one.refused]
    assert len(bounds) > 32  # one in twenty is smaller than the errors make it, and has none: 8 of 40 never
    assert max(bounds) < 0.5  # rad/s; chance alone gives sqrt(2 D_r / 8 s) = 0.16


def test_errors_of_scatter_and_diffusion_cover_the_truth():
    scores = []
    for seed in range(40):
        tracks = wanderers(seed, seconds=4.0)
        found = scatter_of(tracks), diffusion_of(tracks)
        scores.append([(one.value - true) / one.se for one, true in zip(found, (SCATTER, D_R))])  # noqa: B905
    scores = np.array(scores)
    # 68 % +- 7.4 % of 40, 3 sigma, and less for the skewness of variances.
    assert ((np.abs(scores) < 1).mean(axis=0) > 0.42).all()
    assert (np.abs(scores.mean(axis=0)) < 0.6).all()


@pytest.mark.parametrize("lost", [0.0, 0.5])
def test_noise_of_headings_is_no_diffusion(lost):
    noisy = EXACT._replace(heading_noise=0.1, lost=lost)
    tracks = film(3, 60, 8.0, noisy, INTERVAL)
    one = diffusion_of(tracks, exact("noise", "rad2", 0.1**2))
    assert abs(one.value - D_R) < 3.5 * one.se
    if not lost:
        # n pieces of t s that share their ends raise it by noise^2 (n + 1) / (n t): n = 8, t = 1 s.
        assert diffusion_of(tracks).value - one.value == pytest.approx(0.01 * 9 / 8)


def test_turning_below_the_error_of_the_noise_is_refused_and_has_no_bounds():
    """A variance with far less than one degree of freedom would have an infinite bound, which no report can hold."""
    turnings = [turning.Turning(number, 0.1, 1e-9, 12, 3.0, 90.0) for number in range(4)]
    for se in np.geomspace(1e-13, 1e-6, 50):
        found = turning.diffusion(turnings, Quantity("noise", "rad2", 1e-12, float(se)), AT_ONCE)
        assert (found.value is None) == ("headings turn less" in found.refused)
        assert found.value is None or found.interval()[1] < 1e4 * found.value
    assert found.value is None


def test_turning_that_lasts_takes_its_time_off_each_piece():
    lasting = EXACT._replace(rate=1.0, turn_sd=0.0, turn_memory=0.2)
    tracks = film(7, 60, 8.0, lasting, INTERVAL)
    one = diffusion_of(tracks, memory=Quantity("memory", "s", 0.2, 0.02))
    assert abs(one.value - 1.0) < 3.5 * one.se
    # Of 8 pieces of 1 s about their mean: 0.2 s (1 + 1/8) of each.
    plain = diffusion_of(tracks)
    assert plain.value / one.value == pytest.approx(1.0 - 0.2 * 9 / 8)
    assert plain.value < 1.0 - 3.0 * plain.se
    # 0.02 s of some 0.8 s are known besides.
    assert one.se / one.value == pytest.approx(np.hypot(plain.se / plain.value, 0.02 * 9 / 8 / 0.775))
    assert "film for longer" in diffusion_of(tracks, memory=exact("memory", "s", 0.5)).refused
    assert diffusion_of(tracks, memory=Quantity("memory", "s", 0.5, 1.0)) == plain  # anyone's guess


GAPS = {"one by one": 0.0, "short blocks": 8.0, "long blocks": 60.0}
BY_DAY = (0.5, 60.0)
"""Share and gaps of the quick suite; each takes five seconds."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kept", "gap"),
    [
        pytest.param(kept, gap, id=f"{kept}-{name}", marks=[pytest.mark.nightly] * ((kept, gap) != BY_DAY))
        for kept in (0.95, 0.85, 0.75, 0.5)
        for name, gap in GAPS.items()
    ],
)
def test_frames_that_are_missing_change_neither_diffusion_nor_scatter(kept, gap):
    walker = EXACT._replace(rate=0.8, lost=1.0 - kept, gap=gap)
    scores = []
    for seed in range(20):
        found = motion.analyse(film(seed, 10, 20.0, walker, 0.04)).estimates
        truth = (("rotational_diffusion", 0.8), ("turning_scatter", SCATTER), ("persistence_rate", 0.8))
        scores.append([(found[name].value - true) / found[name].se for name, true in truth])
    scores = np.array(scores)
    # Means of 20 scores are off by 0.22, and by another 0.3 as errors grow with the variances.
    assert (np.abs(scores.mean(axis=0)) < 0.95).all(), scores.mean(axis=0)
    assert (np.abs(scores) < 3.5).mean() > 0.95


def test_a_turn_within_a_gap_may_be_more_than_half_a_turn():
    # 5 rad/s over gaps of 1 s and more.
    steady = EXACT._replace(turn=5.0, turn_sd=0.0, lost=0.4, gap=25.0)
    (one,) = turning.walker_turnings(film(6, 1, 40.0, steady, 0.04).tracks, 0.04)
    assert one.seconds == pytest.approx(40.0, rel=0.1)  # no turn was left out
    assert one.rate == pytest.approx(5.0, abs=3.5 * np.sqrt(2 * D_R / 40.0))


def test_few_walkers_have_a_scatter_and_a_lone_one_the_reason_for_none():
    scores = []
    for seed in range(40):
        one = scatter_of(wanderers(seed, walkers=3, seconds=16.0))
        if one.value is not None:
            low, high = one.interval(0.95)
            scores.append(low < SCATTER < high)
    # Of scatters of 1.5 rad/s, against 0.1 by diffusion, one in forty is too small to be resolved.
    assert len(scores) >= 36
    assert np.mean(scores) > 0.85
    lone = motion.analyse(wanderers(4, walkers=1)).estimates
    assert "1 walkers" in lone["turning_scatter"].refused
    assert "at least 8" in lone["rotational_diffusion"].refused


def test_the_local_exponent_of_a_power_law_is_its_power():
    lags = np.unique(np.rint(np.geomspace(1, 500, 40)).astype(int))
    for power in (1.0, 1.5, 2.0):
        found = motion._local_exponents(lags, 3.0 * lags**power)
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
    found = motion._local_exponents(
        lags, persistent_walk.squared_displacement(0.02 * lags, Spread(1.0, 2.0, 0.0, 0.0, TURN))
    )
    known = ~np.isnan(found)
    # Lines through the same lags, which lie unevenly on the scale of logarithms, are 0.02 off.
    np.testing.assert_allclose(found[known], _exact_exponent(0.02 * lags)[known], atol=0.01)


def _exact_exponent(lag):
    up, down = (
        persistent_walk.squared_displacement(lag * f, Spread(1.0, 2.0, 0.0, 0.0, TURN)) for f in (1.001, 1 / 1.001)
    )
    return np.log(up / down) / (2 * np.log(1.001))


@pytest.mark.nightly
def test_persistence_holds_where_a_film_does_not_tell_that_turning_lasts():
    walker = Walker(inertia=0.1, turn_memory=0.15)
    inside = []
    for seed in range(16):
        tracks = film(seed, 3, 20.0, walker, 0.04)
        low, high = motion.analyse(tracks).estimates["persistence_rate"].interval(0.95)
        inside.append(low < walker.rate < high)
    # Of ensembles with 93 % one in 250 has fewer. Exponentials in place of open memories had 8.
    assert sum(inside) >= 12


def test_a_memory_that_a_film_leaves_open_has_a_bound():
    found = motion.analyse(film(1, 1, 40.0, Walker(), 0.04)).estimates
    assert "not resolved: below 0." in found["turning_memory"].refused
    assert found["persistence_rate"].se < 0.3
    # Of many frames the memory is known to be none, and an exponential has the smaller error.
    found = motion.analyse(film(1, 16, 60.0, Walker(), 0.04)).estimates
    assert "from the first on" in found["turning_memory"].refused
    assert found["persistence_rate"].se < 0.05
