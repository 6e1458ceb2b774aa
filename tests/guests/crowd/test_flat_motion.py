"""A walker alone in LAMMPS gives back the numbers of its card."""

import math

import numpy as np
import pytest
from flat_cards import DISC, card, silent, with_lammps

from walkergen.core.dish import Dish
from walkergen.guests.crowd.flat import crowd, crowd_checks, motion

pytestmark = with_lammps


def run(one, side, spacing, seconds, rate_hz, seed=1, turn=0.0):
    """Poses of side x side walkers that are too far apart to meet, shape (F, N, 3)."""
    line = (np.arange(side) - 0.5 * side + 0.5) * spacing
    x, y = np.meshgrid(line, line)
    headings = np.random.default_rng(seed).uniform(-math.pi, math.pi, side**2) + turn
    places = np.column_stack((x.ravel(), y.ravel(), headings))
    kinds = np.zeros(side**2, int)
    dish = Dish("periodic", (side * spacing,))
    return crowd.simulate(
        crowd_checks.make_crowd([one], kinds, dish, places, seconds=seconds, rate_hz=rate_hz, seed=seed)
    )


@pytest.mark.parametrize("aside", [0.05, 0.02])
def test_without_noise_a_walker_runs_circles_at_the_speed_of_its_card_and_lags_by_tau(aside):
    """Closed form: the direction is atan(w0 tau across the heading) behind, its part ahead the speed."""
    one = silent(outline_mm=[DISC], turning_rad_s=4.0, velocity_relaxation_s=0.05, sideways_relaxation_s=aside)
    gone = run(one, 1, 200.0, 1.0, 200.0)
    late = gone.poses[100:, 0]
    rates = (late[2:] - late[:-2]) * 100.0
    lags = late[1:-1, 2] - np.unwrap(np.arctan2(rates[:, 1], rates[:, 0]))
    lag = lags - 2.0 * math.pi * np.round(lags / (2.0 * math.pi))
    ahead = np.hypot(rates[:, 0], rates[:, 1]) * np.cos(lag)
    assert rates[:, 2] == pytest.approx(4.0, rel=1e-4)
    # Half a step of a hundredth of tau is what the integrator is behind
    assert lag == pytest.approx(math.atan(4.0 * aside), rel=6e-3)
    # Differences over 10 ms cut the corner by (w h)^2/6
    assert ahead == pytest.approx(56.0, rel=2e-4)


def test_a_walker_starts_at_rest_and_keeps_a_heading_that_nothing_turns():
    gone = run(silent(outline_mm=[DISC], velocity_relaxation_s=0.1), 1, 200.0, 0.2, 50.0)
    way = np.hypot(*(gone.poses[:, 0, :2] - gone.poses[0, 0, :2]).T)
    assert way == pytest.approx(56.0 * (gone.times - 0.1 * (1.0 - np.exp(-gone.times / 0.1))), abs=0.02)
    assert gone.poses[:, 0, 2] == pytest.approx(gone.poses[0, 0, 2])


def test_speed_is_the_mean_along_a_heading_that_diffuses():
    """The closed form against headings that are drawn: V/tau of past headings, averaged."""
    one = card(velocity_relaxation_s=0.3, turning_rad_s=1.0, rotational_diffusion_rad2_s=1.0)
    rng, step, tau = np.random.default_rng(2), 0.005, 0.3
    rates, heading, velocity, along = np.full(4000, 1.0), np.zeros(4000), np.zeros((2, 4000)), []
    drive = motion.from_card(one).push * tau / 0.9
    for n in range(1600):
        kick = rng.standard_normal(4000)
        rates += (1.0 - rates) * step / tau + math.sqrt(2.0 * step) / tau * kick
        heading += rates * step
        ahead = np.array([np.cos(heading), np.sin(heading)])
        velocity += (drive * ahead - velocity) * step / tau
        if n >= 600:
            along.append((velocity * ahead).sum(axis=0))
    means = np.mean(along, axis=0)
    error = means.std() / math.sqrt(len(means))
    assert abs(means.mean() - 56.0) < 4.0 * error + 0.3  # the step's own error is first order


