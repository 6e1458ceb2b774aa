"""Speed, persistence and spread from tracks of which everything is known."""

import json

import numpy as np
import pytest
from nightly_cases import mostly_nightly
from synthetic_tracks import Walker, film, lane

from walkergen.analysis import facts, motion, persistent_walk
from walkergen.analysis.persistent_walk import Spread
from walkergen.analysis.tracks import Track
from walkergen.core.errors import InputError

WALKER = Walker()


def truth(walker):
    return {
        "speed": walker.speed,
        "turning_bias": walker.turn,
        "persistence_rate": walker.rate,
        "persistence_time": 1 / walker.rate,
        "persistence_length": walker.speed / walker.rate,
        "ballistic_speed": walker.speed,
        "diffusivity": walker.diffusivity,
        "crossover_time": 4 * walker.diffusivity / walker.speed**2,
        "localisation_noise": walker.noise,
    }


@pytest.mark.parametrize(
    ("particles", "seconds", "headed"),
    [
        pytest.param(1, 60.0, True, marks=pytest.mark.nightly),
        pytest.param(1, 60.0, False, marks=pytest.mark.nightly),
        pytest.param(16, 12.0, False, marks=pytest.mark.slow),
    ],
)
def test_stated_errors_cover_the_truth_as_they_should(particles, seconds, headed):
    # 0.05 mm of noise, in 0.6 mm a sample, cannot always be told from diffusion.
    noisy = WALKER._replace(noise=0.1)
    known = truth(noisy)
    scores = {name: [] for name in known}
    for seed in range(30):
        found = motion.analyse(film(seed, particles, seconds, noisy, 0.02, headed))
        for name, expected in known.items():
            one = found.estimates[name]
            assert one.value is not None, (name, one.refused)
            scores[name].append((one.value - expected) / one.se)
    for name, values in scores.items():
        within = np.abs(values) < 1
        # 68 % (66 % for errors from ten samples) +- 8.6 % of 30 films, 3 sigma.
        assert 0.40 < within.mean() < 0.94, (name, within.mean())
        assert np.mean(np.abs(values) < 3) > 0.85, name


def test_headings_noise_is_told_and_does_not_slow_the_walker():
    noisy = WALKER._replace(heading_noise=0.5, lost=0.0)
    found = motion.analyse(film(1, 16, 20.0, noisy)).estimates
    assert found["heading_noise"].value == pytest.approx(0.5, abs=4 * found["heading_noise"].se)
    # Uncorrected, the projection would be exp(-0.5^2/2) = 0.88 of the speed.
    assert found["speed"].se < 0.01 * noisy.speed
    assert found["speed"].value == pytest.approx(30.0, abs=4 * found["speed"].se)


def test_localisation_noise_does_not_speed_up_a_resting_walker():
    resting = Walker(speed=0.0, noise=0.2)
    found = motion.analyse(film(2, 16, 20.0, resting)).estimates
    assert abs(found["speed"].value) < 4 * found["speed"].se
    assert found["speed"].se < 0.1  # frame by frame it would seem to run at 28 mm/s


def test_localisation_noise_does_not_shift_speed_and_persistence_without_headings():
    # 0.5 mm of noise in a run of 1.2 mm between the positions that a displacement is made of.
    noisy = Walker(noise=0.5, lost=0.0, turn=0.0)
    found = motion.analyse(film(14, 16, 20.0, noisy, headed=False)).estimates
    for name, expected in (
        ("speed", 30.0),
        ("persistence_time", 1.0),
        ("ballistic_speed", 30.0),
        ("localisation_noise", 0.5),
    ):
        assert found[name].value == pytest.approx(expected, abs=3.5 * found[name].se), name
        assert found[name].se < 0.1 * expected


def test_products_of_displacements_share_no_position():
    resting = film(15, 8, 20.0, Walker(speed=0.0, noise=1.0, lost=0.0), headed=False)
    curve = motion.analyse(resting).correlation
    assert curve.at[0] == pytest.approx(0.05)
    # Pure noise has no correlation: a shared position would give 2 mm^2.
    assert curve.value[0] < 0.1


