"""Error bars of mean speeds hold what they say: 68 % and 95 % of ensembles contain the truth."""

import functools

import numpy as np
import pytest
from nightly_cases import mostly_nightly
from scipy import special
from scipy.signal import lfilter

from walkergen.core.scene import Scene
from walkergen.core.simulation import batch, ensemble, record
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.run import ENDED_WELL, Outcome, RunResult
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates

BLOCK_S = 4.0 / 90.0
ENSEMBLES = 4000
"""Number of ensembles of a case: coverage of 95 % is then known to 0.34 %."""
SIZES = [(4, 10.0), (8, 2.0), (16, 1.0)]
"""Number and length (s) of the runs of an ensemble."""
EMPTY = record.new_tally(4)


def result(number, seconds, speeds):
    """Return a run with these block speeds; nothing else of it matters."""
    return RunResult(
        number,
        Outcome.OK,
        seconds,
        float(speeds.mean()),
        seconds / len(speeds),
        speeds,
        0.0,
        EMPTY,
        0.0,
        np.zeros((0, 3)),
    )


def decide(ensembles, truth, shrink=1.0):
    """Root mean square of z, and shares inside of the 68 % and the 95 % interval.

    z is normal where Student's law holds: the deviation over the stated error, through Student's
    distribution and back through the normal one. `shrink` is the share of a deviation that is seen.
    """
    scores, inside = [], []
    for runs in ensembles:
        mean = ensemble.mean_speed(runs)
        deviation = (mean.value - truth) / shrink
        # The tail's smaller half keeps digits; 1e-12 means no spread at all.
        tail = special.stdtr(mean.freedom, -abs(deviation) / max(mean.se, 1e-12))
        scores.append(special.ndtri(max(tail, 1e-12)))
        halves = [0.5 * (high - low) for low, high in map(mean.interval, (0.68, 0.95))]
        inside.append([abs(deviation) <= half for half in halves])
    return (float(np.sqrt(np.mean(np.square(scores)))), *np.mean(inside, axis=0))


def assert_honest(found):
    rms, within_68, within_95 = found
    assert 0.85 < rms < 1.15
    assert 0.93 < within_95 < 0.97
    assert 0.64 < within_68 < 0.73  # binomial error 0.7 %; directions are not normal: up to +3 %


def wandering(rng, runs, blocks, time):
    """Ornstein-Uhlenbeck process of unit variance with that correlation time (s)."""
    memory = np.exp(-BLOCK_S / time)
    kicks = rng.normal(size=(runs, blocks)) * np.sqrt(1 - memory**2)
    kicks[:, 0] = rng.normal(size=runs)
    return lfilter([1.0], [1.0, -memory], kicks, axis=1)


def turning(rng, runs, blocks, time):
    """Direction, 1 or -1, that turns once in `time` (s) on average."""
    turns = rng.random((runs, blocks)) < 0.5 * (1 - np.exp(-2 * BLOCK_S / time))
    turns[:, 0] = rng.random(runs) < 0.5
    return np.where(np.cumsum(turns, axis=1) % 2, 1.0, -1.0)


PROCESSES = {
    "fast": lambda *size: wandering(*size, 0.1),
    "as slow as a run": lambda *size: wandering(*size, 5.0),
    "a hundredth is slow": lambda *size: wandering(*size, 0.1) + 0.1 * wandering(*size, 10.0),
    "turns twice a second": lambda *size: turning(*size, 0.5) + 0.5 * wandering(*size, 0.1),
    "turns every two seconds": lambda *size: turning(*size, 2.0) + 0.5 * wandering(*size, 0.1),
    "turns every five seconds": lambda *size: turning(*size, 5.0) + 0.5 * wandering(*size, 0.1),
    "each print is another": lambda rng, runs, blocks: wandering(rng, runs, blocks, 0.1) + rng.normal(size=(runs, 1)),
}


