"""The generators of tracks against the laws that they are to follow."""

import numpy as np
import pytest
from synthetic_tracks import Walker, film, lane, lost_frames

KINDS = {
    "abp": Walker(),
    "chiral": Walker(turn=2.0, drift=5.0),
    "inertial": Walker(inertia=0.3, turn_memory=0.2, turn=0.5),
    "jittering": Walker(speed=10.0, diffusion=40.0),
    "diffusing": Walker(speed=0.0, diffusion=15.0),
}


@pytest.mark.parametrize("kind", KINDS)
def test_walkers_spread_and_turn_as_their_laws_say(kind):
    walker = KINDS[kind]._replace(lost=0.0, noise=0.0, heading_noise=0.0)
    made = film(1, 400, 16.0, walker, interval=0.1).tracks
    place = np.stack([one.position @ [1, 1j] for one in made])
    unit = np.exp(1j * np.stack([one.heading for one in made]))
    half = place.shape[1] // 2
    # The slope of the squared displacement, once persistence and inertia are forgotten: 4 D.
    way = [np.abs(place[:, lag] - place[:, 0]) ** 2 for lag in (half, 2 * half)]
    slopes = (way[1] - way[0]) / (0.1 * half)
    error = slopes.std() / 20.0
    assert slopes.mean() == pytest.approx(4 * walker.diffusivity, abs=3.5 * error)
    for lag in (1, 5, 20):
        turned = unit[:, lag] * np.conj(unit[:, 0]) * np.exp(-0.1j * walker.turn * lag)
        error = turned.real.std() / 20.0
        assert turned.real.mean() == pytest.approx(walker.heading_correlation(0.1 * lag), abs=3.5 * error)
    # Velocities over two frames about the heading between: a second-order mean of the present one.
    ahead = ((place[:, 2::10] - place[:, :-2:10]) / 0.2 * np.conj(unit[:, 1:-1:10])).mean(axis=1)
    for found, law in ((ahead.real, walker.ahead.real), (ahead.imag, walker.ahead.imag)):
        # Half a turn of 0.2 s is not seen: 4 % at 2 rad/s and 1 rad^2/s.
        assert found.mean() == pytest.approx(law, abs=3.5 * found.std() / 20 + 0.055 * walker.speed)


@pytest.mark.parametrize(("gap", "mean"), [(0.0, 1 / 0.7), (25.0, 25.0)], ids=["random", "blocks"])
def test_frames_are_lost_in_the_stated_share_and_length(gap, mean):
    lost = lost_frames(np.random.default_rng(2), Walker(lost=0.3, gap=gap), 400_000)
    begins = np.count_nonzero(np.diff(lost.astype(int)) == 1)
    assert lost.mean() == pytest.approx(0.3, abs=0.02)
    assert lost.sum() / begins == pytest.approx(mean, rel=0.05)


def test_walkers_differ_by_the_stated_spread():
    clean = Walker(rate=0.0, noise=0.0, heading_noise=0.0, lost=0.0, speed_sd=3.0, turn_sd=0.5)
    made = film(3, 400, 1.0, clean, interval=0.1).tracks
    turns = np.array([one.heading[-1] - one.heading[0] for one in made])
    way = np.array([np.abs(np.diff(one.position @ [1, 1j])).sum() for one in made])
    # Standard deviations of 400: +- 3.5 %. Chords are shorter than arcs by 1e-3 of themselves.
    assert (turns.mean(), turns.std()) == pytest.approx((0.2, 0.5), abs=0.09)
    assert (way.mean(), way.std()) == pytest.approx((30.0, 3.0), abs=0.54)


def test_speeds_in_a_lane_fluctuate_about_their_own():
    made = lane(5, [40.0, 80.0], 200_000, memory=4.0, sd=10.0).tracks
    for one, speed in zip(made, (40.0, 80.0), strict=True):
        speeds = np.diff(one.position[:, 0]) / 0.01
        assert speeds.mean() == pytest.approx(speed, abs=3.5 * 10.0 * np.sqrt(8.0 / 200_000))
        assert speeds.std() == pytest.approx(10.0, rel=0.03)
        neighbours = np.corrcoef(speeds[:-1], speeds[1:])[0, 1]
        assert neighbours == pytest.approx(np.exp(-0.25), abs=0.02)