def test_push_of_a_walker_whose_turning_forgets_at_once_is_the_closed_form_of_cards():
    one = card(turning_rad_s=3.0, turning_relaxation_s=1e-7, velocity_relaxation_s=0.1)
    forces = motion.from_card(one)
    assert forces.push * 0.1 / 0.9 == pytest.approx(one.propulsion_mm_s, rel=1e-5)


@pytest.mark.nightly
def test_speed_diffusion_and_relaxation_of_many_walkers_are_those_of_the_card():
    tau, tau_r = 0.05, 0.04
    one = card(
        outline_mm=[DISC], velocity_relaxation_s=tau, turning_relaxation_s=tau_r, turning_rad_s=0.7, inertia_g_mm2=8.0
    )
    gone = run(one, 20, 400.0, 4.0, 200.0, seed=5)
    poses = gone.poses[100:]  # the start is forgotten after 0.5 s, ten tau
    ahead = np.stack((np.cos(poses[:, :, 2]), np.sin(poses[:, :, 2])), axis=-1)
    rates = (poses[2:, :, :2] - poses[:-2, :, :2]) * 100.0
    speeds = (rates * ahead[1:-1]).sum(axis=-1).mean(axis=0)
    assert agrees(speeds, 56.0, bias=0.1)
    assert agrees((poses[-1, :, 2] - poses[0, :, 2]) / 3.5, 0.7)
    lag = 100
    turns = poses[lag::lag, :, 2] - poses[:-lag:lag, :, 2] - 0.7 * 0.5
    waiting = 0.5 - tau_r * (1.0 - math.exp(-0.5 / tau_r))
    assert agrees((turns**2).mean(axis=0) / (2.0 * waiting), 0.5)
    rest = unexplained(gone.poses, one, tau)[100:]
    for lag in (10, 100):  # of the length of tau, and long: D_T and tau apart
        hops = rest[lag::lag] - rest[:-lag:lag]
        time = lag / 200.0
        waiting = time - tau * (1.0 - math.exp(-time / tau))
        assert agrees((hops**2).mean(axis=(0, 2)) / (2.0 * waiting), 5.0)


def unexplained(poses, one, tau):
    """Displacement that the push along the heading does not explain, shape (F, N, 2)."""
    drive, step = motion.from_card(one).push * tau / one.mass_g, 1.0 / 200.0
    heads = drive * np.stack((np.cos(poses[:, :, 2]), np.sin(poses[:, :, 2])), axis=-1)
    velocity, place = np.zeros_like(heads[0]), np.zeros_like(heads)
    keep = math.exp(-step / tau)
    for n in range(1, len(heads)):
        middle = 0.5 * (heads[n] + heads[n - 1])
        later = middle + (velocity - middle) * keep
        place[n] = place[n - 1] + middle * step + (velocity - middle) * tau * (1.0 - keep)
        velocity = later
    return poses[:, :, :2] - place


def agrees(values, expected, bias=0.0):
    """True where the mean of independent walkers is what is expected, to four standard errors."""
    error = values.std(ddof=1) / math.sqrt(len(values))
    assert error < 0.05 * expected
    assert abs(values.mean() - expected) < 4.0 * error + bias, (values.mean(), error)
    return True


def test_spread_of_turning_from_print_to_print_stays_with_each_walker():
    one = silent(outline_mm=[DISC], turning_rad_s=0.0, turning_sd_rad_s=1.0)
    gone = run(one, 8, 60.0, 0.4, 50.0)
    rates = (gone.poses[-1, :, 2] - gone.poses[10, :, 2]) / 0.2  # by then they have them
    halves = (gone.poses[-1, :, 2] - gone.poses[15, :, 2]) / 0.1
    assert rates == pytest.approx(halves, abs=1e-4)
    assert 0.7 < rates.std() < 1.4