@pytest.mark.parametrize(("runs", "seconds"), mostly_nightly(SIZES, (8, 2.0)))
@pytest.mark.parametrize("process", PROCESSES)
def test_intervals_of_slow_and_fast_processes_hold_their_share(process, runs, seconds):
    rng = np.random.default_rng([runs, list(PROCESSES).index(process)])
    speeds = 50.0 + PROCESSES[process](rng, ENSEMBLES * runs, round(seconds / BLOCK_S))
    results = [result(number, seconds, one) for number, one in enumerate(speeds)]
    ensembles = [results[at : at + runs] for at in range(0, len(results), runs)]
    assert_honest(decide(ensembles, 50.0))


def test_directions_that_outlast_everything_are_the_limit_of_few_runs():
    """Runs that never turn agree by chance: 2^(1 - n) of n runs, which nothing in them shows."""
    rng = np.random.default_rng(1)
    for runs, expected in ((4, 2**-3), (8, 2**-7)):
        speeds = turning(rng, ENSEMBLES * runs, 20, 1e9).reshape(ENSEMBLES, runs, 20)
        agreed = np.ptp(speeds[:, :, 0], axis=1) == 0.0
        spread = 3.0 * np.sqrt(expected * (1 - expected) / ENSEMBLES)
        assert np.mean(agreed) == pytest.approx(expected, abs=spread)
        some = [result(n, 1.0, one) for n, one in enumerate(speeds[np.argmax(agreed)])]
        assert ensemble.mean_speed(some).se == 0.0


@functools.cache
def pool(tilt, restitution, count, seconds):
    """Simulate runs of the walker; all end well."""
    scene = templates.load("lane-90hz", "scenes", Scene)
    scene = scene.model_copy(
        update={
            "run": scene.run.model_copy(update={"seconds": seconds, "runs": count}),
            "contact": scene.contact.model_copy(update={"restitution": restitution}),
        }
    )
    design = templates.load("koumakis2016", "walkers", Design).variant(tilt_deg=tilt)
    one = ensemble.runner(prepare(scene, design, solids.mass_of(design)))
    results = batch.run_all(one, scene.run.runs, threads=1)
    assert {one.outcome for one in results} <= set(ENDED_WELL)
    return results


def walkers(tilt, restitution, runs, seconds, count):
    """Judgement of ensembles drawn from a pool of `count` runs, whose mean counts as the truth.

    At tilt 0 the truth is 0: a mirrored run is as likely, and doubles the pool.
    """
    found = pool(tilt, restitution, count, seconds)
    if tilt == 0.0:
        found = [*found, *(one._replace(speed=-one.speed) for one in found)]
    truth = float(np.mean([one.speed for one in found]))
    rng = np.random.default_rng(runs)
    draws = [rng.permutation(len(found))[:runs] for _ in range(ENSEMBLES)]
    # Drawn without putting back, a mean deviates less from the pool's by the share of the pool.
    shrink = np.sqrt(1.0 - runs / len(found))
    return decide([[found[at] for at in draw] for draw in draws], truth, shrink)


@pytest.mark.slow
@pytest.mark.parametrize(("runs", "seconds"), SIZES)
def test_intervals_of_a_walker_that_turns_at_random_hold_their_share(runs, seconds):
    assert_honest(walkers(0.0, 0.8, runs, seconds, 300))
    speeds = np.array([one.speed for one in pool(0.0, 0.8, 300, seconds)])
    # An upright walker has no preferred direction: 0 within 3 standard errors.
    assert abs(speeds.mean()) < 3.0 * speeds.std(ddof=1) / np.sqrt(len(speeds))


@pytest.mark.nightly
@pytest.mark.parametrize(("runs", "seconds"), SIZES)
@pytest.mark.parametrize(
    ("tilt", "restitution"), [(0.0, 0.3), (0.0, 0.8), (5.0, 0.8), (10.0, 0.3), (10.0, 0.8), (20.0, 0.3), (20.0, 0.8)]
)
def test_intervals_hold_their_share_at_every_tilt_and_restitution(tilt, restitution, runs, seconds):
    assert_honest(walkers(tilt, restitution, runs, seconds, 600))
