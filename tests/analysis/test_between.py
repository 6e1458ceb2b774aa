"""Few walkers that differ: a speed each, their mean with an honest error, what limits it."""

import json

import numpy as np
import pytest
from synthetic_tracks import Walker, film, film_of, lane
from typer.testing import CliRunner

from walkergen.analysis import motion, particle_scatter
from walkergen.cli import command_line

SPEEDS = (45.0, 65.0, 85.0)
CLEAN = Walker(rate=0.8, noise=0.0, heading_noise=0.0, lost=0.0)


def three(kind, seed=1, seconds=20.0, speeds=SPEEDS):
    if kind == "lane":
        return lane(seed, speeds, round(50 * seconds), interval=0.02, memory=2.0, sd=10.0)
    rng, walkers = np.random.default_rng(seed), [CLEAN._replace(speed=one) for one in speeds]
    return film_of(rng, walkers, seconds, 0.02, headed=kind == "headings")


@pytest.mark.parametrize("kind", ["headings", "no headings", "lane"])
@pytest.mark.parametrize("speeds", [SPEEDS, (63.0, 65.0, 67.0), (50.0, 80.0)])
def test_unlike_walkers_have_speeds_of_their_own_and_a_mean(kind, speeds):
    found = motion.analyse(three(kind, speeds=speeds))
    mean, scatter = found.estimates["speed"], found.estimates["speed_scatter"]
    for one, speed in zip(found.walkers, speeds, strict=True):
        estimate = one.mean("speed")
        # 99.9 % by t with 9 degrees of freedom: 4.8.
        assert estimate.value == pytest.approx(speed, abs=4.8 * estimate.se + 1e-3)
        assert estimate.se < 1.5
    assert mean.freedom == len(speeds) - 1
    assert mean.value == pytest.approx(np.mean(speeds), abs=2.0)  # 10 mm/s over 3 x 20 s in a lane
    if np.ptp(speeds) > 10.0:
        assert mean.se == pytest.approx(np.std(speeds, ddof=1) / np.sqrt(len(speeds)), rel=0.15)
        low, high = scatter.interval(0.95)
        assert low < np.std(speeds, ddof=1) < high
        assert "more walkers" in found.method


@pytest.mark.parametrize(
    ("walkers", "headed"),
    [
        pytest.param(walkers, headed, marks=pytest.mark.slow if walkers == 7 else pytest.mark.nightly)
        for walkers, headed in [(2, True), (3, True), (7, False), (12, False)]
    ],
)
def test_the_mean_over_unlike_walkers_covers_that_of_all_prints(walkers, headed):
    prints = Walker(speed=60.0, speed_sd=6.0, turn=0.5, turn_sd=0.5, rate=0.8)
    truth = {"speed": 60.0, "speed_scatter": 6.0, "turning_bias": 0.5}
    if not headed:
        del truth["turning_bias"]  # without headings, over pieces
    inside = {name: [] for name in truth}
    for seed in range(40):
        found = motion.analyse(film(seed, walkers, 8.0, prints, 0.04, headed)).estimates
        for name, expected in truth.items():
            if found[name].value is not None:
                low, high = found[name].interval(0.95)
                inside[name].append(low < expected < high)
    assert len(inside["speed"]) == 40
    for name, values in inside.items():
        # 95 % +- 3.4 % of 40 films, 3 sigma; scatters that are resolved are the larger ones.
        assert np.mean(values) > 0.85, (name, np.mean(values))


def test_alike_walkers_are_limited_by_their_tracks():
    found = motion.analyse(lane(3, [60.0] * 4, 500))
    assert "film for longer" in found.method
    assert "not resolved: below" in found.estimates["speed_scatter"].refused
    assert found.estimates["speed"].value == pytest.approx(60.0, abs=4 * 2.0)


@pytest.mark.slow
def test_walkers_that_differ_keep_their_persistence_and_diffusion():
    # Turning rates 2 rad/s apart: a common correlation would vanish within a second.
    walkers = [CLEAN._replace(speed=v, turn=t) for v, t in zip(SPEEDS, (-2, 0, 2), strict=True)]
    scores = []
    for seed in range(12):
        made = film_of(np.random.default_rng(seed), walkers, 30.0, 0.04)
        found = motion.analyse(made).estimates
        names = ("persistence_rate", "rotational_diffusion")
        scores.append([(found[name].value - 0.8) / found[name].se for name in names])
        assert found["speed"].value == pytest.approx(65.0, rel=2e-3)  # headings are exact
    assert (np.abs(np.mean(scores, axis=0)) < 1.1).all()  # 0.29, and as of gaps in test_turning
    assert (np.abs(scores) < 3.5).mean() > 0.95