@pytest.mark.slow
@pytest.mark.parametrize("kind", mostly_nightly([{"inertia": 0.15}, {"turn_memory": 0.15}], {"inertia": 0.15}))
def test_speed_and_persistence_hold_with_inertia(kind):
    walker = Walker(speed=45.0, rate=0.8, **kind)
    truth = {"speed": walker.ahead.real, "persistence_rate": walker.rate, "diffusivity": walker.diffusivity}
    scores = []
    for seed in range(12):
        found = motion.analyse(film(seed, 8, 30.0, walker, 1 / 30)).estimates
        known = {name: found[name] for name in truth if found[name].value is not None}
        assert known.keys() >= {"speed", "persistence_rate"}
        scores.append(
            [(known[name].value - true) / known[name].se if name in known else np.nan for name, true in truth.items()]
        )
    # Half of the films or more tell a diffusivity: in others a run may set in as slowly as it is lost.
    assert np.isfinite(scores).mean() > 0.8
    # Student's t with 7 degrees of freedom scatters by 1.18: 0.34 for the mean of 12, and 3 of it.
    # Headings taken to diffuse gave 3.5 and -8 for the speed, -6 and beyond for persistence.
    assert (np.abs(np.nanmean(scores, axis=0)) < 1.05).all(), np.nanmean(scores, axis=0)


def test_a_mirrored_film_turns_the_other_way():
    one = film(3, 12, 20.0)
    mirrored = one._replace(
        tracks=tuple(t._replace(position=t.position * [1, -1], heading=-t.heading) for t in one.tracks)
    )
    left, right = (motion.analyse(x).estimates for x in (one, mirrored))
    assert left["turning_bias"].value == pytest.approx(-right["turning_bias"].value)
    for name in ("speed", "persistence_time", "diffusivity"):
        # 1e-5: where the least squares stop
        assert left[name].value == pytest.approx(right[name].value, rel=1e-5)


def test_persistence_beyond_the_film_is_refused_with_a_bound():
    straight = WALKER._replace(rate=0.002, turn=0.0)
    found = motion.analyse(film(4, 12, 10.0, straight)).estimates
    assert found["speed"].value == pytest.approx(30.0, abs=4 * found["speed"].se)
    for name in ("persistence_time", "diffusivity", "crossover_time"):
        assert found[name].value is None
    assert "more than" in found["persistence_time"].refused
    assert "ballistic" in found["diffusivity"].refused


@pytest.mark.parametrize("few", [film(5, 1, 0.2), lane(3, [60.0], 1000, memory=100.0)], ids=["brief", "slow"])
def test_few_data_are_refused_with_the_reason(few):
    """A brief film, and one of five independent speeds: 10 s with a memory of 1 s."""
    found = motion.analyse(few, lag_s=0.04).estimates
    assert all(one.value is None or one.se is not None for one in found.values())
    assert found["speed"].value is None
    assert "film for longer" in found["speed"].refused


@pytest.mark.slow
def test_stubs_of_tracks_do_not_pass_for_walkers():
    whole = film(9, 2, 40.0)
    stubs = tuple(
        Track(100 + n, whole.tracks[0].position[5 * n : 5 * n + 4], whole.tracks[0].heading[:4]) for n in range(40)
    )
    found = motion.analyse(whole._replace(tracks=whole.tracks + stubs))
    assert "pieces" in found.method
    alone = motion.analyse(whole).estimates["persistence_time"]
    one = found.estimates["persistence_time"]
    assert one.value == pytest.approx(alone.value, abs=alone.se)
    assert one.se == pytest.approx(alone.se, rel=0.5)


@pytest.mark.parametrize(("particles", "frames"), [(1, 3000), (10, 400)])
def test_lane_speed_covers_the_truth_within_one_track_and_between_many(particles, frames):
    scores = []
    for seed in range(60):
        one = motion.analyse(lane(seed, [60.0] * particles, frames)).estimates["lane_speed"]
        scores.append((one.value - 60.0) / one.se)
    assert 0.5 < np.mean(np.abs(scores) < 1) < 0.86  # 68 % +- 6 % of 60 runs, 3 sigma


def test_a_lane_has_no_turning_and_says_so():
    found = motion.analyse(lane(1, [60.0] * 10, 400))
    assert found.estimates["turning_bias"].refused
    assert found.estimates["parallel_mean"].value == pytest.approx(60 * 0.04, rel=0.1)
    assert not len(found.orthogonal.at)


def test_densities_are_normalised_and_have_the_moments_told():
    found = motion.analyse(film(6, 12, 20.0))
    for curve, name in ((found.parallel, "parallel"), (found.orthogonal, "orthogonal")):
        width = np.diff(curve.at)[0]
        assert (curve.value * width).sum() == pytest.approx(1.0)
        mean = (curve.at * curve.value * width).sum()
        assert mean == pytest.approx(found.estimates[f"{name}_mean"].value, abs=0.02 * width + 1e-3)
    # Along the body: v tau (1 - exp(-rate tau))/(rate tau), shortened by the headings' noise.
    expected = 30 * (1 - np.exp(-0.04)) * np.exp(-0.5 * 0.08**2)
    one = found.estimates["parallel_mean"]
    assert one.value == pytest.approx(expected, abs=4 * one.se)
    assert abs(found.estimates["orthogonal_mean"].value) < 0.02


