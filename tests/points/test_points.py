"""Walkers as experiments: pure functions of what is asked, named by a key."""

import pickle

import numpy as np
import pytest

from walkergen.core.scene import Scene
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.points import walkers
from walkergen.points.experiments import Walker

SHORT = {"seconds": 0.2, "discard_seconds": 0.0, "runs": 2}


def silent(what, done, total):
    assert 0 <= done <= total


def asked_of(tilt=10.0, impacts=False, **tables):
    design = Design().variant(tilt_deg=tilt)
    scene = Scene.model_validate({"run": SHORT} | tables)
    return Walker(scene, design, solids.mass_of(design), impacts)


def numbers(point):
    """All numbers of a point but the time it took."""
    return [
        (
            result.number,
            result.outcome,
            result.speed,
            result.block_speeds.tolist(),
            result.energy_error,
            result.tally.counts.tolist(),
            result.tally.sums.tolist(),
        )
        for result in point.results
    ]


def test_a_walker_and_its_results_survive_a_pickle_bit_for_bit():
    walker = asked_of(impacts=True)
    assert pickle.loads(pickle.dumps(walker)).key == walker.key
    point = walkers.simulate(walker, silent)
    copy = pickle.loads(pickle.dumps(point))
    assert numbers(copy) == numbers(point) == numbers(walkers.simulate(walker, silent, threads=1))
    events = [result.tally.events.rows for result in (point.results[0], copy.results[0])]
    np.testing.assert_array_equal(*events)


def test_parallel_walkers_equal_those_in_sequence():
    asked = [asked_of(tilt) for tilt in (5.0, 15.0)]
    in_turn = list(walkers.simulate_each(asked, ["5", "15"], silent))
    at_once = walkers.simulate_parallel(asked, silent)
    assert [numbers(point) for point in in_turn] == [numbers(at_once[place]) for place in (0, 1)]


def test_a_key_names_every_input_and_no_name():
    keys = {
        asked_of().key,
        asked_of(tilt=10.0000001).key,
        asked_of(impacts=True).key,
        asked_of(contact={"friction": 0.3}).key,
        asked_of(run=SHORT | {"seed": 2}).key,
        asked_of()._replace(mass=asked_of().mass._replace(M=0.8)).key,
    }
    assert len(keys) == 6
    renamed = asked_of(name="other", description="the same", prediction={"impact_speed_factor": 2.0})
    assert renamed.key in keys


def test_a_key_follows_the_kernels(monkeypatch):
    before = asked_of().key
    monkeypatch.setattr("walkergen.core.numerics.kernels.source_digest", lambda: "another")
    assert asked_of().key != before


def test_half_a_point_is_never_given(monkeypatch):
    whole = walkers.simulate(asked_of(), silent)
    half = whole._replace(summary=whole.summary._replace(runs=1))
    monkeypatch.setattr(walkers, "simulate", lambda *words: half)
    with pytest.raises(KeyboardInterrupt):
        list(walkers.simulate_each([asked_of()], ["10"], silent))


def test_progress_goes_through_all_points():
    seen = []
    asked = [asked_of(), asked_of(tilt=12.0)]
    list(walkers.simulate_each(asked, ["one", "two"], lambda *told: seen.append(told)))
    assert {what for what, _, _ in seen} == {"one", "two"}
    shares = [done / total for _, done, total in seen]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