@pytest.mark.parametrize("speeds", [(60.0,) * 4, (40.0, 55.0, 65.0, 80.0)], ids=["alike", "unlike"])
def test_the_spread_in_a_lane_is_about_each_ones_own_speed(speeds):
    memory, sd, interval = 5.0, 30.0, 0.01
    kept = np.exp(-1 / memory)
    # Of a sum of steps that are correlated as kept^n: sd^2 interval (1 + kept) / (1 - kept) / 2.
    truth = 0.5 * sd**2 * interval * (1 + kept) / (1 - kept)
    scores = []
    for seed in range(30):
        one = motion.analyse(lane(seed, speeds, 1500, memory=memory)).estimates["diffusivity"]
        scores.append((one.value - truth) / one.se)
    assert abs(np.mean(scores)) < 0.8  # 0.18 by chance, and as the error grows with the value
    assert np.mean(np.abs(scores) < 2.3) > 0.8


@pytest.mark.nightly
def test_a_pure_jitter_without_headings_has_no_speed_of_its_own():
    still = Walker(speed=0.0, noise=0.3)
    films = [film(seed, 3, 10.0, still, 0.02, headed=False) for seed in range(10)]
    speeds = [one.mean("speed") for made in films for one in motion.analyse(made).walkers]
    # Beyond 3 standard errors of 9 degrees of freedom lies one in 130: 3 of 30 never.
    assert sum(one.value is not None for one in speeds) < 3
    assert sum("no lasting direction" in one.refused for one in speeds) > 15  # others lack a fit


def test_a_spread_of_normal_values_covers_the_one_put_in():
    rng, inside = np.random.default_rng(5), []
    for _ in range(400):
        values = rng.normal(0.0, np.hypot(3.0, 0.5), size=4)
        one = particle_scatter.walker_scatter("speed_scatter", values, 0.25, 30.0)
        if one.value is not None:
            low, high = one.interval(0.95)
            inside.append(low < 3.0 < high)
    assert len(inside) > 360
    assert np.mean(inside) > 0.95 - 3.5 * 0.011  # those too small to be resolved are left out


@pytest.mark.slow
def test_one_command_gives_three_speeds_and_their_mean(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    made = three("headings")
    lines = [
        f"{frame},{one.particle},{x:.9g},{y:.9g},{theta:.9g}\n"
        for one in made.tracks
        for frame, ((x, y), theta) in enumerate(zip(one.position, one.heading, strict=True))
    ]
    (tmp_path / "three.csv").write_text("frame,particle,x,y,theta\n" + "".join(lines))
    units = ("--fps", "50", "--mm-per-px", "1")
    result = CliRunner().invoke(command_line, ["analyse", "three.csv", *units, "--json"])
    assert result.exit_code == 0, result.exception
    data = json.loads(result.stdout)
    assert [one["speed_mm_s"] for one in data["walkers"]] == pytest.approx(SPEEDS, rel=1e-3)
    assert data["speed_low_95_mm_s"] < 65.0 < data["speed_high_95_mm_s"]
    assert (tmp_path / "out" / "three" / "analysis" / "walkers.pdf").is_file()


def test_a_walker_whose_error_is_unknown_still_has_its_speed():
    film = lane(1, SPEEDS, 300, interval=0.02, memory=10.0, sd=10.0)  # 15 independent parts
    for one, speed in zip(motion.analyse(film).walkers, SPEEDS, strict=True):
        assert one.mean("speed").se is None
        assert one.mean("speed").value == pytest.approx(speed, abs=9.0)  # three errors of 10 sqrt(2 x 0.2 / 6)
        assert "film for longer" in one.mean("speed").refused


def test_values_nearer_to_each_other_than_their_errors_have_no_bound_of_zero():
    alike = particle_scatter.walker_scatter("speed_scatter", np.array([50.0, 50.01, 49.99, 50.0]), 0.25, 30.0)
    assert alike.refused == "not resolved: smaller than each one's own error makes it"
