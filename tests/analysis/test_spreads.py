"""Squared displacements: diffusion besides a run, terms that cannot be separated, goodness."""

import math

import numpy as np
import pytest
from synthetic_tracks import Walker, film, film_of

from walkergen.analysis import estimates, interval_laws, motion

SLOW = Walker(speed=15.0, rate=0.8, diffusion=20.0, lost=0.0)
FAST = Walker(speed=45.0, rate=0.8, diffusion=100.0, lost=0.0)
DIFFUSING = Walker(speed=0.0, diffusion=50.0, lost=0.0)
RESTING = Walker(speed=0.0, noise=0.2)
STRAIGHT = Walker(rate=0.01, turn=0.0)
JITTERING = Walker(diffusion=20.0, lost=0.0)
INERTIAL = Walker(inertia=0.1, turn_memory=0.15, lost=0.0)


def analysed(walker, seeds, walkers=8, seconds=20.0, headed=True):
    for seed in range(seeds):
        yield motion.analyse(film(seed, walkers, seconds, walker, 1 / 30, headed))


@pytest.mark.slow
@pytest.mark.parametrize(("walker", "headed"), [(SLOW, False), (FAST, True)])
def test_diffusion_besides_the_run_counts_for_diffusivity_and_is_no_noise(walker, headed):
    truth = {
        "diffusivity": walker.diffusivity,
        "translational_diffusion": walker.diffusion,
        "ballistic_speed": walker.speed,
    }
    inside = {name: [] for name in truth}
    for found in analysed(walker, 20, headed=headed):
        for name, expected in truth.items():
            one = found.estimates[name]
            if one.value is None:
                assert name == "diffusivity"  # 20 s are few times of 1.3 s
                continue
            low, high = one.interval(0.95)
            assert one.se < 0.4 * expected
            inside[name].append(low <= expected <= high)
        noise = found.estimates["localisation_noise"]  # 0.05 mm, in 1.6 mm of diffusion a sample
        assert noise.value is None or noise.value < 4 * noise.se + 0.05
    for name, held in inside.items():
        assert len(held) >= 15, name
        assert np.mean(held) >= 0.8, name  # 95 % less 3 sigma of 20


@pytest.mark.slow
@pytest.mark.parametrize("headed", [True, False])
def test_diffusion_alone_is_not_ballistic(headed):
    inside = []
    for found in analysed(DIFFUSING, 15, headed=headed):
        known = found.estimates
        if known["diffusivity"].known:  # chance makes one in 40 or more look like a run
            low, high = known["diffusivity"].interval(0.95)
            inside.append(low <= DIFFUSING.diffusion <= high)
        assert not found.msd_fit.run
        assert not found.doubts
        for name in ("ballistic_speed", "crossover_time"):
            assert "diffusive" in known[name].refused
        # A run of 1 m/s that turns within a microsecond looks alike: another film tells.
        assert "film more frames" in known["translational_diffusion"].refused
        at_rest = known["speed"]
        assert at_rest.value is None if not headed else abs(at_rest.value) < 6 * at_rest.se
    assert len(inside) >= 10
    assert np.mean(inside) >= 0.75  # 95 % less 3 sigma of 15


def test_a_straight_run_is_ballistic_and_a_resting_walker_is_neither():
    for found in analysed(STRAIGHT, 3, seconds=10.0):
        assert "ballistic" in found.estimates["diffusivity"].refused
        assert found.estimates["ballistic_speed"].value == pytest.approx(30.0, rel=1e-3)
    for found in analysed(RESTING, 3, headed=False):
        known = found.estimates
        for name in ("speed", "ballistic_speed", "diffusivity", "turning_bias"):
            assert known[name].value is None, name
            assert "ballistic" not in known[name].refused
        assert known["localisation_noise"].value == pytest.approx(0.2, rel=0.05)


def test_noise_that_diffusion_could_be_is_refused_with_a_way_to_tell():
    # 0.04 mm of noise, squared 0.006 mm^2, in 0.36 mm^2 of run a sample.
    films = (film(seed, 8, 10.0, Walker(noise=0.04, lost=0.0), 0.02) for seed in range(4))
    reasons = [
        found.estimates[name].refused
        for found in map(motion.analyse, films)
        for name in ("localisation_noise", "translational_diffusion")
        if found.estimates[name].value is None
    ]
    assert any("cannot be separated" in reason and "at rest" in reason for reason in reasons)


