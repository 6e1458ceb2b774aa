"""Ensembles: statistics against closed forms, and models that misbehave."""

from types import SimpleNamespace

import numpy as np
import pytest

from walkergen.core.scene import Scene
from walkergen.core.simulation import batch, ensemble, record
from walkergen.core.simulation.effects.effect import Case
from walkergen.core.simulation.plan import Plan
from walkergen.core.simulation.run import Outcome, RunResult, simulate
from walkergen.core.simulation.world import OK, TOPPLED, Drive, World

PERIOD = 1.0 / 90.0


def scene_of(**run):
    return Scene.model_validate({"run": {"seconds": 4.0, "discard_seconds": 0.0} | run})


class FakePlan(Plan):
    """A plan whose state is (x, y, heading, first drop); its motion is a plain function, in the world's options."""

    def sample_print(self, rng):
        return self

    def initial_state(self, clearance, pitch, phase, roll=0.0, heading=0.0):
        return np.array([0.0, 0.0, 0.0, clearance + phase])

    def advance(self, state, seconds, tally):
        return self.world.options(state, seconds, tally)

    def advancer(self, state, tally):
        return lambda seconds: self.world.options(state, seconds, tally)

    def energy(self, state):
        return 0.0


def fake_plan(advance, scene=None):
    """A plan that moves by `advance(state, seconds, tally)`."""
    case = Case(scene or scene_of(), None, SimpleNamespace(total=1.0))
    return FakePlan(case, None, World(None, Drive(1.0, 2.0 * np.pi / PERIOD), None, advance))


def steady(state, duration, tally):
    """Runs at a speed set by its start."""
    state[0] += state[3] * duration
    tally.sums[record.ELAPSED] += duration
    tally.counts[:2] += 1
    return 0


def silent(what, done, total):
    assert 0 <= done <= total


def noise_result(number, speeds, block_s=4 * PERIOD):
    tally = record.new_tally(4)
    measured = block_s * len(speeds)
    return RunResult(
        number,
        Outcome.OK,
        measured,
        float(speeds.mean()),
        block_s,
        speeds,
        0.0,
        tally,
        0.1,
        np.zeros((len(speeds) + 1, 3)),
    )


def autoregressive(rng, count, memory, mean=50.0, sd=10.0):
    noise = rng.normal(0.0, sd * np.sqrt(1 - memory**2), count)
    values = np.empty(count)
    values[0] = rng.normal(0.0, sd)
    for i in range(1, count):
        values[i] = memory * values[i - 1] + noise[i]
    return mean + values


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.9])
def test_correlation_time_of_an_autoregressive_speed(memory):
    """Closed form: tau = (1 + a) / (2 (1 - a)) blocks for a first-order process."""
    rng = np.random.default_rng(1)
    results = [noise_result(n, autoregressive(rng, 20_000, memory)) for n in range(4)]
    expected = 0.5 * (1 + memory) / (1 - memory) * 4 * PERIOD
    # 80 000 blocks, at least 4000 of them independent: a few percent, window bias included.
    assert ensemble.correlation_time(results) == pytest.approx(expected, rel=0.1)


@pytest.mark.parametrize("runs", [4, 16])
def test_standard_error_is_the_spread_of_repeated_experiments(runs):
    """Rival: the spread of the mean over 200 repetitions of the whole experiment."""
    rng = np.random.default_rng(2)
    means, errors = [], []
    for _ in range(200):
        results = [noise_result(n, autoregressive(rng, 400, 0.7)) for n in range(runs)]
        means.append(np.mean([result.speed for result in results]))
        errors.append(ensemble.mean_speed(results).se ** 2)
    # 200 repetitions know their spread to 5 %, and 4 runs theirs to 41 % each: 3 %; 3 sigma.
    assert np.sqrt(np.mean(errors)) == pytest.approx(np.std(means, ddof=1), rel=0.17)


def simulate_plan(plan):
    results = batch.run_all(ensemble.runner(plan), plan.scene.run.runs)
    return ensemble.summarise(results, plan.equivalent_drive.peak_speed, 0.0), results


@pytest.mark.parametrize("seconds", [0.1, 40.0])
@pytest.mark.parametrize("runs", [1, 3, 4, 9])
def test_too_few_runs_are_reported_instead_of_an_error_bar_at_any_length(runs, seconds):
    scene = scene_of(runs=runs, seconds=seconds)
    summary, results = simulate_plan(fake_plan(steady, scene))
    speed, se, *bounds = summary.speed.row(68, 95).values()
    assert speed == pytest.approx(np.mean([one.speed for one in results]))
    if runs < 4:
        assert se is None
        assert bounds == [None] * 4
        assert summary.outcomes["too few data for an error bar"] == runs
    else:
        assert summary.outcomes == {"ok": runs}
        inner, outer, low, high = bounds
        assert low < inner < speed - 0.9 * se
        assert speed + 0.9 * se < outer < high


def test_few_runs_have_wide_intervals():
    """Student's t: 3.18 standard errors of 4 runs, 2.13 of 16, 1.96 of very many."""
    rng = np.random.default_rng(3)
    for runs, factor in ((4, 3.182), (16, 2.131)):
        results = [noise_result(n, autoregressive(rng, 50, 0.0)) for n in range(runs)]
        speed = ensemble.summarise(results, 31.2, 1.0).speed
        assert speed.half_width() == pytest.approx(factor * speed.se, rel=1e-3)


def test_failures_are_named_and_left_out_of_the_mean():
    def topples(state, duration, tally):
        steady(state, duration, tally)
        return TOPPLED if state[3] > 4.0 else OK

    summary, results = simulate_plan(fake_plan(topples, scene_of(runs=32)))
    good = [r.speed for r in results if r.outcome is Outcome.OK]
    assert 0 < len(good) < 32
    assert summary.outcomes == {"ok": len(good), "toppled": 32 - len(good)}
    assert summary.speed.value == pytest.approx(np.mean(good))


def test_leaving_the_lane_and_energy_errors_are_outcomes():
    scene = Scene.model_validate({"run": {"seconds": 4.0}, "arena": {"length_mm": 1.0}})
    assert simulate(fake_plan(steady, scene), 0).outcome is Outcome.LEFT

    def leaky(state, duration, tally):
        tally.sums[record.PLATE_WORK] += 1.0
        return steady(state, duration, tally)

    assert simulate(fake_plan(leaky, scene_of()), 0).outcome is Outcome.ENERGY


def test_no_impact_and_no_motion_is_stuck():
    def rests(state, duration, tally):
        tally.sums[record.ELAPSED] += duration
        return 0

    result = simulate(fake_plan(rests, scene_of()), 0)
    assert (result.outcome, result.speed) == (Outcome.STUCK, 0.0)