def test_speed_over_plate_speed_is_a_line_through_the_origin():
    runs = [lane(n, [2.0 * plate] * 8, 400, plate) for n, plate in enumerate((15.0, 20.0, 30.0))]
    together = runs[0]._replace(tracks=tuple(t for run in runs for t in run.tracks))
    found = motion.analyse(together)
    assert [plate for plate, *_ in found.by_plate_speed] == [15.0, 20.0, 30.0]
    assert found.line.slope.value == pytest.approx(2.0, abs=4 * found.line.slope.se)
    assert found.line.p_value > 1e-3
    assert found.estimates["speed"].value is None
    assert "plate speeds" in found.estimates["speed"].refused


def test_a_speed_at_a_plate_speed_has_the_number_of_its_own_walkers():
    slow, fast = lane(0, [30.0] * 3, 400, 15.0), lane(1, [40.0] * 2, 400, 20.0).tracks
    resting = slow.tracks[2]._replace(position=0.0 * slow.tracks[2].position)
    found = motion.analyse(slow._replace(tracks=(*slow.tracks[:2], resting, *fast)))
    assert [count for *_, count in found.by_plate_speed] == ["2 of 3 walkers", ""]
    counts = [row.get("speed_walkers") for row in facts.from_motion(found)["by_plate_speed"]]
    assert counts == ["2 of 3 walkers", None]


def test_a_lag_outside_the_film_is_refused():
    for lag_s in (0.001, 100.0, float("nan")):
        with pytest.raises(InputError, match="lag_ms="):
            motion.analyse(film(7, 2, 2.0), lag_s)


def test_the_walks_limits():
    lag = np.array([1e-6, 1e-3, 1.0])
    np.testing.assert_allclose(
        persistent_walk.squared_displacement(lag, Spread(9.0, 1e-9, 0.0, 0.0)), 9.0 * lag**2, rtol=1e-6
    )
    late = np.array([1e4])
    expected = 4 * Spread(9.0, 2.0, 0.0, 0.0, 0.5).diffusivity * late
    np.testing.assert_allclose(
        persistent_walk.squared_displacement(late, Spread(9.0, 2.0, 0.0, 0.0, 0.5)), expected, rtol=1e-3
    )
    # The closed form of the window against the sum it stands for.
    inner = np.linspace(0, 0.3, 301)
    weights = np.ones(301)
    weights[[0, -1]] = 0.5
    weights /= weights.sum()
    grid = 1.0 + inner[None, :] - inner[:, None]
    exact = weights @ np.exp((-2.0 + 0.5j) * grid) @ weights
    found = persistent_walk.velocity_correlation(np.array([1.0]), 1.0, 2.0, 0.5, window=0.3)[0]
    assert found == pytest.approx(exact, rel=1e-5)  # trapezium rule on 300 intervals


def test_the_summary_is_plain_json():
    for tracks in (film(8, 3, 3.0), lane(1, [60.0] * 2, 100), film(8, 1, 0.1)):
        data = facts.from_motion(motion.analyse(tracks))
        assert json.loads(json.dumps(data, allow_nan=False)) == data
        assert data["particles"] == len(tracks.tracks)
        for name, unit in (("speed", "mm_s"), ("persistence_time", "s")):
            refused = f"{name}_{unit}" in data["refused"]
            assert [data[f"{key}_{unit}"] is None for key in (name, f"{name}_se")] == [refused] * 2


@pytest.mark.parametrize("bad", [np.inf, -np.inf, np.nan])
def test_json_holds_no_infinity_whatever_a_number_or_curve_is(bad):
    """Bounds of numbers with hardly any degrees of freedom, curves and fits that have no number."""
    found = motion.analyse(film(3, 4, 4.0))
    wide = {
        name: number._replace(value=1.0, se=1.0, freedom=1e-6, noise=0.0, power=power, refused="")
        for power, (name, number) in zip([1, 2, -1] * len(found.estimates), found.estimates.items(), strict=False)
    }
    curves = {name: getattr(found, name) for name in ("msd", "exponent", "correlation", "parallel", "orthogonal")}
    hostile = found._replace(
        estimates=wide,
        scale_se=0.01,
        **{name: curve._replace(value=bad + curve.value, se=bad + curve.se) for name, curve in curves.items()},
        msd_fit=found.msd_fit._replace(misfit=bad, p_value=bad, spreads=(Spread(*[bad] * 7),)),
    )
    data = json.loads(json.dumps(facts.from_motion(hostile), allow_nan=False))
    assert data["refused"]["diffusivity_high_95_mm2_s"] == facts.UNBOUNDED_REASON
    assert data["diffusivity_high_95_mm2_s"] is data["msd"][0]["msd_mm2"] is data["msd_fit"]["misfit"] is None