def test_a_run_that_only_headings_show_is_not_left_out_of_diffusivity():
    # Pieces of 1 s show lags up to 0.24 s: the jitter alone is 20 mm^2/s, with the run it is 453.
    short = motion.analyse(film(6, 1, 10.0, JITTERING._replace(lost=0.3), 0.04))
    assert not short.msd_fit.run
    assert "do not show what runs add" in short.estimates["diffusivity"].refused
    assert "cannot be separated" in short.estimates["translational_diffusion"].refused
    # One that runs nowhere has no other diffusivity.
    at_rest = motion.analyse(film(1, 3, 20.0, JITTERING._replace(speed=0.0), 0.04))
    assert not at_rest.msd_fit.run
    low, high = at_rest.estimates["diffusivity"].interval()
    assert low < JITTERING.diffusion < high


def test_a_fit_at_its_limit_tells_no_diffusivity():
    at_limit, inside = (motion.analyse(film(seed, 3, 10.0, INERTIAL, 0.04)) for seed in (1, 6))
    assert at_limit.msd_fit.at_its_limit
    for name in ("diffusivity", "crossover_time"):
        assert "the onset of runs" in at_limit.estimates[name].refused
    assert not inside.msd_fit.at_its_limit
    low, high = inside.estimates["diffusivity"].interval()
    assert low < INERTIAL.diffusivity < high


def test_the_error_of_walkers_that_differ_is_that_of_the_same_law_without_each_one():
    walkers = [Walker(speed=speed, rate=2.0, lost=0.0) for speed in (20.0, 30.0, 40.0)]
    found = motion.analyse(film_of(np.random.default_rng(1), walkers, 40.0, 0.04)).estimates
    assert found["speed_scatter"].known
    assert found["ballistic_speed"].freedom == 2
    one = found["diffusivity"]
    # Diffusivities go as the squares 400, 900, 1600: the mean of three is known to 36 %, that of pieces to 20 %.
    assert 0.27 < one.se / one.value < 0.45
    assert one.interval()[0] > 0.0


def test_walkers_that_turn_apart_by_more_than_they_lose_direction_have_no_common_diffusivity():
    walkers = [Walker(turn=turn, lost=0.0) for turn in np.linspace(-0.8, 1.8, 8)]
    found = motion.analyse(film_of(np.random.default_rng(1), walkers, 40.0, 0.04)).estimates
    assert found["turning_scatter"].known
    for name in ("diffusivity", "crossover_time"):
        assert "one by one" in found[name].refused, name
    alone = motion.analyse(film_of(np.random.default_rng(1), walkers[:1], 40.0, 0.04)).estimates["diffusivity"]
    assert abs(alone.value - walkers[0].diffusivity) < 3.5 * alone.se


def diffusivity_told(rate, told_from, freedom):
    """Diffusivity of a walker whose rate was measured as a variance of so many turns, told from one rate on."""
    known = estimates.quantity("diffusivity", 1.0 / rate, math.sqrt(2.0 / freedom) / rate)
    others = ("speed", "persistence_rate", "persistence_time", "persistence_length")
    numbers = {name: estimates.refusal(name, "") for name in others}
    numbers["diffusivity"] = interval_laws.with_detection_limit(known, told_from / rate)
    return interval_laws.with_variance_laws(numbers, run=True)["diffusivity"].interval()


def test_the_upper_bound_of_a_diffusivity_allows_for_its_rate_being_told_where_chance_made_it_large():
    freedom, least = 30, 1.2
    rates = np.random.default_rng(1).chisquare(freedom, 10_000) / freedom  # of 1 per s
    told = rates[rates > least][:1000]
    chosen, all_told = (np.array([diffusivity_told(rate, share, freedom) for rate in told]) for share in (least, 0.0))
    assert np.mean(chosen[:, 1] < 1.0) == pytest.approx(0.025, abs=0.015)  # 3 sigma of 1000
    assert np.mean(all_told[:, 1] < 1.0) > 0.08  # 1 in 40 of all films, which are 1 in 8 of those told
    assert np.array_equal(chosen[:, 0], all_told[:, 0])


@pytest.mark.nightly
def test_the_misfit_is_about_one_where_the_law_holds_and_large_where_it_does_not():
    fits = [found.msd_fit for found in analysed(FAST, 20)]
    assert 0.4 < np.mean([fit.misfit for fit in fits]) < 2.0
    assert np.mean([fit.p_value < 0.05 for fit in fits]) <= 0.2  # 5 % and 3 sigma of 20
    # A dish 80 mm wide, whose walls are mirrors, lets none diffuse beyond it.
    roamer = SLOW._replace(speed=60.0, diffusion=0.0)
    wide, roaming = 40.0, film(1, 16, 40.0, roamer, 1 / 30, headed=False)
    folded = tuple(
        t._replace(position=np.abs((t.position + wide) % (4 * wide) - 2 * wide) - wide) for t in roaming.tracks
    )
    found = motion.analyse(roaming._replace(tracks=folded))
    assert found.msd_fit.misfit > max(fit.misfit for fit in fits)
    assert any("another law" in doubt for doubt in found.doubts)
